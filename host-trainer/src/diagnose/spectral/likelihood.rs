//! Likelihood of power spectra under a prediction.
//!
//! Phases of lines are not used: a wandering speed, a slipping cage or unevenly spaced balls take them away first. That between
//! the channels is left to `cross`. A bin's power is
//! distributed around c (N + p P) + V: N and P the noise of the rig's sensor and process force, c and p their colours, V the power
//! of the rig's lines ([`Density`]).

use std::f64::consts::TAU;

use super::colour::{ColouredNoise, PROCESS, colour_at};
use super::density::{Bin, Density, LEAST_SHARE, ORDINARY};
use super::observation::{Observation, Power};
use super::place::Place;
use super::prediction::{Lines, Prediction, Skirts};
use super::settings::{FORMS, LikelihoodSettings};
use super::sidebands::Sidebands;
use super::stretch::Stretch;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;
/// Spectrum of a channel under a prediction.
pub struct Channel<'a> {
    /// Recording.
    pub observation: &'a Observation,
    /// Prediction.
    pub prediction: &'a Prediction,
    /// Knots around each bin.
    pub hats: &'a [(usize, f64)],
    /// Noise in its colour.
    pub coloured: &'a ColouredNoise,
    /// Stretch of the lines.
    pub stretch: Stretch,
    /// What the jitter of the ball passes takes from a line at each bin; empty without any.
    pub jitter: &'a [Jitter],
    /// Share that uneven balls take; empty if they are even.
    pub spacing: &'a [f64],
    /// Number of the order of the cage from the nearest line, of each bin; empty where these are not told apart.
    pub cage_orders: &'a [usize],
    /// Weights of these orders.
    pub sidebands: &'a Sidebands,
    /// Power of the lines of each error of form, over that of the simulated machines.
    pub form: [f64; FORMS],
    /// Index of the channel.
    pub channel: usize,
}

impl Channel<'_> {
    /// Coloured noise at a bin.
    pub fn noise(&self, k: usize) -> f64 {
        self.coloured.power[self.channel][k]
    }

    /// Share of the process force in the coloured noise at a bin.
    pub fn process_share(&self, k: usize) -> f64 {
        let process = self.prediction.process_share[self.channel][k]
            * colour_at(&self.coloured.colour[PROCESS], self.hats[k]).exp();
        process / (1.0 - self.prediction.process_share[self.channel][k] + process)
    }

    /// Power of lines at a bin.
    pub fn line(&self, k: usize) -> f64 {
        self.outer_line(k) + self.inner_line(k)
    }

    /// Power of lines at a bin without the effects of the inner race.
    pub fn outer_line(&self, k: usize) -> f64 {
        self.rig_line(k) + self.formed(k).power
    }

    /// The same of the rig, whose form has no errors.
    pub fn rig_line(&self, k: usize) -> f64 {
        self.rig_lines(k).power
    }

    fn rig_lines(&self, k: usize) -> Line {
        let place = Place::new(k, self.stretch.outer);
        let weight = self.cage_order(place).map_or(1.0, |order| self.sidebands.weight(order));
        self.spread(&self.prediction.outer, place, weight, k)
    }

    /// Number of the order of the cage beside a line at a bin, and what uneven balls put there.
    pub fn sideband(&self, k: usize) -> Option<(usize, f64)> {
        let place = Place::new(k, self.stretch.outer);
        let order = self.cage_order(place).filter(|order| *order > 0)?;
        let spaced = place.of(&self.prediction.outer.spaced[self.channel]);
        Some((order, self.spacing.get(k)? * self.sidebands.weight(order) * spaced))
    }

    fn cage_order(&self, place: Place) -> Option<usize> {
        self.cage_orders.get(place.lower).copied()
    }

    /// Power of what errors of form add.
    fn formed(&self, k: usize) -> Line {
        let Some(formed) = self.prediction.formed.as_ref().filter(|_| self.form != [0.0; FORMS]) else {
            return Line::default();
        };
        let place = Place::new(k, self.stretch.outer);
        let added = self.form.iter().zip(formed.iter()).filter(|(form, _)| **form > 0.0);
        let each = added.map(|(form, (power, skirts))| self.jittered(power, skirts, place, k).times(*form));
        each.fold(Line::default(), Line::plus)
    }

    /// Power of what these add.
    pub fn inner_line(&self, k: usize) -> f64 {
        self.inner_lines(k).power
    }

    fn inner_lines(&self, k: usize) -> Line {
        let place = Place::new(k, self.stretch.inner);
        self.prediction.inner.as_ref().map_or(Line::default(), |lines| self.spread(lines, place, 1.0, k))
    }

    fn spread(&self, lines: &Lines, place: Place, weight: f64, k: usize) -> Line {
        let line = self.jittered(&lines.power, &lines.skirts, place, k);
        let Some(share) = self.spacing.get(k) else { return line };
        let spaced = weight * place.of(&lines.spaced[self.channel]);
        Line { power: spread(line.power, spaced, *share), skirt: (1.0 - share) * line.skirt }
    }

    fn jittered(&self, power: &Power, skirts: &Skirts, place: Place, k: usize) -> Line {
        let line = place.of(&power[self.channel]);
        let Some(jitter) = self.jitter.get(k) else { return Line { power: line, skirt: 0.0 } };
        let skirt = |width: usize| place.of(&skirts[width][self.channel]);
        let Place { lower, share } = jitter.width;
        let wide = if share > 0.0 { spread(skirt(lower), skirt(lower + 1), share) } else { skirt(lower) };
        Line { power: spread(line, wide, jitter.share), skirt: jitter.share * wide }
    }

    /// Every bin of the likelihood; none of a channel that was not recorded.
    pub fn bins(&self) -> impl Iterator<Item = Expected> + '_ {
        let power = self.observation.power[self.channel].as_deref().unwrap_or_default();
        let bins = if power.is_empty() { 0..0 } else { self.observation.bins() };
        bins.map(move |k| {
            let formed = self.formed(k);
            let line = self.rig_lines(k).plus(formed).plus(self.inner_lines(k));
            let (line, skirt) = (line.power, line.skirt);
            Expected { k, power: power[k], noise: self.noise(k), line, formed: formed.power, skirt }
        })
    }

    /// Density of a bin at its power.
    pub fn bin(&self, expected: &Expected) -> Bin {
        expected.density().bin(expected.power, self.ln_power(expected.k))
    }

    fn ln_power(&self, k: usize) -> f64 {
        self.observation.ln_power[self.channel].as_ref().map_or(0.0, |all| all[k])
    }

    /// −ln L.
    pub fn neg_log_likelihood(&self) -> f64 {
        // The logarithm of a product is cheaper than a sum of logarithms.
        const RANGE: std::ops::Range<f64> = 1e-150..1e150;
        let (mut sum, mut product) = (0.0, 1.0);
        for expected in self.bins() {
            let mean = expected.mean();
            let ratio = expected.power / mean;
            let is_noise = (expected.line - expected.formed).max(expected.skirt) < LEAST_SHARE * mean;
            if is_noise && ratio < ORDINARY[1] {
                sum += ratio;
                product *= mean;
                if !RANGE.contains(&product) {
                    sum += product.ln();
                    product = 1.0;
                }
            } else {
                sum += expected.density().neg_log(expected.power, self.ln_power(expected.k));
            }
        }
        sum + product.ln()
    }
}

/// A bin's power and what is expected there.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    /// Number of the bin.
    pub k: usize,
    /// Measured power.
    pub power: f64,
    /// Coloured noise.
    pub noise: f64,
    /// Lines.
    pub line: f64,
    /// Part of them that errors of form add.
    pub formed: f64,
    /// Part of them that a wandering rotation spreads over several bins.
    pub skirt: f64,
}

/// Power of lines at a bin.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    /// All of it.
    power: f64,
    /// Part that a wandering rotation spreads.
    skirt: f64,
}

impl Line {
    fn times(self, factor: f64) -> Self {
        Self { power: factor * self.power, skirt: factor * self.skirt }
    }

    fn plus(self, other: Self) -> Self {
        Self { power: self.power + other.power, skirt: self.skirt + other.skirt }
    }
}

impl Expected {
    /// Mean of the power.
    pub fn mean(&self) -> f64 {
        self.noise + self.line
    }

    /// Share of the mean that is lines spread over several bins, whose powers are off alike.
    pub fn skirt_share(&self) -> f64 {
        self.skirt / self.mean()
    }

    /// Share of the mean that is a line without errors of form.
    pub fn line_share(&self) -> f64 {
        (self.line - self.formed) / self.mean()
    }

    /// Density of the power. How a machine has its errors of form over its lines is as random as noise.
    fn density(&self) -> Density {
        let mean = self.mean();
        if self.skirt > (self.line - self.skirt).max(LEAST_SHARE * mean) {
            return Density::spread(mean, self.skirt / mean);
        }
        Density::new(self.noise + self.formed, self.line - self.formed)
    }
}

fn spread(power: f64, to: f64, share: f64) -> f64 {
    power + share * (to - power)
}

/// What a jitter of the ball passes takes from a line.
#[derive(Clone, Copy, Debug)]
pub struct Jitter {
    /// Share of its power.
    share: f64,
    /// Place of the half width to which that is spread among those of the settings.
    width: Place,
}

/// What a jitter of the ball passes takes from a line at each bin of a recording, s; empty without any. A phase of a standard deviation
/// φ > 1 spreads a line φ times as wide as it is fast (P. M. Woodward, "The spectrum of random frequency modulation", 1952).
pub fn jitters(observation: &Observation, jitter_s: f64) -> Vec<Jitter> {
    let phase = |hz: f64| TAU * hz * jitter_s;
    let width = |(k, share): (usize, f64)| {
        let wide = phase(observation.hz(k as f64)).max(1.0);
        Jitter { share, width: Place::among(&SETTINGS.wander_widths, wide) }
    };
    shares(observation, phase).into_iter().enumerate().map(width).collect()
}

/// Shares of a line's power at each bin of a recording that balls take whose places in the cage scatter, rad.
pub fn spacing_shares(observation: &Observation, spacing_rad: f64, cage_per_shaft: f64) -> Vec<f64> {
    shares(observation, |hz| hz / (cage_per_shaft * observation.condition.shaft_hz).max(1e-9) * spacing_rad)
}

/// Shares of a line's power that a phase of a standard deviation takes, rad; empty without any.
fn shares(observation: &Observation, phase: impl Fn(f64) -> f64) -> Vec<f64> {
    if phase(1.0) == 0.0 {
        return Vec::new();
    }
    (0..observation.bins().end).map(|k| -(-phase(observation.hz(k as f64)).powi(2)).exp_m1()).collect()
}
