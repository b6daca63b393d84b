//! Features of recordings: classical ones, fitted coefficients, and those of surrogates.

use rayon::prelude::*;

use super::coefficients::coefficients;
use super::settings::FeatureSettings;
use crate::recording::input::Series;
use crate::signal::phases::life::Features;
use crate::signal::surrogate::SurrogateKind;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Surrogates that are the null: the strictest, and that which has the spectrum alone.
pub const NULLS: [SurrogateKind; 2] = [SurrogateKind::Cyclostationary, SurrogateKind::Phase];

/// Coefficients of each library, in the order of the settings' degrees.
pub type Coefficients = [Vec<f64>; SETTINGS.degrees.len()];

/// Features of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Kurtosis and RMS.
    pub classical: Features,
    /// Coefficients of the recording.
    pub coefficients: Coefficients,
    /// Coefficients of a surrogate of each kind of [`NULLS`].
    pub nulls: [Coefficients; NULLS.len()],
}

/// Recording without features.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{recording}: found {found}, expected {}", .expected)]
pub struct MeasureError {
    /// Name of the recording.
    pub recording: String,
    /// What is wrong.
    pub found: String,
    /// What is needed.
    pub expected: &'static str,
}

/// Features of each recording; surrogate n is drawn from `seed` + n. `done` is called after each.
///
/// # Errors
/// The first recording that is too short, constant or not finite.
pub fn measure(series: &[Series], seed: u64, done: &(dyn Fn() + Sync)) -> Result<Vec<Measured>, MeasureError> {
    // A decomposition split over threads would round differently with their number.
    faer::set_global_parallelism(faer::Par::Seq);
    let one = |(n, series): (usize, &Series)| {
        let measured = measure_one(series, seed.wrapping_add(n as u64));
        done();
        measured
    };
    let all: Vec<_> = series.par_iter().enumerate().map(one).collect();
    all.into_iter().collect()
}

fn measure_one(series: &Series, seed: u64) -> Result<Measured, MeasureError> {
    let refuse = |found: String, expected| MeasureError { recording: series.name.clone(), found, expected };
    let samples: Vec<f64> = series.samples.iter().map(|v| f64::from(*v)).collect();
    let classical = Features::new(&samples);
    if !(classical.kurtosis.is_finite() && classical.rms > 0.0) {
        return Err(refuse(format!("a kurtosis of {}", classical.kurtosis), "finite samples that vary"));
    }
    let fitted = |samples: &[f32]| -> Result<Coefficients, MeasureError> {
        let all = SETTINGS.degrees.map(|degree| coefficients(samples, degree));
        let Some(all) = all.into_iter().collect::<Option<Vec<_>>>().and_then(|all| Coefficients::try_from(all).ok())
        else {
            return Err(refuse(format!("{} samples", samples.len()), "ten for each coefficient of an equation"));
        };
        match all.iter().flatten().all(|value| value.is_finite()) {
            true => Ok(all),
            false => Err(refuse("a coefficient that is not finite".into(), "states that vary")),
        }
    };
    let [first, second] = NULLS.map(|kind| fitted(&kind.of(&series.samples, seed)));
    Ok(Measured { classical, coefficients: fitted(&series.samples)?, nulls: [first?, second?] })
}
