//! Power spectra that a rig predicts: noise, and lines of the deterministic motion.

use std::sync::Arc;

use rayon::prelude::*;

use super::observation::{Observation, Power, power};
use super::settings::LikelihoodSettings;
use super::unevenness::Unevenness;
use crate::identify::likelihood::observed::CHANNELS;
use crate::identify::likelihood::whittle;
use crate::recording::Recording;
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
    pub noise: Arc<Power>,
    /// Share of the process force in it.
    pub process_share: Arc<Power>,
    /// Power of the deterministic part.
    pub lines: Power,
    /// The same where a wandering speed has taken the lines' phase.
    pub skirts: Power,
    /// The same where balls are so unevenly spaced that no harmonic of the ball pass stands out.
    pub spaced: Power,
    /// Velocity covariance of the random part.
    pub scatter: VelocityCovariance,
}

impl Prediction {
    fn random_part(&self) -> Noise {
        let (variance, process_share) = (Arc::clone(&self.noise), Arc::clone(&self.process_share));
        Noise { variance, process_share, scatter: self.scatter }
    }

    /// Prediction of an effect `scale` times as large, whose lines grow with its square; `null` is that without the effect.
    pub fn scaled(&self, null: &Self, scale: f64) -> Self {
        let power = |own: &Power, null: &Power| -> Power {
            [0, 1].map(|c| {
                let bins = own[c].iter().zip(&null[c]);
                bins.map(|(own, null)| null + scale * scale * (own - null).max(0.0)).collect()
            })
        };
        Self {
            lines: power(&self.lines, &null.lines),
            skirts: power(&self.skirts, &null.skirts),
            spaced: power(&self.spaced, &null.spaced),
            ..self.clone()
        }
    }
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

/// Predictions of rigs for the same recordings, with what is known of each; all are simulated side by side. A rig that cannot
/// run has an error of its own. Without `unevenness` uneven balls spread all lines alike.
pub fn predictions(
    rigs: &[(&Known, &Rig)],
    observations: &[Observation],
    orders: &Orders,
    unevenness: &[Unevenness],
) -> Vec<Result<Vec<Prediction>, RigError>> {
    let noises = noises_of(rigs, observations);
    let scatter =
        |noise: &Result<Vec<Noise>, RigError>| noise.as_ref().ok().map(|n| n.iter().map(|n| n.scatter).collect());
    let runs: Vec<(&Rig, Vec<VelocityCovariance>)> =
        rigs.iter().zip(&noises).filter_map(|((_, rig), noise)| Some((*rig, scatter(noise)?))).collect();
    let mut lines = lines_of(&runs, observations).into_iter();
    let inner = [EffectKind::InnerRaceDefect, EffectKind::InnerRaceWaviness];
    let complete = |(rig, noise): (&Rig, Vec<Noise>), lines: Vec<Power>| -> Vec<Prediction> {
        let on_cage_orders = !rig.effects.iter().any(|effect| inner.contains(&effect.kind));
        let all = noise.into_iter().zip(lines).zip(observations).enumerate();
        all.map(|(n, ((noise, lines), o))| Prediction {
            skirts: skirts(&lines, o),
            spaced: spaced(&lines, unevenness.get(n), o, orders, on_cage_orders),
            noise: noise.variance,
            process_share: noise.process_share,
            scatter: noise.scatter,
            lines,
        })
        .collect()
    };
    let with_lines = noises.into_iter().map(|noise| noise.map(|noise| (noise, lines.next())));
    let all: Vec<_> = rigs.iter().zip(with_lines).collect();
    all.into_par_iter()
        .map(|((_, rig), found)| {
            let (noise, lines) = found?;
            Ok(complete((rig, noise), lines.unwrap_or_else(|| Ok(Vec::new()))?))
        })
        .collect()
}

/// Random part of a recording, as in a [`Prediction`].
#[derive(Clone)]
pub struct Noise {
    /// Variance at each frequency.
    pub variance: Arc<Power>,
    process_share: Arc<Power>,
    /// Velocity covariance.
    pub scatter: VelocityCovariance,
}

/// Random parts of each rig in all recordings.
pub fn noises_of(rigs: &[(&Known, &Rig)], observations: &[Observation]) -> Vec<Result<Vec<Noise>, RigError>> {
    let persistent: Vec<Rig> = rigs.iter().map(|(_, rig)| without_deterministic(rig)).collect();
    let mut asked = Vec::new();
    for ((known, _), rig) in rigs.iter().zip(&persistent) {
        let scatter = match known {
            Known::Noise(_) => continue,
            Known::Scatter(known) => Some(known),
            Known::Nothing => None,
        };
        let each = observations.iter().enumerate();
        asked.extend(each.map(|(n, o)| Asked { rig, condition: o.condition, known: scatter.map(|all| all[n]) }));
    }
    let noise = |n: whittle::Noise| Noise {
        variance: Arc::new(n.variance),
        process_share: Arc::new(n.process_share),
        scatter: n.velocity_covariance,
    };
    let mut made = whittle::noises(&asked).into_iter().map(|made| made.map(noise));
    let of = |(known, _): &(&Known, &Rig)| match known {
        Known::Noise(known) => Ok(known.iter().map(Prediction::random_part).collect()),
        _ => made.by_ref().take(observations.len()).collect::<Vec<_>>().into_iter().collect(),
    };
    rigs.iter().map(of).collect()
}

/// Rig without the effects of the deterministic motion, which leave the noise as it is.
fn without_deterministic(rig: &Rig) -> Rig {
    let mut rig = rig.clone();
    rig.effects.retain(|effect| !effect.definition().is_deterministic);
    rig
}

/// Variance of the random part, and velocity covariance; `known` are those of nearly the same rig.
///
/// # Errors
/// What the simulation refuses.
pub fn noise(rig: &Rig, observations: &[Observation], known: &[VelocityCovariance]) -> Result<Vec<Noise>, RigError> {
    noises_of(&[(&Known::Scatter(known.to_vec()), rig)], observations)
        .into_iter()
        .collect::<Result<Vec<_>, _>>()
        .map(|all| all.concat())
}

/// Power of the deterministic part.
///
/// # Errors
/// What the simulation refuses, or a run that diverges.
pub fn lines(rig: &Rig, observations: &[Observation], scatter: &[VelocityCovariance]) -> Result<Vec<Power>, RigError> {
    lines_of(&[(rig, scatter.to_vec())], observations)
        .into_iter()
        .collect::<Result<Vec<_>, _>>()
        .map(|all| all.concat())
}

/// Settling of a run of a recording, s.
pub fn settling_s(rig: &Rig, observation: &Observation) -> f64 {
    let duration_s = observation.condition.samples as f64 / observation.condition.sample_rate_hz;
    shortest_settling_s(rig).min(SETTINGS.settle_share * duration_s)
}

/// Powers of the deterministic part of rigs, each with the velocity covariances of its random part.
fn lines_of(
    rigs: &[(&Rig, Vec<VelocityCovariance>)],
    observations: &[Observation],
) -> Vec<Result<Vec<Power>, RigError>> {
    fn run<'r>(rig: &'r Rig, o: &Observation, scatter: VelocityCovariance) -> Run<'r> {
        let [cage, shaft] = START_ANGLES_RAD;
        let scatter = Some(scatter);
        let substeps = Some(fewest_substeps(rig, scatter, &o.condition));
        let settle_s = settling_s(rig, o);
        let start = Start { substeps, settle_s, velocity_covariance: scatter, ..Start::noise_free(cage, shaft) };
        Run { rig, condition: o.condition, start }
    }
    let runs: Vec<Vec<Run>> = rigs
        .iter()
        .map(|(rig, scatter)| observations.iter().zip(scatter).map(|(o, s)| run(rig, o, *s)).collect())
        .collect();
    let spectrum = |recording: Recording| {
        CHANNELS.map(|name| recording.channel(name).map_or_else(Vec::new, |c| power(&c.samples)))
    };
    let simulated = |runs: &[Run]| -> Result<Vec<Result<Power, RigError>>, RigError> {
        Ok(simulate_all(runs)?.into_par_iter().map(|run| run.map(spectrum)).collect())
    };
    match simulated(&runs.concat()) {
        Ok(made) => {
            let mut made = made.into_iter();
            runs.iter().map(|runs| made.by_ref().take(runs.len()).collect::<Vec<_>>().into_iter().collect()).collect()
        }
        // One that is refused refuses all.
        Err(_) => runs.par_iter().map(|runs| simulated(runs)?.into_iter().collect()).collect(),
    }
}

/// Lines spread as widely as a speed wanders: a triangle, by two means in turn.
fn skirts(lines: &Power, observation: &Observation) -> Power {
    let reach = (SETTINGS.wander_hz / observation.hz(1.0)).round().max(1.0) as usize;
    lines.each_ref().map(|power| mean_around(&mean_around(power, reach), reach))
}

/// Lines spread over a ball pass: balls that pass unevenly put a line's power into the orders of the cage around it. What the
/// inner race modulates lies between these too, so that it is spread evenly. Where the lines of an uneven machine are known, only
/// what an effect adds to them is spread.
fn spaced(
    lines: &Power,
    unevenness: Option<&Unevenness>,
    observation: &Observation,
    orders: &Orders,
    on_cage_orders: bool,
) -> Power {
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
    [0, 1].map(|c| {
        let beyond = |(power, even): (&f64, &f64)| (power - even).max(0.0);
        let mut spread = match unevenness {
            Some(known) => mean_around(&lines[c].iter().zip(&known.even[c]).map(beyond).collect::<Vec<_>>(), reach),
            None => mean_around(&lines[c], reach),
        };
        spread = mean_around(&spread, reach);
        if is_comb {
            spread.iter_mut().enumerate().for_each(|(k, p)| *p *= weight(k));
        }
        if let Some(known) = unevenness {
            spread.iter_mut().zip(&known.added[c]).for_each(|(p, added)| *p += added);
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
