//! Shaft angle over time, and spectra in orders of the shaft, theory (77).
//!
//! A recording is resampled at even angles; what repeats with the shaft is then a line at any speed. Method: computed
//! order tracking, K. R. Fyfe, E. D. S. Munck, Mechanical Systems and Signal Processing 11 (1997) 187–205.

use super::Sample;
use super::interpolate::{Interpolator, held};
use super::settings::OrderSettings;
use super::spectrum::amplitudes;

const SETTINGS: OrderSettings = OrderSettings::DEFAULT;

/// Failure of a tachometer channel to give an angle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TachoError {
    /// Fewer than two whole turns.
    #[error("tacho: found {found} pulses, expected 3 or more")]
    TooFew {
        /// Pulses found.
        found: usize,
    },
    /// Turns of so few samples that they are none.
    #[error("tacho: found turns of {found:.1} samples, expected {expected} or more")]
    TooFast {
        /// Mean length of a turn, samples.
        found: f64,
        /// Least length, samples.
        expected: f64,
    },
    /// A turn far longer or shorter than the others.
    #[error("tacho: the turn from sample {sample} lasts {found:.1} samples, expected about {expected:.1}")]
    Uneven {
        /// Sample of the pulse that begins the turn.
        sample: usize,
        /// Length of the turn, samples.
        found: f64,
        /// The median length, samples.
        expected: f64,
    },
}

/// Shaft angle over time, turns: 0 at the first pulse or, without pulses, at time 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaftAngle {
    law: Law,
    mean_hz: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Law {
    /// Constant speed, Hz.
    Constant(f64),
    /// Time in s as a polynomial of (turn − centre)/half, lowest power first.
    Polynomial { centre: f64, half: f64, coefficients: Vec<f64> },
    /// Time of each turn's start, s, cubic between.
    Pulses(Vec<f64>),
}

/// Samples of a tachometer at which it rises above one half. Of a pulse that the recording begins in, the start is not known.
pub fn pulses<S: Sample>(tacho: &[S]) -> Vec<usize> {
    let high = |i: usize| tacho.get(i).is_some_and(|v| (*v).into() > 0.5);
    let begins = |i: &usize| high(*i) && (if *i == 0 { !high(1) } else { !high(i - 1) });
    (0..tacho.len()).filter(begins).collect()
}

impl ShaftAngle {
    /// Angle at a constant speed.
    pub fn constant(shaft_hz: f64) -> Self {
        Self { law: Law::Constant(shaft_hz), mean_hz: shaft_hz }
    }

    /// Angle from a tachometer channel that rises above one half at each turn's first sample.
    ///
    /// A turn began within the sample period before its pulse; the middle of that period is its time. The law is the
    /// polynomial of least degree, up to 6, within 0.6 samples of all these times: ±0.5 is their quantisation. Without
    /// one, cubics join the times.
    ///
    /// # Errors
    /// Fewer than three pulses, turns of too few samples, or one far longer or shorter than the others.
    pub fn from_tacho<S: Sample>(tacho: &[S], sample_rate_hz: f64) -> Result<Self, TachoError> {
        let pulses = pulses(tacho);
        if pulses.len() < 3 {
            return Err(TachoError::TooFew { found: pulses.len() });
        }
        let mean_samples = (pulses[pulses.len() - 1] - pulses[0]) as f64 / (pulses.len() - 1) as f64;
        if mean_samples < SETTINGS.min_turn_samples {
            return Err(TachoError::TooFast { found: mean_samples, expected: SETTINGS.min_turn_samples });
        }
        let lengths: Vec<f64> = pulses.windows(2).map(|w| (w[1] - w[0]) as f64).collect();
        let expected = super::transform::median(&mut lengths.clone()).unwrap_or(0.0);
        let uneven = lengths
            .iter()
            .position(|l| *l > SETTINGS.max_turn_ratio * expected || *l < expected / SETTINGS.max_turn_ratio);
        if let Some(turn) = uneven {
            return Err(TachoError::Uneven { sample: pulses[turn], found: lengths[turn], expected });
        }
        let times: Vec<f64> = pulses.iter().map(|p| (*p as f64 - 0.5) / sample_rate_hz).collect();
        let turns = (times.len() - 1) as f64;
        let mean_hz = turns / (times[times.len() - 1] - times[0]);
        let highest = SETTINGS.max_degree.min((times.len() / SETTINGS.pulses_per_coefficient).max(1) - 1).max(1);
        let (centre, half) = (0.5 * turns, 0.5 * turns);
        let polynomial = (1..=highest).map(|degree| fit_polynomial(&times, degree)).find(|coefficients| {
            let miss = |(k, t): (usize, &f64)| (horner(coefficients, (k as f64 - centre) / half) - t).abs();
            times.iter().enumerate().map(miss).fold(0.0, f64::max) * sample_rate_hz <= SETTINGS.pulse_tolerance_samples
        });
        let law = match polynomial {
            Some(coefficients) => Law::Polynomial { centre, half, coefficients },
            None => Law::Pulses(times),
        };
        Ok(Self { law, mean_hz })
    }

    /// Mean speed, Hz.
    pub fn mean_hz(&self) -> f64 {
        self.mean_hz
    }

    /// Time of an angle, s.
    pub fn time_s(&self, turns: f64) -> f64 {
        match &self.law {
            Law::Constant(shaft_hz) => turns / shaft_hz,
            Law::Polynomial { centre, half, coefficients } => horner(coefficients, (turns - centre) / half),
            Law::Pulses(times) => {
                // Hermite's cubic with slopes between the neighbours; linear beyond the ends.
                let last = times.len() - 1;
                let slope = |k: usize| {
                    let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
                    (times[b] - times[a]) / (b - a) as f64
                };
                if turns <= 0.0 {
                    return times[0] + turns * slope(0);
                }
                if turns >= last as f64 {
                    return times[last] + (turns - last as f64) * slope(last);
                }
                let k = (turns as usize).min(last - 1);
                let u = turns - k as f64;
                let (u2, u3) = (u * u, u * u * u);
                (2.0 * u3 - 3.0 * u2 + 1.0) * times[k]
                    + (u3 - 2.0 * u2 + u) * slope(k)
                    + (3.0 * u2 - 2.0 * u3) * times[k + 1]
                    + (u3 - u2) * slope(k + 1)
            }
        }
    }

    /// Angle at a time, turns.
    pub fn turns(&self, time_s: f64) -> f64 {
        // Newton's method with a difference quotient.
        let mut turns = (time_s - self.time_s(0.0)) * self.mean_hz;
        for _ in 0..SETTINGS.newton_iterations {
            let miss = time_s - self.time_s(turns);
            let slope = (self.time_s(turns + 0.05) - self.time_s(turns - 0.05)) / 0.1;
            let step = miss / slope.max(0.1 / self.mean_hz);
            turns += step;
            if step.abs() < SETTINGS.newton_tolerance_turns {
                break;
            }
        }
        turns
    }
}

fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Least-squares polynomial on −1…1, lowest power first, by polynomials orthogonal on the points (Forsythe 1957).
fn fit_polynomial(values: &[f64], degree: usize) -> Vec<f64> {
    let n = values.len();
    let x = |k: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
    let (mut before, mut basis) = (vec![], vec![1.0]);
    let mut norm_before = 1.0;
    let mut out = vec![0.0; degree + 1];
    let mut rest = values.to_vec();
    for _ in 0..=degree {
        let at: Vec<f64> = (0..n).map(|k| horner(&basis, x(k))).collect();
        let norm: f64 = at.iter().map(|v| v * v).sum();
        let weight = at.iter().zip(&rest).map(|(a, v)| a * v).sum::<f64>() / norm;
        rest.iter_mut().zip(&at).for_each(|(v, a)| *v -= weight * a);
        out.iter_mut().zip(&basis).for_each(|(o, b): (&mut f64, &f64)| *o += weight * b);
        let shift = at.iter().enumerate().map(|(k, a)| x(k) * a * a).sum::<f64>() / norm;
        // Next: (x − shift) basis − (norm/norm_before) before.
        let mut next = vec![0.0; basis.len() + 1];
        for (k, b) in basis.iter().enumerate() {
            next[k + 1] += b;
            next[k] -= shift * b;
        }
        for (k, b) in before.iter().enumerate() {
            let b: &f64 = b;
            next[k] -= norm / norm_before * b;
        }
        (before, basis, norm_before) = (basis, next, norm);
    }
    out
}

/// A recording resampled at even angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Angular {
    /// Samples, `per_turn` to a turn.
    pub samples: Vec<f64>,
    /// Samples a turn, even: keeps the recording's band at the slowest turn.
    pub per_turn: usize,
    /// Angle of the first sample, whole turns.
    pub first_turn: i64,
}

/// Resamples the whole turns of a recording at even angles, theory (77); `None` if there is no whole turn.
pub fn resample<S: Sample>(samples: &[S], sample_rate_hz: f64, angle: &ShaftAngle) -> Option<Angular> {
    let samples: Vec<f64> = samples.iter().map(|v| (*v).into()).collect();
    let end_s = samples.len().checked_sub(1).filter(|n| *n > 0)? as f64 / sample_rate_hz;
    let first = (angle.turns(0.0) - 1e-9).ceil();
    let last = (angle.turns(end_s) + 1e-9).floor();
    if !(last > first && last - first < 1e7) {
        return None;
    }
    let turns = (last - first) as usize;
    let slowest_s = (0..turns).map(|k| first + k as f64).map(|k| angle.time_s(k + 1.0) - angle.time_s(k));
    let per_turn = (slowest_s.fold(0.0, f64::max) * sample_rate_hz).ceil() as usize;
    let per_turn = per_turn.max(2).next_multiple_of(2);
    let interpolator = Interpolator::new();
    let of = held(&samples);
    let at = |k: usize| {
        let time_s = angle.time_s(first + k as f64 / per_turn as f64);
        interpolator.at(time_s * sample_rate_hz, &of)
    };
    Some(Angular { samples: (0..turns * per_turn).map(at).collect(), per_turn, first_turn: first as i64 })
}

/// Amplitudes over orders of the shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderSpectrum {
    /// Step from order 0, orders.
    pub step: f64,
    /// Peak amplitudes in the unit of the samples.
    pub values: Vec<f64>,
}

impl OrderSpectrum {
    /// Order and value, from order 0 on.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.values.iter().enumerate().map(|(k, v)| (k as f64 * self.step, *v))
    }
}

/// Amplitude spectrum over orders, Hann window over all whole turns; `None` for fewer than 2 turns.
pub fn order_spectrum<S: Sample>(samples: &[S], sample_rate_hz: f64, angle: &ShaftAngle) -> Option<OrderSpectrum> {
    let angular = resample(samples, sample_rate_hz, angle)?;
    if angular.samples.len() < 2 * angular.per_turn {
        return None;
    }
    // With samples a turn for samples a second, what was Hz is order.
    let spectrum = amplitudes(&[&angular.samples], angular.per_turn as f64)?;
    Some(OrderSpectrum { step: spectrum.step_hz, values: spectrum.values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const RATE: f64 = 10_000.0;

    /// Turns of a shaft that speeds up evenly from 20 Hz by 4 Hz a second, from a quarter of a turn on.
    fn turns(t: f64) -> f64 {
        0.25 + 20.0 * t + 2.0 * t * t
    }

    fn tacho(turns: impl Fn(f64) -> f64, count: usize) -> Vec<f64> {
        let whole = |i: i64| turns(i as f64 / RATE).floor();
        (0..count as i64).map(|i| f64::from(u8::from(whole(i) != whole(i - 1)))).collect()
    }

    #[test]
    fn invariant_a_chirp_is_one_line_in_orders() {
        let samples: Vec<f64> = (0..30_000).map(|i| 1.5 * (TAU * 7.0 * turns(i as f64 / RATE)).cos()).collect();
        let angle = ShaftAngle::from_tacho(&tacho(turns, 30_000), RATE).unwrap();
        assert!(matches!(angle.law, Law::Polynomial { .. }));
        let spectrum = order_spectrum(&samples, RATE, &angle).unwrap();
        let at = (7.0 / spectrum.step).round() as usize;
        assert!((spectrum.values[at] - 1.5).abs() < 0.01, "{}", spectrum.values[at]);
        let elsewhere = spectrum.points().filter(|(o, _)| (o - 7.0).abs() > 3.0 * spectrum.step);
        let most = elsewhere.map(|(_, v)| v).fold(0.0, f64::max);
        assert!(most < 0.02, "{most}");
        // In frequency it is smeared over 140 to 220 Hz.
        let smeared = amplitudes(&[&samples], RATE).unwrap().values.into_iter().fold(0.0, f64::max);
        assert!(smeared < 0.4, "{smeared}");
    }

    #[test]
    fn invariant_angle_and_time_are_inverses() {
        let wobbling = |t: f64| 30.0 * t + 0.02 * (TAU * 9.0 * t).sin();
        let constant = ShaftAngle::constant(24.67);
        let even = ShaftAngle::from_tacho(&tacho(|t| 25.3 * t + 0.4, 20_000), RATE).unwrap();
        let pulses = ShaftAngle::from_tacho(&tacho(wobbling, 20_000), RATE).unwrap();
        assert!(matches!(pulses.law, Law::Pulses(_)));
        for angle in [constant, even.clone(), pulses.clone()] {
            for k in 0..200 {
                let time_s = 0.01 * f64::from(k);
                assert!((angle.time_s(angle.turns(time_s)) - time_s).abs() < 1e-9);
            }
        }
        // Fifty pulses to a sample each: the speed is known to a few millionths.
        let slope = even.turns(1.5) - even.turns(0.5);
        assert!((slope / 25.3 - 1.0).abs() < 1e-5, "{slope}");
        // Angle 0 is the first pulse, when a whole turn was complete.
        assert!((pulses.turns(1.0) - (wobbling(1.0) - 0.0)).abs() < 0.01, "{}", pulses.turns(1.0));
    }

    #[test]
    fn pulses_out_of_step_are_refused() {
        let mut missing = tacho(|t| 25.0 * t + 0.1, 10_000);
        let second = missing.iter().enumerate().filter(|(_, v)| **v > 0.5).nth(3).unwrap().0;
        missing[second] = 0.0;
        let error = ShaftAngle::from_tacho(&missing, RATE).unwrap_err();
        assert!(matches!(error, TachoError::Uneven { expected, .. } if (expected - 400.0).abs() < 2.0), "{error}");
        assert_eq!(ShaftAngle::from_tacho(&[0.0, 1.0, 0.0], RATE), Err(TachoError::TooFew { found: 1 }));
    }
}
