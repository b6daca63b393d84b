//! White noise and random angles, each from a stream of its own of one seed, so that leaving one out does not
//! change another.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Stream of the process force.
pub const PROCESS_FORCE: u64 = 1;
/// Stream of the initial angles.
pub const ANGLES: u64 = 2;
/// Stream of the balls' places in the cage.
pub const BALLS: u64 = 3;
/// Stream of the balls' diameters.
pub const BALL_SIZES: u64 = 4;
/// Stream of the first channel's sensor noise; the next channel's is the next.
pub const SENSOR: u64 = 16;
/// Stream of the first random force of an effect; the next one's is the next.
pub const RANDOM_FORCE: u64 = 32;

fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

/// `count` independent normal numbers of zero mean and standard deviation `deviation`, from stream `of` of a seed.
pub fn white(seed: u64, of: u64, deviation: f64, count: usize) -> Vec<f64> {
    let mut rng = stream(seed, of);
    (0..count)
        .map(|_| {
            let unit: f64 = StandardNormal.sample(&mut rng);
            unit * deviation
        })
        .collect()
}

/// Two independent angles, uniform over a turn, rad.
pub fn angles(seed: u64) -> [f64; 2] {
    let mut rng = stream(seed, ANGLES);
    std::array::from_fn(|_| rng.random_range(0.0..std::f64::consts::TAU))
}
