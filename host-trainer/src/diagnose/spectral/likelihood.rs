//! Likelihood of power spectra under a prediction.
//!
//! Phases of lines are not used: a wandering speed, a slipping cage or unevenly spaced balls take them away first. That between
//! the channels is left to `cross`. A bin's power is
//! gamma distributed around c (N + p P) + V: N and P the noise of the rig's sensor and process force, c and p their colours, V
//! the power of the rig's lines. The power of noise
//! is exponential (P. Whittle, Arkiv för Matematik 2 (1953) 423–434); that of a line has the relative variance of the machine
//! against the rig. A few bins are neither.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, LazyLock};

use statrs::function::gamma::ln_gamma;

use super::observation::{Observation, Power};
use super::prediction::{Lines, Prediction, Skirts};
use super::settings::{FORMS, LikelihoodSettings};
use super::sidebands::Sidebands;
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
    colour: Colour,
    power: Arc<Power>,
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

/// A bin under a prediction.
#[derive(Clone, Copy, Debug)]
pub struct Bin {
    /// −ln of the density.
    pub neg_log: f64,
    /// Weight times shape: information of the logarithm of the mean.
    pub information: f64,
    /// Slope of −ln of the density by the logarithm of the mean.
    pub slope: f64,
}

/// Density of a bin's power under noise and line.
#[derive(Clone, Copy, Debug)]
pub struct Density {
    mean: f64,
    ln_mean: f64,
    /// Shape k of the gamma density.
    shape: f64,
    /// ln Γ(k) − k ln k.
    shape_term: f64,
}

impl Density {
    /// Density around a mean of noise and line.
    pub fn new(noise: f64, line: f64) -> Self {
        let mean = noise + line;
        let (shape, shape_term) = shape(line / mean);
        Self { mean, ln_mean: mean.ln(), shape, shape_term }
    }

    /// Whether the density of outliers adds nothing at a power.
    fn is_ordinary(&self, ratio: f64) -> bool {
        ratio < ORDINARY[1] && (self.shape == 1.0 || ratio > ORDINARY[0])
    }

    /// −ln of the gamma density.
    fn gamma(&self, ratio: f64, ln_power: f64) -> f64 {
        if self.shape == 1.0 {
            return self.ln_mean + ratio;
        }
        let ln_ratio = (ln_power - self.ln_mean).max(LEAST_LN_RATIO);
        self.shape * ratio + self.shape_term - (self.shape - 1.0) * ln_ratio + self.ln_mean
    }

    /// −ln of the density of outliers, times their share. A Pareto density, so that one strong line that is not predicted does
    /// not outweigh all others.
    fn outlier(&self, power: f64) -> f64 {
        let wide = SETTINGS.outlier_power * self.mean;
        self.ln_mean + (SETTINGS.outlier_power / SETTINGS.outliers).ln() + 2.0 * (power / wide).ln_1p()
    }

    /// −ln of the density at a power with its logarithm.
    pub fn neg_log(&self, power: f64, ln_power: f64) -> f64 {
        let ratio = power / self.mean;
        let gamma = self.gamma(ratio, ln_power);
        if self.is_ordinary(ratio) { gamma } else { least_of(gamma, self.outlier(power)) }
    }

    /// −ln of the density at a power, with its slope and information.
    pub fn bin(&self, power: f64, ln_power: f64) -> Bin {
        let (ratio, shape) = (power / self.mean, self.shape);
        let gamma = self.gamma(ratio, ln_power);
        if self.is_ordinary(ratio) {
            return Bin { neg_log: gamma, information: shape, slope: shape * (1.0 - ratio) };
        }
        let outlier = self.outlier(power);
        let weight = 1.0 / (1.0 + (gamma - outlier).exp());
        let wide = SETTINGS.outlier_power * self.mean;
        let of_outlier = (1.0 - weight) * (1.0 - 2.0 * power / (wide + power));
        let slope = weight * shape * (1.0 - ratio) + of_outlier;
        Bin { neg_log: least_of(gamma, outlier), information: weight * shape, slope }
    }
}

/// Power over the mean between which the density of outliers adds nothing.
pub const ORDINARY: [f64; 2] = [0.3, 4.0];
/// Bound on the logarithm of power over mean.
const LEAST_LN_RATIO: f64 = -27.6;
/// Share of a line below which a bin counts as noise.
const LEAST_SHARE: f64 = 0.05;

/// −ln(e^−a + e^−b).
fn least_of(a: f64, b: f64) -> f64 {
    let apart = (a - b).abs();
    // Beyond that it adds less than a rounding.
    if apart > 40.0 { a.min(b) } else { a.min(b) - (-apart).exp().ln_1p() }
}

/// Shape k of the gamma density of a bin with a line's share of its mean, and ln Γ(k) − k ln k.
fn shape(share: f64) -> (f64, f64) {
    const STEPS: usize = 1024;
    static TERMS: LazyLock<Vec<f64>> = LazyLock::new(|| {
        let shape = |n: usize| shape_of(n as f64 / STEPS as f64);
        (0..=STEPS).map(shape).map(|k| ln_gamma(k) - k * k.ln()).collect()
    });
    if share < LEAST_SHARE { (1.0, 0.0) } else { (shape_of(share), Place::at(share * STEPS as f64).of(&TERMS)) }
}

/// Shape of the gamma density of a bin with a line's share of its mean.
pub fn shape_of(share: f64) -> f64 {
    1.0 / (1.0 - share * share * (1.0 - SETTINGS.line_variance))
}

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
        self.rig_line(k) + self.formed(k)
    }

    /// The same of the rig, whose form has no errors.
    pub fn rig_line(&self, k: usize) -> f64 {
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
    fn formed(&self, k: usize) -> f64 {
        let Some(formed) = self.prediction.formed.as_ref().filter(|_| self.form != [0.0; FORMS]) else { return 0.0 };
        let place = Place::new(k, self.stretch.outer);
        let added = self.form.iter().zip(formed.iter()).filter(|(form, _)| **form > 0.0);
        added.map(|(form, (power, skirts))| form * self.jittered(power, skirts, place, k)).sum()
    }

    /// Power of what these add.
    pub fn inner_line(&self, k: usize) -> f64 {
        let place = Place::new(k, self.stretch.inner);
        self.prediction.inner.as_ref().map_or(0.0, |lines| self.spread(lines, place, 1.0, k))
    }

    fn spread(&self, lines: &Lines, place: Place, weight: f64, k: usize) -> f64 {
        let line = self.jittered(&lines.power, &lines.skirts, place, k);
        let spaced = || weight * place.of(&lines.spaced[self.channel]);
        self.spacing.get(k).map_or(line, |share| spread(line, spaced(), *share))
    }

    fn jittered(&self, power: &Power, skirts: &Skirts, place: Place, k: usize) -> f64 {
        let line = place.of(&power[self.channel]);
        let Some(jitter) = self.jitter.get(k) else { return line };
        let skirt = |width: usize| place.of(&skirts[width][self.channel]);
        let Place { lower, share } = jitter.width;
        let wide = if share > 0.0 { spread(skirt(lower), skirt(lower + 1), share) } else { skirt(lower) };
        spread(line, wide, jitter.share)
    }

    /// Every bin of the likelihood; none of a channel that was not recorded.
    pub fn bins(&self) -> impl Iterator<Item = Expected> + '_ {
        let power = self.observation.power[self.channel].as_deref().unwrap_or_default();
        let bins = if power.is_empty() { 0..0 } else { self.observation.bins() };
        bins.map(move |k| {
            let formed = self.formed(k);
            let line = self.rig_line(k) + formed + self.inner_line(k);
            Expected { k, power: power[k], noise: self.noise(k), line, formed }
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
            if expected.line - expected.formed < LEAST_SHARE * mean && ratio < ORDINARY[1] {
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
}

impl Expected {
    /// Mean of the power.
    pub fn mean(&self) -> f64 {
        self.noise + self.line
    }

    /// Share of the mean that is a line without errors of form.
    pub fn line_share(&self) -> f64 {
        (self.line - self.formed) / self.mean()
    }

    /// Density of the power. How a machine has its errors of form over its lines is as random as noise.
    fn density(&self) -> Density {
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

/// Place between two values of a list.
#[derive(Clone, Copy, Debug)]
struct Place {
    lower: usize,
    /// Share of the upper bin.
    share: f64,
}

impl Place {
    /// Place from which a stretch moves lines to a bin.
    fn new(k: usize, stretch: f64) -> Self {
        Self::at(k as f64 / (1.0 + stretch))
    }

    /// Place of a value among rising ones by its logarithm, within the first and the last.
    fn among(values: &[f64], value: f64) -> Self {
        let last = values.len() - 1;
        let lower = values[..last].partition_point(|v| *v <= value).max(1) - 1;
        let share = (value / values[lower]).ln() / (values[lower + 1] / values[lower]).ln();
        if share < 1.0 { Self { lower, share: share.max(0.0) } } else { Self { lower: last, share: 0.0 } }
    }

    fn at(place: f64) -> Self {
        let lower = place as usize;
        Self { lower, share: place - lower as f64 }
    }

    /// Value there.
    fn of(self, values: &[f64]) -> f64 {
        match values.get(self.lower..self.lower + 2) {
            Some(&[lower, upper]) => lower * (1.0 - self.share) + upper * self.share,
            _ => values.last().copied().unwrap_or_default(),
        }
    }
}

/// Frequencies of lines over those predicted, less 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Of the balls' passes over the outer race: stated speed less slip of the cage.
    pub outer: f64,
    /// Of the inner race: stated speed and what the slip adds.
    pub inner: f64,
}

impl Stretch {
    /// −ln of the prior of a stretch without lines of the inner race.
    pub fn outer_prior(observation: &Observation, outer: f64) -> f64 {
        let std = SETTINGS.slip_std.hypot(observation.speed_std);
        0.5 * ((outer + SETTINGS.slip_mean) / std).powi(2)
    }

    /// −ln of the prior with such lines; `cage_per_shaft` is the order of the cage.
    pub fn prior(self, observation: &Observation, cage_per_shaft: f64) -> f64 {
        // outer = speed − slip, inner = speed + slip times the cage's speed over that of the shaft against it.
        let slip = (self.inner - self.outer) * (1.0 - cage_per_shaft);
        let speed = self.outer + slip;
        let speed_std = observation.speed_std.max(SETTINGS.least_speed_std);
        0.5 * ((slip - SETTINGS.slip_mean) / SETTINGS.slip_std).powi(2) + 0.5 * (speed / speed_std).powi(2)
    }
}

/// Range of a search for a stretch of the lines.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Middle.
    pub around: f64,
    /// Half width.
    pub reach: f64,
}

/// Bin of a predicted line.
struct LineBin {
    /// Power over the background.
    ratio: f64,
    channel: usize,
    k: usize,
    /// Density of a power to which the line is moved: the background is nearly the same there.
    density: Density,
}

/// Stretch of `lines` over a `background` of each channel that fits a recording best under a `prior`, −ln, and its gain over no
/// lines at all.
pub fn best_stretch(
    observation: &Observation,
    lines: &Power,
    background: &Power,
    range: Range,
    prior: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let mut bins: Vec<LineBin> = Vec::new();
    let mut without_lines: [Vec<f64>; 2] = Default::default();
    for (channel, without) in without_lines.iter_mut().enumerate() {
        let (Some(power), Some(ln_power)) = (&observation.power[channel], &observation.ln_power[channel]) else {
            continue;
        };
        let (predicted, background) = (&lines[channel], &background[channel]);
        let ratio = |k: usize| predicted[k] / background[k];
        let line =
            |k: usize| LineBin { ratio: ratio(k), channel, k, density: Density::new(background[k], predicted[k]) };
        bins.extend(observation.bins().filter(|k| ratio(*k) > SETTINGS.line_ratio).map(line));
        let each = background.iter().zip(power).zip(ln_power);
        *without = each.map(|((background, p), ln)| Density::new(*background, 0.0).neg_log(*p, *ln)).collect();
    }
    bins.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    bins.truncate(SETTINGS.most_lines);
    let last = bins.iter().map(|line| line.k).max().unwrap_or(1) as f64;
    let step = SETTINGS.stretch[1].max(SETTINGS.stretch_bins / last);
    let steps = (range.reach / step).round() as i32;
    let grid: Vec<f64> = (-steps..=steps).map(|n| range.around + f64::from(n) * step).collect();
    let mut gains = vec![0.0; grid.len()];
    for LineBin { k, channel, density, .. } in bins {
        let (Some(power), Some(ln_power)) = (&observation.power[channel], &observation.ln_power[channel]) else {
            continue;
        };
        let moved =
            |to: usize| without_lines[channel].get(to).map_or(0.0, |w| w - density.neg_log(power[to], ln_power[to]));
        // Neighbouring stretches move a line of low frequency to the same bin.
        let (mut at, mut gain) = (k, moved(k));
        for (sum, stretch) in gains.iter_mut().zip(&grid) {
            let to = ((1.0 + stretch) * k as f64).round() as usize;
            if to != at {
                (at, gain) = (to, moved(to));
            }
            *sum += gain;
        }
    }
    let costs = grid.iter().zip(gains).map(|(stretch, gain)| (prior(*stretch) - gain, *stretch));
    let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((range.around, 0.0), |(cost, stretch)| (stretch, -cost))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bin(power: f64, noise: f64, line: f64) -> Bin {
        Density::new(noise, line).bin(power, power.ln())
    }

    /// −ln of the density, integrated over all powers.
    fn mass(noise: f64, line: f64) -> f64 {
        let step = 1e-3;
        (0..60_000)
            .map(|n| {
                step * (noise + line) * (-bin((f64::from(n) + 0.5) * step * (noise + line), noise, line).neg_log).exp()
            })
            .sum()
    }

    #[test]
    fn invariant_a_density_has_a_mass_of_one_but_for_the_outliers() {
        for line in [0.0, 1.0, 30.0] {
            let mass = mass(1.0, line);
            assert!((0.99..1.03).contains(&mass), "{line}: {mass}");
        }
    }

    #[test]
    fn literature_noise_alone_has_whittles_density() {
        let found = bin(1.7, 2.0, 0.0);
        assert!((found.neg_log - (2.0f64.ln() + 0.85)).abs() < 1e-12 && (found.slope - 0.15).abs() < 1e-12);
    }

    #[test]
    fn an_unpredicted_line_costs_no_more_than_its_logarithm() {
        let cost = |power: f64| bin(power, 1.0, 0.0).neg_log;
        assert!(cost(1e6) - cost(1e3) < 2.1 * 1e3f64.ln(), "{}", cost(1e6) - cost(1e3));
        assert!(bin(1e6, 1.0, 1e6).neg_log < cost(1e6) - 10.0, "a predicted one is likelier");
    }

    #[test]
    fn the_slope_is_that_of_the_density() {
        for (power, noise, line) in [(0.3, 1.0, 0.0), (9.0, 1.0, 2.0), (300.0, 1.0, 20.0)] {
            let at = |log: f64| bin(power, noise * log.exp(), line * log.exp()).neg_log;
            let quotient = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((quotient - bin(power, noise, line).slope).abs() < 1e-4, "{power}: {quotient}");
        }
    }
}
