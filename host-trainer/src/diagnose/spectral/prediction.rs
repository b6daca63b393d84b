//! Power spectra that a rig predicts: noise, and lines of the deterministic motion.

use std::sync::Arc;

use rayon::prelude::*;

use super::observation::{Observation, Power, power};
use super::settings::LikelihoodSettings;
use crate::identify::likelihood::observed::CHANNELS;
use crate::identify::likelihood::whittle::noises;
use crate::rig::effect::EffectKind;
use crate::rig::random_part::Asked;
use crate::rig::simulate::{fewest_substeps, shortest_settling_s, simulate_all};
use crate::rig::state::VelocityCovariance;
use crate::rig::{Rig, RigError, Run, Start};
use crate::signal::kinematics::Orders;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;
/// Angles of cage and shaft at t = 0 of the runs, rad: power spectra do not depend on them.
pub const START_ANGLES_RAD: [f64; 2] = [0.4, 1.1];

/// Predicted spectra of a recording.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Variance of the random part at each frequency.
    pub noise: Power,
    /// Power of the deterministic part.
    pub lines: Power,
    /// The same where a wandering speed has taken the lines' phase.
    pub skirts: Power,
    /// The same where balls are so unevenly spaced that no harmonic of the ball pass stands out.
    pub spaced: Power,
    /// Velocity covariance of the random part.
    pub scatter: VelocityCovariance,
}

/// Part of the predictions that is known from a nearby rig.
#[derive(Clone, Debug, Default)]
pub enum Known {
    /// Nothing.
    #[default]
    Nothing,
    /// Noise, which effects of the deterministic motion leave as it is.
    Noise(Arc<Vec<Prediction>>),
    /// Velocity covariance, on which friction depends.
    Scatter(Vec<VelocityCovariance>),
}

impl Known {
    /// Predictions of a rig.
    ///
    /// # Errors
    /// What the simulation refuses, or a run that diverges.
    pub fn predictions(
        &self,
        rig: &Rig,
        observations: &[Observation],
        orders: &Orders,
    ) -> Result<Vec<Prediction>, RigError> {
        let noise = match self {
            Self::Noise(known) => known.iter().map(|p| (p.noise.clone(), p.scatter)).collect(),
            Self::Scatter(known) => noise(rig, observations, Some(known))?,
            Self::Nothing => noise(rig, observations, None)?,
        };
        let scatter: Vec<_> = noise.iter().map(|(_, scatter)| *scatter).collect();
        let lines = lines(rig, observations, &scatter)?;
        let inner = [EffectKind::InnerRaceDefect, EffectKind::InnerRaceWaviness];
        let on_cage_orders = !rig.effects.iter().any(|effect| inner.contains(&effect.kind));
        let all = noise.into_iter().zip(lines).zip(observations);
        Ok(all
            .map(|(((noise, scatter), lines), o)| Prediction {
                skirts: skirts(&lines, o),
                spaced: spaced(&lines, o, orders, on_cage_orders),
                noise,
                lines,
                scatter,
            })
            .collect())
    }
}

/// Variance of the random part, and velocity covariance; `known` are those of nearly the same rig.
///
/// # Errors
/// What the simulation refuses.
pub fn noise(
    rig: &Rig,
    observed: &[Observation],
    known: Option<&[VelocityCovariance]>,
) -> Result<Vec<(Power, VelocityCovariance)>, RigError> {
    // Effects of the deterministic motion leave the noise as it is.
    let mut rig = rig.clone();
    rig.effects.retain(|effect| !effect.definition().is_deterministic);
    let asked = observed.iter().enumerate();
    let asked = asked.map(|(n, o)| Asked { rig: &rig, condition: o.condition, known: known.map(|k| k[n]) });
    let made = noises(&asked.collect::<Vec<_>>());
    made.into_iter().map(|noise| noise.map(|n| (n.variance, n.velocity_covariance))).collect()
}

/// Power of the deterministic part.
///
/// # Errors
/// What the simulation refuses, or a run that diverges.
pub fn lines(rig: &Rig, observed: &[Observation], scatter: &[VelocityCovariance]) -> Result<Vec<Power>, RigError> {
    let runs = observed.iter().zip(scatter).map(|(o, scatter)| {
        let scatter = Some(*scatter);
        let substeps = Some(fewest_substeps(rig, scatter, &o.condition));
        let settle_s = shortest_settling_s(rig)
            .min(SETTINGS.settle_share * o.condition.samples as f64 / o.condition.sample_rate_hz);
        let [cage, shaft] = START_ANGLES_RAD;
        let start = Start::noise_free(cage, shaft);
        Run { rig, condition: o.condition, start: Start { substeps, settle_s, velocity_covariance: scatter, ..start } }
    });
    let runs: Vec<Run> = runs.collect();
    let spectrum = |recording: crate::recording::Recording| {
        CHANNELS.map(|name| recording.channel(name).map_or_else(Vec::new, |c| power(&c.samples)))
    };
    simulate_all(&runs)?.into_par_iter().map(|run| run.map(spectrum)).collect()
}

/// Lines spread as widely as a speed wanders: a triangle, by two means in turn.
fn skirts(lines: &Power, observation: &Observation) -> Power {
    let reach = (SETTINGS.wander_hz / observation.hz(1.0)).round().max(1.0) as usize;
    lines.each_ref().map(|power| mean_around(&mean_around(power, reach), reach))
}

/// Lines spread over a ball pass: balls that pass unevenly put a line's power into the orders of the cage around it. What the
/// inner race modulates lies between these too, so that it is spread evenly.
fn spaced(lines: &Power, observation: &Observation, orders: &Orders, on_cage_orders: bool) -> Power {
    let bins = |order: f64| order * observation.condition.shaft_hz / observation.hz(1.0);
    let reach = (0.25 * bins(orders.bpfo)).round().max(1.0) as usize;
    let period = bins(orders.ftf);
    let lobe = |away: f64| (1.0 - (away / SETTINGS.lobe_bins).powi(2)).max(0.0);
    // A lobe's integral over all bins.
    let scale = period / (4.0 / 3.0 * SETTINGS.lobe_bins);
    let weight = |k: usize| {
        let place = k as f64 / period;
        scale * lobe((place - place.round()) * period)
    };
    let is_comb = on_cage_orders && period > 4.0 * SETTINGS.lobe_bins;
    lines.each_ref().map(|power| {
        let mut spread = mean_around(&mean_around(power, reach), reach);
        if is_comb {
            spread.iter_mut().enumerate().for_each(|(k, p)| *p *= weight(k));
        }
        spread
    })
}

fn mean_around(power: &[f64], reach: usize) -> Vec<f64> {
    let mut sums = vec![0.0; power.len() + 1];
    power.iter().enumerate().for_each(|(k, p)| sums[k + 1] = sums[k] + p);
    let of = |k: usize| {
        let (from, to) = (k.saturating_sub(reach), (k + reach + 1).min(power.len()));
        (sums[to] - sums[from]) / (2 * reach + 1) as f64
    };
    (0..power.len()).map(of).collect()
}
