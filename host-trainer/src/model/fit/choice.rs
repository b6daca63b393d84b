//! Choices of a fit by their names, on the command line and in files.

use ballrace_core::states::Alignment;
use serde::{Deserialize, Serialize};

/// Solver for Ξ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SolverKind {
    /// Autoencoder with sparse dynamics.
    #[default]
    SindyNn,
    /// Sequentially thresholded least squares.
    Stlsq,
}

/// Alignment of the finite differences in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum AlignmentKind {
    /// Even orders centred, odd ones half a sample later.
    #[default]
    Half,
    /// All forward differences at one index.
    Forward,
    /// Backward differences of the past.
    Causal,
}

impl From<AlignmentKind> for Alignment {
    fn from(kind: AlignmentKind) -> Self {
        match kind {
            AlignmentKind::Half => Self::Half,
            AlignmentKind::Forward => Self::Forward,
            AlignmentKind::Causal => Self::Causal,
        }
    }
}
