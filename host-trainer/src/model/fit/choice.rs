//! Choices of a fit by their names, on the command line and in files.

use ballrace_core::network::Arithmetic;
use ballrace_core::states::{Alignment, Estimator};
use serde::{Deserialize, Serialize};

use super::settings::EstimatorSettings;

const ESTIMATOR: EstimatorSettings = EstimatorSettings::DEFAULT;

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

/// Arithmetic of the networks on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ArithmeticKind {
    /// Single precision.
    #[default]
    Float,
    /// 16-bit fixed point, for one hidden layer: less than half of the instructions.
    Fixed,
}

impl From<ArithmeticKind> for Arithmetic {
    fn from(kind: ArithmeticKind) -> Self {
        match kind {
            ArithmeticKind::Float => Self::Float,
            ArithmeticKind::Fixed => Self::Fixed,
        }
    }
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

/// Estimator of the states of order 1 and above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum EstimatorKind {
    /// Finite differences.
    #[default]
    Differences,
    /// Savitzky–Golay derivatives at the newest sample.
    SavitzkyGolay,
    /// Kalman filter of a chain of integrators.
    Kalman,
}

impl EstimatorKind {
    /// Estimator with these parameters; `None`: the default.
    pub fn with(self, excess: Option<u8>, stretch: Option<f32>, cutoff: Option<f32>) -> Estimator {
        match self {
            Self::Differences => Estimator::Differences,
            Self::SavitzkyGolay => Estimator::SavitzkyGolay {
                excess: excess.unwrap_or(ESTIMATOR.excess),
                stretch: stretch.unwrap_or(ESTIMATOR.stretch),
            },
            Self::Kalman => Estimator::Kalman { cutoff: cutoff.unwrap_or(ESTIMATOR.cutoff) },
        }
    }
}

/// Estimator as the end of a sentence; empty for finite differences.
pub(super) fn estimator_in_words(estimator: Estimator) -> String {
    match estimator {
        Estimator::Differences => String::new(),
        Estimator::SavitzkyGolay { excess, stretch } => {
            format!(", Savitzky–Golay of excess degree {excess} and stretch {stretch}")
        }
        Estimator::Kalman { cutoff } => format!(", Kalman of cut-off {cutoff} cycles a sample"),
    }
}
