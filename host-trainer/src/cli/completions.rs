//! Command `ballrace completions`.

use clap::CommandFactory;

use super::{Cli, Failure};

/// Print completions of the commands and options for a shell
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace completions bash > ~/.local/share/bash-completion/completions/ballrace")]
pub struct Args {
    /// Shell that completes
    shell: clap_complete::Shell,
}

/// Runs `completions`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "ballrace", &mut script);
    super::line(String::from_utf8_lossy(&script).trim_end())
}
