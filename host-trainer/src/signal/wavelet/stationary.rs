//! Stationary (undecimated) wavelet transform by the à trous algorithm (M. J. Shensa, IEEE Trans. Signal Process. 40 (1992)
//! 2464–2482), theory (98).
//!
//! Shifts and signs are those of PyWavelets. The signal is continued periodically; any length will do.

use super::Wavelet;

/// Stationary wavelet transform of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// Approximation of the last level.
    pub approximation: Vec<f64>,
    /// Details of each level, the finest first.
    pub details: Vec<Vec<f64>>,
}

/// Fewest levels whose approximation lies below a frequency: its band ends at sample rate / 2^(levels + 1).
///
/// ```
/// use ballrace::signal::wavelet::stationary::levels_below;
/// assert_eq!(levels_below(50.0, 25_600.0), 9);
/// ```
pub fn levels_below(hz: f64, sample_rate_hz: f64) -> usize {
    let is_above = |levels: &usize| sample_rate_hz / 2f64.powi(*levels as i32 + 1) >= hz;
    (0..MOST_LEVELS).take_while(is_above).count()
}

/// Most levels: the values of a filter are then 2^29 samples apart, farther than any recording is long.
const MOST_LEVELS: usize = 30;

/// Transform of a signal, level by level.
pub fn decompose(signal: &[f64], wavelet: &Wavelet, levels: usize) -> Decomposition {
    let mut approximation = signal.to_vec();
    let mut details = Vec::with_capacity(levels);
    for level in 0..levels.min(MOST_LEVELS) {
        details.push(filtered(&approximation, &wavelet.high, level));
        approximation = filtered(&approximation, &wavelet.low, level);
    }
    Decomposition { approximation, details }
}

impl Decomposition {
    /// Signal of which this is the transform.
    pub fn reconstruct(&self, wavelet: &Wavelet) -> Vec<f64> {
        let mut signal = self.approximation.clone();
        for (level, details) in self.details.iter().enumerate().rev() {
            let mut finer = vec![0.0; signal.len()];
            add_adjoint(&mut finer, &signal, &wavelet.low, level);
            add_adjoint(&mut finer, details, &wavelet.high, level);
            signal = finer;
        }
        signal
    }
}

/// Samples that a level's filter moves a signal, so that it acts around each sample, and the distance of its values.
fn reach(filter: &[f64], level: usize, len: usize) -> (usize, usize) {
    let step = 1 << level;
    (step * (filter.len() / 2) % len.max(1), step % len.max(1))
}

/// Signal filtered at a level: y_n = Σ_k f_k x_(n + 2^j L/2 − 2^j k).
fn filtered(signal: &[f64], filter: &[f64], level: usize) -> Vec<f64> {
    let len = signal.len();
    let (shift, step) = reach(filter, level, len);
    let mut out = vec![0.0; len];
    let mut from = shift;
    for value in filter {
        add_rotated(&mut out, signal, *value, from);
        from = (from + len - step) % len.max(1);
    }
    out
}

/// Adds half the adjoint of [`filtered`], which together with that of the other filter is its inverse.
fn add_adjoint(out: &mut [f64], coefficients: &[f64], filter: &[f64], level: usize) {
    let len = out.len();
    let (shift, step) = reach(filter, level, len);
    let mut from = (len - shift) % len.max(1);
    for value in filter {
        add_rotated(out, coefficients, 0.5 * value, from);
        from = (from + step) % len.max(1);
    }
}

/// Adds `factor` times a signal whose sample `from` becomes the first.
fn add_rotated(out: &mut [f64], signal: &[f64], factor: f64, from: usize) {
    let (before, after) = signal.split_at(from);
    let (head, tail) = out.split_at_mut(after.len());
    head.iter_mut().zip(after).for_each(|(out, s)| *out += factor * s);
    tail.iter_mut().zip(before).for_each(|(out, s)| *out += factor * s);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::test_signals::gaussian;

    #[derive(serde::Deserialize)]
    struct Golden {
        signal: Vec<f64>,
        wavelets: std::collections::BTreeMap<String, Vec<Vec<f64>>>,
    }

    #[test]
    fn golden_coefficients_are_those_of_pywavelets() {
        let golden: Golden = serde_json::from_str(include_str!("pywavelets.json")).unwrap();
        assert_eq!(golden.wavelets.len(), Wavelet::names().count());
        for (name, expected) in &golden.wavelets {
            let made = decompose(&golden.signal, &name.parse().unwrap(), 2);
            let made = [&made.approximation, &made.details[1], &made.details[0]];
            for (made, expected) in made.into_iter().zip(expected) {
                let error = made.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error < 1e-10, "{name}: {error}");
            }
        }
    }

    #[test]
    fn invariant_the_inverse_gives_the_signal_back() {
        for len in [2560, 1001, 7, 1] {
            let signal = gaussian(len, 3);
            for name in Wavelet::names() {
                let wavelet: Wavelet = name.parse().unwrap();
                let back = decompose(&signal, &wavelet, 9).reconstruct(&wavelet);
                let error = back.iter().zip(&signal).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error < 1e-10, "{name}, {len} samples: {error}");
            }
        }
    }

    #[test]
    fn invariant_a_shifted_signal_has_shifted_coefficients() {
        let wavelet: Wavelet = "sym5".parse().unwrap();
        let signal = gaussian(640, 4);
        let mut shifted = signal.clone();
        shifted.rotate_left(77);
        let mut expected = decompose(&signal, &wavelet, 4);
        expected.details.iter_mut().for_each(|level| level.rotate_left(77));
        assert_eq!(decompose(&shifted, &wavelet, 4).details, expected.details);
    }

    #[test]
    fn no_samples_have_no_coefficients() {
        let wavelet: Wavelet = "db2".parse().unwrap();
        assert!(decompose(&[], &wavelet, 3).reconstruct(&wavelet).is_empty());
    }
}
