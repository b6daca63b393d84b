//! What can be wrong with a rig.

use std::{io, path::PathBuf};

/// Why a rig cannot be read, changed, written or run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The operating system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Not TOML.
    #[error("{path}, row {row}: found {found}, expected TOML")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// What the parser said.
        found: String,
    },
    /// A section or key that a rig does not have.
    #[error("{path}, {key}: found an unknown key, expected {expected}")]
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// The key with its section, such as `outer.mass_g` or `effect[2].depth`.
        key: String,
        /// The keys there are.
        expected: String,
    },
    /// A key that must be there.
    #[error("{path}, {key}: found nothing, expected {expected}")]
    MissingKey {
        /// The file.
        path: PathBuf,
        /// The key with its section.
        key: String,
        /// What should be there.
        expected: String,
    },
    /// A value of a wrong type or an impossible one.
    #[error("{path}, {key}: found {found}, expected {expected}")]
    BadValue {
        /// The file.
        path: PathBuf,
        /// The key with its section.
        key: String,
        /// The value.
        found: String,
        /// What should be there.
        expected: String,
    },
    /// An operating condition or start that cannot be simulated.
    #[error("{field}: found {found}, expected {expected}")]
    BadCondition {
        /// The field.
        field: &'static str,
        /// Its value.
        found: String,
        /// What it can be.
        expected: &'static str,
    },
    /// A state that is no longer finite: the parameters are impossible together.
    #[error("the simulation diverged at {time_s} s")]
    Diverged {
        /// Time from the first sample, s; negative while settling.
        time_s: f64,
    },
}
