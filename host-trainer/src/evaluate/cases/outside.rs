//! Effects outside the vocabulary.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp};

use super::machine::{Drawn, log_uniform};
use super::settings::OutsideSettings;
use crate::recording::Recording;
use crate::rig::assembly::{Assembly, Stage};
use crate::rig::noise::white;
use crate::rig::state::{INNER_X, INNER_Y, OUTER_X, OUTER_Y};

const SETTINGS: OutsideSettings = OutsideSettings::DEFAULT;

/// Kind of effect outside the vocabulary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Stiffness of the housing that swings at a rate that is no order of the bearing.
    SwingingStiffness,
    /// Cross-coupled force on the inner race, as of a seal or an oil film.
    CrossCoupling,
    /// Damping of the housing that is negative for small motions.
    SelfExcitation,
    /// Many small impacts at random times, as of cavitation or grit.
    RandomImpacts,
    /// Tone of another machine.
    ForeignTone,
    /// Sensor with a quadratic characteristic.
    SensorCurve,
    /// Second, later and weaker copy of the signal.
    Echo,
    /// Noise of periodically changing level.
    SwellingNoise,
}

/// Alters the assembly of a recording, given by its index among the others.
pub type Alter = Box<dyn Fn(usize, &mut Assembly)>;

impl Outside {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::SwingingStiffness,
        Self::CrossCoupling,
        Self::SelfExcitation,
        Self::RandomImpacts,
        Self::ForeignTone,
        Self::SensorCurve,
        Self::Echo,
        Self::SwellingNoise,
    ];

    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::SwingingStiffness => "swinging stiffness",
            Self::CrossCoupling => "cross-coupled force",
            Self::SelfExcitation => "self-excited housing",
            Self::RandomImpacts => "random impacts",
            Self::ForeignTone => "tone of another machine",
            Self::SensorCurve => "curved sensor",
            Self::Echo => "echo",
            Self::SwellingNoise => "swelling noise",
        }
    }
}

/// Draws an effect of a kind.
pub fn draw(kind: Outside, drawn: &Drawn, without: &[Recording], rng: &mut ChaCha8Rng) -> Alter {
    let machine = &drawn.machine;
    match kind {
        Outside::SwingingStiffness => {
            let depth = uniform(SETTINGS.swing_depth, rng) * machine.outer.stiffness_n_per_m;
            let order = uniform(SETTINGS.swing_order, rng);
            Box::new(move |_, assembly| {
                assembly.force(move |at, q, _, f| {
                    let k = depth * (order * at.shaft_rad).sin();
                    f[OUTER_X] -= k * q[OUTER_X];
                    f[OUTER_Y] -= k * q[OUTER_Y];
                });
            })
        }
        Outside::CrossCoupling => {
            // Damping c ω of the inner race balances the whirl: half of it stays bounded.
            let omega = (machine.inner.stiffness_n_per_m / machine.inner.mass_kg).sqrt();
            let cross = uniform(SETTINGS.cross_coupling, rng) * machine.inner.damping_n_s_per_m * omega;
            Box::new(move |_, assembly| {
                assembly.force(move |_, q, _, f| {
                    f[INNER_X] += cross * q[INNER_Y];
                    f[INNER_Y] -= cross * q[INNER_X];
                });
            })
        }
        Outside::SelfExcitation => {
            let push = uniform(SETTINGS.negative_damping, rng) * machine.outer.damping_n_s_per_m;
            let speed = TAU * drawn.outer_hz() * uniform(SETTINGS.self_excited_m, rng);
            Box::new(move |_, assembly| {
                assembly.force(move |_, _, v, f| {
                    for dof in [OUTER_X, OUTER_Y] {
                        f[dof] += push * v[dof] / (1.0 + (v[dof] / speed).powi(2));
                    }
                });
            })
        }
        Outside::RandomImpacts => {
            let (rate_hz, seconds) = (uniform(SETTINGS.impact_rate_hz, rng), drawn.seconds());
            let size = log_within(SETTINGS.impact_n_s, rng);
            let each = Each::draw(rng);
            Box::new(move |n, assembly| {
                let times = impacts(rate_hz, seconds, size, &mut each.rng_for(n));
                assembly.force(move |at, _, _, f| {
                    let first = times.partition_point(|(t, _)| t + SETTINGS.impact_s < at.time_s);
                    for (t, impulse) in times[first..].iter().take_while(|(t, _)| *t <= at.time_s) {
                        let x = (at.time_s - t) / SETTINGS.impact_s;
                        f[OUTER_Y] += impulse / SETTINGS.impact_s * 2.0 * (std::f64::consts::PI * x).sin().powi(2);
                    }
                });
            })
        }
        Outside::ForeignTone => {
            let hz = log_within(SETTINGS.tone_hz, rng);
            let amplitude = log_within(SETTINGS.tone_amplitude, rng) * rms(without);
            let each = Each::draw(rng);
            Box::new(move |n, assembly| {
                let phase = each.rng_for(n).random_range(0.0..TAU);
                assembly.signal(Stage::Structure, move |at, signal| {
                    for (i, value) in signal.iter_mut().enumerate() {
                        *value += amplitude * (TAU * hz * at.time_s(i) + phase).sin();
                    }
                });
            })
        }
        Outside::SensorCurve => {
            let curve = uniform(SETTINGS.curvature, rng) / rms(without);
            Box::new(move |_, assembly| {
                assembly.signal(Stage::Transducer, move |_, signal| {
                    signal.iter_mut().for_each(|v| *v += curve * *v * *v);
                });
            })
        }
        Outside::Echo => {
            let (later_s, weaker) = (log_within(SETTINGS.echo_s, rng), uniform(SETTINGS.echo_gain, rng));
            Box::new(move |_, assembly| {
                assembly.preroll_s = assembly.preroll_s.max(later_s);
                assembly.signal(Stage::Structure, move |at, signal| {
                    let later = (later_s * at.sample_rate_hz).round() as usize;
                    for i in (later..signal.len()).rev() {
                        signal[i] += weaker * signal[i - later];
                    }
                });
            })
        }
        Outside::SwellingNoise => {
            let (hz, size) = (log_within(SETTINGS.swell_hz, rng), log_within(SETTINGS.swell_noise, rng));
            let std = size * machine.sensor.noise_std_m_per_s2;
            let each = Each::draw(rng);
            Box::new(move |n, assembly| {
                let mut rng = each.rng_for(n);
                let (phase, seed) = (rng.random_range(0.0..TAU), rng.random());
                assembly.signal(Stage::Structure, move |at, signal| {
                    let noise = white(seed, u64::from(at.channel == "ay"), std, signal.len());
                    for (i, (value, noise)) in signal.iter_mut().zip(noise).enumerate() {
                        *value += noise * (1.0 + (TAU * hz * at.time_s(i) + phase).sin());
                    }
                });
            })
        }
    }
}

/// Uniform draw from a range.
fn uniform([from, to]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(from..to)
}

/// Draw from a range, uniform in the logarithm.
fn log_within([from, to]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    log_uniform(from, to, rng)
}

/// Seed of what is drawn anew for every recording.
struct Each(u64);

impl Each {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        Self(rng.random())
    }

    fn rng_for(&self, recording: usize) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.0);
        rng.set_stream(recording as u64);
        rng
    }
}

/// Times, s, and impulses, N s, of impacts of a mean rate.
fn impacts(rate_hz: f64, seconds: f64, size_n_s: f64, rng: &mut ChaCha8Rng) -> Vec<(f64, f64)> {
    let mut impacts = Vec::new();
    let Ok(gap) = Exp::new(rate_hz) else { return impacts };
    let mut time = gap.sample(rng);
    while time < seconds {
        impacts.push((time, size_n_s * uniform(SETTINGS.impact_scatter, rng)));
        time += gap.sample(rng);
    }
    impacts
}

fn rms(recordings: &[Recording]) -> f64 {
    let all: Vec<f64> = recordings.iter().filter_map(|r| r.channel("ay")).flat_map(|c| c.samples.clone()).collect();
    (all.iter().map(|v| v * v).sum::<f64>() / all.len().max(1) as f64).sqrt()
}
