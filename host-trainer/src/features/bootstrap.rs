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

/// Interval of 95 % of the finite values of draws about the value itself, widened by √2: every pair of bearings enters the mean of
/// the scores twice, by what the one learns for the other and the other way round, and where there is nothing to learn both are
/// one random number. A draw with fixed predictions sees it once. NaN without any draws.
pub fn interval95(mut draws: Vec<f64>, value: f64) -> [f64; 2] {
    draws.retain(|draw| draw.is_finite());
    draws.sort_by(f64::total_cmp);
    let quantile = |share: f64| match draws.len() {
        0 => f64::NAN,
        count => value + std::f64::consts::SQRT_2 * (draws[(share * (count - 1) as f64).round() as usize] - value),
    };
    [quantile(0.025), quantile(0.975)]
}
