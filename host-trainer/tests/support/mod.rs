//! The binary as a user runs it.

use std::path::Path;
use std::process::{Command, Output};

/// Runs the binary in a folder.
pub fn ballrace(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ballrace")).current_dir(folder).args(arguments).output().expect("the binary runs")
}

/// What it printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Done, with its stdout.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = ballrace(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Refused with status 2, with its stderr.
pub fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = ballrace(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stdout));
    assert!(output.stdout.is_empty(), "nothing on stdout");
    text(&output.stderr)
}
