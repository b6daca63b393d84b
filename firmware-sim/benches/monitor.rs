//! Speed of the device on the host, in multiples of real time at 25.6 kHz: sample by sample, and recordings side by side.
//!
//! `cargo bench -p ballrace-firmware-sim --bench monitor`; `RAYON_NUM_THREADS=1` for one core. 100 made-up recordings of
//! 2,560 samples, models with random weights; medians of 5 runs. Both ways give the same events, which is checked.

use std::time::Instant;

use ballrace_core::model::Model;
use ballrace_core::network::Arithmetic;
use ballrace_firmware_sim::batch::Batch;
use ballrace_firmware_sim::runner::{Recording, Runner};
use ballrace_firmware_sim::source::{Arrival, in_memory};
use rayon::prelude::*;

#[path = "../tests/common/mod.rs"]
mod common;

use common::{PAPER, SAMPLE_RATE_HZ, SMALL, Sizes};

const RECORDINGS: u32 = 100;
const SAMPLES: usize = 2560;
const RUNS: usize = 5;

fn main() {
    let recordings: Vec<Vec<f32>> = (0..RECORDINGS).map(|k| common::signal(SAMPLES, k)).collect();
    let threads = rayon::current_num_threads();
    println!("model                         sample by sample   side by side, {threads} threads   ratio");
    for (name, sizes) in [
        ("f32, 8-256-8, 2 harmonics", PAPER),
        ("f32, 8-256-8, polynomials", Sizes { harmonics: 0, ..PAPER }),
        ("f32, 8-24-8", Sizes { hidden: 24, ..PAPER }),
        ("fixed point, 8-24-8", Sizes { hidden: 24, arithmetic: Arithmetic::Fixed, ..PAPER }),
        ("f32, 3-12-2", SMALL),
    ] {
        let bytes = common::model(sizes, &common::signal(5000, 4));
        let model = Model::from_bytes(&bytes).expect("a valid model");
        let ((one, events), (many, same)) =
            (median(|| one_by_one(&model, &recordings)), median(|| side_by_side(&model, &recordings)));
        assert_eq!(events, same);
        println!("{name:28} {one:15.1} x {many:25.1} x {:12.1}", many / one);
    }
}

/// Median speed over the runs, and the events of one.
fn median(run: impl Fn() -> Vec<String>) -> (f64, Vec<String>) {
    let seconds_of_signal = f64::from(RECORDINGS) * SAMPLES as f64 / f64::from(SAMPLE_RATE_HZ);
    let (mut speeds, mut events) = (Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let start = Instant::now();
        events = run();
        speeds.push(seconds_of_signal / start.elapsed().as_secs_f64());
    }
    speeds.sort_by(f64::total_cmp);
    (speeds[RUNS / 2], events)
}

fn one_by_one(model: &Model<'_>, recordings: &[Vec<f32>]) -> Vec<String> {
    run(model, recordings, |runner, samples, events| {
        runner.run(&RECORDING, in_memory(samples), |event| events.push(format!("{event:?}")));
    })
}

fn side_by_side(model: &Model<'_>, recordings: &[Vec<f32>]) -> Vec<String> {
    let batch = Batch::new(model).expect("virtual states");
    let evaluated: Vec<_> =
        recordings.par_iter().map(|samples| batch.evaluate(samples.iter().map(|s| Arrival::Sample(*s)))).collect();
    run(model, &evaluated, |runner, evaluated, events| {
        runner.run_evaluated(&RECORDING, evaluated, |event| events.push(format!("{event:?}")));
    })
}

const RECORDING: Recording<'_> = Recording { name: "made up", sample_rate_hz: SAMPLE_RATE_HZ as f64 };

fn run<T>(
    model: &Model<'_>,
    recordings: &[T],
    each: impl Fn(&mut Runner<'_, '_>, &T, &mut Vec<String>),
) -> Vec<String> {
    let mut scratch = vec![0.0; Runner::scratch_len(model)];
    let mut runner = Runner::new(model, &mut scratch).expect("virtual states");
    let mut events = Vec::new();
    recordings.iter().for_each(|recording| each(&mut runner, recording, &mut events));
    let summary = runner.finish(|_| ());
    events.push(format!("{summary:?}"));
    events
}
