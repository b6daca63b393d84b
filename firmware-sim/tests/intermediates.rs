//! The report that host and device are compared by.

use ballrace_core::device::Device;
use ballrace_core::model::Model;
use ballrace_core::network::Arithmetic;
use ballrace_core::states::{Alignment, Estimator};
use ballrace_firmware_sim::intermediates::{JSON_LEN, Report, run};

mod common;

fn report(bytes: &[u8], samples: &[f32]) -> Report {
    let model = Model::from_bytes(bytes).unwrap();
    let mut scratch = vec![0.0; Device::scratch_len(&model)];
    run(&model, &mut scratch, samples.iter().copied()).unwrap()
}

#[test]
fn same_input_same_crc_and_one_bit_shows() {
    for (alignment, estimator, arithmetic) in [
        (Alignment::Forward, Estimator::Differences, Arithmetic::Float),
        (Alignment::Half, Estimator::Differences, Arithmetic::Float),
        (Alignment::Causal, Estimator::Differences, Arithmetic::Float),
        (Alignment::Causal, common::SAVITZKY_GOLAY, Arithmetic::Float),
        (Alignment::Causal, common::KALMAN, Arithmetic::Float),
        (Alignment::Half, Estimator::Differences, Arithmetic::Fixed),
    ] {
        let sizes = common::Sizes { alignment, estimator, arithmetic, ..common::SMALL };
        let bytes = common::model(sizes, &common::signal(5_000, 4));
        let samples = common::signal(300, 9);
        let expected = report(&bytes, &samples);
        assert_eq!(report(&bytes, &samples), expected);
        assert!(expected.evaluated > 270 && expected.evaluated < 300);
        // A filter has forgotten the last bit of its first sample by the end of its warm-up.
        let first = if estimator == Estimator::Differences { 0 } else { 60 };
        for (at, bit) in [(first, 0), (150, 0), (150, 12), (150, 31), (299, 0)] {
            let mut changed = samples.clone();
            changed[at] = f32::from_bits(changed[at].to_bits() ^ (1 << bit));
            assert_ne!(
                report(&bytes, &changed).crc,
                expected.crc,
                "{alignment:?} {estimator:?}: sample {at}, bit {bit}"
            );
        }
    }
}

#[test]
fn broken_samples_are_counted_and_the_sign_of_a_nan_is_no_difference() {
    let bytes = common::model(common::SMALL, &common::signal(5_000, 4));
    let mut samples = common::signal(300, 9);
    samples[100] = f32::NAN;
    samples[200] = -80.0;
    let expected = report(&bytes, &samples);
    assert_eq!((expected.faults.non_finite, expected.faults.saturated, expected.faults.total()), (1, 1, 2));
    samples[100] = -f32::NAN;
    assert_eq!(report(&bytes, &samples), expected);
}

#[test]
fn golden_json() {
    let bytes = common::model(common::SMALL, &common::signal(5_000, 4));
    let report = Report { crc: 0x0012_ab3f, ..report(&bytes, &common::signal(300, 9)) };
    let mut buffer = [0; JSON_LEN];
    assert_eq!(
        report.to_json(&mut buffer),
        Some(
            "{\"crc\":\"0012ab3f\",\"samples\":300,\"evaluated\":295,\"blocks\":5,\"anomalous_blocks\":0,\
             \"status\":\"healthy\",\"faults\":{\"non_finite\":0,\"saturated\":0,\"stuck\":0,\"missing\":0}}"
        )
    );
    assert_eq!(report.to_json(&mut [0; 20]), None);
    let most = Report { crc: u32::MAX, samples: u32::MAX, evaluated: u32::MAX, blocks: u32::MAX, ..report };
    assert!(most.to_json(&mut buffer).is_some_and(|text| text.len() + 200 < JSON_LEN));
}
