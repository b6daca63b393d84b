//! Methods that a sweep compares.

use serde::{Deserialize, Serialize};

use crate::model::fit::choice::SolverKind;
use crate::rivals::Rival;

/// Method of a fit: a solver for Ξ, or a rival without equations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// [`SolverKind::SindyNn`].
    #[default]
    SindyNn,
    /// [`SolverKind::Stlsq`].
    Stlsq,
    /// [`Rival::Lstm`].
    Lstm,
    /// [`Rival::Tcn`].
    Tcn,
    /// [`Rival::PatchTransformer`].
    PatchTransformer,
}

impl Method {
    /// The rivals of the paper's Table 4.
    pub const RIVALS: [Self; 3] = [Self::Lstm, Self::Tcn, Self::PatchTransformer];

    /// The rival; `None` for a solver.
    pub const fn rival(self) -> Option<Rival> {
        match self {
            Self::SindyNn | Self::Stlsq => None,
            Self::Lstm => Some(Rival::Lstm),
            Self::Tcn => Some(Rival::Tcn),
            Self::PatchTransformer => Some(Rival::PatchTransformer),
        }
    }

    /// Whether this build has the method.
    pub const fn is_built(self) -> bool {
        self.rival().is_none() || cfg!(feature = "rivals")
    }

    /// Name in the paper's Table 4.
    pub const fn paper_name(self) -> &'static str {
        match self {
            Self::SindyNn => "SINDy-NN",
            Self::Stlsq => "STLSQ",
            Self::Lstm => "LSTM",
            Self::Tcn => "TCN",
            Self::PatchTransformer => "PatchTransformer",
        }
    }
}

impl From<SolverKind> for Method {
    fn from(solver: SolverKind) -> Self {
        match solver {
            SolverKind::SindyNn => Self::SindyNn,
            SolverKind::Stlsq => Self::Stlsq,
        }
    }
}
