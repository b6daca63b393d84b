//! Errors of a force balance.

use crate::recording::Recording;
use crate::rig::RigError;

/// Errors of a force balance.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BalanceError {
    /// A rig of another kind.
    #[error("kind: found {found:?}, expected \"sdof\"")]
    NotSdof {
        /// The kind.
        found: &'static str,
    },
    /// No recordings.
    #[error("found no recordings, expected at least one with channels u and q (or qdd)")]
    NoRecordings,
    /// A recording that lacks a channel, is too short, or has another sample rate.
    #[error("{recording}: found {found}, expected {expected}")]
    BadRecording {
        /// The recording.
        recording: String,
        /// Contents of the recording.
        found: String,
        /// Expected contents.
        expected: String,
    },
    /// No parameter is unknown, or none can be determined.
    #[error("found nothing to determine, expected {expected}")]
    Nothing {
        /// Expected input.
        expected: String,
    },
    /// The rig cannot be run.
    #[error(transparent)]
    Rig(#[from] RigError),
}

impl BalanceError {
    /// Error of a recording's contents.
    pub fn recording(recording: &Recording, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::BadRecording { recording: recording.source.to_string(), found: found.into(), expected: expected.into() }
    }

    /// Error of a recording without a channel; `channel` is said to be missing, `example` the one that a manifest can name.
    pub fn no_channel(recording: &Recording, channel: &str, example: &str) -> Self {
        let there: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        Self::recording(
            recording,
            format!("no channel {channel} among {}", there.join(", ")),
            format!("one; `channels = {{ NAME = \"{example}\" }}` in the manifest says which is which"),
        )
    }
}
