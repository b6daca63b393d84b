//! Colours of the noise: what the noises of a machine's channels and of its process force have beyond those of its rig.

use std::f64::consts::PI;
use std::sync::Arc;

use super::observation::{Observation, Power};
use super::prediction::Prediction;
use super::settings::LikelihoodSettings;
use crate::identify::likelihood::observed::CHANNELS;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;
/// Values of a noise's colour in a channel.
pub const KNOTS: usize = SETTINGS.knots.len();

/// Colours of the noise: of each channel, and of the process force.
pub const COLOURS: usize = 3;
/// Index of the process force's colour.
pub const PROCESS: usize = 2;

/// Logarithms of the noise's colours at the knots, Np of power.
pub type Colour = [[f64; KNOTS]; COLOURS];

/// What a recording's colours of its channels have of their own, Np of power.
pub type OwnColour = [[f64; KNOTS]; CHANNELS.len()];

/// Colours of a recording: those of all, and what it has of its own.
pub fn colour_with(colour: &Colour, own: &OwnColour) -> Colour {
    let mut colour = *colour;
    colour.iter_mut().zip(own).for_each(|(all, own)| all.iter_mut().zip(own).for_each(|(all, own)| *all += own));
    colour
}

/// Knots around each bin of a recording: number of the lower one, and share of the upper one.
pub fn hats(observation: &Observation) -> Vec<(usize, f64)> {
    let half = 0.5 * observation.condition.samples as f64;
    let knots = SETTINGS.knots.map(f64::ln);
    let of = |k: usize| {
        let at = (k.max(1) as f64 / half).ln();
        let lower = knots[..KNOTS - 1].partition_point(|knot| *knot <= at).clamp(1, KNOTS - 1) - 1;
        (lower, ((at - knots[lower]) / (knots[lower + 1] - knots[lower])).clamp(0.0, 1.0))
    };
    (0..=observation.condition.samples / 2).map(of).collect()
}

/// Logarithm of a channel's colour at a bin with its knots, Np of power.
pub fn colour_at(colour: &[f64; KNOTS], (knot, share): (usize, f64)) -> f64 {
    colour[knot] * (1.0 - share) + colour[knot + 1] * share
}

impl Prediction {
    /// Coloured noise of a channel over that of the rig at a bin with its knots.
    pub fn colouring(&self, colour: &Colour, channel: usize, hat: (usize, f64), k: usize) -> f64 {
        let process = self.process_share[channel][k];
        colour_at(&colour[channel], hat).exp() * (1.0 + process * colour_at(&colour[PROCESS], hat).exp_m1())
    }
}

/// Noise of a prediction in a colour, at each bin.
#[derive(Clone, Debug)]
pub struct ColouredNoise {
    plain: Arc<Power>,
    /// Colour.
    pub colour: Colour,
    /// Power of each channel.
    pub power: Arc<Power>,
}

impl ColouredNoise {
    /// Noise of a prediction in a colour; `before` itself if that is the same.
    pub fn new(before: Option<&Self>, prediction: &Prediction, colour: &Colour, hats: &[(usize, f64)]) -> Self {
        if let Some(before) = before.filter(|b| Arc::ptr_eq(&b.plain, &prediction.noise) && b.colour == *colour) {
            return before.clone();
        }
        let plain = Arc::clone(&prediction.noise);
        if *colour == Colour::default() {
            return Self { power: Arc::clone(&plain), plain, colour: *colour };
        }
        let of = |channel: usize| {
            let bins = plain[channel].iter().zip(hats).enumerate();
            bins.map(|(k, (plain, hat))| plain * prediction.colouring(colour, channel, *hat, k)).collect()
        };
        Self { power: Arc::new([0, 1].map(of)), plain, colour: *colour }
    }
}

/// Covariance of a colour before any recording.
pub fn colour_covariance(a: usize, b: usize) -> f64 {
    let roll_off = |knot: usize| SETTINGS.roll_off_np * SETTINGS.knots[knot].powi(2);
    without_roll_off(a, b) + roll_off(a) * roll_off(b)
}

/// Covariance of what a recording's colour has of its own.
pub fn own_colour_covariance(a: usize, b: usize) -> f64 {
    SETTINGS.own_colour_std.powi(2) * without_roll_off(a, b)
}

fn without_roll_off(a: usize, b: usize) -> f64 {
    let own = if a == b { SETTINGS.knot_np.powi(2) } else { 0.0 };
    let cosine = |k: usize, knot: usize| SETTINGS.cosine_np / k as f64 * (PI * k as f64 * SETTINGS.knots[knot]).cos();
    let cosines: f64 = (1..=SETTINGS.cosines).map(|k| cosine(k, a) * cosine(k, b)).sum();
    SETTINGS.level_np.powi(2) + cosines + own
}
