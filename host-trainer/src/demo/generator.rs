//! A run to failure that is not one: the 5-DoF rig, recording after recording, and from one of them on
//! a pit in its outer race that grows.

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::recording::Recording;
use crate::rig::RigError;
use crate::rig::config::{EffectEntry, Model, Rig};
use crate::rig::simulate::{OperatingCondition, Run, Start, simulate_many};

/// What to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Recordings, in order of time.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Depth of the pit in the last recording, m; 0 for a machine that stays healthy.
    pub depth_m: f64,
    /// Seed of everything random, the effect's start included.
    pub seed: u64,
}

/// What anyone may know of the machine: its drawing and its tachometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Shaft speed, Hz.
    pub shaft_hz: f64,
    /// Rate at which balls pass a point of the outer race, Hz.
    pub ball_pass_hz: f64,
}

/// What only the maker knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Truth {
    /// Name of the effect.
    pub effect: &'static str,
    /// First recording with it, from 0; `None` where it never comes.
    pub first_affected: Option<usize>,
}

/// What was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// The recordings: one channel, `ay`, the vertical sensor.
    pub recordings: Vec<Recording>,
    /// What may be known.
    pub machine: Machine,
    /// What may not.
    pub truth: Truth,
}

const EFFECT: &str = "outer-race-defect";
const RIG: &str = include_str!("rig.toml");
const SHAFT_HZ: f64 = 25.0;
const LOAD_N: f64 = 500.0;
/// From one recording to the next speed and load are not quite the same: largest relative difference.
const SCATTER: f64 = 0.01;
/// Width of the pit, rad.
const WIDTH_RAD: f64 = 0.09;
/// The effect starts after a share of the recordings in this range.
const START: std::ops::Range<f64> = 0.5..0.65;

/// Makes the recordings. The same plan gives the same samples.
///
/// # Errors
/// What the simulation refuses.
pub fn make(plan: &Plan) -> Result<Made, RigError> {
    let rig = Rig::parse(RIG, Path::new("rig.toml"))?;
    let mut rng = ChaCha8Rng::seed_from_u64(plan.seed);
    let start = rng.random_range(START) * plan.recordings as f64;
    let last = (plan.recordings.max(1) - 1) as f64;
    let depth = |n: usize| plan.depth_m * ((n as f64 - start) / (last - start)).max(0.0);
    // Toward the load, where the balls press hardest.
    let angle = std::f64::consts::FRAC_PI_2 + rng.random_range(-0.3..0.3);
    let rigs: Vec<Rig> = (0..plan.recordings)
        .map(|n| match depth(n) {
            0.0 => rig.clone(),
            depth => rig.clone().with_effect(EffectEntry::new(
                EFFECT,
                &[("depth_m", depth), ("width_rad", WIDTH_RAD), ("angle_rad", angle)],
            )),
        })
        .collect();
    let mut near = |value: f64| value * (1.0 + rng.random_range(-SCATTER..SCATTER));
    let runs: Vec<Run> = rigs
        .iter()
        .enumerate()
        .map(|(n, rig)| Run {
            rig,
            condition: OperatingCondition {
                shaft_hz: near(SHAFT_HZ),
                load_n: near(LOAD_N),
                sample_rate_hz: plan.sample_rate_hz,
                samples: (plan.seconds * plan.sample_rate_hz).round() as usize,
            },
            start: Start::seeded(plan.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(n as u64)),
        })
        .collect();
    let mut recordings = simulate_many(&runs)?;
    recordings.iter_mut().for_each(|recording| recording.channels.retain(|channel| channel.name == "ay"));
    let machine = Machine { shaft_hz: SHAFT_HZ, ball_pass_hz: SHAFT_HZ * ball_pass_order(&rig) };
    let first_affected = (0..plan.recordings).find(|n| depth(*n) > 0.0);
    Ok(Made { recordings, machine, truth: Truth { effect: EFFECT, first_affected } })
}

fn ball_pass_order(rig: &Rig) -> f64 {
    match &rig.model {
        Model::Bearing(rig) => rig.bearing.geometry().orders().bpfo,
        Model::Sdof(_) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::envelope::envelope_spectrum;

    const PLAN: Plan = Plan { recordings: 12, seconds: 0.4, sample_rate_hz: 25_600.0, depth_m: 4e-6, seed: 3 };

    #[test]
    fn the_effect_comes_after_half_and_shows_at_the_ball_pass_rate() {
        let made = make(&PLAN).unwrap();
        let first = made.truth.first_affected.unwrap();
        assert!((6..9).contains(&first), "{first}");
        let strength_at_ball_pass = |recording: &Recording| {
            let samples: Vec<f32> = recording.channels[0].samples.iter().map(|v| *v as f32).collect();
            let spectrum = envelope_spectrum(&[&samples], 25_600.0, &(3500.0..7000.0)).unwrap();
            let at = (made.machine.ball_pass_hz / spectrum.step_hz).round() as usize;
            spectrum.values[at - 1..=at + 1].iter().fold(0.0, |a: f64, b| a.max(*b))
        };
        let (early, late) = (strength_at_ball_pass(&made.recordings[0]), strength_at_ball_pass(&made.recordings[11]));
        assert!(late > 5.0 * early, "{early} {late}");
    }

    #[test]
    fn null_without_depth_there_is_no_effect() {
        let made = make(&Plan { depth_m: 0.0, ..PLAN }).unwrap();
        assert_eq!(made.truth.first_affected, None);
    }

    #[test]
    fn same_seed_same_samples_and_the_effect_changes_nothing_before_it_starts() {
        let (made, control) = (make(&PLAN).unwrap(), make(&Plan { depth_m: 0.0, ..PLAN }).unwrap());
        assert_eq!(made, make(&PLAN).unwrap());
        assert_ne!(made, make(&Plan { seed: 4, ..PLAN }).unwrap());
        let first = made.truth.first_affected.unwrap();
        assert_eq!(made.recordings[..first], control.recordings[..first]);
        assert_ne!(made.recordings[first], control.recordings[first]);
    }
}
