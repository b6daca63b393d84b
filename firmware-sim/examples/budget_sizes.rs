//! Writes models of many sizes with random weights, and clean samples: what the costs of `ballrace budget` are fitted to
//! and, other sizes, checked against (`cycles/budget.sh`).
//!
//! `cargo run --example budget_sizes -- DIR` writes `DIR/fit/*.bin`, `DIR/check/*.bin` and `DIR/samples.f32`.

use std::error::Error;
use std::path::PathBuf;

use ballrace_core::network::Arithmetic::{self, Fixed, Float};
use ballrace_core::states::Alignment::{self, Causal, Forward, Half};
use ballrace_core::states::Estimator::{self, Differences};
use ballrace_core::states::Orders::{self, Consecutive, Even};

#[path = "../tests/common/mod.rs"]
mod common;

use common::{KALMAN, SAVITZKY_GOLAY, SMALL, Sizes, model, signal};

const SAMPLES: usize = 300;

/// One model: dimension, latent variables, hidden width, hidden layers; degree, harmonics, powers; terms, equations of each;
/// alignment, estimator and orders; arithmetic.
type Row = ([usize; 4], (usize, usize, bool), [usize; 2], Alignment, Estimator, Orders, Arithmetic);

const FIT: [Row; 31] = [
    ([8, 8, 256, 1], (2, 2, false), [40, 1], Half, Differences, Even, Float),
    ([8, 8, 64, 1], (2, 0, false), [40, 1], Half, Differences, Even, Float),
    ([8, 8, 16, 1], (2, 0, false), [8, 1], Half, Differences, Even, Float),
    ([3, 2, 12, 1], (3, 2, false), [9, 1], Half, Differences, Even, Float),
    ([5, 3, 100, 1], (2, 1, false), [10, 2], Forward, Differences, Even, Float),
    ([4, 4, 31, 1], (3, 0, false), [20, 3], Half, Differences, Even, Float),
    ([12, 6, 48, 1], (1, 3, false), [30, 1], Forward, Differences, Consecutive, Float),
    ([16, 16, 128, 1], (2, 1, false), [100, 1], Half, Differences, Even, Float),
    ([2, 2, 8, 2], (4, 0, false), [6, 1], Half, Differences, Even, Float),
    ([6, 4, 40, 2], (2, 0, true), [12, 2], Half, Differences, Even, Float),
    ([8, 6, 32, 3], (1, 2, true), [25, 1], Forward, Differences, Even, Float),
    ([8, 3, 20, 1], (0, 3, false), [18, 1], Causal, Differences, Even, Float),
    ([4, 5, 24, 1], (2, 1, false), [15, 2], Causal, Differences, Consecutive, Float),
    ([8, 4, 24, 1], (2, 0, false), [10, 1], Causal, SAVITZKY_GOLAY, Even, Float),
    ([3, 4, 24, 1], (2, 0, false), [10, 1], Causal, SAVITZKY_GOLAY, Even, Float),
    // Ten of eleven terms: one power of each sign would not tell their costs apart.
    ([5, 2, 16, 1], (1, 1, true), [10, 1], Causal, SAVITZKY_GOLAY, Even, Float),
    ([8, 4, 24, 1], (2, 1, false), [10, 1], Causal, KALMAN, Even, Float),
    ([3, 7, 72, 1], (2, 0, true), [30, 2], Causal, KALMAN, Even, Float),
    ([8, 8, 256, 1], (2, 2, false), [40, 1], Half, Differences, Even, Fixed),
    ([8, 8, 16, 1], (2, 0, false), [8, 1], Half, Differences, Even, Fixed),
    ([5, 2, 40, 1], (2, 0, false), [5, 1], Forward, Differences, Even, Fixed),
    ([16, 10, 64, 1], (2, 0, false), [20, 1], Half, Differences, Even, Fixed),
    ([12, 16, 24, 1], (1, 0, false), [10, 1], Causal, Differences, Even, Fixed),
    // Few inputs and many outputs, and the reverse, or the two layers would not be told apart.
    ([16, 6, 96, 1], (2, 0, false), [10, 1], Half, Differences, Even, Fixed),
    ([3, 12, 96, 1], (1, 0, false), [10, 1], Half, Differences, Even, Fixed),
    ([3, 3, 150, 1], (2, 0, false), [10, 1], Half, Differences, Even, Fixed),
    // Inputs, units, words and outputs apart.
    ([4, 5, 60, 1], (2, 1, false), [15, 2], Causal, Differences, Even, Fixed),
    ([7, 2, 30, 1], (3, 0, false), [8, 1], Half, Differences, Even, Fixed),
    ([10, 13, 40, 1], (1, 1, false), [20, 1], Forward, Differences, Even, Fixed),
    ([16, 16, 12, 1], (1, 0, false), [12, 1], Half, Differences, Even, Fixed),
    ([1, 1, 20, 1], (5, 2, false), [6, 1], Causal, Differences, Even, Fixed),
];

const CHECK: [Row; 22] = [
    ([8, 8, 110, 1], (2, 2, false), [77, 1], Half, Differences, Even, Float),
    ([8, 8, 200, 1], (2, 0, false), [30, 3], Causal, Differences, Even, Float),
    ([10, 5, 80, 2], (3, 1, false), [33, 1], Forward, Differences, Even, Float),
    ([1, 1, 9, 1], (5, 2, false), [6, 1], Half, Differences, Even, Float),
    ([6, 6, 60, 1], (1, 4, false), [40, 2], Half, Differences, Consecutive, Float),
    ([7, 9, 44, 1], (2, 1, true), [50, 1], Causal, Differences, Even, Float),
    ([6, 8, 256, 1], (2, 0, false), [45, 1], Causal, SAVITZKY_GOLAY, Even, Float),
    ([8, 8, 37, 2], (2, 2, false), [60, 1], Causal, KALMAN, Even, Float),
    ([8, 8, 32, 1], (2, 1, false), [12, 1], Half, Differences, Even, Fixed),
    ([4, 4, 100, 1], (2, 2, false), [30, 1], Causal, Differences, Even, Fixed),
    ([10, 7, 51, 1], (2, 0, false), [25, 1], Half, Differences, Even, Fixed),
    // The errors of those above chose the kinds of work; these are for a fresh judgement.
    ([6, 4, 80, 1], (2, 0, false), [14, 1], Half, Differences, Even, Fixed),
    ([2, 2, 26, 1], (3, 1, false), [9, 2], Causal, Differences, Even, Fixed),
    ([9, 9, 33, 1], (2, 0, false), [30, 1], Half, Differences, Even, Fixed),
    ([14, 5, 128, 1], (2, 1, false), [16, 3], Forward, Differences, Even, Fixed),
    ([8, 12, 18, 1], (1, 2, false), [25, 1], Half, Differences, Consecutive, Fixed),
    ([5, 6, 200, 1], (2, 0, false), [20, 1], Causal, KALMAN, Even, Fixed),
    ([8, 8, 24, 1], (2, 1, false), [15, 1], Half, Differences, Even, Float),
    ([4, 3, 52, 2], (3, 0, false), [12, 2], Causal, Differences, Even, Float),
    ([11, 7, 90, 1], (2, 0, true), [28, 1], Half, Differences, Even, Float),
    ([3, 3, 17, 1], (2, 3, false), [20, 1], Causal, SAVITZKY_GOLAY, Even, Float),
    ([16, 8, 40, 1], (1, 1, false), [30, 1], Forward, Differences, Consecutive, Float),
];

fn main() -> Result<(), Box<dyn Error>> {
    let directory: PathBuf = std::env::args().nth(1).ok_or("expected a directory to write to")?.into();
    for (name, rows) in [("fit", &FIT[..]), ("check", &CHECK[..])] {
        let folder = directory.join(name);
        std::fs::create_dir_all(&folder)?;
        for (n, row) in rows.iter().enumerate() {
            let ([dimension, latent, hidden, depth], (degree, harmonics, powers), [nonzeros, equations], ..) = *row;
            let (hidden, alignment, estimator, orders, arithmetic) = (hidden.try_into()?, row.3, row.4, row.5, row.6);
            let networks =
                Sizes { dimension, latent, hidden, arithmetic, depth, orders, alignment, estimator, ..SMALL };
            let sizes = Sizes { degree, harmonics, powers, nonzeros, equations, ..networks };
            std::fs::write(folder.join(format!("{n:02}.bin")), model(sizes, &signal(2_000, 4)))?;
        }
    }
    let samples: Vec<u8> = signal(SAMPLES, 3).iter().flat_map(|sample| sample.to_le_bytes()).collect();
    std::fs::write(directory.join("samples.f32"), samples)?;
    Ok(())
}
