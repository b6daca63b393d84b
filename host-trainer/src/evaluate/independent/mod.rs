//! Independent simulator of the rig: another integration, other forms of the effects, machines that are not their drawings.
//!
//! What a diagnosis finds with the simulator it searches with says little about a machine. These cases are made by code that
//! shares with [`crate::rig`] the parameters of a rig and nothing of its simulation.
//!
//! | module | holds |
//! |---|---|
//! | [`motion`] | rotation of shaft and cage |
//! | [`plant`] | the machine as it runs |
//! | [`integrate`] | integration, measuring chain, recording |
//! | [`noise`] | noise of smooth colour |
//! | [`imperfections`] | what is never as stated |
//! | [`effects`] | effects of the vocabulary in forms of their own |
//! | [`outside`] | effects outside the vocabulary |
//! | [`strength`] | how strong an effect is, by what it changes |

pub mod effects;
pub mod imperfections;
pub mod integrate;
pub mod motion;
pub mod noise;
pub mod outside;
pub mod plant;
pub mod settings;
pub mod strength;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::evaluate::cases::case_spec::{CaseSpec, Hidden};
use crate::evaluate::cases::machine::{self, Drawn};
use crate::evaluate::cases::settings::CaseSettings;
use crate::evaluate::cases::{Case, HiddenEffect, Truth, change};
use crate::recording::Recording;
use crate::rig::RigError;
use effects::{Apply, Context};
use imperfections::Imperfections;
use motion::{Pace, Wander};
use plant::Plant;
use settings::StrengthSettings;

const SETTINGS: StrengthSettings = StrengthSettings::DEFAULT;
const CASES: CaseSettings = CaseSettings::DEFAULT;

/// Machine of a case, healthy, in each of its recordings.
pub struct Bench {
    /// Machine as stated, and conditions as stated.
    pub drawn: Drawn,
    imperfections: Imperfections,
    angles: Vec<[f64; 2]>,
    seeds: Vec<u64>,
}

impl Bench {
    /// Draws a machine with imperfections of a size, and `count` conditions.
    ///
    /// # Errors
    /// None, as long as the reference machines are rigs.
    pub fn draw(loud: bool, seconds: f64, count: usize, size: f64, rng: &mut ChaCha8Rng) -> Result<Self, RigError> {
        let mut drawn = machine::draw(loud, seconds, count, rng)?;
        if rng.random_bool(SETTINGS.wide_machines) {
            machine::widen(&mut drawn, SETTINGS.wide_factor, rng)?;
        }
        let angle = |rng: &mut ChaCha8Rng| rng.random_range(0.0..TAU);
        let angles = (0..count).map(|_| [angle(rng), angle(rng)]).collect();
        let seeds = (0..count).map(|_| rng.random()).collect();
        let (bearing, sensor) = (&drawn.machine.bearing, &drawn.machine.sensor);
        let imperfections = Imperfections::draw(size, bearing.balls, count, sensor.noise_std_m_per_s2, rng);
        Ok(Self { drawn, imperfections, angles, seeds })
    }

    /// Healthy machine of a recording.
    pub fn plant(&self, recording: usize) -> Plant {
        let (machine, condition) = (&self.drawn.machine, &self.drawn.conditions[recording]);
        let [shaft_angle_rad, cage_angle_rad] = self.angles[recording];
        let pace = Pace {
            shaft_hz: condition.shaft_hz,
            shaft_angle_rad,
            cage_angle_rad,
            cage_ratio: Plant::cage_ratio(machine),
            slip: 0.0,
            shaft_wander: Wander::default(),
            cage_wander: Wander::default(),
            drift: None,
        };
        let mut plant = Plant::of_rig(machine, pace, condition.load_n);
        self.imperfections.apply(recording, &mut plant);
        plant
    }

    /// Records machines, given with the index of their recording, side by side.
    ///
    /// # Errors
    /// A run that diverges.
    pub fn record(&self, plants: &[(usize, Plant)]) -> Result<Vec<Recording>, RigError> {
        let one = |(n, plant): &(usize, Plant)| integrate::run(plant, &self.drawn.conditions[*n], Some(self.seeds[*n]));
        plants.par_iter().map(one).collect()
    }
}

/// Draws a case of the independent simulator. The same spec, size of the imperfections and seed give the same samples.
///
/// # Errors
/// The last draw's error if no draw of the effect can be simulated.
pub fn draw_case(spec: &CaseSpec, seconds: f64, size: f64, seed: u64) -> Result<Case, RigError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (count, all) = (CASES.recordings, CASES.recordings + CASES.baseline);
    let bench = Bench::draw(spec.loud, seconds, all, size, &mut rng)?;
    let healthy = |from: usize, to: usize| bench.record(&(from..to).map(|n| (n, bench.plant(n))).collect::<Vec<_>>());
    let without = healthy(0, count)?;
    let mut attempt = hide(spec, &bench, &without, 1.0, &mut rng);
    for n in 1..CASES.attempts {
        if attempt.is_ok() {
            break;
        }
        // The more forms have failed, the weaker an effect may be.
        attempt = hide(spec, &bench, &without, 1.0 - n as f64 / CASES.attempts as f64, &mut rng);
    }
    let (mut recordings, mut truth) = attempt?;
    truth.change = change(&without, &recordings);
    let mut rig = bench.drawn.rig.clone();
    let baseline = if spec.guessed {
        machine::guess(&mut rig, &mut rng)?;
        Some(healthy(count, all)?)
    } else {
        None
    };
    if !spec.tachometer {
        recordings.iter_mut().for_each(|r| r.channels.retain(|c| c.name != "tacho"));
    }
    Ok(Case { rig, recordings, baseline, truth })
}

/// Error of an effect that only the other simulator has.
pub(super) fn foreign() -> RigError {
    let expected = "an effect of the simulator that makes the case";
    RigError::BadCondition { field: "effect", found: "one of another simulator".into(), expected }
}

/// Error of an effect that changes next to nothing in its form; another form is drawn.
fn slight() -> RigError {
    let expected = "an effect that changes what is recorded";
    RigError::BadCondition { field: "effect", found: "next to no change in any form".into(), expected }
}

/// Recordings of the machine with its hidden causes, and the truth; `patience`, from 1 to 0, scales the least change and the
/// greatest strength.
fn hide(
    spec: &CaseSpec,
    bench: &Bench,
    without: &[Recording],
    patience: f64,
    rng: &mut ChaCha8Rng,
) -> Result<(Vec<Recording>, Truth), RigError> {
    let mut truth = Truth::default();
    let sizes = ["ax", "ay"].map(|name| sizes(without, name));
    let context = Context {
        drawn: &bench.drawn,
        rms: ["ax", "ay"].map(|name| strength::rms(without, name)),
        sizes: [&sizes[0], &sizes[1]],
        recordings: without.len(),
        share: 0.5,
    };
    let mut applied: Vec<(f64, Vec<bool>, Apply)> = Vec::new();
    match &spec.hidden {
        Hidden::Nothing => {}
        Hidden::Effects(names) => {
            for (kind, severity) in names {
                let (at, span) = severity.share();
                let context = Context { share: at + span * rng.random::<f64>(), ..context };
                let effect = effects::draw(*kind, &context, rng);
                let target = effects::target(&effect.strength, &context);
                let size = strength::reach(&effect.strength, target, patience, &effect.present, &effect.apply, bench)?
                    .ok_or_else(slight)?;
                truth.accept.extend(effect.accept.map(|kind| kind.to_string()));
                truth.causes.push(kind.to_string());
                let present: Vec<usize> = (0..without.len()).filter(|n| effect.present[*n]).map(|n| n + 1).collect();
                let told = |mut told: HiddenEffect| {
                    if told.recordings.is_empty() && present.len() < without.len() {
                        told.recordings = present.clone();
                    }
                    told
                };
                truth.effects.extend((effect.told)(size).into_iter().map(told));
                applied.push((size, effect.present, effect.apply));
            }
        }
        Hidden::OutsideIndependent(kind) => {
            let context = Context { share: rng.random(), ..context };
            let (how, apply) = outside::draw(*kind, &context, rng);
            let present = vec![true; without.len()];
            let size = strength::reach(&how, effects::target(&how, &context), patience, &present, &apply, bench)?
                .ok_or_else(slight)?;
            truth.causes.push("unexplained".into());
            truth.outside = Some(kind.name().into());
            applied.push((size, present, apply));
        }
        // Forms of the shared simulator, which only that one has.
        Hidden::Outside(_) => return Err(foreign()),
    }
    let plants = (0..without.len()).map(|n| {
        let mut plant = bench.plant(n);
        applied.iter().filter(|(_, present, _)| present[n]).for_each(|(size, _, apply)| apply(*size, n, &mut plant));
        (n, plant)
    });
    Ok((bench.record(&plants.collect::<Vec<_>>())?, truth))
}

/// Sizes of a channel's samples, ascending.
fn sizes(recordings: &[Recording], name: &str) -> Vec<f64> {
    let all = recordings.iter().filter_map(|r| r.channel(name)).flat_map(|c| &c.samples);
    let mut sizes: Vec<f64> = all.map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes
}
