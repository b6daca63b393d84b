//! Writes models of the paper's sizes with random weights, and samples with every kind of fault that
//! a file can hold: something to hold host and device against each other with (`compare.sh`).
//!
//! `cargo run --example paper_sizes -- DIR [SAMPLES [small]]` writes `DIR/samples.f32`, and a model for each
//! alignment, `DIR/forward.bin`, `DIR/half.bin`, `DIR/causal.bin`, for each other estimator of the causal one,
//! `DIR/savitzky_golay.bin`, `DIR/kalman.bin`, and for less hidden units in single precision and fixed point,
//! `DIR/float_32.bin`, `DIR/fixed_32.bin` and so on; with `small` of the tests' sizes, as seeds of the fuzz targets.

use std::error::Error;
use std::path::PathBuf;

use ballrace_core::network::Arithmetic;
use ballrace_core::states::{Alignment, Estimator};
use ballrace_firmware_sim::faults::Injector;
use ballrace_firmware_sim::source::{Arrival, in_memory};

#[path = "../tests/common/mod.rs"]
mod common;

use common::{KALMAN, PAPER, SAVITZKY_GOLAY, Sizes, model, signal};

const FAULTS: &str = "drop:1e-3,stuck:3e-3x20,nan:2e-3,flip:1e-2,saturate:50";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let directory: PathBuf = arguments.next().ok_or("expected a directory to write to")?.into();
    let count = arguments.next().map_or(Ok(2000), |count| count.parse())?;
    let sizes = if arguments.next().as_deref() == Some("small") { common::SMALL } else { PAPER };
    std::fs::create_dir_all(&directory)?;
    let mut injector = Injector::new(FAULTS.parse()?, 1);
    let samples = signal(count, 3);
    let values = injector.over(in_memory(&samples)).filter_map(|arrival| match arrival {
        Arrival::Sample(sample) => Some(sample.to_le_bytes()),
        Arrival::Missing(_) => None,
    });
    std::fs::write(directory.join("samples.f32"), values.flatten().collect::<Vec<u8>>())?;
    for (name, alignment, estimator) in [
        ("forward.bin", Alignment::Forward, Estimator::Differences),
        ("half.bin", Alignment::Half, Estimator::Differences),
        ("causal.bin", Alignment::Causal, Estimator::Differences),
        ("savitzky_golay.bin", Alignment::Causal, SAVITZKY_GOLAY),
        ("kalman.bin", Alignment::Causal, KALMAN),
    ] {
        std::fs::write(directory.join(name), model(Sizes { alignment, estimator, ..sizes }, &signal(20_000, 4)))?;
    }
    for hidden in [16, 24, 32, 48, 64, 128, 256] {
        for (name, arithmetic) in [("float", Arithmetic::Float), ("fixed", Arithmetic::Fixed)] {
            let sizes = Sizes { hidden, arithmetic, ..sizes };
            std::fs::write(directory.join(format!("{name}_{hidden}.bin")), model(sizes, &signal(20_000, 4)))?;
        }
    }
    Ok(())
}
