use std::f64::consts::TAU;

use super::result::{DiagnosisResult, Parameter, Verdict};
use super::{Task, diagnose};
use crate::recording::{LoadOptions, Recording, Unit, load, reference_data};
use crate::rig::config::ModelKey;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::test_support::{RATE, RIG, condition, nominal, parse};
use crate::rig::{EffectEntry, OperatingCondition, Rig, Run, Start, simulate_many};
use crate::signal::test_signals::gaussian;

/// Recordings of half a second at other speeds and loads, each by a rig of its own; the last is held out.
fn recordings_of(
    rigs: &[Rig; 3],
    seed: u64,
    stated: impl Fn(OperatingCondition) -> OperatingCondition,
) -> Vec<Recording> {
    let at = |i: usize| condition(31.0 + 2.5 * i as f64, 380.0 + 130.0 * i as f64, 12_800);
    let run = |i: usize| Run { rig: &rigs[i], condition: stated(at(i)), start: Start::seeded(seed * 10 + i as u64) };
    let runs: Vec<Run> = (0..3).map(run).collect();
    let mut made = simulate_many(&runs).unwrap();
    for (i, recording) in made.iter_mut().enumerate() {
        (recording.shaft_hz, recording.load_n) = (Some(at(i).shaft_hz), Some(at(i).load_n));
    }
    made
}

fn recordings(rig: &Rig, seed: u64) -> Vec<Recording> {
    let rigs = [rig.clone(), rig.clone(), rig.clone()];
    let mut made = recordings_of(&rigs, seed, |condition| condition);
    made.iter_mut().for_each(|r| r.channels.retain(|c| c.name != "tacho"));
    made
}

fn diagnosed(rig: &Rig, baseline: Option<&[Recording]>, recordings: &[Recording], seed: u64) -> DiagnosisResult {
    diagnose(&Task { rig, baseline, recordings, seed }, &|_| ()).unwrap()
}

fn diagnosed_alone(truth: &Rig, seed: u64) -> DiagnosisResult {
    diagnosed(&nominal(), None, &recordings(truth, seed), seed)
}

fn with(kind: EffectKind, numbers: &[(ParameterKey, f64)]) -> Rig {
    nominal().with_effect(EffectEntry::new(kind, numbers))
}

fn names(outcome: &DiagnosisResult) -> Vec<&str> {
    outcome.diagnosis.causes.iter().map(|c| c.name.as_str()).collect()
}

fn number(outcome: &DiagnosisResult, key: ParameterKey) -> f64 {
    match outcome.diagnosis.causes[0].parameters[key.name()] {
        Parameter::Number(value) => value,
        Parameter::Name(_) => f64::NAN,
    }
}

#[test]
fn null_a_healthy_rig_is_quiet() {
    let outcome = diagnosed_alone(&nominal(), 1);
    assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
    assert!(outcome.diagnosis.causes.is_empty() && outcome.rig.effects.is_empty());
    let standing = outcome.tests.iter().filter(|t| t.is_significant()).count();
    assert!(outcome.tests.len() > 50 && standing <= 2, "{standing} of {}", outcome.tests.len());
    let fit = &outcome.diagnosis.fit;
    assert!(fit.before == fit.after && fit.p_value == 1.0, "{fit:?}");
    assert!(!outcome.held_out.is_empty());
}

#[test]
fn null_a_machine_whose_speed_load_and_cage_are_not_quite_as_stated_is_quiet() {
    let slipping = with(EffectKind::CageSlip, &[(ParameterKey::Fraction, 0.003)]);
    let rigs = [slipping.clone(), slipping.clone(), slipping];
    let made = recordings_of(&rigs, 12, |c| OperatingCondition {
        shaft_hz: 1.0007 * c.shaft_hz,
        load_n: 0.995 * c.load_n,
        ..c
    });
    let outcome = diagnosed(&nominal(), None, &made, 12);
    assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
    let slip: Vec<f64> = outcome.diagnosis.nuisance.iter().filter_map(|n| n.slip).collect();
    assert!(slip.iter().all(|s| (s - 0.0023).abs() < 0.0012), "{slip:?}");
}

/// Races out of round by 0.2 and 0.3 µm, balls of several sizes.
#[test]
fn null_races_out_of_round_and_balls_of_several_sizes_are_within_tolerance() {
    use ParameterKey::{AmplitudeM, Lobes, PhaseRad};
    let race =
        |kind, amplitude, lobes| EffectEntry::new(kind, &[(AmplitudeM, amplitude), (Lobes, lobes), (PhaseRad, 1.0)]);
    let rig = nominal().with_effect(race(EffectKind::OuterRaceWaviness, 3e-7, 2.0)).with_effect(race(
        EffectKind::InnerRaceWaviness,
        2e-7,
        3.0,
    ));
    let at = |i: u32| condition(31.0 + 2.5 * f64::from(i), 380.0 + 130.0 * f64::from(i), 12_800);
    // The same seed: the balls are the same in all recordings.
    let start = Start { ball_std_m: 6e-8, ..Start::seeded(11) };
    let runs: Vec<Run> = (0..3).map(|i| Run { rig: &rig, condition: at(i), start }).collect();
    let outcome = diagnosed(&nominal(), None, &simulate_many(&runs).unwrap(), 11);
    assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
}

/// Few balls under a light load carry much of a strong force in y into x. About the mean slope of the contact 5,000 nats were left.
#[test]
fn null_noise_that_passing_balls_carry_is_no_cause() {
    let rig = parse(
        &RIG.replace("balls = 9", "balls = 7")
            .replace("psd_n2_per_hz = 2e-05", "psd_n2_per_hz = 2e-03")
            .replace("std_m_per_s2 = 0.02", "std_m_per_s2 = 0.005"),
    );
    let at = |i: u32| condition(9.0 + f64::from(i), 230.0 + 80.0 * f64::from(i), 25_600);
    let run = |i: u32| Run { rig: &rig, condition: at(i), start: Start::seeded(u64::from(i)) };
    let outcome = diagnosed(&rig, None, &simulate_many(&[0, 1, 2].map(run)).unwrap(), 3);
    assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?} {:?}", outcome.diagnosis.causes, outcome.caveats);
}

/// A badly glued sensor, whose signal falls from 1.7 kHz on: the colour of the noise takes it up, but is too great for one.
#[test]
fn null_a_sensor_that_falls_is_unexplained() {
    let mut made = recordings(&nominal(), 15);
    let share = 1.0 - (-TAU * 1700.0 / RATE).exp();
    for channel in made.iter_mut().flat_map(|r| &mut r.channels).filter(|c| c.name == "ay") {
        let mut last = 0.0;
        for value in &mut channel.samples {
            last += share * (*value - last);
            *value = last;
        }
    }
    let outcome = diagnosed(&nominal(), None, &made, 15);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis.causes);
    assert!(outcome.caveats.iter().any(|c| c.contains("another filter")), "{:?}", outcome.caveats);
}

/// The noise of the first recording has twice the power where frequencies are high, that of the second where they are low. Without a
/// colour of each recording, 100 nats beyond chance and more are left.
#[test]
fn null_noise_that_differs_in_colour_between_recordings_is_no_cause() {
    let mut made = recordings(&nominal(), 14);
    for (n, (recording, sign)) in made.iter_mut().zip([-1.0, 1.0]).enumerate() {
        for (c, channel) in recording.channels.iter_mut().enumerate() {
            let noise = gaussian(channel.samples.len() + 1, (2 * n + c) as u64);
            let more = nominal().get(ModelKey::SensorNoise).unwrap() / 2.0;
            channel.samples.iter_mut().zip(noise.windows(2)).for_each(|(v, w)| *v += more * (w[1] + sign * w[0]));
        }
    }
    let outcome = diagnosed(&nominal(), None, &made, 14);
    assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
}

/// A fault that came after the first two recordings.
#[test]
fn a_pit_in_the_last_recording_alone_is_named() {
    let pit = [(ParameterKey::DepthM, 9e-7), (ParameterKey::WidthRad, 0.07), (ParameterKey::AngleRad, 1.7)];
    let rigs = [nominal(), nominal(), with(EffectKind::OuterRaceDefect, &pit)];
    let outcome = diagnosed(&nominal(), None, &recordings_of(&rigs, 15, |condition| condition), 15);
    assert_eq!(names(&outcome), ["outer-race-defect"], "{:?}", outcome.diagnosis);
    assert!(outcome.caveats.iter().any(|c| c.contains("alone")), "{:?}", outcome.caveats);
}

/// A sensor that was loose in the first and last recording, or only in the last: the colours of the noise take up its level.
#[test]
fn a_gain_of_some_recordings_is_no_all_clear() {
    let loose = || {
        let gain = EffectEntry::new(EffectKind::SensorGain, &[(ParameterKey::Value, 1.5)]);
        nominal().with_effect(gain.with_text(ParameterKey::Channel, "all"))
    };
    let made = recordings_of(&[loose(), nominal(), loose()], 33, |condition| condition);
    let outcome = diagnosed(&nominal(), None, &made, 33);
    assert_eq!(names(&outcome), ["sensor-gain"], "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::Value) / 1.5 - 1.0).abs() < 0.05, "{:?}", outcome.diagnosis.causes);
    assert!(outcome.caveats.iter().any(|c| c.contains("alone")), "{:?}", outcome.caveats);
    let made = recordings_of(&[nominal(), nominal(), loose()], 34, |condition| condition);
    let outcome = diagnosed(&nominal(), None, &made, 34);
    assert_ne!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
}

/// A drift leaves little, as the colours of the noise take up the gain. Its rate is that of an even rotation: one that wanders takes
/// up the drift.
#[test]
fn a_gain_beside_a_drift_is_named() {
    let gain = EffectEntry::new(EffectKind::SensorGain, &[(ParameterKey::Value, 0.75)]);
    let truth = with(EffectKind::SpeedDrift, &[(ParameterKey::RatePerS, 0.06)])
        .with_effect(gain.with_text(ParameterKey::Channel, "all"));
    let outcome = diagnosed_alone(&truth, 35);
    assert_eq!(names(&outcome), ["speed-drift", "sensor-gain"], "{:?}", outcome.diagnosis);
}

/// A fault that is ten times as strong in one recording is that of it, and of the others with numbers of their own.
#[test]
fn a_misalignment_that_grows_is_followed_from_recording_to_recording() {
    let of = |force: f64| with(EffectKind::Misalignment, &[(ParameterKey::ForceN, force)]);
    let outcome =
        diagnosed(&nominal(), None, &recordings_of(&[of(10.0), of(100.0), of(40.0)], 17, |condition| condition), 17);
    assert_eq!(names(&outcome)[0], "misalignment", "{:?}", outcome.diagnosis);
    let said = outcome.caveats.iter().find(|c| c.contains("numbers of their own")).unwrap();
    let forces = said.split("misalignment (force ").skip(1).map(|s| s.split(' ').next().unwrap().parse().unwrap());
    let forces: Vec<f64> = forces.collect();
    assert!(forces.len() == 2 && (forces[0] - 10.0).abs() < 1.5 && (forces[1] - 40.0).abs() < 2.0, "{said}");
}

/// What one recording shows is no cause where the others differ as much in another way.
#[test]
fn null_a_mode_of_another_frequency_in_each_recording_is_no_cause() {
    let of = |hz: f64| {
        let mode = [(ParameterKey::FrequencyHz, hz), (ParameterKey::DampingRatio, 0.02)];
        let mode = EffectEntry::new(EffectKind::StructuralResonance, &mode);
        nominal().with_effect(mode.with_text(ParameterKey::Channel, "ax"))
    };
    let rigs = [of(600.0), of(1100.0), of(2100.0)];
    let outcome = diagnosed(&nominal(), None, &recordings_of(&rigs, 18, |condition| condition), 18);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
}

/// A spike among others is neither a shock nor a step of the load.
#[test]
fn null_spikes_of_one_recording_are_no_event() {
    let mut made = recordings(&nominal(), 19);
    made.last_mut().into_iter().for_each(with_spikes);
    let outcome = diagnosed(&nominal(), None, &made, 19);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
    assert!(outcome.caveats.iter().any(|c| c.contains("kurtosis")), "{:?}", outcome.caveats);
}

fn with_spikes(recording: &mut Recording) {
    for channel in &mut recording.channels {
        channel.samples.iter_mut().skip(37).step_by(613).for_each(|v| *v += 0.5);
    }
}

#[test]
fn spikes_are_unexplained() {
    let mut made = recordings(&nominal(), 19);
    made.iter_mut().for_each(with_spikes);
    let outcome = diagnosed(&nominal(), None, &made, 19);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
    assert!(outcome.caveats.iter().any(|c| c.contains("kurtosis")), "{:?}", outcome.caveats);
}

/// A rig that is given with a ball's pit strikes as its recordings do.
#[test]
fn null_a_rig_that_strikes_is_quiet() {
    let pit = with(EffectKind::BallDefect, &[(ParameterKey::DepthM, 1.5e-6), (ParameterKey::WidthRad, 0.05)]);
    let outcome = diagnosed(&pit, None, &recordings(&pit, 20), 20);
    assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?} {:?}", outcome.diagnosis, outcome.caveats);
}

#[test]
fn a_pit_is_named_and_proved() {
    let pit = [(ParameterKey::DepthM, 9e-7), (ParameterKey::WidthRad, 0.07), (ParameterKey::AngleRad, 1.7)];
    let outcome = diagnosed_alone(&with(EffectKind::OuterRaceDefect, &pit), 2);
    assert_eq!(names(&outcome), ["outer-race-defect"], "{:?}", outcome.diagnosis);
    let depth = number(&outcome, ParameterKey::DepthM);
    assert!((0.5..2.0).contains(&(depth / 9e-7)), "{depth}");
    let [from, to] = outcome.diagnosis.causes[0].interval95["angle_rad"];
    assert!(from < 1.7 && 1.7 < to && to < 1.85, "{from} {to}");
    let fit = &outcome.diagnosis.fit;
    assert!(fit.after < 0.7 * fit.before && fit.p_value < 0.001, "{fit:?}");
    assert!(outcome.diagnosis.rejected.iter().all(|r| r.name != "outer-race-defect"));
}

/// A trough between short flanks, of which the half sine that comes nearest is far wider than it and leaves most.
#[test]
fn a_pit_of_another_shape_is_fitted_with_its_flanks() {
    use ParameterKey::{AngleRad, DepthM, Flank, WidthRad};
    let pit = [(DepthM, 9e-7), (WidthRad, 0.07), (AngleRad, 1.7), (Flank, 0.15)];
    let outcome = diagnosed_alone(&with(EffectKind::OuterRaceDefect, &pit), 16);
    assert_eq!(names(&outcome), ["outer-race-defect"], "{:?}", outcome.diagnosis);
    let found = |key: ParameterKey| outcome.rig.effects[0].number(key).unwrap();
    let [depth, width, flank] = [DepthM, WidthRad, Flank].map(found);
    assert!((depth / 9e-7 - 1.0).abs() < 0.1 && (width / 0.07 - 1.0).abs() < 0.05, "{depth} {width}");
    assert!((0.1..0.22).contains(&flank), "{flank}");
}

#[test]
fn a_pit_seen_by_one_sensor_may_be_on_either_side_of_the_load() {
    let pit = [(ParameterKey::DepthM, 9e-7), (ParameterKey::WidthRad, 0.07), (ParameterKey::AngleRad, 1.85)];
    let mut made = recordings(&with(EffectKind::OuterRaceDefect, &pit), 2);
    made.iter_mut().for_each(|r| r.channels.retain(|c| c.name == "ay"));
    let outcome = diagnosed(&nominal(), None, &made, 2);
    assert_eq!(names(&outcome), ["outer-race-defect"], "{:?}", outcome.diagnosis);
    let [from, to] = outcome.diagnosis.causes[0].interval95["angle_rad"];
    assert!((from + to - std::f64::consts::PI).abs() < 1e-9 && (1.85..2.3).contains(&to), "{from} {to}");
}

/// Sensors are seldom as quiet as their sheet says: that is no gain, which lines and the process force would have as well.
#[test]
fn null_a_louder_noise_of_the_sensors_is_no_gain() {
    let noisy = |factor: f64| {
        let mut rig = nominal();
        rig.set(ModelKey::SensorNoise, factor * rig.get(ModelKey::SensorNoise).unwrap()).unwrap();
        rig
    };
    for (stated, factor) in [(2.0, 1.25), (5.0, 1.25), (5.0, 0.8)] {
        let outcome = diagnosed(&noisy(stated), None, &recordings(&noisy(stated * factor), 21), 21);
        assert!(names(&outcome).is_empty(), "{stated} {factor}: {:?}", outcome.diagnosis);
    }
}

fn assert_named_with(effect: EffectEntry, key: ParameterKey, within: f64, seed: u64) {
    let outcome = diagnosed_alone(&nominal().with_effect(effect.clone()), seed);
    assert_eq!(names(&outcome), [effect.kind.name()], "{:?}", outcome.diagnosis);
    let (found, truth) = (number(&outcome, key), effect.number(key).unwrap());
    assert!((found / truth - 1.0).abs() < within, "{found}");
    let component = effect.text(ParameterKey::Component).unwrap();
    assert_eq!(outcome.diagnosis.causes[0].parameters["component"], Parameter::Name(component.into()));
}

#[test]
fn a_stiffness_is_not_taken_for_another_effect() {
    let change = EffectEntry::new(EffectKind::StiffnessChange, &[(ParameterKey::Value, 1.2e7)])
        .with_text(ParameterKey::Component, "outer");
    assert_named_with(change, ParameterKey::Value, 0.02, 3);
}

/// The greatest load is nearly what the spring can carry; one that comes at once takes it past its summit.
#[test]
fn a_spring_that_softens_almost_to_its_summit_is_not_taken_for_an_asymmetric_one() {
    let softening = EffectEntry::new(EffectKind::SofteningStiffness, &[(ParameterKey::CubicNPerM3, -2.9e15)])
        .with_text(ParameterKey::Component, "outer");
    assert_named_with(softening, ParameterKey::CubicNPerM3, 0.1, 6);
}

/// A hundredth of the static deflection: it frees the housing across the load alone.
#[test]
fn a_small_play_is_named() {
    let play = EffectEntry::new(EffectKind::Backlash, &[(ParameterKey::WidthM, 2e-7)])
        .with_text(ParameterKey::Component, "outer");
    assert_named_with(play, ParameterKey::WidthM, 0.15, 7);
}

/// In both directions it would take the lines of the loaded one too, which are there. What takes lines leaves nothing in excess.
#[test]
fn a_friction_across_the_load_is_named_and_its_force_is_not_stated_where_it_holds_the_housing() {
    let numbers = [(ParameterKey::ForceN, 17.0), (ParameterKey::RegularisationMPerS, 5e-6)];
    let friction =
        EffectEntry::new(EffectKind::CoulombFriction, &numbers).with_text(ParameterKey::Component, "outer-x");
    let outcome = diagnosed_alone(&nominal().with_effect(friction), 5);
    assert_eq!(names(&outcome), ["coulomb-friction"], "{:?}", outcome.diagnosis);
    let parameters = &outcome.diagnosis.causes[0].parameters;
    assert_eq!(parameters.keys().collect::<Vec<_>>(), ["component"], "{parameters:?}");
    assert_eq!(outcome.rig.effects[0].kind, EffectKind::CoulombFriction);
}

#[test]
fn a_damper_in_one_direction_is_not_taken_for_a_friction() {
    let damper = EffectEntry::new(EffectKind::DampingChange, &[(ParameterKey::Value, 7e3)])
        .with_text(ParameterKey::Component, "outer-y");
    // Its interval is 15 % either way.
    assert_named_with(damper, ParameterKey::Value, 0.2, 5);
}

/// A stop of the shaft, with a damper that the corrected rig has as well.
#[test]
fn a_stop_is_fitted_with_its_damping() {
    let numbers =
        [(ParameterKey::GapM, 2e-5), (ParameterKey::StiffnessNPerM, 1.5e8), (ParameterKey::DampingNSPerM, 2.5e4)];
    let stop = EffectEntry::new(EffectKind::EndStopContact, &numbers).with_text(ParameterKey::Component, "inner-y");
    let outcome = diagnosed_alone(&nominal().with_effect(stop), 8);
    assert_eq!(names(&outcome), ["end-stop-contact"], "{:?}", outcome.diagnosis);
    let found = numbers.map(|(key, truth)| outcome.rig.effects[0].number(key).map_or(0.0, |found| found / truth));
    assert!(found.iter().all(|share| (share - 1.0).abs() < 0.3), "{found:?}");
}

/// Nor is it taken for a mode or a gain, and the corrected rig has it.
fn assert_nameless(effect: EffectEntry, key: ParameterKey, within: f64, seed: u64) {
    let outcome = diagnosed_alone(&nominal().with_effect(effect.clone()), seed);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
    assert!(names(&outcome).is_empty() && outcome.caveats.iter().any(|c| c.contains(effect.kind.name())));
    let [found, truth] = [&outcome.rig.effects[0], &effect].map(|e| e.number(key).unwrap());
    assert!((found.abs() / truth.abs() - 1.0).abs() < within, "{found}");
    let fit = &outcome.diagnosis.fit;
    assert!(fit.after < fit.before, "{fit:?}");
}

#[test]
fn a_sensor_that_is_sensitive_across_is_no_cause_of_the_vocabulary() {
    let transverse = EffectEntry::new(EffectKind::TransverseSensitivity, &[(ParameterKey::Value, 0.6)])
        .with_text(ParameterKey::Channel, "ax");
    assert_nameless(transverse, ParameterKey::Value, 0.05, 4);
}

#[test]
fn a_random_force_is_no_cause_of_the_vocabulary() {
    let random = EffectEntry::new(EffectKind::RandomForce, &[(ParameterKey::PsdN2PerHz, 2e-5)])
        .with_text(ParameterKey::Component, "outer-x");
    assert_nameless(random, ParameterKey::PsdN2PerHz, 0.1, 5);
}

#[test]
fn a_coarse_converter_is_a_mismatch_unless_the_baseline_has_it() {
    let coarse = |seed: u64| {
        let mut made = recordings(&nominal(), seed);
        let step = 0.05;
        let samples = made.iter_mut().flat_map(|r| &mut r.channels).flat_map(|c| &mut c.samples);
        samples.for_each(|v| *v = (*v / step).floor() * step + 0.5 * step);
        made
    };
    let verdict = |baseline: Option<&[Recording]>| diagnosed(&nominal(), baseline, &coarse(1), 1).diagnosis.verdict;
    assert_eq!(verdict(None), Verdict::Unexplained);
    assert_eq!(verdict(Some(&coarse(2))), Verdict::NoMismatch);
}

#[test]
fn what_the_baseline_shows_as_well_is_no_change_since() {
    let change = EffectEntry::new(EffectKind::StiffnessChange, &[(ParameterKey::Value, 1.2e7)])
        .with_text(ParameterKey::Component, "outer");
    let truth = nominal().with_effect(change);
    let now = recordings(&truth, 7);
    let named = |baseline: &Rig| {
        let outcome = diagnosed(&nominal(), Some(&recordings(baseline, 8)), &now, 7);
        names(&outcome).iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(named(&nominal()), ["stiffness-change"]);
    assert_eq!(named(&truth), [""; 0]);
}

#[test]
fn what_is_seen_in_the_samples_is_named() {
    let clip = EffectEntry::new(EffectKind::SensorClipping, &[(ParameterKey::Value, 0.2)])
        .with_text(ParameterKey::Channel, "ay");
    let outcome = diagnosed_alone(&nominal().with_effect(clip), 4);
    assert_eq!(outcome.diagnosis.causes[0].name, "sensor-clipping", "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::Value) - 0.2).abs() < 1e-9);
    let bias =
        EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, 0.09)]).with_text(ParameterKey::Channel, "ax");
    let mains = EffectEntry::new(
        EffectKind::MainsInterference,
        &[(ParameterKey::FrequencyHz, 50.0), (ParameterKey::Amplitude, 0.02)],
    );
    let outcome = diagnosed_alone(&nominal().with_effect(bias).with_effect(mains), 5);
    // The most probable first: sensors have offsets.
    assert_eq!(names(&outcome), ["mains-interference", "sensor-bias"], "{:?}", outcome.diagnosis);
}

#[test]
fn samples_that_are_missing_are_counted_by_the_tachometer() {
    let missing = with(EffectKind::DroppedSamples, &[(ParameterKey::TimeS, 0.17), (ParameterKey::Count, 83.0)]);
    let rigs = [missing.clone(), missing.clone(), missing];
    let outcome = diagnosed(&nominal(), None, &recordings_of(&rigs, 7, |c| c), 7);
    assert_eq!(names(&outcome), ["dropped-samples"], "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::Count) - 83.0).abs() <= 2.0);
    assert!((number(&outcome, ParameterKey::TimeS) - 0.17).abs() < 0.02);
}

#[test]
fn a_strong_mode_is_met() {
    let mode = [(ParameterKey::FrequencyHz, 2895.0), (ParameterKey::DampingRatio, 0.05), (ParameterKey::Gain, -14.7)];
    let outcome = diagnosed_alone(&with(EffectKind::StructuralResonance, &mode), 10);
    assert_eq!(names(&outcome), ["structural-resonance"], "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::FrequencyHz) / 2895.0 - 1.0).abs() < 0.01);
    assert!((number(&outcome, ParameterKey::DampingRatio) / 0.05 - 1.0).abs() < 0.2);
}

/// At another time in every recording, as real events are.
#[test]
fn a_shock_is_found_at_the_time_of_each_recording_and_is_no_load_step() {
    let shock = |time: f64| with(EffectKind::Shock, &[(ParameterKey::TimeS, time), (ParameterKey::ImpulseNS, 0.02)]);
    let rigs = [shock(0.2715), shock(0.11), shock(0.33)];
    let outcome = diagnosed(&nominal(), None, &recordings_of(&rigs, 11, |c| c), 11);
    assert_eq!(names(&outcome), ["shock"], "{:?}", outcome.diagnosis);
    let evidence = &outcome.diagnosis.causes[0].evidence;
    for time in ["0.27", "0.11", "0.33"] {
        assert!(evidence.contains(time), "{evidence}");
    }
}

#[test]
fn an_event_in_the_held_out_recording_alone_is_named() {
    let shock = with(EffectKind::Shock, &[(ParameterKey::TimeS, 0.2), (ParameterKey::ImpulseNS, 0.02)]);
    let outcome = diagnosed(&nominal(), None, &recordings_of(&[nominal(), nominal(), shock], 13, |c| c), 13);
    assert_eq!(names(&outcome), ["shock"], "{:?}", outcome.diagnosis);
}

#[test]
fn a_pit_in_the_held_out_recording_alone_is_no_all_clear() {
    let pit = [(ParameterKey::DepthM, 2e-6), (ParameterKey::WidthRad, 0.07), (ParameterKey::AngleRad, 1.7)];
    let pitted = with(EffectKind::OuterRaceDefect, &pit);
    let outcome = diagnosed(&nominal(), None, &recordings_of(&[nominal(), nominal(), pitted], 14, |c| c), 14);
    assert_ne!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
}

#[test]
fn a_cage_that_slips_is_told_by_how_much() {
    let outcome = diagnosed_alone(&with(EffectKind::CageSlip, &[(ParameterKey::Fraction, 0.021)]), 8);
    assert_eq!(names(&outcome), ["cage-slip"], "{:?}", outcome.diagnosis);
    // What a healthy cage slips by is in it.
    assert!((number(&outcome, ParameterKey::Fraction) - 0.021).abs() < 0.005);
}

/// Signals that swell and fade at a rate of their own: nothing in the vocabulary does that.
#[test]
fn what_nothing_explains_is_said_to_be_unexplained() {
    let mut made = recordings(&nominal(), 6);
    for recording in &mut made {
        let rate = recording.sample_rate_hz;
        for channel in &mut recording.channels {
            for (i, v) in channel.samples.iter_mut().enumerate() {
                // A tone of 778 Hz that no order of the machine has, swelling at 13.7 Hz.
                let time = i as f64 / rate;
                let swell = 1.0 + 0.8 * (std::f64::consts::TAU * 13.7 * time).sin();
                *v += 0.03 * swell * (std::f64::consts::TAU * 778.3 * time).sin();
            }
        }
    }
    let outcome = diagnosed(&nominal(), None, &made, 6);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
    assert!(outcome.diagnosis.causes.is_empty());
    assert!(outcome.caveats.iter().any(|c| c.contains("no effect of the vocabulary")), "{:?}", outcome.caveats);
}

/// Case Western Reserve University records: 97 healthy, 130 a pit in the outer race, 118 one on a ball that nobody finds.
#[test]
fn literature_a_real_pit_is_named_by_its_rhythm_and_no_other_name_is_given() {
    let Some(folder) = reference_data::folder("cwru") else { return };
    let read = |file: &str, record: u32, rate: f64| {
        let options = LoadOptions {
            variable: Some(format!("X{record:03}_DE_time")),
            sample_rate_hz: Some(rate),
            resample_hz: Some(12_000.0),
            unit: Unit::parse("g"),
            ..LoadOptions::default()
        };
        let mut recording = load(&[folder.join(file)], &options).unwrap().recordings.swap_remove(0);
        (recording.shaft_hz, recording.load_n) = (Some(29.93), Some(300.0));
        vec![recording]
    };
    let mut rig = nominal();
    rig.set(ModelKey::BallDiameter, 0.3126 * 0.0254).unwrap();
    rig.set(ModelKey::PitchDiameter, 1.537 * 0.0254).unwrap();
    rig.unknown = ["inner", "outer", "resonator"].map(String::from).to_vec();
    let healthy = read("97_Normal_0.mat", 97, 48_000.0);
    let of = |recordings: &[Recording]| diagnosed(&rig, Some(&healthy), recordings, 1);
    let outer = of(&read("130_at_6_0.mat", 130, 12_000.0));
    assert_eq!(outer.diagnosis.causes[0].name, "outer-race-defect", "{:?}", outer.diagnosis);
    assert!(outer.diagnosis.fit.after < 0.5 * outer.diagnosis.fit.before);
    let ball = of(&read("118_0.mat", 118, 12_000.0));
    assert_eq!(ball.diagnosis.verdict, Verdict::Unexplained, "{:?}", ball.diagnosis);
    let same = diagnosed(&rig, None, &healthy, 1);
    assert_eq!(same.diagnosis.verdict, Verdict::NoMismatch, "{:?}", same.diagnosis);
}
