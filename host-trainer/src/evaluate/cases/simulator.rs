//! Simulators that cases are made with.

use serde::{Deserialize, Serialize};

/// Simulator of the cases, and how far their machines are as their drawings say.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Simulator {
    /// The simulator that the diagnosis searches with, its forms of the effects, everything as stated.
    #[default]
    Shared,
    /// The independent simulator with forms of its own, everything as stated.
    Exact,
    /// The independent simulator, and machines as machines are: speed, load, slip and noise are not quite what is stated.
    Real,
}

impl Simulator {
    /// All simulators.
    pub const ALL: [Self; 3] = [Self::Shared, Self::Exact, Self::Real];

    /// Name in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Exact => "exact",
            Self::Real => "real",
        }
    }

    /// Simulator of a name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }

    /// Size of the imperfections with the independent simulator, 1 as machines are; `None` with the shared one.
    pub fn imperfections(self) -> Option<f64> {
        match self {
            Self::Shared => None,
            Self::Exact => Some(0.0),
            Self::Real => Some(1.0),
        }
    }
}
