//! Samples that a logger dropped, by the lines of a spectrum: their phases all jump at once, by the time that is missing.
//!
//! The phase of a line before a time is held against that after it, in windows on either side. A wander of the speed turns phases too,
//! but no faster than a machine does, and less in shorter windows; a step of the load turns each line otherwise.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::dropped::{Gap, Kind};
use crate::identify::likelihood::observed::accelerations;
use crate::recording::Recording;
use crate::signal::lines::{floor, half_width};
use crate::signal::transform::{forward, hann, median};

/// Length of a window, s. By hand: several turns of most shafts.
const WINDOW_S: f64 = 0.125;
/// Fewest windows of a recording.
const WINDOWS: usize = 4;
/// Times at which phases are compared, to a window.
const TIMES: usize = 25;
/// Power of a line over that of the noise. By hand.
const LEAST_RATIO: f64 = 30.0;
/// Most lines of a channel.
const LINES: usize = 16;
/// Values of a spectrum to either side among which a line is the greatest: those of its window.
const PEAK: usize = 3;
/// Share of a window that a wandering or stepping speed may gain or lose within it.
const WANDER: f64 = 0.004;
/// Angle by which a wandering cage may gain or lose within it, rad. By hand.
const CAGE_WANDER_RAD: f64 = 0.06;
/// Turns of a cage to one of the shaft, about.
const CAGE_ORDER: f64 = 0.4;
/// Least gain by missing samples over a wander, nats. Choosing seeds 83 and 84 (docs/results.md): gaps gain 18 to 88, and what is
/// none and has the shares below less than 2.
const LEAST_NATS: f64 = 12.0;
/// Share of what lines of the same phases would gain, at least.
const LEAST_SHARE: f64 = 0.85;
/// Greatest gain elsewhere in the recording over that of the gap: a machine that drifts does so all the time.
const ELSEWHERE: f64 = 0.25;
/// Parts of a window in which a jump must turn phases as much as in all of it. A cage may wander by nearly as much within half of it.
const SHORTER: [usize; 2] = [2, 4];
/// Gains that are the same, nats.
const SAME_NATS: f64 = 2.0;

/// A line of a channel.
struct Line<'s> {
    samples: &'s [f64],
    /// Frequency, periods to a sample.
    frequency: f64,
    /// Power over that of the noise in all of the recording.
    ratio: f64,
}

/// Phase of a line after a time less that before it, as a number of the length of its weight, nats.
type Turned = Complex<f64>;

/// Missing samples of a recording without a tachometer; `None` without a speed or lines, or if no time explains them all.
pub fn gap(recording: &Recording) -> Option<Gap> {
    let turn = recording.sample_rate_hz / recording.shaft_hz?;
    let hop = (WINDOW_S * recording.sample_rate_hz) as usize / TIMES;
    let window = TIMES * hop;
    if hop == 0 || recording.len() < WINDOWS * window {
        return None;
    }
    let lines: Vec<Line> = accelerations(recording).into_iter().flatten().flat_map(|c| lines(&c.samples)).collect();
    let times: Vec<usize> = (window..=recording.len() - window).step_by(hop).collect();
    let (lines, turned): (Vec<Line>, Vec<Vec<Turned>>) =
        lines.into_iter().map(|line| line.refined(&times, window)).unzip();
    // A turn's worth of counts, however slow the shaft.
    let most = (0.5 * turn).min(window as f64) as i64;
    let counts: Vec<f64> = (1 - most..=most).map(|count| count as f64).collect();
    // Phases of each count of missing samples.
    let phases: Vec<Vec<Complex<f64>>> =
        lines.iter().map(|line| counts.iter().map(|c| Complex::cis(-TAU * line.frequency * c)).collect()).collect();
    let of_cage = CAGE_WANDER_RAD / TAU * turn / CAGE_ORDER;
    let is_wander = |count: f64| count.abs() <= (WANDER * window as f64).max(of_cage);
    let all = |time: usize| turned.iter().map(|line| line[time].norm()).sum::<f64>();
    let gains = |time: usize| -> Vec<f64> {
        let of = |k: usize| turned.iter().zip(&phases).map(|(line, phases)| (line[time] * phases[k]).re).sum();
        (0..counts.len()).map(of).collect()
    };
    let jump = |time: usize| {
        let of_none: f64 = turned.iter().map(|line| line[time].re).sum();
        // Phases that stay have nothing to gain.
        let is_still = all(time) - of_none < ELSEWHERE * LEAST_NATS;
        if is_still { Jump::default() } else { Jump::of(&gains(time), &counts, is_wander) }
    };
    let each: Vec<Jump> = (0..times.len()).into_par_iter().map(jump).collect();
    let (best, jump) = each.iter().enumerate().max_by(|a, b| a.1.gain().total_cmp(&b.1.gain()))?;
    let elsewhere = (0..each.len()).filter(|time| time.abs_diff(best) > TIMES).map(|time| each[time].gain());
    let is_one = best > 0
        && best + 1 < times.len()
        && jump.gain() > LEAST_NATS
        && jump.gain() > LEAST_SHARE * (all(best) - jump.of_wander)
        && elsewhere.fold(0.0, f64::max) < ELSEWHERE * jump.gain();
    // A rotation that changes turns phases by less in shorter windows.
    let is_change = |part: usize| {
        let turned: Vec<(f64, Turned)> =
            lines.iter().map(|line| (line.frequency, line.turned(&times[best..=best], window / part)[0])).collect();
        let gain = |count: f64| -> f64 {
            turned.iter().map(|(frequency, turned)| (turned * Complex::cis(-TAU * frequency * count)).re).sum()
        };
        gain(jump.count) < gain(0.5 * jump.count)
    };
    if !is_one || SHORTER.into_iter().any(is_change) {
        return None;
    }
    let count = jump.fewest.round() as usize;
    Some(Gap { sample: times[best], count, z: (2.0 * jump.gain()).sqrt(), kind: Kind::PhaseJump })
}

/// How well a jump of the phases explains them at a time.
#[derive(Clone, Copy, Debug, Default)]
struct Jump {
    /// Count of missing samples that does best.
    count: f64,
    /// Fewest missing samples that do as well.
    fewest: f64,
    /// What that gains over no order in the phases, nats.
    most: f64,
    /// The same of counts that a wander of the speed amounts to.
    of_wander: f64,
}

impl Jump {
    fn of(gains: &[f64], counts: &[f64], is_wander: impl Fn(f64) -> bool) -> Self {
        let best = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).unwrap_or(0);
        let most = gains.get(best).copied().unwrap_or(0.0);
        let each = || counts.iter().zip(gains);
        let fewest = each().find(|(count, gain)| **count > 0.0 && **gain > most - SAME_NATS);
        let of_wander = each().filter(|(count, _)| is_wander(**count)).map(|(_, gain)| *gain).fold(0.0, f64::max);
        let count = counts.get(best).copied().unwrap_or(0.0);
        Self { count, fewest: fewest.map_or(count.abs(), |(count, _)| *count), most, of_wander }
    }

    /// Gain over a wander, nats.
    fn gain(&self) -> f64 {
        self.most - self.of_wander
    }
}

/// Strongest lines of a channel.
fn lines(samples: &[f64]) -> Vec<Line<'_>> {
    let n = samples.len();
    let mean = samples.iter().sum::<f64>() / n as f64;
    let mut windowed: Vec<f64> = samples.iter().zip(hann(n)).map(|(v, w)| (v - mean) * w).collect();
    let powers: Vec<f64> = forward(&mut windowed).iter().map(|c| c.norm_sqr()).collect();
    let noise = floor(&powers, half_width(1.0));
    let is_greatest = |k: usize| (k - PEAK..=k + PEAK).all(|other| powers[other] <= powers[k]);
    let line = |k: usize| {
        // Vertex of a parabola through the logarithms.
        let [a, b, c] = [k - 1, k, k + 1].map(|k| powers[k].max(f64::MIN_POSITIVE).ln());
        let vertex = 0.5 * (a - c) / (a - 2.0 * b + c).min(-f64::MIN_POSITIVE);
        Line { samples, frequency: (k as f64 + vertex) / n as f64, ratio: powers[k] / noise[k] }
    };
    let inner = PEAK + 1..powers.len().saturating_sub(PEAK);
    let peaks: Vec<usize> = inner.filter(|k| powers[*k] > LEAST_RATIO * noise[*k] && is_greatest(*k)).collect();
    // The skirts of a line whose phase jumps fall with the square of the distance.
    let skirt = |k: usize, other: usize| powers[other] / (k.abs_diff(other) as f64).powi(2);
    let is_skirt = |k: usize| peaks.iter().any(|other| *other != k && skirt(k, *other) > powers[k]);
    let mut out: Vec<Line> = peaks.iter().filter(|k| !is_skirt(**k)).map(|k| line(*k)).collect();
    out.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    out.truncate(LINES);
    out
}

impl Line<'_> {
    /// Line of the frequency at which its phase usually stays, which a jump in the recording does not move, with its turns.
    fn refined(self, times: &[usize], window: usize) -> (Self, Vec<Turned>) {
        let turned = self.turned(times, window);
        let usual = median(&mut turned.iter().map(|t| t.arg()).collect::<Vec<_>>()).unwrap_or(0.0);
        let frequency = self.frequency + usual / TAU / window as f64;
        (Self { frequency, ..self }, turned.into_iter().map(|t| t * Complex::cis(-usual)).collect())
    }

    /// Turns of the phase at some times, each between two windows. The weight is that of the weaker side.
    fn turned(&self, times: &[usize], window: usize) -> Vec<Turned> {
        let shape = hann(window);
        let oscillation = Complex::cis(-TAU * self.frequency);
        let amplitude = |from: usize| {
            let mut phase = Complex::cis(-TAU * (self.frequency * from as f64).fract());
            let mut sum = Complex::ZERO;
            for (v, w) in self.samples[from..from + window].iter().zip(&shape) {
                sum += phase * (v * w);
                phase *= oscillation;
            }
            sum
        };
        let firsts: BTreeSet<usize> = times.iter().flat_map(|time| [time - window, *time]).collect();
        let amplitudes: BTreeMap<usize, Complex<f64>> =
            firsts.into_par_iter().map(|first| (first, amplitude(first))).collect();
        let mut squares: Vec<f64> = amplitudes.values().map(|a| a.norm_sqr()).collect();
        let usual = median(&mut squares).unwrap_or(0.0).max(f64::MIN_POSITIVE);
        let weight = 0.5 * self.ratio * window as f64 / self.samples.len() as f64;
        let turn = |time: &usize| {
            let (before, after) = (amplitudes[&(time - window)], amplitudes[time]);
            let weaker = (before.norm_sqr().min(after.norm_sqr()) / usual).min(1.0);
            let turned = after * before.conj();
            turned * (weight * weaker / turned.norm().max(f64::MIN_POSITIVE))
        };
        times.iter().map(turn).collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    /// Orders 1, 3.6, 7.2 and 10.7 of a shaft whose angle in turns is a function of the time, in noise; no tachometer.
    fn recording(turns: impl Fn(f64) -> f64) -> Recording {
        let mut recording = simulate(&nominal(), &condition(30.0, 500.0, 26_000), &Start::seeded(3)).unwrap();
        recording.channels.retain(|c| c.name == "ax");
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let value = |i: usize| {
            let angle = TAU * turns(i as f64 / recording.sample_rate_hz);
            let lines: f64 = [1.0, 3.6, 7.2, 10.7].iter().map(|order| 0.5 * (order * angle).sin()).sum();
            lines + rng.random_range(-1.0..1.0)
        };
        recording.channels[0].samples = (0..26_000).map(value).collect();
        recording
    }

    #[test]
    fn missing_samples_are_found_by_the_phases_of_lines() {
        let whole = recording(|t| 30.0 * t);
        for (first, count) in [(9000, 90), (15_000, 300)] {
            let mut cut = whole.clone();
            cut.channels.iter_mut().for_each(|c| drop(c.samples.drain(first..first + count)));
            let gap = gap(&cut).unwrap();
            assert!(gap.sample.abs_diff(first) < super::super::MARGIN, "{gap:?}");
            assert!(gap.count.abs_diff(count) < 6, "{gap:?}");
        }
    }

    /// Beside a steady speed one that drifts, steps or wanders, and a cage that drifts.
    #[test]
    fn null_a_whole_recording_of_any_speed_has_lost_nothing() {
        let even = recording(|t| 30.0 * t);
        assert_eq!(gap(&even), None);
        assert_eq!(gap(&Recording { shaft_hz: Some(1e-9), ..even }), None);
        // By 1.1 ms within 40 ms, as a cage that drifts.
        assert_eq!(gap(&recording(|t| 30.0 * t + 0.016 * ((t - 0.5) / 0.02).tanh())), None);
        for rate in [0.003, 0.01, 0.05] {
            assert_eq!(gap(&recording(|t| 30.0 * (t + 0.5 * rate * t * t))), None, "{rate}");
            assert_eq!(gap(&recording(|t| 30.0 * (t + rate * (t - 0.5).max(0.0)))), None, "{rate}");
            assert_eq!(gap(&recording(|t| 30.0 * (t + 0.1 * rate * (8.0 * t).sin()))), None, "{rate}");
        }
    }
}
