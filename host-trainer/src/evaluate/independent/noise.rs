//! Noise of smooth colour.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::settings::IntegrationSettings;

const SETTINGS: IntegrationSettings = IntegrationSettings::DEFAULT;

/// Standard normal numbers of a stream of a seed.
pub fn white(seed: u64, stream: u64, count: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    StandardNormal.sample_iter(&mut rng).take(count).collect()
}

/// Colours white noise: the filter of least phase whose logarithmic gain, Np, is the sum of `cepstrum[k] cos((k+1)ω)`.
pub fn colour(cepstrum: &[f64], noise: &mut [f64]) {
    if cepstrum.iter().all(|c| *c == 0.0) {
        return;
    }
    let mut taps = vec![1.0; 1];
    for n in 1..SETTINGS.colour_taps {
        let of = |k: usize| cepstrum.get(k - 1).map_or(0.0, |c| k as f64 * c * taps[n - k]);
        taps.push((1..=n).map(of).sum::<f64>() / n as f64);
    }
    for i in (0..noise.len()).rev() {
        noise[i] = taps.iter().take(i + 1).enumerate().map(|(k, tap)| tap * noise[i - k]).sum();
    }
}
