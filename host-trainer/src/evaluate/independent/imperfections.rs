//! Imperfections that every real machine has, and that no drawing states.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::motion::Wander;
use super::plant::Plant;
use super::settings::ImperfectionSettings;

const SETTINGS: ImperfectionSettings = ImperfectionSettings::DEFAULT;

/// Imperfections of a machine and of each of its recordings.
#[derive(Clone, Debug)]
pub struct Imperfections {
    balls_rad: Vec<f64>,
    colour: [Vec<f64>; 3],
    noise_factor: [f64; 2],
    offset: [f64; 2],
    each: Vec<EachRecording>,
}

#[derive(Clone, Debug)]
struct EachRecording {
    speed: f64,
    load: f64,
    slip: f64,
    shaft: Wander,
    cage: Wander,
}

impl Imperfections {
    /// Draws the imperfections of a machine with `balls` balls and `recordings` recordings, by `size`: 1 is a machine as
    /// machines are, 0 a machine as its drawing says.
    pub fn draw(size: f64, balls: usize, recordings: usize, noise_std: f64, rng: &mut ChaCha8Rng) -> Self {
        let mut normal = |std: f64| -> f64 {
            let unit: f64 = StandardNormal.sample(rng);
            size * std * unit.clamp(-SETTINGS.most_sigmas, SETTINGS.most_sigmas)
        };
        let balls_rad = (0..balls).map(|_| normal(SETTINGS.ball_spacing_rad)).collect();
        let mut curve = || (1..=SETTINGS.colour_terms).map(|k| normal(SETTINGS.colour_np / k as f64)).collect();
        let colour = [curve(), curve(), curve()];
        let noise_factor = [0, 1].map(|_| normal(SETTINGS.noise_level).exp());
        let offset = [0, 1].map(|_| normal(SETTINGS.offset_of_noise * noise_std));
        let [least, most] = SETTINGS.load_std;
        let load_std = rng.random_range(least..most);
        // A machine that wanders little does so in all of its recordings.
        let log = |[low, high]: [f64; 2], rng: &mut ChaCha8Rng| low * (high / low).powf(rng.random::<f64>());
        let (shaft_rms, cage_rms) = (log(SETTINGS.shaft_wander, rng), log(SETTINGS.cage_wander, rng));
        let slip = rng.random_range(0.0..SETTINGS.most_slip);
        let each = (0..recordings)
            .map(|_| {
                let mut unit = || -> f64 {
                    let unit: f64 = StandardNormal.sample(rng);
                    unit.clamp(-SETTINGS.most_sigmas, SETTINGS.most_sigmas)
                };
                let (speed, load) = (size * SETTINGS.speed_std * unit(), size * load_std * unit());
                let slip = size * (slip * rng.random_range(0.7..1.3)).min(SETTINGS.most_slip);
                let wander = |rms: f64, rng: &mut ChaCha8Rng| {
                    Wander::draw(size * rms, SETTINGS.wander_hz, SETTINGS.wander_tones, rng)
                };
                EachRecording { speed, load, slip, shaft: wander(shaft_rms, rng), cage: wander(cage_rms, rng) }
            })
            .collect();
        Self { balls_rad, colour, noise_factor, offset, each }
    }

    /// Puts the imperfections of a recording into its machine.
    pub fn apply(&self, recording: usize, plant: &mut Plant) {
        let each = &self.each[recording];
        plant.pace.shaft_hz *= 1.0 + each.speed;
        plant.load_n *= 1.0 + each.load;
        plant.pace.slip = 1.0 - (1.0 - plant.pace.slip) * (1.0 - each.slip);
        plant.pace.shaft_wander = each.shaft.clone();
        plant.pace.cage_wander = each.cage.clone();
        plant.balls_rad.iter_mut().zip(&self.balls_rad).for_each(|(angle, error)| *angle += error);
        plant.colour = self.colour.clone();
        plant.noise = self.noise_factor;
        plant.offset = self.offset;
    }
}
