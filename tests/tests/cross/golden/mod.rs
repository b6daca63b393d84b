//! Golden: numbers stored from a fixed FEMTO recording. `GOLDEN=print cargo test -p ballrace-tests
//! -- golden --nocapture` prints them anew; a change of any of them is a change of the maths.

use ballrace::model::OwnedModel;
use ballrace::model::fit::{FitConfig, Solver, fit};
use ballrace::model::stlsq::StlsqConfig;
use ballrace_core::evaluator::{Evaluator, scratch_len};
use ballrace_core::library::Library;
use ballrace_core::states::{Alignment, Estimator, Orders, StateSpec};
use ballrace_firmware_sim::intermediates;
use ballrace_tests::femto;

mod numbers;
use numbers::*;

fn spec(alignment: Alignment) -> StateSpec {
    StateSpec { dimension: 4, orders: Orders::Even, alignment, estimator: Estimator::Differences }
}

fn check(name: &str, got: &[f32], expected: &[f32]) {
    if std::env::var_os("GOLDEN").is_some() {
        println!("{name}: {got:?}");
        return;
    }
    assert_eq!(got.len(), expected.len(), "{name}");
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        assert_eq!(got.to_bits(), expected.to_bits(), "{name}[{i}]: {got} for {expected}");
    }
}

#[test]
fn virtual_states_and_library_row_of_bearing_3_3() {
    let Some(recordings) = femto("Bearing3_3", "horizontal", 0..1) else { return };
    let samples = &recordings[0].samples;
    check("first samples", &samples[..3], FIRST_SAMPLES);
    for (alignment, states, targets) in [
        (Alignment::Forward, FORWARD[0], FORWARD[1]),
        (Alignment::Half, HALF[0], HALF[1]),
        (Alignment::Causal, CAUSAL[0], CAUSAL[1]),
    ] {
        let rows = ballrace::model::states::rows(samples, spec(alignment));
        let (x, dx) = rows.row(100);
        check(&format!("{alignment:?} states"), x, states);
        check(&format!("{alignment:?} targets"), dx, targets);
    }
    let rows = ballrace::model::states::rows(samples, spec(Alignment::Half));
    let library = Library::new(4, 2, 1).unwrap();
    let mut theta = vec![0.0; library.len()];
    library.row(rows.row(100).0, &mut theta);
    check("library row", &theta, LIBRARY_ROW);
}

/// A model whose numbers do not depend on a solver's last bits: fitted, then rounded to 8 bits.
fn model(recordings: &[ballrace::recording::input::Series]) -> OwnedModel {
    let config = FitConfig {
        spec: spec(Alignment::Causal),
        degree: 2,
        harmonics: 1,
        powers: false,
        solver: Solver::Stlsq(StlsqConfig { threshold: Some(1e-4), ridge: 1e-9, ..StlsqConfig::default() }),
        null_fits: 0,
        ..FitConfig::default()
    };
    let model = fit(recordings, 25_600.0, &config, &|_| ()).unwrap().model;
    let json = model.to_json().unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&json).unwrap();
    for key in ["state_mean", "state_scale", "derivative_mean", "derivative_scale", "residual_spread", "coefficients"] {
        for number in value[key].as_array_mut().unwrap() {
            let rounded = f32::from_bits((number.as_f64().unwrap() as f32).to_bits() & 0xffff_0000);
            *number = serde_json::Value::from(f64::from(rounded));
        }
    }
    OwnedModel::from_json(&value.to_string()).unwrap()
}

#[test]
fn evaluator_output_of_bearing_3_3() {
    let Some(recordings) = femto("Bearing3_3", "horizontal", 0..3) else { return };
    let owned = model(&recordings);
    let model = owned.view();
    let mut scratch = vec![0.0; scratch_len(&model)];
    let mut evaluator = Evaluator::new(&model, &mut scratch).unwrap();
    let mut last = None;
    for sample in &recordings[0].samples[..200] {
        if let Some(step) = evaluator.step(*sample) {
            last = Some((step.predicted.to_vec(), step.next_sample));
        }
    }
    let (predicted, next) = last.unwrap();
    check("predicted", &predicted, PREDICTED);
    check("next sample", &[next.unwrap()], NEXT_SAMPLE);
}

#[test]
fn every_written_form_runs_to_the_same_bits() {
    let Some(recordings) = femto("Bearing3_3", "horizontal", 0..3) else { return };
    let owned = model(&recordings);
    let again = [
        OwnedModel::from_json(&owned.to_json().unwrap()).unwrap(),
        OwnedModel::from_bytes(owned.bytes().to_vec()).unwrap(),
    ];
    let crc = |model: &OwnedModel| {
        let model = model.view();
        let mut scratch = vec![0.0; scratch_len(&model)];
        intermediates::run(&model, &mut scratch, recordings[0].samples.iter().copied()).unwrap().crc
    };
    let expected = crc(&owned);
    assert!(again.iter().all(|m| crc(m) == expected));
    // The CRC sees a model that differs in one coefficient's last bit.
    let mut changed = owned.bytes().to_vec();
    let (coefficient, checksum) = (changed.len() - 8, changed.len() - 4);
    changed[coefficient] ^= 1;
    let valid = ballrace_core::crc::crc32(&changed[..checksum]).to_le_bytes();
    changed[checksum..].copy_from_slice(&valid);
    assert_ne!(crc(&OwnedModel::from_bytes(changed).unwrap()), expected);
}
