//! Statistics of a residual: its power in each band, stretch of time, order, angle and range of the state.
//!
//! Every statistic is nearly standard normal if the residual is white noise of unit variance; [`evidence`](super::evidence)
//! estimates the true null distributions.

use std::f64::consts::{FRAC_PI_2, TAU};

use realfft::num_complex::Complex;

use super::residual::{EDGE, Whitened, inner};
use super::result::Aspect;
use crate::identify::likelihood::observed::{CHANNELS, coefficients};
use crate::identify::likelihood::whittle::judged_bins;
use crate::rig::OperatingCondition;
use crate::signal::characteristic::{Characteristic, Speeds, list};
use crate::signal::kinematics::Geometry;
use crate::signal::lines::{floor, half_width};
use crate::signal::transform::{inverse_plan, median};
use crate::stats::format::significant;

/// Frequency bands.
const BANDS: usize = 32;
/// Stretches of time.
const STRETCHES: usize = 40;
/// Parts of a turn, and of the balls' pitch.
const ANGLES: usize = 12;
/// Ranges of position, and of velocity.
const STATES: usize = 8;
/// Harmonics of each bearing frequency.
const HARMONICS: u32 = 3;
/// Bins to either side that belong to a line.
const BESIDE: usize = 1;
/// Lower frequency limit of integration, Hz; below it noise drifts.
const INTEGRATED_FROM_HZ: f64 = 20.0;
/// Samples of a block whose mean square measures how power varies in time.
const BLOCK: usize = 64;
/// Median of |x| for a standard normal x.
const MEDIAN_DEVIATION: f64 = 0.6745;
/// Segments of a recording over which the median is taken.
const SEGMENTS: usize = 8;
/// Minimum count of segments, over all recordings, for a median.
const LEAST_SEGMENTS: usize = 6;
/// Minimum samples of a range in a segment.
const LEAST_SAMPLES: usize = 8;
/// Parts of a recording whose means give the standard error of its mean.
const PARTS: usize = 20;

/// Residual of one channel of one recording, with what it may depend on.
#[derive(Clone, Copy, Debug)]
pub struct ResidualView<'a> {
    /// Whitened residual.
    pub whitened: &'a Whitened,
    /// Recorded channel, m/s².
    pub samples: &'a [f64],
    /// Operating condition.
    pub condition: OperatingCondition,
    /// Angle of the cage at the first sample, rad, if estimated.
    pub cage: Option<f64>,
    /// Angle of the shaft at the first sample, rad, if there is a tachometer.
    pub shaft: Option<f64>,
}

/// Statistic of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistic {
    /// Aspect of the residual.
    pub aspect: Aspect,
    /// Channel.
    pub channel: &'static str,
    /// Interval, in the unit of the aspect.
    pub at: Option<[f64; 2]>,
    /// Description.
    pub what: String,
    /// Value, nearly standard normal under the null hypothesis.
    pub value: f64,
}

/// Statistics of all channels, recordings pooled. Count and order are the same for all recordings of the same conditions.
pub fn statistics(views: &[ResidualView], geometry: &Geometry) -> Vec<Statistic> {
    let channels = CHANNELS.into_iter().enumerate().map(|(channel, name)| {
        let views = views.iter().filter(|l| l.whitened.channel == channel).copied().collect();
        Channel { name, views }
    });
    channels.filter(|c| !c.views.is_empty()).flat_map(|c| c.statistics(geometry)).collect()
}

/// Residuals of one channel, at least one.
struct Channel<'a> {
    name: &'static str,
    views: Vec<ResidualView<'a>>,
}

impl Channel<'_> {
    fn statistics(&self, geometry: &Geometry) -> Vec<Statistic> {
        [
            self.moments(),
            self.bands(),
            self.lines(Aspect::Order, geometry),
            self.lines(Aspect::Envelope, geometry),
            self.times(),
            self.shaft_angles(),
            self.ball_places(geometry),
            self.motions(Aspect::Velocity, 1, "at velocities from", "m/s"),
            self.motions(Aspect::Displacement, 2, "at positions from", "m"),
            self.conditions(),
        ]
        .concat()
    }

    fn statistic(&self, aspect: Aspect, at: Option<[f64; 2]>, what: &str, value: f64) -> Statistic {
        Statistic { aspect, channel: self.name, at, what: format!("{}, {what}", self.name), value }
    }

    fn moments(&self) -> Vec<Statistic> {
        let means = self.views.iter().map(|l| mean_in_deviations(l.samples));
        let mean = means.sum::<f64>() / (self.views.len() as f64).sqrt();
        let all: Vec<f64> = self.views.iter().flat_map(|l| inner(&l.whitened.signal)).copied().collect();
        let count = all.len().max(1) as f64;
        let middle = all.iter().sum::<f64>() / count;
        let power = |n: i32| all.iter().map(|v| (v - middle).powi(n)).sum::<f64>() / count;
        let variance = power(2).max(f64::MIN_POSITIVE);
        let (skewness, kurtosis) = (power(3) / variance.powf(1.5), power(4) / (variance * variance));
        vec![
            self.statistic(Aspect::Mean, None, "mean", mean),
            self.statistic(Aspect::Moments, None, "skewness", skewness * (count / 6.0).sqrt()),
            self.statistic(Aspect::Moments, None, "kurtosis", (kurtosis - 3.0) * (count / 24.0).sqrt()),
        ]
    }

    fn bands(&self) -> Vec<Statistic> {
        let mut all = vec![([0.0; 2], 0.0, 0usize); BANDS];
        for w in self.views.iter().map(|l| l.whitened) {
            let bins = judged_bins(&w.spectrum, 1.0);
            let step = w.sample_rate_hz / w.signal.len() as f64;
            for k in bins.clone() {
                let band = (k - bins.start) * BANDS / bins.len();
                let (hz, sum, count) = &mut all[band];
                *hz = [band, band + 1].map(|b| (bins.start as f64 + (b * bins.len()) as f64 / BANDS as f64) * step);
                *sum += w.spectrum[k].norm_sqr();
                *count += 1;
            }
        }
        let of = |(hz, sum, count): ([f64; 2], f64, usize)| {
            let what = format!("power from {:.0} to {:.0} Hz", hz[0], hz[1]);
            self.statistic(Aspect::Spectrum, Some(hz), &what, power_in_deviations(sum / count as f64, count as f64))
        };
        all.into_iter().filter(|(.., count)| *count > 0).map(of).collect()
    }

    /// Lines at the bearing's frequencies over the noise around them.
    fn lines(&self, aspect: Aspect, geometry: &Geometry) -> Vec<Statistic> {
        let ratios = |l: &ResidualView| {
            if aspect == Aspect::Envelope {
                over_floor(&coefficients(&squared_less_mean(&l.whitened.signal)), step_hz(l))
            } else {
                over_floor(&l.whitened.spectrum, step_hz(l))
            }
        };
        let all: Vec<Vec<f64>> = self.views.iter().map(ratios).collect();
        let spectrum = if aspect == Aspect::Envelope { "squared signal" } else { "signal" };
        let orders = Speeds { shaft_hz: 1.0, geometry: Some(*geometry), slip: 0.0 };
        let of = |line: Characteristic| {
            let (mut sum, mut count) = (0.0, 0usize);
            for (l, ratios) in self.views.iter().zip(&all) {
                let at = (line.frequency_hz * l.condition.shaft_hz / step_hz(l)).round() as usize;
                // The mean and its leakage are no line.
                let here = ratios.get(at.saturating_sub(BESIDE).max(2)..=at + BESIDE).unwrap_or_default();
                sum += here.iter().sum::<f64>();
                count += here.len();
            }
            let what = format!("{} of the {spectrum}, order {:.3}", line.name, line.frequency_hz);
            let value = power_in_deviations(sum / count as f64, count as f64);
            (count > 0).then(|| self.statistic(aspect, Some([line.frequency_hz; 2]), &what, value))
        };
        list(&orders, f64::INFINITY, HARMONICS, 0).into_iter().filter_map(of).collect()
    }

    /// Power in stretches of time over the median of all.
    fn times(&self) -> Vec<Statistic> {
        let longest_s = self.views.iter().map(duration_s).fold(0.0, f64::max);
        let edges = evenly(STRETCHES, longest_s);
        let mut all = vec![Power::default(); STRETCHES];
        for l in &self.views {
            for (i, v) in inside(&l.whitened.signal) {
                all[between(&edges, i as f64 / l.condition.sample_rate_hz)].add(*v);
            }
        }
        let mut means: Vec<f64> = all.iter().filter(|p| p.count > 0).map(Power::mean).collect();
        let Some(usual) = median(&mut means).filter(|m| *m > 0.0) else { return Vec::new() };
        let uneven = unevenness(&self.views);
        let deviate = |power: &Power| {
            // Half as many degrees of freedom to a real number.
            let freedom = 0.5 * power.count as f64 / uneven;
            if power.count > 0 { power_in_deviations(power.mean() / usual, freedom) } else { 0.0 }
        };
        let deviates: Vec<f64> = all.iter().map(deviate).collect();
        // Recurring events make all stretches uneven, and none of them a location.
        let scatter = typical_size(deviates.iter().copied()).max(1.0);
        let each = deviates.iter().zip(edges.windows(2));
        each.map(|(deviate, ends)| self.place(Aspect::Time, "from", "s", ends, deviate / scatter)).collect()
    }

    /// Power at shaft angles, if there are tachometers.
    fn shaft_angles(&self) -> Vec<Statistic> {
        let Some(from) = self.views.iter().map(|l| l.shaft).collect::<Option<Vec<f64>>>() else { return Vec::new() };
        let angle = |n: usize, i: usize| turned(from[n], &self.views[n].condition, 1.0, i).rem_euclid(TAU);
        self.places(Aspect::ShaftAngle, "at shaft angles from", "rad", &evenly(ANGLES, TAU), angle)
    }

    /// Power at positions of the balls in their pitch.
    fn ball_places(&self, geometry: &Geometry) -> Vec<Statistic> {
        let Some(from) = self.views.iter().map(|l| l.cage).collect::<Option<Vec<f64>>>() else { return Vec::new() };
        let (pitch, ftf) = (TAU / geometry.balls as f64, geometry.orders().ftf);
        let angle = |n: usize, i: usize| turned(from[n], &self.views[n].condition, ftf, i).rem_euclid(pitch);
        self.places(Aspect::CageAngle, "at ball positions from", "rad of the pitch", &evenly(ANGLES, pitch), angle)
    }

    /// Power in ranges of the channel's velocity or position, each with as many samples.
    fn motions(&self, aspect: Aspect, times: i32, words: &str, unit: &str) -> Vec<Statistic> {
        let motions: Vec<Vec<f64>> = self.views.iter().map(|l| integrated(l, times)).collect();
        let mut all: Vec<f64> = motions.iter().flat_map(|m| inner(m)).copied().collect();
        all.sort_by(f64::total_cmp);
        let Some(last) = all.len().checked_sub(1) else { return Vec::new() };
        let edges: Vec<f64> = (0..=STATES).map(|k| all[k * last / STATES]).collect();
        self.places(aspect, words, unit, &edges, |n, i| motions[n][i])
    }

    /// Power where `of` is between two of the edges over that of the surrounding segment: the median over segments, so that single
    /// events do not count.
    fn places(
        &self,
        aspect: Aspect,
        words: &str,
        unit: &str,
        edges: &[f64],
        of: impl Fn(usize, usize) -> f64,
    ) -> Vec<Statistic> {
        let mut shares: Vec<Vec<(f64, usize)>> = vec![Vec::new(); edges.len() - 1];
        for (n, l) in self.views.iter().enumerate() {
            let samples: Vec<(usize, &f64)> = inside(&l.whitened.signal).collect();
            for segment in samples.chunks(samples.len().div_ceil(SEGMENTS).max(1)) {
                let (mut all, mut each) = (Power::default(), vec![Power::default(); shares.len()]);
                for (i, v) in segment {
                    all.add(**v);
                    each[between(edges, of(n, *i))].add(**v);
                }
                for (share, power) in shares.iter_mut().zip(&each).filter(|(_, p)| p.count >= LEAST_SAMPLES) {
                    share.push((power.mean() / all.mean().max(f64::MIN_POSITIVE), power.count));
                }
            }
        }
        let each = shares.iter().zip(edges.windows(2));
        each.map(|(share, ends)| self.place(aspect, words, unit, ends, median_in_deviations(share))).collect()
    }

    fn place(&self, aspect: Aspect, words: &str, unit: &str, ends: &[f64], value: f64) -> Statistic {
        let what = format!("power {words} {} to {} {unit}", significant(ends[0], 3), significant(ends[1], 3));
        self.statistic(aspect, Some([ends[0], ends[1]]), &what, value)
    }

    /// Dependence of the recordings' power on load and speed, if these differ.
    fn conditions(&self) -> Vec<Statistic> {
        let power = |l: &ResidualView| {
            let bins = &l.whitened.spectrum[judged_bins(&l.whitened.spectrum, 1.0)];
            let count = bins.len().max(1) as f64;
            ((bins.iter().map(|x| x.norm_sqr()).sum::<f64>() / count).max(f64::MIN_POSITIVE).ln(), count)
        };
        let powers: Vec<(f64, f64)> = self.views.iter().map(power).collect();
        let over = |aspect: Aspect, what: &str, of: fn(&OperatingCondition) -> f64| {
            let values: Vec<f64> = self.views.iter().map(|l| of(&l.condition)).collect();
            let middle = values.iter().sum::<f64>() / values.len() as f64;
            let scatter = values.iter().zip(&powers).map(|(v, (_, n))| (v - middle).powi(2) / n).sum::<f64>().sqrt();
            let slope: f64 = values.iter().zip(&powers).map(|(v, (power, _))| (v - middle) * power).sum();
            (scatter > 0.0).then(|| self.statistic(aspect, None, what, slope / scatter))
        };
        let load = over(Aspect::Load, "dependence of power on load", |c| c.load_n);
        let speed = over(Aspect::Speed, "dependence of power on speed", |c| c.shaft_hz);
        load.into_iter().chain(speed).collect()
    }
}

/// Highest lines of a residual, highest first: order of the shaft, and power over the noise around.
pub fn highest_lines(view: &ResidualView, most: usize) -> Vec<(f64, f64)> {
    let ratios = over_floor(&view.whitened.spectrum, step_hz(view));
    let peaks =
        (2..ratios.len().saturating_sub(2)).filter(|k| ratios[*k] > ratios[k - 1] && ratios[*k] >= ratios[k + 1]);
    let mut lines: Vec<(f64, f64)> =
        peaks.map(|k| (k as f64 * step_hz(view) / view.condition.shaft_hz, ratios[k])).collect();
    lines.sort_by(|a, b| b.1.total_cmp(&a.1));
    lines.truncate(most);
    lines
}

fn step_hz(view: &ResidualView) -> f64 {
    view.condition.sample_rate_hz / view.whitened.signal.len() as f64
}

fn duration_s(view: &ResidualView) -> f64 {
    view.whitened.signal.len() as f64 / view.condition.sample_rate_hz
}

/// Power of a spectrum's values over that of the noise around them.
fn over_floor(spectrum: &[Complex<f64>], step_hz: f64) -> Vec<f64> {
    let powers: Vec<f64> = spectrum.iter().map(|x| x.norm_sqr()).collect();
    let floor = floor(&powers, half_width(step_hz));
    powers.iter().zip(floor).map(|(p, f)| if f > 0.0 { p / f } else { 0.0 }).collect()
}

fn squared_less_mean(signal: &[f64]) -> Vec<f64> {
    let inside = inner(signal);
    let mean = inside.iter().map(|v| v * v).sum::<f64>() / inside.len().max(1) as f64;
    let last = signal.len().saturating_sub(EDGE);
    let of = |(i, v): (usize, &f64)| if (EDGE..last).contains(&i) { v * v - mean } else { 0.0 };
    signal.iter().enumerate().map(of).collect()
}

/// Standard normal value of the mean square of `count` complex numbers of expected mean square 1 (E. B. Wilson, M. M. Hilferty, "The distribution of
/// chi-square", PNAS 17 (1931) 684–688).
fn power_in_deviations(mean: f64, count: f64) -> f64 {
    (mean.max(0.0).cbrt() - 1.0 + 1.0 / (9.0 * count)) * 3.0 * count.sqrt()
}

/// Mean of a recording in standard errors, estimated from the means of its parts.
fn mean_in_deviations(samples: &[f64]) -> f64 {
    let length = samples.len() / PARTS;
    if length == 0 {
        return 0.0;
    }
    let means: Vec<f64> =
        samples.chunks_exact(length).take(PARTS).map(|p| p.iter().sum::<f64>() / length as f64).collect();
    let mean = means.iter().sum::<f64>() / PARTS as f64;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (PARTS - 1) as f64;
    if variance > 0.0 { mean / (variance / PARTS as f64).sqrt() } else { 0.0 }
}

/// Variance of the power of short blocks over that of white noise, at least 1: coloured noise has fewer degrees of freedom than
/// samples. A median, so that single events do not count.
fn unevenness(views: &[ResidualView]) -> f64 {
    let of = |signal: &[f64]| -> Vec<f64> {
        inner(signal).chunks_exact(BLOCK).map(|b| b.iter().map(|v| v * v).sum::<f64>() / BLOCK as f64).collect()
    };
    let mut blocks: Vec<f64> = views.iter().flat_map(|l| of(&l.whitened.signal)).collect();
    let Some(usual) = median(&mut blocks).filter(|m| *m > 0.0) else { return 1.0 };
    let deviation = typical_size(blocks.iter().map(|b| b / usual - 1.0));
    (deviation * deviation * BLOCK as f64 / 2.0).max(1.0)
}

/// Velocity (`times` 1) or position (`times` 2) of the channel, by integration.
fn integrated(view: &ResidualView, times: i32) -> Vec<f64> {
    let mut bins = coefficients(view.samples);
    let step = TAU * view.condition.sample_rate_hz / view.samples.len() as f64;
    let last = bins.len().saturating_sub(1);
    for (k, bin) in bins.iter_mut().enumerate() {
        let omega = k as f64 * step;
        let kept = omega >= TAU * INTEGRATED_FROM_HZ && k < last;
        *bin = if kept { *bin / Complex::new(0.0, omega).powi(times) } else { Complex::default() };
    }
    let inverse = inverse_plan(view.samples.len());
    let mut out = inverse.make_output_vec();
    // Both buffers are made to the transform's measure.
    inverse.process(&mut bins, &mut out).unwrap_or_default();
    let scale = (view.samples.len() as f64).sqrt().recip();
    out.iter_mut().for_each(|v| *v *= scale);
    out
}

/// Sum of squares and count of some samples.
#[derive(Clone, Copy, Debug, Default)]
struct Power {
    sum: f64,
    count: usize,
}

impl Power {
    fn add(&mut self, v: f64) {
        self.sum += v * v;
        self.count += 1;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }
}

/// Standard normal value of the median of power shares, 1 on average, each with its count of samples. Its spread is that of the
/// shares, at least that of white noise. 0 for too few shares.
fn median_in_deviations(shares: &[(f64, usize)]) -> f64 {
    if shares.len() < LEAST_SEGMENTS {
        return 0.0;
    }
    let mut values: Vec<f64> = shares.iter().map(|(share, _)| *share).collect();
    let middle = median(&mut values).unwrap_or(1.0);
    let white = shares.iter().map(|(_, count)| 2.0 / *count as f64).sum::<f64>() / shares.len() as f64;
    let scatter = typical_size(values.iter().map(|v| v - middle)).max(white.sqrt());
    // The variance of a median is π/2 that of a mean.
    (middle - 1.0) / scatter * (shares.len() as f64 / FRAC_PI_2).sqrt()
}

/// Robust standard deviation of values of mean 0, by the median of their magnitudes.
fn typical_size(deviates: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = deviates.map(f64::abs).collect();
    median(&mut sizes).unwrap_or_default() / MEDIAN_DEVIATION
}

/// Angle at a sample of a rotation of a given order, rad.
fn turned(from: f64, condition: &OperatingCondition, order: f64, sample: usize) -> f64 {
    from + TAU * order * condition.shaft_hz * sample as f64 / condition.sample_rate_hz
}

fn evenly(count: usize, until: f64) -> Vec<f64> {
    (0..=count).map(|k| until * k as f64 / count as f64).collect()
}

/// Index of the interval between edges that holds a value.
fn between(edges: &[f64], value: f64) -> usize {
    edges.partition_point(|edge| *edge <= value).clamp(1, edges.len() - 1) - 1
}

/// Samples without those at the ends of a recording, with their indices.
fn inside(signal: &[f64]) -> impl Iterator<Item = (usize, &f64)> {
    let last = signal.len().saturating_sub(EDGE);
    signal.iter().enumerate().take(last).skip(EDGE)
}
