//! Autoregression by Burg's method: whitening, and colouring again.

use crate::signal::settings::SurrogateSettings;

const SETTINGS: SurrogateSettings = SurrogateSettings::DEFAULT;

/// Autoregression of a signal without mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Autoregression {
    /// Prediction-error filter 1 + Σ c_k q⁻ᵏ.
    filter: Vec<f64>,
}

impl Autoregression {
    /// Autoregression of a signal, its order by the signal's length.
    pub fn new(x: &[f64]) -> Self {
        Self { filter: burg(x, SETTINGS.max_order.min(x.len() / SETTINGS.samples_per_order)) }
    }

    /// Innovations of a signal, from the sample on that has a whole past.
    pub fn innovations(&self, x: &[f64]) -> Vec<f64> {
        let order = self.filter.len();
        x.windows(order + 1)
            .map(|w| w[order] + self.filter.iter().zip(w.iter().rev().skip(1)).map(|(c, v)| c * v).sum::<f64>())
            .collect()
    }

    /// Signal with the samples that are `unknown` such that the innovations are least (A. J. E. M. Janssen, R. N. J. Veldhuis,
    /// L. B. Vries, IEEE Trans. Acoust. Speech Signal Process. 34 (1986) 317–330), by conjugate gradients.
    pub fn restored(&self, x: &[f64], unknown: &[bool]) -> Vec<f64> {
        let places: Vec<usize> = (0..x.len()).filter(|n| unknown[*n]).collect();
        let mut out: Vec<f64> = x.iter().zip(unknown).map(|(v, u)| if *u { 0.0 } else { *v }).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut residual: Vec<f64> = self.normal(&out, &places).iter().map(|v| -v).collect();
        let (mut direction, mut solved) = (residual.clone(), vec![0.0; places.len()]);
        let first = dot(&residual, &residual);
        let mut power = first;
        for _ in 0..SETTINGS.restoring_steps {
            if power <= SETTINGS.restored_share * first {
                break;
            }
            let mut spread = vec![0.0; x.len()];
            places.iter().zip(&direction).for_each(|(n, v)| spread[*n] = *v);
            let image = self.normal(&spread, &places);
            let step = power / dot(&direction, &image);
            for n in 0..places.len() {
                solved[n] += step * direction[n];
                residual[n] -= step * image[n];
            }
            let next = dot(&residual, &residual);
            direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + next / power * *d);
            power = next;
        }
        places.iter().zip(solved).for_each(|(n, v)| out[*n] = v);
        out
    }

    /// Gradient of half the innovations' sum of squares by the samples at `places`.
    fn normal(&self, x: &[f64], places: &[usize]) -> Vec<f64> {
        let order = self.filter.len();
        let innovations = self.innovations(x);
        let weight = |lag: usize| if lag == 0 { 1.0 } else { self.filter[lag - 1] };
        let of = |n: &usize| {
            let lags = (0..=order).filter(|lag| n + lag >= order && n + lag - order < innovations.len());
            lags.map(|lag| weight(lag) * innovations[n + lag - order]).sum()
        };
        places.iter().map(of).collect()
    }

    /// Signal of `len` samples that has these innovations.
    pub fn coloured(&self, innovations: &[f64], len: usize) -> Vec<f64> {
        // Twice around: the first time settles the filter.
        let mut coloured: Vec<f64> = Vec::with_capacity(innovations.len() + len);
        for innovation in innovations.iter().cycle().take(innovations.len() + len) {
            let past: f64 = self.filter.iter().zip(coloured.iter().rev()).map(|(c, v)| c * v).sum();
            coloured.push(innovation - past);
        }
        coloured.split_off(innovations.len())
    }
}

/// Prediction-error filter 1 + Σ c_k q⁻ᵏ by Burg's method (1967): always stable.
fn burg(x: &[f64], order: usize) -> Vec<f64> {
    let (mut forward, mut backward) = (x.to_vec(), x.to_vec());
    let mut filter: Vec<f64> = Vec::new();
    for m in 0..order {
        let pairs = || forward[m + 1..].iter().zip(&backward[m..]);
        let cross: f64 = pairs().map(|(f, b)| f * b).sum();
        let power: f64 = pairs().map(|(f, b)| f * f + b * b).sum();
        if power <= 0.0 {
            break;
        }
        let reflection = -2.0 * cross / power;
        let reversed: Vec<f64> = filter.iter().rev().copied().collect();
        filter.iter_mut().zip(&reversed).for_each(|(a, b)| *a += reflection * b);
        filter.push(reflection);
        for t in (m + 1..x.len()).rev() {
            let (f, b) = (forward[t], backward[t - 1]);
            forward[t] = f + reflection * b;
            backward[t] = b + reflection * f;
        }
    }
    filter.resize(order, 0.0);
    filter
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn invariant_clipped_tops_of_a_smooth_signal_are_restored() {
        let x: Vec<f64> = (0..4000).map(|n| (0.11 * f64::from(n)).sin() + 0.5 * (0.273 * f64::from(n)).cos()).collect();
        let unknown: Vec<bool> = x.iter().map(|v| *v > 1.2).collect();
        let clipped: Vec<f64> = x.iter().map(|v| v.min(1.2)).collect();
        let restored = Autoregression::new(&clipped).restored(&clipped, &unknown);
        let error = |y: &[f64]| x.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        assert!(error(&restored) < 0.05 * error(&clipped), "{} {}", error(&restored), error(&clipped));
        assert!(x.iter().zip(&restored).zip(&unknown).all(|((a, b), unknown)| *unknown || a == b));
    }

    #[test]
    fn literature_burg_finds_an_autoregression() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut a, mut b) = (0.0, 0.0);
        let x: Vec<f64> = (0..20_000)
            .map(|_| {
                (b, a) = (a, 1.6 * a - 0.9 * b + rng.random_range(-1.0..1.0));
                a
            })
            .collect();
        let filter = burg(&x, 4);
        for (got, expected) in filter.iter().zip([-1.6, 0.9, 0.0, 0.0]) {
            assert!((got - expected).abs() < 0.02, "{filter:?}");
        }
    }
}
