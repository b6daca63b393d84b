//! The `ballrace` command.

use std::process::ExitCode;

use ballrace::cli;

fn main() -> ExitCode {
    cli::run()
}
