//! A machine that is not there: structural modes shaken by noise, shaft harmonics, and from some
//! recording on the impacts of an outer race with a growing pit.
//!
//! Each mode is a complex number that turns and decays from sample to sample. An impact between two
//! samples enters it with the turn and decay of what is left of the interval, so its instant is exact.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use realfft::num_complex::Complex;
use serde::Serialize;

use crate::recording::{Channel, Recording};

/// What to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Recordings, in order of time.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Momentum of an impact in the last recording, in m/s² of the first mode; 0 for a machine that
    /// stays healthy.
    pub strength: f64,
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
    /// The recordings: one channel, `ax`.
    pub recordings: Vec<Recording>,
    /// What may be known.
    pub machine: Machine,
    /// What may not.
    pub truth: Truth,
}

const SHAFT_HZ: f64 = 25.0;
/// Balls, and the ratio of ball to pitch diameter.
const BALLS: f64 = 9.0;
const BALL_TO_PITCH: f64 = 0.2;
/// Balls slip: standard deviation of the time from one impact to the next, of itself.
const SLIP: f64 = 0.01;
/// Frequency in Hz, damping ratio, and share of the excitation of each mode.
const MODES: [(f64, f64, f64); 3] = [(1150.0, 0.035, 1.0), (2700.0, 0.03, 0.7), (4400.0, 0.025, 0.45)];
/// Standard deviation of a sample's random push, m/s².
const SHAKING: f64 = 1.0;
/// From one recording to the next the load is not quite the same.
const LOAD_SCATTER: f64 = 0.02;
/// Amplitudes of the first shaft harmonics, m/s².
const HARMONICS: [f64; 3] = [1.2, 0.7, 0.3];
/// White noise of the sensor, m/s².
const SENSOR_NOISE: f64 = 0.15;
/// The effect starts after a share of the recordings in this range.
const START: std::ops::Range<f64> = 0.5..0.65;

/// Makes the recordings. The same plan gives the same samples.
pub fn make(plan: &Plan) -> Made {
    let machine = Machine { shaft_hz: SHAFT_HZ, ball_pass_hz: 0.5 * BALLS * (1.0 - BALL_TO_PITCH) * SHAFT_HZ };
    let start = stream(plan.seed, 0).random_range(START) * plan.recordings as f64;
    let last = (plan.recordings.max(1) - 1) as f64;
    let strength = |n: usize| plan.strength * ((n as f64 - start) / (last - start)).max(0.0);
    let recordings = (0..plan.recordings).map(|n| recording(plan, &machine, n, strength(n))).collect();
    let first_affected = (0..plan.recordings).find(|n| strength(*n) > 0.0);
    Made { recordings, machine, truth: Truth { effect: "outer-race-defect", first_affected } }
}

fn recording(plan: &Plan, machine: &Machine, index: usize, strength: f64) -> Recording {
    let rng = &mut stream(plan.seed, 1 + index as u64);
    let load = 1.0 + LOAD_SCATTER * normal(rng);
    let phases = HARMONICS.map(|_| rng.random_range(0.0..std::f64::consts::TAU));
    let mut impacts = Impacts::new(machine.ball_pass_hz, rng);
    let rate = plan.sample_rate_hz;
    let mut modes = MODES.map(|(frequency, damping, share)| Mode::new(frequency, damping, share, rate));
    // The slowest mode has settled after this.
    let settling = (0.05 * rate) as i64;
    let count = (plan.seconds * rate).round() as i64;
    let mut samples = Vec::with_capacity(count.max(0) as usize);
    for i in -settling..count {
        let now = i as f64 / rate;
        let push = SHAKING * load * normal(rng);
        modes.iter_mut().for_each(|mode| mode.advance(push));
        // `settling` before the start, so that the first sample has the decay of earlier impacts.
        while let Some((ago, force)) = impacts.before(now + settling as f64 / rate, rng) {
            modes.iter_mut().for_each(|mode| mode.strike(strength * force, ago));
        }
        if i < 0 {
            continue;
        }
        let shaft: f64 = (1..)
            .zip(HARMONICS.iter().zip(&phases))
            .map(|(k, (a, phase))| a * (std::f64::consts::TAU * f64::from(k) * machine.shaft_hz * now + phase).cos())
            .sum();
        let shaken: f64 = modes.iter().map(|mode| mode.state.re).sum();
        samples.push(shaft + shaken + SENSOR_NOISE * normal(rng));
    }
    Recording {
        channels: vec![Channel { name: "ax".into(), location: None, samples }],
        sample_rate_hz: rate,
        shaft_hz: Some(machine.shaft_hz),
        ..Recording::default()
    }
}

/// A structural mode's answer, as an acceleration.
struct Mode {
    state: Complex<f64>,
    pole: Complex<f64>,
    share: f64,
    /// Turn and decay per second.
    rate: Complex<f64>,
}

impl Mode {
    fn new(frequency_hz: f64, damping: f64, share: f64, sample_rate_hz: f64) -> Self {
        let omega = std::f64::consts::TAU * frequency_hz;
        let rate = Complex::new(-damping * omega, omega * (1.0 - damping * damping).sqrt());
        Self { state: Complex::default(), pole: (rate / sample_rate_hz).exp(), share, rate }
    }

    fn advance(&mut self, push: f64) {
        self.state = self.state * self.pole + self.share * push;
    }

    fn strike(&mut self, force: f64, seconds_ago: f64) {
        self.state += self.share * force * (self.rate * seconds_ago).exp();
    }
}

/// Balls passing the pit, one after the other.
struct Impacts {
    period_s: f64,
    next_s: f64,
}

impl Impacts {
    fn new(rate_hz: f64, rng: &mut ChaCha8Rng) -> Self {
        Self { period_s: 1.0 / rate_hz, next_s: rng.random_range(0.0..1.0 / rate_hz) }
    }

    /// How long ago the next impact was, and its force; `None` while it is still to come.
    fn before(&mut self, now_s: f64, rng: &mut ChaCha8Rng) -> Option<(f64, f64)> {
        let ago = now_s - self.next_s;
        (ago >= 0.0).then(|| {
            self.next_s += self.period_s * (1.0 + SLIP * normal(rng)).max(0.5);
            (ago, 1.0 + 0.1 * normal(rng))
        })
    }
}

/// Random numbers of one part of one plan.
fn stream(seed: u64, part: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(part);
    rng
}

/// Standard normal (Box and Muller 1958).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{envelope_spectrum, welch};

    const PLAN: Plan = Plan { recordings: 20, seconds: 0.5, sample_rate_hz: 12_800.0, strength: 30.0, seed: 3 };

    fn samples(recording: &Recording) -> Vec<f32> {
        recording.channels[0].samples.iter().map(|v| *v as f32).collect()
    }

    #[test]
    fn the_effect_comes_after_half_and_shows_at_the_ball_pass_rate() {
        let made = make(&PLAN);
        let first = made.truth.first_affected.unwrap();
        assert!((10..15).contains(&first), "{first}");
        let (early, late) = (samples(&made.recordings[0]), samples(&made.recordings[19]));
        let strength_at_ball_pass = |samples: &[f32]| {
            let spectrum = envelope_spectrum(&[samples], 12_800.0, &(2000.0..6000.0)).unwrap();
            let at = (made.machine.ball_pass_hz / spectrum.step_hz).round() as usize;
            spectrum.values[at - 1..=at + 1].iter().fold(0.0, |a: f64, b| a.max(*b))
        };
        assert!(strength_at_ball_pass(&late) > 5.0 * strength_at_ball_pass(&early));
    }

    #[test]
    fn resonances_and_harmonics_are_where_they_should_be() {
        let made = make(&Plan { seconds: 4.0, recordings: 1, strength: 0.0, ..PLAN });
        let spectrum = welch(&[&samples(&made.recordings[0])], 12_800.0, 4096).unwrap();
        let power = |around: f64| spectrum.integral(&(around - 20.0..around + 20.0));
        for (frequency, ..) in MODES {
            assert!(
                power(frequency) > 1.5 * power(frequency - 300.0) && power(frequency) > 1.5 * power(frequency + 300.0)
            );
        }
        assert!((spectrum.integral(&(12.0..38.0)) - 0.5 * HARMONICS[0].powi(2)).abs() < 0.1);
    }

    #[test]
    fn null_without_strength_there_is_no_effect() {
        let made = make(&Plan { strength: 0.0, ..PLAN });
        assert_eq!(made.truth.first_affected, None);
    }

    #[test]
    fn same_seed_same_samples_and_the_effect_changes_nothing_before_it_starts() {
        let (made, control) = (make(&PLAN), make(&Plan { strength: 0.0, ..PLAN }));
        assert_eq!(made, make(&PLAN));
        assert_ne!(made, make(&Plan { seed: 4, ..PLAN }));
        let first = made.truth.first_affected.unwrap();
        assert_eq!(made.recordings[..first], control.recordings[..first]);
        assert_ne!(made.recordings[first], control.recordings[first]);
    }
}
