//! Sets of features that are compared.

use serde::{Serialize, Serializer};

use super::measure::{Measured, NULLS};
use super::settings::FeatureSettings;
use crate::signal::surrogate::SurrogateKind;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Coefficients of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fitted {
    /// Place of the library among the settings' degrees.
    pub library: usize,
    /// Place among [`NULLS`] of the surrogate fitted to; `None` for the recording itself.
    pub null: Option<usize>,
}

/// Features together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeatureSet {
    /// Whether logarithms of RMS and kurtosis are among them.
    pub classical: bool,
    /// Coefficients among them.
    pub fitted: Option<Fitted>,
}

impl FeatureSet {
    /// RMS and kurtosis.
    pub const CLASSICAL: Self = Self { classical: true, fitted: None };

    /// Coefficients of a recording.
    pub const fn of_recording(library: usize, classical: bool) -> Self {
        Self { classical, fitted: Some(Fitted { library, null: None }) }
    }

    /// Coefficients of its surrogate.
    pub const fn of_null(library: usize, null: usize, classical: bool) -> Self {
        Self { classical, fitted: Some(Fitted { library, null: Some(null) }) }
    }

    /// All sets: the classical one, then coefficients without and with it.
    pub fn all() -> Vec<Self> {
        let libraries = 0..SETTINGS.degrees.len();
        let fitted = |classical| {
            libraries.clone().flat_map(move |library| {
                let nulls = (0..NULLS.len()).map(move |null| Self::of_null(library, null, classical));
                std::iter::once(Self::of_recording(library, classical)).chain(nulls)
            })
        };
        std::iter::once(Self::CLASSICAL).chain(fitted(false)).chain(fitted(true)).collect()
    }

    /// Values for a recording.
    pub fn values(self, measured: &Measured) -> Vec<f64> {
        let classical = [measured.classical.rms.ln(), measured.classical.kurtosis.ln()];
        let classical = classical.into_iter().filter(|_| self.classical);
        let fitted = self.fitted.map_or(&[][..], |Fitted { library, null }| {
            &null.map_or(&measured.coefficients, |null| &measured.nulls[null])[library]
        });
        classical.chain(fitted.iter().copied()).collect()
    }

    /// Name, such as `RMS, kurtosis, null's Ξ2 (phase)`: Ξ with the degree n_D of its library.
    pub fn name(self) -> String {
        let fitted = self.fitted.map(|Fitted { library, null }| {
            let name = format!("Ξ{}", SETTINGS.degrees[library]);
            null.map_or(name.clone(), |null| format!("null's {name} ({})", null_name(null)))
        });
        let parts: Vec<String> = self.classical.then(|| "RMS, kurtosis".to_owned()).into_iter().chain(fitted).collect();
        parts.join(", ")
    }
}

impl Serialize for FeatureSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

/// Name of a kind of [`NULLS`].
pub fn null_name(null: usize) -> &'static str {
    match NULLS[null] {
        SurrogateKind::White => "white",
        SurrogateKind::Phase => "phase",
        SurrogateKind::Amplitude => "amplitude",
        SurrogateKind::Cyclostationary => "cyclic",
    }
}
