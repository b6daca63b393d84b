//! The `ballrace` command.

use std::process::ExitCode;

use ballrace::commands;

fn main() -> ExitCode {
    commands::run()
}
