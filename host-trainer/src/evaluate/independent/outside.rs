//! Effects outside the vocabulary, other ones than those of the shared simulator.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::effects::{Apply, Context, Strength, log_within, within};
use super::noise::white;
use super::plant::{INNER_X, INNER_Y, OUTER_X, OUTER_Y, Stage};
use super::settings::OutsideSettings;

const SETTINGS: OutsideSettings = OutsideSettings::DEFAULT;

/// Kind of effect outside the vocabulary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Force of a belt, at a fraction of the shaft's speed and its multiples.
    Belt,
    /// Force of a gear mesh, modulated once a turn.
    GearMesh,
    /// Random force of a flow, of a level that changes once a turn.
    FlowNoise,
    /// One ball that is larger than the others.
    OversizeBall,
    /// Part of one channel in the other.
    CrossTalk,
    /// Gain that swings slowly, as of a loose connector.
    SwingingGain,
    /// Single samples that are far off, at random times.
    Spikes,
    /// Converter with too few steps.
    CoarseConverter,
}

impl Outside {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Belt,
        Self::GearMesh,
        Self::FlowNoise,
        Self::OversizeBall,
        Self::CrossTalk,
        Self::SwingingGain,
        Self::Spikes,
        Self::CoarseConverter,
    ];

    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Belt => "belt force",
            Self::GearMesh => "gear mesh",
            Self::FlowNoise => "flow noise",
            Self::OversizeBall => "oversize ball",
            Self::CrossTalk => "cross-talk",
            Self::SwingingGain => "swinging gain",
            Self::Spikes => "spikes",
            Self::CoarseConverter => "coarse converter",
        }
    }
}

/// Draws an effect of a kind: how its strength is measured, and what puts it into a machine.
pub fn draw(kind: Outside, context: &Context, rng: &mut ChaCha8Rng) -> (Strength, Apply) {
    let load = context.drawn.load_n();
    let seed: u64 = rng.random();
    let each = move |n: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(n as u64);
        rng
    };
    let loudest = context.rms[0].max(context.rms[1]);
    match kind {
        Outside::Belt => {
            let order = within(SETTINGS.belt_order, rng);
            let parts: Vec<[f64; 4]> = (1..=4)
                .map(|k| [f64::from(k), 1.0 / f64::from(k), within([-PI, PI], rng), within([-PI, PI], rng)])
                .collect();
            let apply: Apply = Box::new(move |size, _, plant| {
                let parts = parts.clone();
                plant.forces.push(Box::new(move |m, _, _, f| {
                    for [k, share, x, y] in &parts {
                        f[INNER_X] += size * share * (k * order * m.shaft_rad + x).cos();
                        f[INNER_Y] += size * share * (k * order * m.shaft_rad + y).cos();
                    }
                }));
            });
            (Strength::Lasting([1e-4 * load, 1.5 * load]), apply)
        }
        Outside::GearMesh => {
            let teeth = rng.random_range(SETTINGS.teeth[0]..SETTINGS.teeth[1]) as f64;
            let (depth, angle) = (within(SETTINGS.mesh_depth, rng), within([-PI, PI], rng));
            let apply: Apply = Box::new(move |size, _, plant| {
                plant.forces.push(Box::new(move |m, _, _, f| {
                    let level = size * (1.0 + depth * m.shaft_rad.cos());
                    let mesh = (teeth * m.shaft_rad).cos() + 0.4 * (2.0 * teeth * m.shaft_rad + angle).cos();
                    f[INNER_X] += level * mesh * angle.cos();
                    f[INNER_Y] += level * mesh * angle.sin();
                }));
            });
            (Strength::Lasting([1e-5 * load, 3.0 * load]), apply)
        }
        Outside::FlowNoise => {
            let apply: Apply = Box::new(move |size, n, plant| {
                let rate = SETTINGS.flow_rate_hz;
                let noise = white(seed, n as u64, (rate * SETTINGS.flow_noise_s) as usize);
                plant.forces.push(Box::new(move |m, _, _, f| {
                    // Before the first sample too, and over again after its length.
                    let index = ((m.time_s * rate).floor() as i64).rem_euclid(noise.len() as i64) as usize;
                    let force = size * noise[index] * (1.0 + m.shaft_rad.cos());
                    f[OUTER_X] += force;
                    f[OUTER_Y] += force;
                }));
            });
            (Strength::Lasting([1e-3, 1e3]), apply)
        }
        Outside::OversizeBall => {
            let ball = rng.random_range(0..context.drawn.machine.bearing.balls);
            let apply: Apply = Box::new(move |size, _, plant| {
                plant.losses.push(Box::new(move |_, j, _| if j == ball { -size } else { 0.0 }));
            });
            (Strength::Lasting([1e-8, 2e-5]), apply)
        }
        Outside::CrossTalk => {
            let to = rng.random_range(0..2usize);
            let apply: Apply = Box::new(move |size, _, plant| {
                plant.both.push(Box::new(move |_, channels| {
                    let [ax, ay] = channels;
                    let (into, from) = if to == 0 { (ax, &*ay) } else { (ay, &*ax) };
                    into.iter_mut().zip(from).for_each(|(v, other)| *v += size * other);
                }));
            });
            (Strength::Lasting([1e-2, 30.0]), apply)
        }
        Outside::SwingingGain => {
            let hz = log_within(SETTINGS.gain_hz, rng);
            let apply: Apply = Box::new(move |size, n, plant| {
                let phase = each(n).random_range(-PI..PI);
                plant.signals.push((
                    Stage::Cable,
                    Box::new(move |index, rate, samples| {
                        if index < 2 {
                            let swing = |i: usize| 1.0 + size * (TAU * hz * i as f64 / rate + phase).sin();
                            samples.iter_mut().enumerate().for_each(|(i, v)| *v *= swing(i));
                        }
                    }),
                ));
            });
            (Strength::Lasting([0.05, 0.9]), apply)
        }
        Outside::Spikes => {
            let rate_hz = log_within(SETTINGS.spikes_hz, rng);
            let apply: Apply = Box::new(move |size, n, plant| {
                plant.signals.push((
                    Stage::Cable,
                    Box::new(move |index, rate, samples| {
                        if index < 2 {
                            let mut rng = each(2 * n + index);
                            let chance = (rate_hz / rate).min(1.0);
                            for v in samples {
                                if rng.random_bool(chance) {
                                    *v += size * within([-1.0, 1.0], &mut rng);
                                }
                            }
                        }
                    }),
                ));
            });
            (Strength::Lasting([0.1 * loudest, 100.0 * loudest]), apply)
        }
        Outside::CoarseConverter => {
            let apply: Apply = Box::new(move |step, _, plant| {
                plant.signals.push((
                    Stage::Converter,
                    Box::new(move |index, _, samples| {
                        if index < 2 {
                            samples.iter_mut().for_each(|v| *v = (*v / step).floor() * step + 0.5 * step);
                        }
                    }),
                ));
            });
            (Strength::Lasting([0.05 * loudest, 4.0 * loudest]), apply)
        }
    }
}
