//! Errors of a rig.

use std::{io, path::PathBuf};

/// Errors of reading, changing, writing or running a rig.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The operating system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Not TOML.
    #[error("{path}, row {row}: found {found}, expected TOML")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Message of the parser.
        found: String,
    },
    /// Unknown section or key.
    #[error("{path}, {key}: found an unknown key, expected {expected}")]
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// The key with its section, such as `outer.mass_g` or `effect[2].depth`.
        key: String,
        /// Known keys.
        expected: String,
    },
    /// Missing key.
    #[error("{path}, {key}: found nothing, expected {expected}")]
    MissingKey {
        /// The file.
        path: PathBuf,
        /// The key with its section.
        key: String,
        /// Expected value.
        expected: String,
    },
    /// Value of a wrong type or out of range.
    #[error("{path}, {key}: found {found}, expected {expected}")]
    BadValue {
        /// The file.
        path: PathBuf,
        /// The key with its section.
        key: String,
        /// The value.
        found: String,
        /// Expected value.
        expected: String,
    },
    /// Operating condition or start that cannot be simulated.
    #[error("{field}: found {found}, expected {expected}")]
    BadCondition {
        /// The field.
        field: &'static str,
        /// Value of the field.
        found: String,
        /// Allowed values.
        expected: &'static str,
    },
    /// Recording that contradicts itself or the rig.
    #[error("{place}: found {found}, expected {expected}")]
    BadRecording {
        /// File and channel or key.
        place: String,
        /// What was found.
        found: String,
        /// Expected value.
        expected: String,
    },
    /// State that is no longer finite: the parameters are impossible together.
    #[error("the simulation diverged at {time_s} s")]
    Diverged {
        /// Time from the first sample, s; negative while settling.
        time_s: f64,
    },
}
