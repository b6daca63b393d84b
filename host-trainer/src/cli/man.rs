//! Command `ballrace man`.

use std::path::PathBuf;

use clap::CommandFactory;
use clap_mangen::Man;

use super::{Cli, Failure, line, write};

/// Write manual pages: ballrace.1, and one for each command
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace man --out ~/.local/share/man/man1\n  then: man ballrace-diagnose")]
pub struct Args {
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Runs `man`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let refused = |error: std::io::Error| Failure::Input(format!("--out: {}: {error}", args.out.display()));
    std::fs::create_dir_all(&args.out).map_err(refused)?;
    let mut command = Cli::command().disable_help_subcommand(true);
    // Gives the commands their full names, `ballrace-fit`.
    command.build();
    let commands: Vec<clap::Command> = std::iter::once(&command).chain(command.get_subcommands()).cloned().collect();
    for command in &commands {
        let man = Man::new(command.clone());
        let mut page = Vec::new();
        man.render(&mut page).map_err(Failure::other)?;
        write(&args.out.join(man.get_filename()), &page)?;
    }
    line(format_args!("wrote {} pages to {}", commands.len(), args.out.display()))
}
