//! Effects that the vocabulary has no name for.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp};

use super::machine::{Drawn, log_uniform};
use crate::recording::Recording;
use crate::rig::assembly::{Assembly, Stage};
use crate::rig::noise::white;
use crate::rig::state::{INNER_X, INNER_Y, OUTER_X, OUTER_Y};

/// A kind of effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// The housing's spring swings at a rate that is no order of the bearing.
    SwingingStiffness,
    /// A force across the motion of the inner race, as of a seal or an oil film.
    CrossCoupling,
    /// Damping that is negative for small motions: the housing keeps itself in motion.
    SelfExcitation,
    /// Many small impacts at random times, as of cavitation or grit.
    RandomImpacts,
    /// A tone of another machine.
    ForeignTone,
    /// A sensor whose output is a curve.
    SensorCurve,
    /// The signal comes a second time, later and weaker.
    Echo,
    /// Noise that swells and fades.
    SwellingNoise,
}

/// Alters the plan of a recording, given by its place among the others.
pub type Alter = Box<dyn Fn(usize, &mut Assembly)>;

impl Outside {
    /// All.
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

    /// As words.
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

/// Draws one of this kind.
pub fn draw(kind: Outside, drawn: &Drawn, without: &[Recording], rng: &mut ChaCha8Rng) -> Alter {
    let machine = &drawn.machine;
    match kind {
        Outside::SwingingStiffness => {
            let depth = rng.random_range(0.1..0.3) * machine.outer.stiffness_n_per_m;
            let order = rng.random_range(0.55..0.85);
            Box::new(move |_, plan| {
                plan.force(move |at, q, _, f| {
                    let k = depth * (order * at.shaft_rad).sin();
                    f[OUTER_X] -= k * q[OUTER_X];
                    f[OUTER_Y] -= k * q[OUTER_Y];
                });
            })
        }
        Outside::CrossCoupling => {
            // The damper of the inner race takes out c ω each turn of the whirl: half of that stays bounded.
            let omega = (machine.inner.stiffness_n_per_m / machine.inner.mass_kg).sqrt();
            let cross = rng.random_range(0.3..0.6) * machine.inner.damping_n_s_per_m * omega;
            Box::new(move |_, plan| {
                plan.force(move |_, q, _, f| {
                    f[INNER_X] += cross * q[INNER_Y];
                    f[INNER_Y] -= cross * q[INNER_X];
                });
            })
        }
        Outside::SelfExcitation => {
            let push = rng.random_range(1.2..2.0) * machine.outer.damping_n_s_per_m;
            let speed = TAU * drawn.outer_hz() * rng.random_range(0.5e-7..2e-7);
            Box::new(move |_, plan| {
                plan.force(move |_, _, v, f| {
                    for dof in [OUTER_X, OUTER_Y] {
                        f[dof] += push * v[dof] / (1.0 + (v[dof] / speed).powi(2));
                    }
                });
            })
        }
        Outside::RandomImpacts => {
            let (rate_hz, seconds) = (rng.random_range(15.0..60.0), drawn.seconds());
            let size = log_uniform(0.5e-3, 4e-3, rng);
            let each = Each::draw(rng);
            Box::new(move |n, plan| {
                let times = impacts(rate_hz, seconds, size, &mut each.rng_for(n));
                plan.force(move |at, _, _, f| {
                    const LASTS_S: f64 = 2e-4;
                    let first = times.partition_point(|(t, _)| t + LASTS_S < at.time_s);
                    for (t, impulse) in times[first..].iter().take_while(|(t, _)| *t <= at.time_s) {
                        let x = (at.time_s - t) / LASTS_S;
                        f[OUTER_Y] += impulse / LASTS_S * 2.0 * (std::f64::consts::PI * x).sin().powi(2);
                    }
                });
            })
        }
        Outside::ForeignTone => {
            let hz = log_uniform(150.0, 5000.0, rng);
            let amplitude = log_uniform(0.2, 1.0, rng) * rms(without);
            let each = Each::draw(rng);
            Box::new(move |n, plan| {
                let phase = each.rng_for(n).random_range(0.0..TAU);
                plan.signal(Stage::Structure, move |at, signal| {
                    for (i, value) in signal.iter_mut().enumerate() {
                        *value += amplitude * (TAU * hz * at.time_s(i) + phase).sin();
                    }
                });
            })
        }
        Outside::SensorCurve => {
            let curve = rng.random_range(0.05..0.2) / rms(without);
            Box::new(move |_, plan| {
                plan.signal(Stage::Transducer, move |_, signal| {
                    signal.iter_mut().for_each(|v| *v += curve * *v * *v);
                });
            })
        }
        Outside::Echo => {
            let (later_s, weaker) = (log_uniform(3e-4, 5e-3, rng), rng.random_range(0.3..0.7));
            Box::new(move |_, plan| {
                plan.preroll_s = plan.preroll_s.max(later_s);
                plan.signal(Stage::Structure, move |at, signal| {
                    let later = (later_s * at.sample_rate_hz).round() as usize;
                    for i in (later..signal.len()).rev() {
                        signal[i] += weaker * signal[i - later];
                    }
                });
            })
        }
        Outside::SwellingNoise => {
            let (hz, size) = (log_uniform(1.5, 8.0, rng), log_uniform(1.5, 5.0, rng));
            let std = size * machine.sensor.noise_std_m_per_s2;
            let each = Each::draw(rng);
            Box::new(move |n, plan| {
                let mut rng = each.rng_for(n);
                let (phase, seed) = (rng.random_range(0.0..TAU), rng.random());
                plan.signal(Stage::Structure, move |at, signal| {
                    let noise = white(seed, u64::from(at.channel == "ay"), std, signal.len());
                    for (i, (value, noise)) in signal.iter_mut().zip(noise).enumerate() {
                        *value += noise * (1.0 + (TAU * hz * at.time_s(i) + phase).sin());
                    }
                });
            })
        }
    }
}

/// What is drawn anew for every recording.
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

/// Times, s, and impulses, N s, of impacts that come at a rate.
fn impacts(rate_hz: f64, seconds: f64, size_n_s: f64, rng: &mut ChaCha8Rng) -> Vec<(f64, f64)> {
    let mut impacts = Vec::new();
    let Ok(gap) = Exp::new(rate_hz) else { return impacts };
    let mut time = gap.sample(rng);
    while time < seconds {
        impacts.push((time, size_n_s * rng.random_range(0.3..1.7)));
        time += gap.sample(rng);
    }
    impacts
}

fn rms(recordings: &[Recording]) -> f64 {
    let all: Vec<f64> = recordings.iter().filter_map(|r| r.channel("ay")).flat_map(|c| c.samples.clone()).collect();
    (all.iter().map(|v| v * v).sum::<f64>() / all.len().max(1) as f64).sqrt()
}
