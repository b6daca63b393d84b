//! Synchronous average and residual, theory (78).
//!
//! S. Braun, "The synchronous (time domain) average revisited", Mechanical Systems and Signal Processing 25 (2011)
//! 1087–1102: over N turns, what is not synchronous falls by √N in amplitude. Gears, unbalance and a bent shaft are
//! synchronous; bearings are not, as balls slip and their orders are not integers.

use super::Sample;
use super::interpolate::Interpolator;
use super::order::{ShaftAngle, resample};

/// Synchronous average of a recording and its residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Synchronous {
    /// The periodic part at even angles over one period, from angle 0 of the [`ShaftAngle`] on.
    pub average: Vec<f64>,
    /// Turns in a period.
    pub period_turns: usize,
    /// Periods averaged over.
    pub periods: usize,
    /// Recording less its periodic part, sample by sample over its whole length.
    pub residual: Vec<f64>,
    /// Share of the recording's variance that the periodic part explains, corrected for noise (1/N of the rest, for N
    /// periods); at most 1, about 0 for noise.
    pub explained: f64,
}

/// Averages a recording over periods of `period_turns`, theory (78).
///
/// `None` for fewer than two periods, or `period_turns` of 0.
pub fn average<S: Sample>(
    samples: &[S],
    sample_rate_hz: f64,
    angle: &ShaftAngle,
    period_turns: usize,
) -> Option<Synchronous> {
    let angular = resample(samples, sample_rate_hz, angle)?;
    let length = angular.per_turn.checked_mul(period_turns).filter(|length| *length > 0)?;
    let periods = angular.samples.len() / length;
    if periods < 2 {
        return None;
    }
    let mut average = vec![0.0; length];
    for period in angular.samples.chunks_exact(length) {
        average.iter_mut().zip(period).for_each(|(a, v)| *a += v / periods as f64);
    }
    // The resampled record may begin within a period; a period begins at angle 0.
    let shift = angular.first_turn.rem_euclid(period_turns as i64) as usize * angular.per_turn;
    average.rotate_right(shift);
    let interpolator = Interpolator::new();
    let periodic = |i: usize| {
        let turns = angle.turns(i as f64 / sample_rate_hz).rem_euclid(period_turns as f64);
        interpolator.at(turns * angular.per_turn as f64, |k| average[k.rem_euclid(length as i64) as usize])
    };
    let residual: Vec<f64> = samples.iter().enumerate().map(|(i, v)| (*v).into() - periodic(i)).collect();
    // Over the averaged samples, whose shares add up exactly.
    let mean = average.iter().sum::<f64>() / length as f64;
    let power = |values: &[f64]| values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let (whole, part) = (power(&angular.samples[..periods * length]), power(&average));
    let share = if whole > 0.0 { part / whole } else { 0.0 };
    let n = periods as f64;
    Some(Synchronous { average, period_turns, periods, residual, explained: (n * share - 1.0) / (n - 1.0) })
}

#[cfg(test)]
mod tests {
    use super::super::test_signals::gaussian;
    use super::*;
    use std::f64::consts::TAU;

    const RATE: f64 = 10_000.0;

    fn periodic(turns: f64) -> f64 {
        (TAU * turns).sin() + 0.6 * (TAU * 5.0 * turns + 1.0).cos()
    }

    #[test]
    fn invariant_the_error_of_the_average_falls_with_the_turns() {
        for (count, expected_turns) in [(20_000, 50), (80_000, 200)] {
            let angle = ShaftAngle::constant(25.0);
            let noise = gaussian(count, 1);
            let samples: Vec<f64> = (0..count).map(|i| periodic(25.0 * i as f64 / RATE) + noise[i]).collect();
            let found = average(&samples, RATE, &angle, 1).unwrap();
            assert!(found.periods.abs_diff(expected_turns) <= 1, "{}", found.periods);
            let length = found.average.len() as f64;
            let error = found.average.iter().enumerate().map(|(k, v)| (v - periodic(k as f64 / length)).powi(2));
            // Noise of variance 1, so 1/N.
            let scaled = error.sum::<f64>() / length * found.periods as f64;
            assert!((0.8..1.2).contains(&scaled), "{count} {scaled}");
            // Variance 0.68 of 1.68.
            assert!((found.explained - 0.68 / 1.68).abs() < 0.02, "{}", found.explained);
            let rest = found.residual.iter().map(|v| v * v).sum::<f64>() / count as f64;
            assert!((rest - 1.0).abs() < 0.05, "{rest}");
        }
    }

    #[test]
    fn the_periodic_part_goes_whatever_the_speed_does_and_wherever_the_first_pulse_is() {
        let turns = |t: f64| 0.7 + 22.0 * t + 1.5 * t * t;
        let whole = |i: i64| turns(i as f64 / RATE).floor();
        let tacho: Vec<f64> = (0..20_000).map(|i| f64::from(u8::from(whole(i) != whole(i - 1)))).collect();
        let samples: Vec<f64> = (0..20_000).map(|i| periodic(turns(f64::from(i) / RATE) / 2.0)).collect();
        let angle = ShaftAngle::from_tacho(&tacho, RATE).unwrap();
        let found = average(&samples, RATE, &angle, 2).unwrap();
        // A slow turn takes 450 samples, and a pulse is known to half of one.
        assert!(found.explained > 0.9999, "{}", found.explained);
        let middle = found.residual[100..19_900].iter().map(|v| v.abs()).fold(0.0, f64::max);
        assert!(middle < 0.03, "{middle}");
        assert_eq!(average(&samples, RATE, &angle, 0), None);
        assert_eq!(average(&samples, RATE, &angle, 40), None);
    }

    #[test]
    fn null_noise_repeats_nothing() {
        for seed in 0..10 {
            let found = average(&gaussian(20_000, seed), RATE, &ShaftAngle::constant(25.0), 1).unwrap();
            assert!(found.explained.abs() < 0.01, "{}", found.explained);
        }
    }
}
