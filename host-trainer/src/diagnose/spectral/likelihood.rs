//! Likelihood of power spectra under a prediction.
//!
//! Phases are not used: a wandering speed, a slipping cage or unevenly spaced balls take them away first. A bin's power is
//! gamma distributed around S c + V: S the noise of the rig, c its colour, V the power of the rig's lines. The power of noise
//! is exponential (P. Whittle, Arkiv för Matematik 2 (1953) 423–434); that of a line has the relative variance of the machine
//! against the rig. A few bins are neither.

use std::f64::consts::{PI, TAU};

use statrs::function::gamma::ln_gamma;

use super::observation::Observation;
use super::prediction::Prediction;
use super::settings::LikelihoodSettings;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;
/// Values of a noise's colour in a channel.
pub const KNOTS: usize = SETTINGS.knots.len();

/// Logarithm of a noise's colour at the knots, Np of power, of each channel.
pub type Colour = [[f64; KNOTS]; 2];

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

/// Covariance of a channel's colour before any recording.
pub fn colour_covariance(a: usize, b: usize) -> f64 {
    let roll_off = |knot: usize| SETTINGS.roll_off_np * SETTINGS.knots[knot].powi(2);
    let own = if a == b { SETTINGS.knot_np.powi(2) } else { 0.0 };
    let cosine = |k: usize, knot: usize| SETTINGS.cosine_np / k as f64 * (PI * k as f64 * SETTINGS.knots[knot]).cos();
    let cosines: f64 = (1..=SETTINGS.cosines).map(|k| cosine(k, a) * cosine(k, b)).sum();
    SETTINGS.level_np.powi(2) + roll_off(a) * roll_off(b) + cosines + own
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

/// Density of a power under noise and line.
pub fn bin(power: f64, noise: f64, line: f64) -> Bin {
    let mean = noise + line;
    let share = line / mean;
    let shape = if share < 0.05 { 1.0 } else { 1.0 / (1.0 - share * share * (1.0 - SETTINGS.line_variance)) };
    let ratio = power / mean;
    let log_mean = mean.ln();
    let gamma = if shape == 1.0 {
        log_mean + ratio
    } else {
        let log_ratio = ratio.max(1e-12).ln();
        shape * (ratio - shape.ln()) - (shape - 1.0) * log_ratio + ln_gamma(shape) + log_mean
    };
    // The outliers' density adds nothing to an ordinary bin.
    let ordinary = if shape == 1.0 { ratio < 4.0 } else { ratio < 4.0 && ratio > 0.3 };
    if ordinary {
        return Bin { neg_log: gamma, information: shape, slope: shape * (1.0 - ratio) };
    }
    // A Pareto density, so that one strong line that is not predicted does not outweigh all others.
    let wide = SETTINGS.outlier_power * mean;
    let outlier = wide.ln() + 2.0 * (power / wide).ln_1p() - SETTINGS.outliers.ln();
    let more = gamma - outlier;
    let weight = 1.0 / (1.0 + more.exp());
    let neg_log = if more > 0.0 { outlier - (-more).exp().ln_1p() } else { gamma - more.exp().ln_1p() };
    let of_outlier = (1.0 - weight) * (1.0 - 2.0 * power / (wide + power));
    Bin { neg_log, information: weight * shape, slope: weight * shape * (1.0 - ratio) + of_outlier }
}

/// Spectrum of a channel under a prediction.
pub struct Channel<'a> {
    /// Recording.
    pub observation: &'a Observation,
    /// Prediction.
    pub prediction: &'a Prediction,
    /// Knots around each bin.
    pub hats: &'a [(usize, f64)],
    /// Colour of both channels.
    pub colour: &'a Colour,
    /// Frequency of the lines over that predicted, less 1.
    pub stretch: f64,
    /// Standard deviation of the time of a ball pass, s.
    pub jitter_s: f64,
    /// Standard deviation of a ball's place in the cage, rad.
    pub spacing_rad: f64,
    /// Orders of the cage in one of the shaft.
    pub cage_per_shaft: f64,
    /// Index of the channel.
    pub channel: usize,
}

impl Channel<'_> {
    /// Coloured noise at a bin.
    pub fn noise(&self, k: usize) -> f64 {
        self.prediction.noise[self.channel][k] * colour_at(&self.colour[self.channel], self.hats[k]).exp()
    }

    /// Power of lines at a bin.
    pub fn line(&self, k: usize) -> f64 {
        let place = k as f64 / (1.0 + self.stretch);
        let line = at(&self.prediction.lines[self.channel], place);
        let (jitter, spacing) = self.lost(k);
        let passes = if jitter == 0.0 {
            line
        } else {
            line + jitter * (at(&self.prediction.skirts[self.channel], place) - line)
        };
        if spacing == 0.0 {
            passes
        } else {
            passes + spacing * (at(&self.prediction.spaced[self.channel], place) - passes)
        }
    }

    /// Shares of a line's power at a bin that jitter and uneven spacing take.
    fn lost(&self, k: usize) -> (f64, f64) {
        let hz = self.observation.hz(k as f64);
        let share = |phase: f64| if phase == 0.0 { 0.0 } else { -(-phase * phase).exp_m1() };
        let order = hz / (self.cage_per_shaft * self.observation.condition.shaft_hz).max(1e-9);
        (share(TAU * hz * self.jitter_s), share(order * self.spacing_rad))
    }

    /// Every bin of the likelihood: number, power, noise, line; empty for a channel that was not recorded.
    pub fn bins(&self) -> impl Iterator<Item = (usize, f64, f64, f64)> + '_ {
        let power = self.observation.power[self.channel].as_deref().unwrap_or_default();
        let bins = if power.is_empty() { 0..0 } else { self.observation.bins() };
        bins.map(move |k| (k, power[k], self.noise(k), self.line(k)))
    }

    /// −ln L.
    pub fn neg_log_likelihood(&self) -> f64 {
        self.bins().map(|(_, power, noise, line)| bin(power, noise, line).neg_log).sum()
    }
}

/// Value between two bins.
fn at(values: &[f64], place: f64) -> f64 {
    let lower = place as usize;
    let share = place - lower as f64;
    match values.get(lower + 1) {
        Some(upper) => values[lower] * (1.0 - share) + upper * share,
        None => values.last().copied().unwrap_or_default(),
    }
}

/// Range in which a stretch of the lines is sought.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Middle.
    pub around: f64,
    /// Half width.
    pub reach: f64,
    /// Whether a healthy machine's stretch is preferred.
    pub healthy: bool,
}

/// Stretch of the lines that suits a recording best, and its gain over no lines at all.
pub fn best_stretch(
    observation: &Observation,
    prediction: &Prediction,
    hats: &[(usize, f64)],
    colour: &Colour,
    range: Range,
) -> (f64, f64) {
    let last = observation.bins().end;
    // Bins of the predicted lines: power over noise, channel, bin, power. Each bin: power, noise, −ln L without a line.
    let mut line_bins: Vec<(f64, usize, usize, f64)> = Vec::new();
    let mut without_lines: [Vec<(f64, f64, f64)>; 2] = [Vec::new(), Vec::new()];
    for (channel, without_lines) in without_lines.iter_mut().enumerate() {
        let Some(power) = &observation.power[channel] else { continue };
        let at = Channel {
            observation,
            prediction,
            hats,
            colour,
            stretch: 0.0,
            jitter_s: 0.0,
            spacing_rad: 0.0,
            cage_per_shaft: 1.0,
            channel,
        };
        let lines = &prediction.lines[channel];
        let noise: Vec<f64> = (0..last).map(|k| at.noise(k)).collect();
        let of = |k: usize| (lines[k] / noise[k], channel, k, lines[k]);
        line_bins.extend(observation.bins().map(of).filter(|(ratio, ..)| *ratio > SETTINGS.line_ratio));
        *without_lines =
            noise.iter().zip(power).map(|(noise, power)| (*power, *noise, bin(*power, *noise, 0.0).neg_log)).collect();
    }
    line_bins.sort_by(|a, b| b.0.total_cmp(&a.0));
    line_bins.truncate(SETTINGS.most_lines);
    let cost = |stretch: f64| {
        let off = if range.healthy { (stretch - SETTINGS.stretch_mean) / SETTINGS.stretch_std } else { 0.0 };
        let gain = line_bins.iter().filter_map(|(_, channel, k, line)| {
            let (power, noise, without) = without_lines[*channel].get(((1.0 + stretch) * *k as f64).round() as usize)?;
            Some(without - bin(*power, *noise, *line).neg_log)
        });
        0.5 * off * off - gain.sum::<f64>()
    };
    let steps = (range.reach / SETTINGS.stretch[1]).round() as i32;
    let grid = (-steps..=steps).map(|n| range.around + f64::from(n) * SETTINGS.stretch[1]);
    let best = grid.map(|stretch| (cost(stretch), stretch)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((range.around, 0.0), |(cost, stretch)| (stretch, -cost))
}

#[cfg(test)]
mod tests {
    use super::*;

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
