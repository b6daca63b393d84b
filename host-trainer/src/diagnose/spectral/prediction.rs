//! Power spectra that a rig predicts: noise, and lines of the deterministic motion, those of the inner race apart: where a cage
//! slips, balls pass the outer race more slowly and the inner race faster.

use std::sync::Arc;

use rayon::prelude::*;

use super::observation::{Observation, Power, power};
use super::settings::{LikelihoodSettings, WIDTHS};
use super::sidebands::cage_bins;
use super::unevenness::{Formed, UnevenMachines, Unevenness};
use crate::identify::likelihood::observed::CHANNELS;
use crate::identify::likelihood::whittle;
use crate::recording::Recording;
use crate::rig::effect::EffectKind;
use crate::rig::random_part::{Asked, depends_on_velocity_noise};
use crate::rig::simulate::{fewest_substeps, shortest_settling_s, simulate, simulate_all};
use crate::rig::state::VelocityCovariance;
use crate::rig::{EffectEntry, Rig, RigError, Run, Start};
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
    /// Lines of the deterministic part without the effects of the inner race, but no more than with them.
    pub outer: Lines,
    /// What the effects of the inner race add; `None` without any.
    pub inner: Option<Lines>,
    /// What each error of form of a simulated machine adds to the lines; `None` where it is not known.
    pub formed: Option<Formed>,
    /// Velocity covariance of the random part.
    pub scatter: VelocityCovariance,
}

/// Lines spread to each of the half widths of the settings.
pub type Skirts = [Power; WIDTHS];

/// Lines of which each keeps its ratio to the others when the cage slips.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Power.
    pub power: Power,
    /// The same where a wandering rotation has taken the lines' phase.
    pub skirts: Skirts,
    /// What uneven balls make of it, over the share of a line's power that they take.
    pub spaced: Power,
}

impl Lines {
    /// Lines as if they had grown from `from` to these by a factor in the amplitude.
    fn scaled(&self, from: Option<&Self>, scale: f64) -> Self {
        let power = |own: &Power, from: Option<&Power>| -> Power {
            [0, 1].map(|c| {
                let grown = |(k, own): (usize, &f64)| {
                    let from = from.map_or(0.0, |from| from[c][k]);
                    from + scale * scale * (own - from).max(0.0)
                };
                own[c].iter().enumerate().map(grown).collect()
            })
        };
        Self {
            power: power(&self.power, from.map(|f| &f.power)),
            skirts: std::array::from_fn(|width| power(&self.skirts[width], from.map(|f| &f.skirts[width]))),
            spaced: power(&self.spaced, from.map(|f| &f.spaced)),
        }
    }
}

impl Prediction {
    fn new(
        noise: Noise,
        Parts { outer, inner }: Parts,
        unevenness: Option<&Unevenness>,
        observation: &Observation,
        orders: &Orders,
    ) -> Self {
        Self {
            outer: Lines {
                skirts: skirts(&outer, observation),
                spaced: spaced(&outer, unevenness, observation, orders),
                power: outer,
            },
            inner: inner.map(|power| Lines {
                skirts: skirts(&power, observation),
                spaced: power.each_ref().map(|power| over_ball_pass(power, observation, orders)),
                power,
            }),
            formed: unevenness.map(|known| Arc::clone(&known.formed)),
            noise: noise.variance,
            process_share: noise.process_share,
            scatter: noise.scatter,
        }
    }

    fn random_part(&self) -> Noise {
        let (variance, process_share) = (Arc::clone(&self.noise), Arc::clone(&self.process_share));
        Noise { variance, process_share, scatter: self.scatter }
    }

    /// Prediction of an effect `scale` times as large, whose lines grow with its square; `null` is that without the effect.
    pub fn scaled(&self, null: &Self, scale: f64) -> Self {
        Self {
            outer: self.outer.scaled(Some(&null.outer), scale),
            inner: self.inner.as_ref().map(|inner| inner.scaled(null.inner.as_ref(), scale)),
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
    /// The same, and what effects of the inner race add, which another effect hardly changes.
    NoiseAndInner(Arc<Vec<Prediction>>),
    /// Velocity covariance, on which friction depends.
    Scatter(Vec<VelocityCovariance>),
}

impl Known {
    /// Predictions whose noise is that of the rig.
    pub fn noise(&self) -> Option<&[Prediction]> {
        match self {
            Self::Noise(known) | Self::NoiseAndInner(known) => Some(known),
            Self::Nothing | Self::Scatter(_) => None,
        }
    }

    /// Part of the lines of each recording; that without the effects of the inner race if the nearby rig has none there.
    fn part(&self) -> Option<Part> {
        match self {
            Self::Noise(known) if known.iter().all(|p| p.inner.is_none()) => {
                Some(Part::Outer(known.iter().map(|p| p.outer.power.clone()).collect()))
            }
            Self::NoiseAndInner(known) => known
                .iter()
                .map(|p| p.inner.as_ref().map(|inner| inner.power.clone()))
                .collect::<Option<_>>()
                .map(Part::Inner),
            _ => None,
        }
    }
}

/// Predictions of rigs for the same recordings, with what is known of each; all are simulated side by side. A rig that cannot
/// run has an error of its own. Where `unevenness` is not known, uneven balls spread all lines alike.
pub fn predictions(
    rigs: &[(&Known, &Rig)],
    observations: &[Observation],
    orders: &Orders,
    unevenness: &UnevenMachines,
) -> Vec<Result<Vec<Prediction>, RigError>> {
    let noises = noises_of(rigs, observations);
    let runs = rigs.iter().zip(&noises).filter_map(|((known, rig), noise)| {
        let scatter = noise.as_ref().ok()?.iter().map(|n| n.scatter).collect();
        Some(Deterministic { rig, scatter, part: known.part() })
    });
    let mut lines = lines_of(&runs.collect::<Vec<_>>(), observations).into_iter();
    let mut found = Vec::with_capacity(rigs.len());
    for ((_, rig), noise) in rigs.iter().zip(noises) {
        found.push(match noise {
            Ok(noise) => lines.next().unwrap_or_else(|| Ok(Vec::new())).map(|lines| (*rig, noise, lines)),
            Err(error) => Err(error),
        });
    }
    let complete = |(rig, noise, lines): (&Rig, Vec<Noise>, Vec<Parts>)| -> Vec<Prediction> {
        let all = noise.into_iter().zip(lines).zip(observations).enumerate();
        all.map(|(n, ((noise, lines), o))| Prediction::new(noise, lines, unevenness.of(rig, n), o, orders)).collect()
    };
    found.into_par_iter().map(|found| found.map(complete)).collect()
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
        if known.noise().is_some() {
            continue;
        }
        let scatter = match known {
            Known::Scatter(known) => Some(known),
            _ => None,
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
    let of = |(known, _): &(&Known, &Rig)| match known.noise() {
        Some(known) => Ok(known.iter().map(Prediction::random_part).collect()),
        None => made.by_ref().take(observations.len()).collect::<Vec<_>>().into_iter().collect(),
    };
    rigs.iter().map(of).collect()
}

/// Rig without the effects of the deterministic motion, which leave the noise as it is.
fn without_deterministic(rig: &Rig) -> Rig {
    let mut rig = rig.clone();
    rig.effects.retain(|effect| !effect.definition().is_deterministic);
    rig
}

/// Deterministic part of a rig that is asked for.
pub struct Deterministic<'r> {
    /// Rig.
    pub rig: &'r Rig,
    /// Velocity covariance of the random part in each recording.
    pub scatter: Vec<VelocityCovariance>,
    /// Part of the lines that is known.
    pub part: Option<Part>,
}

/// Part of the lines of each recording.
#[derive(Clone)]
pub enum Part {
    /// Without the effects of the inner race.
    Outer(Vec<Power>),
    /// What these add.
    Inner(Vec<Power>),
}

/// Power of the deterministic part of a recording.
#[derive(Clone, Debug)]
pub struct Parts {
    /// Without the effects of the inner race, but no more than with them.
    pub outer: Power,
    /// What these add; `None` without any.
    pub inner: Option<Power>,
}

impl Parts {
    /// Parts of the powers of each recording, of which one part is known.
    fn of_each(wholes: Vec<Power>, part: Option<Part>) -> Vec<Self> {
        match part {
            None => wholes.into_iter().map(|whole| Self { outer: whole, inner: None }).collect(),
            Some(Part::Outer(all)) => {
                let split = wholes.iter().zip(&all).map(|(whole, outer)| split(whole, outer));
                split.map(|(outer, inner)| Self { outer, inner: Some(inner) }).collect()
            }
            Some(Part::Inner(all)) => {
                let split = wholes.iter().zip(&all).map(|(whole, inner)| split(whole, inner));
                split.map(|(inner, outer)| Self { outer, inner: Some(inner) }).collect()
            }
        }
    }
}

/// A part of a power, no more than the whole, and the rest.
fn split(whole: &Power, part: &Power) -> (Power, Power) {
    let both = |c: usize| whole[c].iter().zip(&part[c]);
    let part = [0, 1].map(|c| both(c).map(|(whole, part)| whole.min(*part)).collect());
    let rest = [0, 1].map(|c| both(c).map(|(whole, part)| (whole - part).max(0.0)).collect());
    (part, rest)
}

/// Whether an effect is fixed to the inner race.
pub fn is_inner(effect: &EffectEntry) -> bool {
    matches!(effect.kind, EffectKind::InnerRaceDefect | EffectKind::InnerRaceWaviness)
}

/// Power of the deterministic part of rigs in each recording, all simulated side by side; a rig that cannot run, or a run that
/// diverges in finer steps too, has an error of its own.
pub fn lines_of(asked: &[Deterministic], observations: &[Observation]) -> Vec<Result<Vec<Parts>, RigError>> {
    let without_inner = |asked: &Deterministic| {
        let mut rig = asked.rig.clone();
        rig.effects.retain(|effect| !is_inner(effect));
        (rig.effects.len() < asked.rig.effects.len() && asked.part.is_none()).then_some(rig)
    };
    let others: Vec<Option<Rig>> = asked.iter().map(without_inner).collect();
    let wholes = asked.iter().map(|one| (one.rig, one.scatter.as_slice()));
    let rest = asked.iter().zip(&others).filter_map(|(one, rig)| Some((rig.as_ref()?, one.scatter.as_slice())));
    let mut powers = powers_of(&wholes.chain(rest).collect::<Vec<_>>(), observations);
    let mut rest = powers.split_off(asked.len()).into_iter();
    let mut parts = Vec::with_capacity(asked.len());
    for ((whole, one), other) in powers.into_iter().zip(asked).zip(&others) {
        let part = match other {
            Some(_) => rest.next().transpose().map(|outer| outer.map(Part::Outer)),
            None => Ok(one.part.clone().filter(|_| one.rig.effects.iter().any(is_inner))),
        };
        parts.push(whole.and_then(|whole| Ok(Parts::of_each(whole, part?))));
    }
    parts
}

/// Start of a noise-free run of a recording, with the velocity covariance of the random part.
pub fn noise_free(rig: &Rig, observation: &Observation, scatter: VelocityCovariance) -> Start {
    let [cage, shaft] = START_ANGLES_RAD;
    let duration_s = observation.condition.samples as f64 / observation.condition.sample_rate_hz;
    Start {
        substeps: Some(fewest_substeps(rig, Some(scatter), &observation.condition)),
        settle_s: shortest_settling_s(rig).min(SETTINGS.settle_share * duration_s),
        velocity_covariance: Some(scatter),
        ..Start::noise_free(cage, shaft)
    }
}

/// Simulated noise-free runs, each with an error of its own if it diverges in finer steps too.
///
/// # Errors
/// A rig that is refused.
pub fn noise_free_runs(runs: &[Run]) -> Result<Vec<Result<Recording, RigError>>, RigError> {
    let ended = |(made, run): (Result<Recording, RigError>, &Run)| match made {
        // A drag is stiffer where the motion is fast than where its steps are counted for.
        Err(RigError::Diverged { .. }) if depends_on_velocity_noise(run.rig) => {
            simulate(run.rig, &run.condition, &Start { substeps: None, ..run.start })
        }
        other => other,
    };
    Ok(simulate_all(runs)?.into_par_iter().zip(runs).map(ended).collect())
}

/// Powers of the deterministic part of rigs, each with the velocity covariances of its random part.
fn powers_of<'r>(
    rigs: &[(&'r Rig, &[VelocityCovariance])],
    observations: &[Observation],
) -> Vec<Result<Vec<Power>, RigError>> {
    let runs_of = |(rig, scatter): &(&'r Rig, &[VelocityCovariance])| -> Vec<Run<'r>> {
        let each = observations.iter().zip(*scatter);
        each.map(|(o, s)| Run { rig, condition: o.condition, start: noise_free(rig, o, *s) }).collect()
    };
    let runs: Vec<Vec<Run>> = rigs.iter().map(runs_of).collect();
    let spectrum = |recording: Recording| {
        CHANNELS.map(|name| recording.channel(name).map_or_else(Vec::new, |c| power(&c.samples)))
    };
    let simulated = |runs: &[Run]| -> Result<Vec<Result<Power, RigError>>, RigError> {
        Ok(noise_free_runs(runs)?.into_par_iter().map(|made| made.map(spectrum)).collect())
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

/// Lines spread as widely as a rotation wanders: triangles, by two means in turn.
pub fn skirts(lines: &Power, observation: &Observation) -> Skirts {
    SETTINGS.wander_widths.map(|width| {
        let reach = (width * SETTINGS.wander_hz / observation.hz(1.0)).round().max(1.0) as usize;
        lines.each_ref().map(|power| mean_around(&mean_around(power, reach), reach))
    })
}

/// Lines spread over a ball pass, as what the inner race modulates is by uneven balls.
fn over_ball_pass(power: &[f64], observation: &Observation, orders: &Orders) -> Vec<f64> {
    let reach = (0.5 * observation.bins_of(orders.bpfo)).round().max(1.0) as usize;
    mean_around(&mean_around(power, reach), reach)
}

/// Lines spread over the orders of the cage within a ball pass: balls that pass unevenly put a line's power there. Where the lines
/// of an uneven machine are known, only what an effect adds to them is spread.
fn spaced(lines: &Power, unevenness: Option<&Unevenness>, observation: &Observation, orders: &Orders) -> Power {
    let comb = cage_bins(observation, orders);
    let lobe = |away: f64| (1.0 - (away / SETTINGS.lobe_bins).powi(2)).max(0.0);
    let weight = |k: usize, period: f64| {
        let place = k as f64 / period;
        // A lobe's integral over all bins.
        let scale = period / (4.0 / 3.0 * SETTINGS.lobe_bins);
        scale * lobe((place - place.round()) * period)
    };
    [0, 1].map(|c| {
        let beyond = |(power, even): (&f64, &f64)| (power - even).max(0.0);
        let mut spread = match unevenness {
            Some(known) => {
                let added: Vec<f64> = lines[c].iter().zip(&known.even[c]).map(beyond).collect();
                over_ball_pass(&added, observation, orders)
            }
            None => over_ball_pass(&lines[c], observation, orders),
        };
        if let Some(period) = comb {
            spread.iter_mut().enumerate().for_each(|(k, p)| *p *= weight(k, period));
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
