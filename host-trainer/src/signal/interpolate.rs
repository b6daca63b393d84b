//! Band-limited interpolation by a Kaiser-windowed sinc (Oppenheim & Schafer, *Discrete-Time Signal Processing*, §7.5).

use super::settings::InterpolationSettings;

const SETTINGS: InterpolationSettings = InterpolationSettings::DEFAULT;
const HALF: usize = SETTINGS.half_width;
const PLACES: usize = SETTINGS.table_rows;
/// Shape parameter of the Kaiser window for its stopband.
const BETA: f64 = 0.1102 * (SETTINGS.stopband_db - 8.7);

pub(crate) struct Interpolator {
    /// Weights: `PLACES + 1` rows of `2 HALF`.
    weights: Vec<f64>,
}

impl Interpolator {
    pub(crate) fn new() -> Self {
        let mut weights = Vec::with_capacity((PLACES + 1) * 2 * HALF);
        for place in 0..=PLACES {
            let position = place as f64 / PLACES as f64 + (HALF - 1) as f64;
            let start = weights.len();
            weights.extend((0..2 * HALF).map(|tap| {
                let distance = tap as f64 - position;
                let within = (1.0 - (distance / HALF as f64).powi(2)).max(0.0);
                sinc(distance) * bessel_i0(BETA * within.sqrt()) / bessel_i0(BETA)
            }));
            // A constant passes unchanged.
            let sum: f64 = weights[start..].iter().sum();
            weights[start..].iter_mut().for_each(|w| *w /= sum);
        }
        Self { weights }
    }

    /// Value at a position in samples; `of` gives the sample of any index, beyond the ends as well.
    pub(crate) fn at(&self, position: f64, of: impl Fn(i64) -> f64) -> f64 {
        let whole = position.floor();
        let place = (position - whole) * PLACES as f64;
        let row = (place as usize).min(PLACES - 1);
        let share = place - row as f64;
        let first = whole as i64 - (HALF as i64 - 1);
        let rows = self.weights[row * 2 * HALF..(row + 2) * 2 * HALF].split_at(2 * HALF);
        rows.0.iter().zip(rows.1).zip(first..).map(|((a, b), i)| (a + share * (b - a)) * of(i)).sum()
    }
}

/// Sample of an index; the first and last are held beyond the ends.
pub(crate) fn held(samples: &[f64]) -> impl Fn(i64) -> f64 + '_ {
    let last = samples.len().saturating_sub(1) as i64;
    move |i| samples[i.clamp(0, last) as usize]
}

fn sinc(x: f64) -> f64 {
    let angle = std::f64::consts::PI * x;
    if x.abs() < 1e-9 { 1.0 } else { angle.sin() / angle }
}

/// Modified Bessel function of the first kind, order 0, by its series.
fn bessel_i0(x: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 1..60 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_tones_come_out_between_samples_as_stated() {
        let interpolator = Interpolator::new();
        for share in [0.1, 0.5, 0.8] {
            let tone = |t: f64| (std::f64::consts::PI * share * t + 0.4).sin();
            let samples: Vec<f64> = (0..400).map(|i| tone(f64::from(i))).collect();
            for k in 0..900 {
                let at = 50.0 + 0.31 * f64::from(k);
                let got = interpolator.at(at, held(&samples));
                assert!((got - tone(at)).abs() < 1e-4, "{share} {at} {got}");
            }
        }
    }
}
