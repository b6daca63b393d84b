//! The device's calls with arbitrary bit patterns, on a model of each kind of virtual states.
#![no_main]

use std::sync::LazyLock;

use ballrace_core::model::Model;
use ballrace_core::states::{Alignment, Estimator};
use libfuzzer_sys::fuzz_target;

#[path = "../../../firmware-sim/tests/common/mod.rs"]
mod common;

static MODELS: LazyLock<[Vec<u8>; 5]> = LazyLock::new(|| {
    [
        (Alignment::Forward, Estimator::Differences),
        (Alignment::Half, Estimator::Differences),
        (Alignment::Causal, Estimator::Differences),
        (Alignment::Causal, common::SAVITZKY_GOLAY),
        (Alignment::Causal, common::KALMAN),
    ]
    .map(|(alignment, estimator)| {
        common::model(common::Sizes { alignment, estimator, ..common::SMALL }, &common::signal(5_000, 4))
    })
});

fuzz_target!(|data: &[u8]| {
    let Some((which, calls)) = data.split_first() else { return };
    let model = Model::from_bytes(&MODELS[usize::from(*which) % MODELS.len()]).unwrap();
    ballrace_core_fuzz::run(&model, calls);
});
