use super::bearing::{Options, PathChoice, calibrate};
use super::estimate::Estimate;
use crate::recording::{LoadOptions, Recording, Unit, load, reference_data};
use crate::rig::config::ModelKey;
use crate::rig::test_support::{condition, nominal};
use crate::rig::{Rig, Run, Start, simulate_many};

fn recordings(rig: &Rig, count: usize, samples: usize, seed: u64) -> Vec<Recording> {
    let run = |i: usize| Run {
        rig,
        condition: condition(30.0 + 2.0 * i as f64, 350.0 + 150.0 * i as f64, samples),
        start: Start::seeded(seed * 100 + i as u64),
    };
    let runs: Vec<Run> = (0..count).map(run).collect();
    simulate_many(&runs).unwrap()
}

fn guess(keys: &[ModelKey], factors: &[f64]) -> Rig {
    let mut rig = nominal();
    for (key, factor) in keys.iter().zip(factors) {
        rig.set(*key, rig.get(*key).unwrap() * factor).unwrap();
    }
    rig.unknown = keys.iter().map(ModelKey::to_string).collect();
    rig
}

fn holds(estimate: &Estimate, truth: &Rig) -> bool {
    let value = truth.get(estimate.key).unwrap();
    estimate.interval95[0] <= value && value <= estimate.interval95[1]
}

#[test]
fn intervals_hold_the_truth_in_at_least_ninety_of_a_hundred_repeats() {
    let truth = nominal();
    let keys = [ModelKey::OuterStiffness, ModelKey::InnerDamping, ModelKey::RadialClearance];
    let rig = guess(&keys, &[1.1, 0.9, 1.1]);
    let repeats = 100;
    let mut held = std::collections::BTreeMap::<String, usize>::new();
    for seed in 0..repeats {
        let recordings = recordings(&truth, 2, 6_400, seed);
        let done = calibrate(&rig, &recordings, &Options { path: PathChoice::None, seed }, &|_| ()).unwrap();
        for estimate in done.parameters {
            *held.entry(estimate.key.to_string()).or_default() += usize::from(holds(&estimate, &truth));
        }
    }
    assert_eq!(held.len(), 5, "three parameters and two noise levels");
    for (key, count) in held {
        // At 95 % the expected count is 95, with a standard deviation of 2.2.
        assert!(count >= 90, "{key}: {count} of {repeats}");
    }
}

#[test]
fn what_a_channel_does_not_see_is_said_to_be_undetermined() {
    let truth = nominal();
    let rig = guess(&[ModelKey::ResonatorDamping, ModelKey::OuterStiffness], &[1.2, 1.1]);
    let mut recordings = recordings(&truth, 2, 6_400, 1);
    recordings.iter_mut().for_each(|r| r.channels.retain(|c| c.name == "ax"));
    let done = calibrate(&rig, &recordings, &Options::default(), &|_| ()).unwrap();
    assert!(done.path_poles.is_empty(), "{:?}", done.explained);
    let told = |key: ModelKey| done.parameters.iter().find(|p| p.key == key.into()).unwrap().determined;
    assert!(told(ModelKey::OuterStiffness) && told(ModelKey::SensorNoise), "{:?}", done.parameters);
    assert!(!told(ModelKey::ResonatorDamping), "{:?}", done.parameters);
    let free: Vec<_> = done.undetermined.iter().flat_map(|u| u.keys.clone()).collect();
    assert!(free.contains(&ModelKey::ResonatorDamping.into()), "{free:?}");
    assert_eq!(done.rig.unknown, [ModelKey::ResonatorDamping.name()]);
}

/// A structure that no rig has is identified as a path; a rig of the right kind has none, and reaches the floor.
#[test]
fn a_path_is_identified_where_one_is() {
    let truth = nominal();
    let plain = recordings(&truth, 4, 12_800, 2);
    let done = calibrate(&nominal(), &plain, &Options::default(), &|_| ()).unwrap();
    assert!(done.path_poles.is_empty(), "{:?}", done.path_poles);
    assert!(done.explained.iter().all(|e| e.residual_db < 0.3), "{:?}", done.explained);
    let mut filtered = plain;
    let a = [1.6, -0.9];
    for samples in
        filtered.iter_mut().flat_map(|r| &mut r.channels).filter(|c| c.name != "tacho").map(|c| &mut c.samples)
    {
        for k in 2..samples.len() {
            samples[k] = 4.0 * samples[k] + a[0] * samples[k - 1] + a[1] * samples[k - 2];
        }
    }
    let done = calibrate(&nominal(), &filtered, &Options::default(), &|_| ()).unwrap();
    assert_eq!(done.path_poles.len(), 2);
    for held in &done.held_out {
        assert!(held.after_db < held.floor_db + 0.7 && held.before_db > 8.0, "{held:?}");
    }
    let text = done.rig.to_toml();
    assert_eq!(Rig::parse(&text, std::path::Path::new("rig.toml")).unwrap(), done.rig);
}

/// Record 97 of Case Western Reserve University: a healthy machine with a structure that no such rig has.
#[test]
fn literature_the_path_of_a_real_machine_is_identified() {
    let Some(folder) = reference_data::folder("cwru") else { return };
    let options = LoadOptions {
        variable: Some("X097_DE_time".into()),
        sample_rate_hz: Some(48_000.0),
        resample_hz: Some(12_000.0),
        unit: Unit::parse("g"),
        ..LoadOptions::default()
    };
    let mut recordings = load(&[folder.join("97_Normal_0.mat")], &options).unwrap().recordings;
    (recordings[0].shaft_hz, recordings[0].load_n) = (Some(29.93), Some(300.0));
    let done = calibrate(&nominal(), &recordings, &Options::default(), &|_| ()).unwrap();
    let held = &done.held_out[0];
    // 16.6 dB before, 4.4 after: bounds half way between show the path without depending on digits.
    assert!(held.after_db < 6.0 && held.before_db > 12.0, "{held:?}");
}
