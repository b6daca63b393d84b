//! Bootstrap over blocks of consecutive recordings, theory (124).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::settings::FeatureSettings;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Rows of each bearing drawn anew, in blocks of consecutive rows of one stretch, whose end is followed by its beginning, so that
/// all rows are drawn equally often (circular blocks of Politis and Romano). The same for every set of features, so that their
/// scores can be compared draw by draw. `stretches` holds the lengths of each bearing's stretches.
pub fn draws(stretches: &[Vec<usize>], seed: u64) -> Vec<Vec<Vec<usize>>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..SETTINGS.draws).map(|_| stretches.iter().map(|own| draw(own, &mut rng)).collect()).collect()
}

fn draw(stretches: &[usize], rng: &mut ChaCha8Rng) -> Vec<usize> {
    let mut rows = Vec::with_capacity(stretches.iter().sum());
    let mut first = 0;
    for length in stretches.iter().copied().filter(|length| *length > 0) {
        let block = (length / SETTINGS.blocks).clamp(1, SETTINGS.block);
        let end = rows.len() + length;
        while rows.len() < end {
            let start = rng.random_range(0..length);
            let count = block.min(end - rows.len());
            rows.extend((start..start + count).map(|row| first + row % length));
        }
        first += length;
    }
    rows
}

/// Interval of 95 % of the finite values; NaN without any.
pub fn interval95(mut values: Vec<f64>) -> [f64; 2] {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let quantile = |share: f64| match values.len() {
        0 => f64::NAN,
        count => values[(share * (count - 1) as f64).round() as usize],
    };
    [quantile(0.025), quantile(0.975)]
}
