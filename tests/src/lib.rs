//! What the tests that cross crates share.
#![forbid(unsafe_code)]

use ballrace::recording::input::Series;
use ballrace::recording::{LoadOptions, load, reference_data};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One channel of some recordings of a FEMTO bearing; `None` (said on stderr) where the data is not there.
pub fn femto(bearing: &str, channel: &str, recordings: std::ops::Range<usize>) -> Option<Vec<Series>> {
    let folder = reference_data::folder("femto")?.join(bearing);
    let options =
        LoadOptions { channels: Some(vec![channel.into()]), recordings: Some(recordings), ..LoadOptions::default() };
    let loaded = load(&[folder], &options).expect("the reference data can be read");
    let series = |r: &ballrace::recording::Recording| Series {
        name: r.name(),
        samples: r.channels[0].samples.iter().map(|v| *v as f32).collect(),
    };
    Some(loaded.recordings.iter().map(series).collect())
}

/// Gaussian white noise of unit variance.
pub fn white_noise(count: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || {
        let (u, v): (f64, f64) = (rng.random_range(1e-12..1.0), rng.random_range(0.0..1.0));
        ((-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()) as f32
    };
    (0..count).map(|_| normal()).collect()
}
