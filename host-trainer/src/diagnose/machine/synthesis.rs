//! Held-out recordings as the machine would give them without the cause and with it.
//!
//! Without: noise of the baseline's power density. With: noise of the density that the other recordings predict, its power
//! modulated, band by band, as theirs is: a train of impacts through a path that is known by its power alone.

use std::ops::Range;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use realfft::num_complex::Complex;

use super::comb::Comb;
use super::modulation::{Modulation, Tones, partition};
use super::observation::{Observation, neighbours};
use super::settings::SynthesisSettings;
use crate::signal::kinematics::Geometry;
use crate::signal::spectrum::{Spectrum, welch};
use crate::signal::transform::{forward, hann, inverse_plan};

const SETTINGS: SynthesisSettings = SynthesisSettings::DEFAULT;

/// Modulation of the power of a band.
#[derive(Clone, Debug)]
pub struct Modulator {
    /// Band, Hz.
    pub band_hz: Range<f64>,
    /// Orders of the shaft with the amplitudes of the relative modulation.
    pub lines: Vec<(f64, f64)>,
}

impl Modulator {
    /// The same band without any modulation.
    pub fn still(&self) -> Self {
        Self { lines: Vec::new(), ..self.clone() }
    }

    /// Share of the band's power that comes and goes: what the least power in a few turns lacks to the mean.
    pub fn share(&self) -> f64 {
        let least = self.course(SETTINGS.course_turns / COURSE as f64).into_iter().fold(1.0, f64::min);
        (1.0 - least).clamp(0.0, SETTINGS.most_share)
    }

    /// Power over its mean at steps of `turn` turns of the shaft.
    fn course(&self, turn: f64) -> Vec<f64> {
        let at = |i: usize| {
            let wave = |(order, a): &(f64, f64)| a * (std::f64::consts::TAU * order * turn * i as f64).cos();
            1.0 + self.lines.iter().map(wave).sum::<f64>()
        };
        (0..COURSE).map(at).collect()
    }

    /// Modulator whose power, never below nothing, has the lines of this one: the bound distorts a deep modulation.
    fn bounded(&self) -> Self {
        let turn = SETTINGS.course_turns / COURSE as f64;
        let waves: Vec<Vec<f64>> = self
            .lines
            .iter()
            .map(|(order, _)| (0..COURSE).map(|i| (std::f64::consts::TAU * order * turn * i as f64).cos()).collect())
            .collect();
        let window = hann(COURSE);
        let weight = 0.5 * window.iter().sum::<f64>();
        let mut out = self.clone();
        for _ in 0..SETTINGS.rounds {
            let course: Vec<f64> = out.course(turn).into_iter().map(|v| v.max(SETTINGS.least_power)).collect();
            let mean = course.iter().zip(&window).map(|(v, w)| v * w).sum::<f64>() / (2.0 * weight);
            for ((line, wanted), wave) in out.lines.iter_mut().zip(&self.lines).zip(&waves) {
                let sum: f64 = course.iter().zip(wave).zip(&window).map(|((v, c), w)| (v / mean - 1.0) * c * w).sum();
                line.1 += SETTINGS.step * (wanted.1 - sum / weight);
            }
        }
        out
    }
}

/// Points of a course over a few turns of the shaft.
const COURSE: usize = 4096;

/// Modulators of a channel in bands as wide as a comb's, mean over recordings.
pub fn modulators(
    fitted: &[&Observation],
    channel: usize,
    comb: &Comb,
    width_hz: f64,
    geometry: &Geometry,
) -> Vec<Modulator> {
    let Some(first) = fitted.first() else { return Vec::new() };
    let nyquist = 0.5 * first.sample_rate_hz;
    let bands = partition(nyquist, (nyquist / width_hz).round().max(1.0) as usize);
    let slip = |n: usize| comb.slip.get(n).or(comb.slip.first()).copied().unwrap_or_default();
    let mut powers: Vec<Vec<f64>> = Vec::new();
    for (n, recording) in fitted.iter().enumerate() {
        let Some(samples) = recording.channels[channel].as_deref() else { continue };
        let orders = comb.pattern.lines(geometry, slip(n), None);
        let highest = orders.iter().copied().fold(0.0, f64::max) * 1.1 * recording.shaft_hz;
        let (rate, shaft_hz) = (recording.sample_rate_hz, recording.shaft_hz);
        let Some(found) = Modulation::new(samples, rate, shaft_hz, &bands, highest, Tones::Kept) else { continue };
        powers.resize(bands.len(), vec![0.0; orders.len()]);
        for (band, sums) in found.bands.iter().zip(&mut powers) {
            for (order, sum) in orders.iter().zip(sums) {
                let at = (order / found.order_step).round() as usize;
                if at == 0 || at + 1 >= band.shown {
                    continue;
                }
                let excess = band.power[at] - band.floor[at];
                if excess > SETTINGS.line_excess * band.floor[at] {
                    *sum += excess / fitted.len() as f64;
                }
            }
        }
    }
    let mean = comb.slip.iter().sum::<f64>() / comb.slip.len().max(1) as f64;
    let orders = comb.pattern.lines(geometry, mean, None);
    let lines = |sums: Vec<f64>| orders.iter().copied().zip(sums.into_iter().map(f64::sqrt)).collect();
    bands.into_iter().zip(powers).map(|(band_hz, sums)| Modulator { band_hz, lines: lines(sums) }).collect()
}

/// Power density of a channel on the grid of `segment` samples.
fn density(of: &Observation, channel: usize, segment: usize) -> Option<Vec<f64>> {
    Some(welch(&[of.channels[channel].as_deref()?], of.sample_rate_hz, segment)?.values)
}

/// Power densities of a held-out channel without and with the cause.
#[derive(Clone, Debug)]
pub struct Densities {
    /// Without the cause.
    pub before: Spectrum,
    /// With it.
    pub after: Spectrum,
}

impl Densities {
    /// Densities by the other recordings and the baseline; `None` if there are none of this channel.
    ///
    /// Without a baseline the part of the power that the cause modulates is left out before.
    pub fn predict(
        held_out: &Observation,
        others: &[&Observation],
        baseline: &[Observation],
        channel: usize,
        modulators: &[Modulator],
    ) -> Option<Self> {
        let around = neighbours(others, held_out.shaft_hz);
        let matched = held_out.matches(baseline);
        let all = || around.iter().map(|(r, _)| *r).chain(matched.iter().copied()).chain([held_out]);
        let shortest = all().map(Observation::len).min()?;
        let segment = SETTINGS.segment.min(2 * shortest / (SETTINGS.least_segments + 1)).max(8);
        let step_hz = held_out.sample_rate_hz / segment as f64;
        // Interpolated between speeds; in logarithms, since a change is a factor.
        let mut straight = vec![0.0; segment / 2 + 1];
        let mut ratio = vec![0.0; segment / 2 + 1];
        let mut compared = 0.0;
        for (recording, weight) in &around {
            let now = density(recording, channel, segment)?;
            straight.iter_mut().zip(&now).for_each(|(s, v)| *s += weight * v.max(1e-30).ln());
            if let Some(then) = healthy(recording, baseline, channel, segment) {
                let pairs = now.iter().zip(&then).map(|(a, b)| (a.max(1e-30) / b.max(1e-30)).ln());
                ratio.iter_mut().zip(pairs).for_each(|(r, v)| *r += weight * v);
                compared += weight;
            }
        }
        let spectrum = |values: Vec<f64>| Spectrum { step_hz, values };
        let then = healthy(held_out, baseline, channel, segment).filter(|_| compared > 0.99);
        let Some(then) = then else {
            let after: Vec<f64> = straight.iter().map(|v| v.exp()).collect();
            let left = |k: usize| {
                let hz = k as f64 * step_hz;
                let of_band = modulators.iter().find(|m| m.band_hz.contains(&hz)).or(modulators.last());
                1.0 - of_band.map_or(0.0, Modulator::share)
            };
            let before = after.iter().enumerate().map(|(k, v)| v * left(k)).collect();
            return Some(Self { before: spectrum(before), after: spectrum(after) });
        };
        let smooth = smoothed(&ratio);
        let after = (0..then.len()).map(|k| (0.5 * (straight[k] + then[k].max(1e-30).ln() + smooth[k])).exp());
        Some(Self { after: spectrum(after.collect()), before: spectrum(then) })
    }
}

/// Mean density of the healthy machine under the conditions of a recording.
fn healthy(of: &Observation, baseline: &[Observation], channel: usize, segment: usize) -> Option<Vec<f64>> {
    let matched = of.matches(baseline);
    let samples: Vec<&[f64]> = matched.iter().filter_map(|m| m.channels[channel].as_deref()).collect();
    Some(welch(&samples, of.sample_rate_hz, segment)?.values)
}

fn smoothed(values: &[f64]) -> Vec<f64> {
    let reach = SETTINGS.smooth / 2;
    let mean = |k: usize| {
        let near = &values[k.saturating_sub(reach)..(k + reach + 1).min(values.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// Noise of a power density, its power modulated.
pub fn noise(
    length: usize,
    sample_rate_hz: f64,
    shaft_hz: f64,
    density: &Spectrum,
    modulators: &[Modulator],
    seed: u64,
) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let step_hz = sample_rate_hz / length as f64;
    let mut sum = vec![Complex::default(); length / 2 + 1];
    let still = [Modulator { band_hz: 0.0..f64::INFINITY, lines: Vec::new() }];
    for modulator in if modulators.is_empty() { &still } else { modulators } {
        let mut white: Vec<f64> = (0..length).map(|_| StandardNormal.sample(&mut random)).collect();
        if modulator.lines.iter().any(|(_, amplitude)| *amplitude > 0.0) {
            let bounded = modulator.bounded();
            let gain = |i: usize| {
                let turns = shaft_hz * i as f64 / sample_rate_hz;
                let wave = |(order, a): &(f64, f64)| a * (std::f64::consts::TAU * order * turns).cos();
                (1.0 + bounded.lines.iter().map(wave).sum::<f64>()).max(SETTINGS.least_power)
            };
            let gains: Vec<f64> = (0..length).map(gain).collect();
            let mean = gains.iter().sum::<f64>() / length as f64;
            white.iter_mut().zip(&gains).for_each(|(v, g)| *v *= (g / mean).sqrt());
        }
        let last = modulator.band_hz.end >= 0.5 * sample_rate_hz * (1.0 - 1e-9);
        for (k, bin) in forward(&mut white).into_iter().enumerate() {
            let hz = k as f64 * step_hz;
            if modulator.band_hz.contains(&hz) || (last && hz >= modulator.band_hz.start) {
                sum[k] += bin * (0.5 * sample_rate_hz * value_at(density, hz)).sqrt() / length as f64;
            }
        }
    }
    sum[0] = Complex::default();
    if length.is_multiple_of(2) {
        sum[length / 2].im = 0.0;
    }
    let mut out = vec![0.0; length];
    // Both buffers have the transform's length.
    inverse_plan(length).process(&mut sum, &mut out).unwrap_or_default();
    out
}

/// Modulators with which noise of a density has the modulation of the given ones: where a density has peaks narrower than the
/// modulation is fast, less of it passes.
pub fn passed(
    wanted: &[Modulator],
    held_out: &Observation,
    length: usize,
    density: &Spectrum,
    seed: u64,
) -> Vec<Modulator> {
    let (rate, shaft_hz) = (held_out.sample_rate_hz, held_out.shaft_hz);
    let bands: Vec<Range<f64>> = wanted.iter().map(|m| m.band_hz.clone()).collect();
    let orders = || wanted.iter().flat_map(|m| m.lines.iter().map(|(order, _)| *order));
    let highest_hz = 1.1 * shaft_hz * orders().fold(0.0, f64::max);
    let mut out = wanted.to_vec();
    for _ in 0..SETTINGS.passes {
        let made = noise(length, rate, shaft_hz, density, &out, seed);
        let Some(found) = Modulation::new(&made, rate, shaft_hz, &bands, highest_hz, Tones::Kept) else { break };
        for ((modulator, wanted), band) in out.iter_mut().zip(wanted).zip(&found.bands) {
            let depth: f64 = wanted.lines.iter().map(|(_, a)| a * a).sum();
            let at = |order: f64| (order / found.order_step).round() as usize;
            let power = |order: f64| band.power.get(at(order)).copied().unwrap_or_default();
            let reached: f64 = wanted.lines.iter().filter(|l| l.1 > 0.0).map(|l| power(l.0)).sum();
            if depth < SETTINGS.least_depth.powi(2) || reached <= 0.0 {
                continue;
            }
            let factor = (depth / reached).sqrt().clamp(0.5, 2.0);
            modulator.lines.iter_mut().for_each(|(_, a)| *a = (*a * factor).min(SETTINGS.most_amplitude));
        }
    }
    out
}

/// Density at a frequency, linear between values.
fn value_at(density: &Spectrum, hz: f64) -> f64 {
    let place = hz / density.step_hz;
    let at = (place as usize).min(density.values.len() - 1);
    let next = (at + 1).min(density.values.len() - 1);
    let part = (place - at as f64).clamp(0.0, 1.0);
    density.values[at] * (1.0 - part) + density.values[next] * part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With and without a modulation of no depth the noise is the same, and with one it is not.
    #[test]
    fn null_noises_with_and_without_a_cause_differ_by_its_modulation_alone() {
        let density = Spectrum { step_hz: 100.0, values: vec![1.0; 51] };
        let modulated =
            |depth: f64| [0.0..2000.0, 2000.0..5000.0].map(|band_hz| Modulator { band_hz, lines: vec![(3.6, depth)] });
        let made = |modulators: &[Modulator]| noise(4096, 10_000.0, 30.0, &density, modulators, 5);
        let still = made(&modulated(0.8).map(|modulator| modulator.still()));
        let apart = |other: &[f64]| other.iter().zip(&still).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let power: f64 = still.iter().map(|v| v * v).sum();
        assert!(apart(&made(&modulated(0.0))) < 1e-20 * power);
        let of_cause = apart(&made(&modulated(0.8))) / power;
        assert!((0.01..0.5).contains(&of_cause), "{of_cause}");
    }
}
