extern crate std;
use super::*;
use crate::network::Arithmetic;
use crate::states::{Alignment, Estimator, Orders, SpecError};
use crate::testing::Parts;
use std::string::{String, ToString};
use std::vec::Vec;

const ESTIMATORS: [Estimator; 3] =
    [Estimator::Differences, Estimator::SavitzkyGolay { excess: 1, stretch: 1.5 }, Estimator::Kalman { cutoff: 0.22 }];

fn with(estimator: Estimator) -> Parts {
    Parts::new(StateSpec { dimension: 3, orders: Orders::Even, alignment: Alignment::Causal, estimator })
}

fn parts() -> Parts {
    Parts::new(StateSpec {
        dimension: 3,
        orders: Orders::Even,
        alignment: Alignment::Causal,
        estimator: Estimator::Differences,
    })
}

fn bytes(model: &Model<'_>) -> Vec<u8> {
    let mut bytes = std::vec![0; model.byte_len()];
    assert_eq!(model.to_bytes(&mut bytes).unwrap(), bytes.len());
    bytes
}

fn json(model: &Model<'_>) -> String {
    let mut buffer = std::vec![0; 64 * 1024];
    let length = model.to_json(&mut buffer).unwrap();
    String::from_utf8(buffer[..length].to_vec()).unwrap()
}

/// Writes a word and makes the checksum right again.
fn patched(bytes: &[u8], word: usize, value: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
    let body = bytes.len() - 4;
    let crc = crc32(&bytes[..body]);
    bytes[body..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

#[test]
fn binary_round_trips_at_any_alignment() {
    for parts in ESTIMATORS.into_iter().flat_map(|estimator| [with(estimator), with(estimator).with_powers()]) {
        let model = parts.model();
        let bytes = bytes(&model);
        assert_eq!(Model::from_bytes(&bytes).unwrap(), model);
        for shift in 1..4 {
            let mut shifted = std::vec![0; shift];
            shifted.extend(&bytes);
            assert_eq!(Model::from_bytes(&shifted[shift..]).unwrap(), model);
        }
    }
}

/// Form of version 1 to 3 of a model in that of version 4: without the newer words, and with the monitor's words of then
/// (mean 2, spread 0.5, weight 0.2, limit 3, slack 2, limit 8, 2 votes of 5, release 0.4).
fn older(bytes: &[u8], version: u32) -> Vec<u8> {
    let mut words: Vec<[u8; 4]> = bytes.chunks(4).map(|w| w.try_into().unwrap()).collect();
    let newer = [0, 0, 3, 4][version as usize];
    words.drain(26 + newer..31);
    words[1] = version.to_le_bytes();
    words[2] = (words.len() as u32).to_le_bytes();
    for (word, value) in words[17..23].iter_mut().zip([2.0f32, 0.5, 0.2, 3.0, 2.0, 8.0]) {
        *word = value.to_le_bytes();
    }
    words[23..26].copy_from_slice(&[2u32.to_le_bytes(), 5u32.to_le_bytes(), 0.4f32.to_le_bytes()]);
    patched(words.as_flattened(), 1, version)
}

/// Settings that [`older`] is read as.
fn converted(block: u32) -> MonitorConfig {
    let levels = MonitorConfig::from_levels(block, 2.0, 0.5);
    assert_eq!((levels.healthy_centre, levels.healthy_spread), (core::f32::consts::LN_2, 0.25));
    MonitorConfig { ewma_weight: 0.2, limit: 3.0, release: 0.4, calm_blocks: 5, ..levels }
}

#[test]
fn forms_of_before_are_read_with_their_monitor_converted() {
    for (estimator, version) in ESTIMATORS.into_iter().zip([1, 2, 2]) {
        let parts = with(estimator);
        let model = parts.model();
        let expected = Model { monitor: converted(model.monitor.block), ..model.clone() };
        for version in [version, 3] {
            let found = older(&bytes(&model), version);
            assert_eq!(Model::from_bytes(&found).unwrap(), expected, "{estimator:?} {version}");
        }
        assert_eq!(bytes(&model)[4], 4);
        // Written anew it keeps its settings.
        assert_eq!(Model::from_bytes(&bytes(&expected)).unwrap(), expected);
        let schema = std::format!("device-model/{version}");
        let text = json(&model);
        let start = text.find("\"monitor\":{").unwrap();
        let end = start + text[start..].find('}').unwrap();
        let monitor = "\"monitor\":{\"block\":32,\"healthy_mean\":2.0,\"healthy_spread\":0.5,\"ewma_weight\":0.2,\
            \"ewma_limit\":3.0,\"cusum_slack\":2.0,\"cusum_limit\":8.0,\"votes\":2,\"of_blocks\":5,\"release\":0.4";
        let text = text.replace(&text[start..end], monitor).replace("device-model/4", &schema);
        let mut storage = std::vec![[0; 4]; text.len()];
        assert_eq!(Model::from_json(&text, &mut storage).unwrap(), expected, "{text}");
        // In keys of before, the newest schema lacks some.
        let text = text.replace(&schema, "device-model/4");
        assert_eq!(Model::from_json(&text, &mut storage).err(), Some(ModelError::Json));
    }
}

#[test]
fn fixed_point_has_a_form_that_devices_of_before_refuse() {
    use Arithmetic::{Fixed, Float};
    for networks in [[Fixed, Fixed], [Fixed, Float], [Float, Fixed]] {
        let parts = parts().with_arithmetic(networks);
        let (bytes, text) = (bytes(&parts.model()), json(&parts.model()));
        assert_eq!(bytes[4], 4);
        assert!(text.contains("device-model/4"), "{text}");
        assert_eq!(Model::from_bytes(&bytes).unwrap(), parts.model());
        let mut storage = std::vec![[0; 4]; text.len()];
        assert_eq!(Model::from_json(&text, &mut storage).unwrap(), parts.model());
        // The name of an array of integers under the schema of before.
        let old = text.replace("device-model/4", "device-model/1");
        assert_eq!(Model::from_json(&old, &mut storage), Err(ModelError::Schema));
    }
    let parts = parts().with_arithmetic([Fixed, Fixed]);
    let good = bytes(&parts.model());
    // Words after the header: estimator, powers, arithmetic.
    assert!(matches!(Model::from_bytes(&patched(&good, 30, 4)), Err(ModelError::HeaderWord { index: 30, found: 4 })));
    let widths = 2 * 3;
    let exponent = 31 + widths + 5 * 3;
    let bad = patched(&good, exponent, 28);
    assert_eq!(Model::from_bytes(&bad), Err(ModelError::Network { network: Array::Encoder }));
}

#[test]
fn powers_have_a_form_that_devices_of_before_refuse() {
    let parts = with(ESTIMATORS[0]);
    let (before, length) = (json(&parts.model()), bytes(&parts.model()).len());
    let parts = parts.with_powers();
    let (after, bytes) = (json(&parts.model()), bytes(&parts.model()));
    assert!(!before.contains("powers") && after.contains("powers"), "{after}");
    assert_eq!((bytes[4], bytes.len()), (4, length));
    // Terms of powers in a library without.
    assert!(Model::from_bytes(&patched(&bytes, 29, 0)).is_err());
    assert_eq!(Model::from_bytes(&patched(&bytes, 29, 2)).err(), Some(ModelError::HeaderWord { index: 29, found: 2 }));
}

#[test]
fn estimators_out_of_range_are_refused() {
    let [_, savitzky_golay, kalman] = ESTIMATORS.map(|estimator| bytes(&with(estimator).model()));
    let read = |bytes: &[u8]| Model::from_bytes(bytes).err();
    let expected = |found| Some(ModelError::HeaderWord { index: 26, found });
    assert_eq!(read(&patched(&kalman, 26, 3)), expected(3));
    assert_eq!(read(&patched(&older(&kalman, 2), 26, 0)), expected(0));
    assert_eq!(read(&patched(&kalman, 28, 1.0_f32.to_bits())), Some(states(SpecError::Cutoff { found: 1.0 })));
    assert!(matches!(read(&patched(&kalman, 28, f32::NAN.to_bits())), Some(ModelError::States(_))));
    assert_eq!(read(&patched(&savitzky_golay, 27, 9)), Some(states(SpecError::Excess { found: 9 })));
    let half = states(SpecError::NotCausal { found: Alignment::Half });
    assert_eq!(read(&patched(&savitzky_golay, 5, 1)), Some(half));
    // Version 1 has no words of an estimator.
    assert!(read(&patched(&kalman, 1, 1)).is_some());
    let text = json(&with(ESTIMATORS[2]).model());
    let mut storage = std::vec![[0; 4]; text.len()];
    let read = Model::from_json(&text.replace("device-model/4", "device-model/1"), &mut storage).err();
    assert_eq!(read, Some(ModelError::Schema));
}

fn states(error: SpecError) -> ModelError {
    ModelError::States(error)
}

#[test]
fn json_round_trips_to_the_bit() {
    for parts in ESTIMATORS.into_iter().flat_map(|estimator| [with(estimator), with(estimator).with_powers()]) {
        let model = parts.model();
        let text = json(&model);
        let mut storage = std::vec![[0; 4]; text.len()];
        assert_eq!(Model::from_json(&text, &mut storage).unwrap(), model, "{text}");
    }
}

#[test]
fn each_way_to_be_wrong_is_its_own_error() {
    let parts = parts();
    let good = bytes(&parts.model());
    let read = |bytes: &[u8]| Model::from_bytes(bytes).err();
    assert!(matches!(read(&good[..50]), Some(ModelError::Truncated { .. })));
    assert!(matches!(read(&good[..good.len() - 1]), Some(ModelError::Truncated { .. })));
    assert_eq!(read(&patched(&good, 0, 0)), Some(ModelError::Magic { found: [0; 4] }));
    assert_eq!(read(&patched(&good, 1, 9)), Some(ModelError::Version { found: 9 }));
    let mut flipped = good.clone();
    flipped[200] ^= 1;
    assert!(matches!(read(&flipped), Some(ModelError::Checksum { .. })));
    assert_eq!(read(&patched(&good, 4, 7)), Some(ModelError::HeaderWord { index: 4, found: 7 }));
    assert!(matches!(read(&patched(&good, 3, 4)), Some(ModelError::ArraySizes)));
    let nan = f32::NAN.to_bits();
    assert!(matches!(read(&patched(&good, 6, nan)), Some(ModelError::SampleRate { .. })));
    assert!(matches!(read(&patched(&good, 7, 0)), Some(ModelError::Library { .. })));
    assert!(matches!(read(&patched(&good, 7, 3)), Some(ModelError::NetworkShape { .. })));
    assert_eq!(read(&patched(&good, 16, 0)), Some(ModelError::Monitor));
    // Widths are 3, 11, 2 and 2, 9, 3 from word 31 on; the scales follow from word 37 on.
    let shape = read(&patched(&patched(&good, 33, 3), 34, 2));
    assert!(matches!(shape, Some(ModelError::ArraySizes)), "{shape:?}");
    let not_finite = ModelError::NotFinite { array: Array::StateMean, index: 1 };
    assert_eq!(read(&patched(&good, 38, nan)), Some(not_finite));
    let not_positive = ModelError::ScaleNotPositive { array: Array::StateScale, index: 0 };
    assert_eq!(read(&patched(&good, 40, 0)), Some(not_positive));
    let words = good.len() / 4;
    let (coefficients, terms) = (12, 6);
    let equations = words - 1 - 2 * coefficients;
    let ends = equations - terms;
    assert_eq!(read(&patched(&good, equations, 2)), Some(ModelError::Equation { index: 0 }));
    assert_eq!(read(&patched(&good, ends, 99)), Some(ModelError::TermRun { index: 0 }));
    assert_eq!(read(&patched(&good, ends - 3, 0x0909_0909)), Some(ModelError::Term { index: terms - 1 }));
}

#[test]
fn no_bytes_make_the_reader_panic() {
    ESTIMATORS.map(|estimator| bytes(&with(estimator).model())).iter().for_each(|good| read_changed(good));
}

/// Reads a model with one word changed at a time, and runs what is still a model.
fn read_changed(good: &[u8]) {
    let mut seed = 1u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed >> 8
    };
    for _ in 0..7_000 {
        // Checksum made right, so that the checks behind it are reached.
        let word = random() as usize % (good.len() / 4 - 1);
        let bad = patched(good, word, if random() % 2 == 0 { random() % 64 } else { random() << 8 });
        if let Ok(model) = Model::from_bytes(&bad) {
            let mut scratch = std::vec![0.0; crate::device::Device::scratch_len(&model)];
            let mut device = crate::device::Device::new(&model, &mut scratch).unwrap();
            crate::testing::samples(20).into_iter().for_each(|s| _ = device.push(s).block);
        }
    }
}

#[test]
fn json_errors_are_told() {
    let parts = parts();
    let text = json(&parts.model());
    let read = |text: &str, words: usize| {
        let mut storage = std::vec![[0; 4]; words];
        Model::from_json(text, &mut storage).err()
    };
    let n = text.len();
    assert_eq!(read(&text, 10), Some(ModelError::StorageTooSmall));
    assert!(matches!(read(&text[..n / 2], n), Some(ModelError::Json)));
    assert_eq!(read(&text.replace("device-model/4", "device-model/2"), n), Some(ModelError::Schema));
    // A key that is misspelt is neither read over nor a default.
    for key in ["decoder", "orders", "false_alarms_per_day", "release", "stuck_after", "degree"] {
        let misspelt = text.replace(&std::format!("\"{key}\""), &std::format!("\"{key}s\""));
        assert!(misspelt != text && matches!(read(&misspelt, n), Some(ModelError::Json)), "{key}");
    }
    let first = text.split("\"state_mean\":[").nth(1).unwrap().split(',').next().unwrap().to_string();
    let with_null = text.replace(&std::format!("\"state_mean\":[{first}"), "\"state_mean\":[null");
    assert!(read(&with_null, n).is_some(), "null must not become a number");
    let mut short = [0; 100];
    assert_eq!(parts.model().to_json(&mut short), Err(ModelError::JsonBufferTooSmall));
}
