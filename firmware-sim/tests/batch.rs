//! Recordings evaluated many samples at a time give the device's own events, to the bit.

use ballrace_core::model::Model;
use ballrace_core::network::Arithmetic;
use ballrace_core::states::{Alignment, Estimator, Orders};
use ballrace_firmware_sim::batch::Batch;
use ballrace_firmware_sim::faults::Injector;
use ballrace_firmware_sim::runner::{Recording, Runner};
use ballrace_firmware_sim::source::{Arrival, in_memory};

mod common;

/// Events of a run over recordings with faults, those of the device and those of the batch.
fn events(sizes: common::Sizes) -> [Vec<String>; 2] {
    let bytes = common::model(sizes, &common::signal(20_000, 4));
    let model = Model::from_bytes(&bytes).unwrap();
    let plan = "nan:2e-3,stuck:1e-3x12,flip:3e-3,gap:1e-3x7,drop:1e-3,saturate:50";
    let mut injector = Injector::new(plan.parse().unwrap(), 1);
    let recordings: Vec<Vec<Arrival>> =
        (0..4).map(|k| injector.over(in_memory(&common::signal(1500 + 7 * k, 9 + k as u32))).collect()).collect();
    let batch = Batch::new(&model).unwrap();
    [false, true].map(|evaluated| {
        let mut scratch = vec![0.0; Runner::scratch_len(&model)];
        let mut runner = Runner::new(&model, &mut scratch).unwrap();
        let mut lines = Vec::new();
        let recording = Recording { name: "r", sample_rate_hz: 25_600.0 };
        for arrivals in &recordings {
            let on_event = |event: ballrace_firmware_sim::event::Event<'_>| {
                // The statistics in all their digits.
                lines.push(format!("{event:?}"));
            };
            if evaluated {
                runner.run_evaluated(&recording, &batch.evaluate(arrivals.iter().copied()), on_event);
            } else {
                runner.run(&recording, arrivals.iter().copied(), on_event);
            }
        }
        runner.finish(|event| lines.push(format!("{event:?}")));
        lines
    })
}

#[test]
fn invariant_a_batch_gives_the_device_s_events() {
    let mut checked = 0;
    for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
        for (alignment, estimator) in [
            (Alignment::Forward, Estimator::Differences),
            (Alignment::Half, Estimator::Differences),
            (Alignment::Causal, Estimator::Differences),
            (Alignment::Causal, common::SAVITZKY_GOLAY),
            (Alignment::Causal, common::KALMAN),
        ] {
            for (powers, orders) in [(false, Orders::Even), (true, Orders::Consecutive)] {
                let sizes = common::Sizes { alignment, estimator, arithmetic, powers, orders, ..common::SMALL };
                let [device, batch] = events(sizes);
                assert_eq!(device, batch, "{arithmetic:?} {alignment:?} {estimator:?}");
                assert!(device.iter().filter(|line| line.starts_with("Block")).count() > 80);
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 20);
}

#[test]
fn invariant_networks_of_any_shape_give_the_device_s_events() {
    for (dimension, latent, hidden, depth) in [(1, 1, 3, 1), (5, 4, 17, 2), (8, 8, 40, 1), (9, 3, 8, 3)] {
        let [device, batch] = events(common::Sizes { dimension, latent, hidden, depth, ..common::SMALL });
        assert_eq!(device, batch, "{dimension}-{hidden}x{depth}-{latent}");
    }
}
