use super::data_split::DataSplit;
use super::hypothesis::{self, InitialGuesses};
use super::model_selection::{Candidate, ModelSelection, Part};
use super::result::{Aspect, DiagnosisResult, Parameter, Test, Verdict};
use super::{Task, diagnose};
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::Observed;
use crate::identify::likelihood::problem::Problem;
use crate::identify::likelihood::search::{Limits, search};
use crate::recording::{LoadOptions, Recording, Unit, load, reference_data};
use crate::rig::config::{ModelKey, RigKey};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::test_support::{condition, nominal};
use crate::rig::{EffectEntry, Rig, Run, Start, simulate_many};

/// Three recordings of half a second at other speeds and loads, one of them held out; without tachometer.
pub(super) fn recordings(rig: &Rig, seed: u64) -> Vec<Recording> {
    let mut recordings = recordings_with_tachometer(rig, seed);
    recordings.iter_mut().for_each(|r| r.channels.retain(|c| c.name != "tacho"));
    recordings
}

fn recordings_with_tachometer(rig: &Rig, seed: u64) -> Vec<Recording> {
    let run = |i: usize| Run {
        rig,
        condition: condition(31.0 + 2.5 * i as f64, 380.0 + 130.0 * i as f64, 12_800),
        start: Start::seeded(seed * 10 + i as u64),
    };
    let runs: Vec<Run> = (0..3).map(run).collect();
    simulate_many(&runs).unwrap()
}

fn diagnosed(rig: &Rig, baseline: Option<&[Recording]>, recordings: &[Recording], seed: u64) -> DiagnosisResult {
    diagnose(&Task { rig, baseline, recordings, seed }, &|_| ()).unwrap()
}

fn diagnosed_alone(truth: &Rig, seed: u64) -> DiagnosisResult {
    diagnosed(&nominal(), None, &recordings(truth, seed), seed)
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
    assert!(outcome.tests.len() > 200 && standing <= 2, "{standing} of {}", outcome.tests.len());
    // What was held out is shown all the same, and no error is no more than its noise.
    let fit = &outcome.diagnosis.fit;
    assert!(fit.noise_floor > 0.0 && fit.before.abs() < 5.0 * fit.noise_floor && fit.p_value == 1.0, "{fit:?}");
    assert!(!outcome.held_out.is_empty());
}

#[test]
fn a_pit_is_named_sized_and_proved() {
    let pit = [(ParameterKey::DepthM, 9e-7), (ParameterKey::WidthRad, 0.07), (ParameterKey::AngleRad, 1.7)];
    let outcome = diagnosed_alone(&nominal().with_effect(EffectEntry::new(EffectKind::OuterRaceDefect, &pit)), 2);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Mismatch, "{:?}", outcome.diagnosis);
    let cause = &outcome.diagnosis.causes[0];
    assert_eq!((cause.name.as_str(), outcome.diagnosis.causes.len()), ("outer-race-defect", 1));
    for (key, truth) in pit {
        let [from, to] = cause.interval95[key.name()];
        assert!((number(&outcome, key) / truth - 1.0).abs() < 0.02, "{key}: {}", number(&outcome, key));
        // Twice the interval: one in twenty would miss the interval itself.
        let width = to - from;
        assert!((number(&outcome, key) - truth).abs() < width, "{key}: {from} to {to}, {truth}");
    }
    let fit = &outcome.diagnosis.fit;
    assert!(fit.after < 0.05 * fit.before && fit.p_value < 0.001, "{fit:?}");
    assert!(!outcome.held_out.is_empty());
    assert!(outcome.diagnosis.rejected.iter().all(|r| r.name != "outer-race-defect"));
    // It strikes once for every ball that passes.
    let (location, bpfo) = (&outcome.diagnosis.location, nominal().bearing().unwrap().bearing.geometry().orders().bpfo);
    assert!(location.order.iter().any(|o| (o / bpfo - (o / bpfo).round()).abs() < 2e-3), "{location:?}");
    let at_its_place = |t: &Test| t.aspect == Aspect::CageAngle && t.is_significant();
    assert!(outcome.tests.iter().any(at_its_place) && !location.frequency_hz.is_empty(), "{location:?}");
}

#[test]
fn a_stiffness_is_not_taken_for_another_effect() {
    let change = EffectEntry::new(EffectKind::StiffnessChange, &[(ParameterKey::Value, 1.2e7)])
        .with_text(ParameterKey::Component, "outer");
    let outcome = diagnosed_alone(&nominal().with_effect(change), 3);
    assert_eq!(outcome.diagnosis.causes[0].name, "stiffness-change", "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::Value) / 1.2e7 - 1.0).abs() < 0.02);
    assert_eq!(outcome.diagnosis.causes[0].parameters["component"], Parameter::Name("outer".into()));
}

#[test]
fn what_is_seen_in_the_samples_needs_no_search() {
    let clip = EffectEntry::new(EffectKind::SensorClipping, &[(ParameterKey::Value, 0.2)])
        .with_text(ParameterKey::Channel, "ay");
    let outcome = diagnosed_alone(&nominal().with_effect(clip), 4);
    assert_eq!(outcome.diagnosis.causes[0].name, "sensor-clipping", "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::Value) - 0.2).abs() < 1e-9);
    // Nothing else was sought, and so none is said not to explain it.
    assert!(outcome.caveats.len() == 1 && outcome.caveats[0].contains("cut off"), "{:?}", outcome.caveats);
    let bias =
        EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, 0.03)]).with_text(ParameterKey::Channel, "ax");
    let mains = EffectEntry::new(
        EffectKind::MainsInterference,
        &[(ParameterKey::FrequencyHz, 50.0), (ParameterKey::Amplitude, 0.02)],
    );
    let outcome = diagnosed_alone(&nominal().with_effect(bias).with_effect(mains), 5);
    let names: Vec<_> = outcome.diagnosis.causes.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["sensor-bias", "mains-interference"], "{:?}", outcome.diagnosis);
    assert!(outcome.caveats.is_empty(), "{:?}", outcome.caveats);
}

/// Where nothing else tells the shaft's angle: a balanced shaft.
#[test]
fn a_tachometer_tells_where_on_the_shaft_a_wave_is() {
    let mut rig = nominal();
    rig.set(ModelKey::Unbalance, 0.0).unwrap();
    let wavy = [(ParameterKey::AmplitudeM, 1.2e-7), (ParameterKey::Lobes, 5.0), (ParameterKey::PhaseRad, -0.35)];
    let made =
        recordings_with_tachometer(&rig.clone().with_effect(EffectEntry::new(EffectKind::InnerRaceWaviness, &wavy)), 9);
    let outcome = diagnosed(&rig, None, &made, 9);
    assert_eq!(outcome.diagnosis.causes[0].name, "inner-race-waviness", "{:?}", outcome.diagnosis);
    assert_eq!(number(&outcome, ParameterKey::Lobes), 5.0);
    let found = outcome.rig.effects[0].number(ParameterKey::PhaseRad).unwrap();
    assert!((found + 0.35).sin().abs() < 0.1 && (found + 0.35).cos() > 0.0, "{found}");
}

/// The angles that suit the rig without the gap are those after it, or before it, whichever is longer.
#[test]
fn samples_that_are_missing_are_counted() {
    let missing = [(ParameterKey::TimeS, 0.17), (ParameterKey::Count, 83.0)];
    let outcome = diagnosed_alone(&nominal().with_effect(EffectEntry::new(EffectKind::DroppedSamples, &missing)), 7);
    assert_eq!(outcome.diagnosis.causes[0].name, "dropped-samples", "{:?}", outcome.diagnosis);
    assert_eq!(number(&outcome, ParameterKey::Count), 83.0);
    assert!(
        (number(&outcome, ParameterKey::TimeS) - 0.17).abs() < 3.0 / 25_600.0,
        "{}",
        number(&outcome, ParameterKey::TimeS)
    );
}

/// From half its frequency, or with the other sign, no search comes to it.
#[test]
fn a_strong_mode_that_counters_what_it_is_driven_by_is_met() {
    let mode = [(ParameterKey::FrequencyHz, 2895.0), (ParameterKey::DampingRatio, 0.05), (ParameterKey::Gain, -14.7)];
    let outcome = diagnosed_alone(&nominal().with_effect(EffectEntry::new(EffectKind::StructuralResonance, &mode)), 10);
    assert_eq!(outcome.diagnosis.causes[0].name, "structural-resonance", "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::FrequencyHz) / 2895.0 - 1.0).abs() < 0.01);
    assert!((number(&outcome, ParameterKey::DampingRatio) / 0.05 - 1.0).abs() < 0.2);
}

#[test]
fn a_strong_shock_is_no_load_step() {
    let shock = [(ParameterKey::TimeS, 0.2715), (ParameterKey::ImpulseNS, 0.08)];
    let outcome = diagnosed_alone(&nominal().with_effect(EffectEntry::new(EffectKind::Shock, &shock)), 11);
    let names: Vec<_> = outcome.diagnosis.causes.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["shock"], "{:?}", outcome.diagnosis);
    assert!((number(&outcome, ParameterKey::TimeS) - 0.2715).abs() < 1.0 / 25_600.0);
}

/// A gap that is too small by a tenth, and a pit that makes up for it: what goes through whole recordings at once stays there.
#[test]
fn a_slow_search_goes_on_where_another_stops() {
    let with = |depth: f64, width: f64, gap: f64| {
        let pit = [(ParameterKey::DepthM, depth), (ParameterKey::WidthRad, width), (ParameterKey::SpinRad, 0.0)];
        let clearance = EffectEntry::new(EffectKind::ExcessClearance, &[(ParameterKey::RadialClearanceM, gap)]);
        nominal().with_effect(EffectEntry::new(EffectKind::BallDefect, &pit)).with_effect(clearance)
    };
    let observed = Observed::from_recordings(&recordings(&with(1e-6, 0.05, 8e-6), 13)).unwrap();
    let wrong = with(0.96e-6, 0.0496, 7.2e-6);
    let keys = [
        (0, ParameterKey::DepthM),
        (0, ParameterKey::WidthRad),
        (0, ParameterKey::SpinRad),
        (1, ParameterKey::RadialClearanceM),
    ];
    let coordinates = keys.map(|(n, key)| Coordinate::for_key(&wrong, RigKey::Effect { index: n, key }).unwrap());
    let problem = Problem::new(&observed, wrong, coordinates.to_vec());
    let found = search(&problem, problem.start().unwrap(), &Limits::default()).unwrap();
    let stopped = Candidate {
        kind: EffectKind::ExcessClearance,
        place: String::new(),
        problem,
        found,
        bic_gain: 0.0,
        log_likelihood_gain: 0.0,
    };
    let nearer = stopped.refined(12.0).unwrap();
    let gap = |c: &Candidate| c.rig().unwrap().effects[1].number(ParameterKey::RadialClearanceM).unwrap();
    assert!((gap(&stopped) / 8e-6 - 1.0).abs() > 0.02, "{}", gap(&stopped));
    assert!((gap(&nearer) / 8e-6 - 1.0).abs() < 0.002, "{}", gap(&nearer));
}

/// Where another effect is sought beside that of a rig, which has been fitted alone.
fn selection_given<'o, const N: usize>(split: &'o DataSplit, rig: Rig, keys: [ParameterKey; N]) -> ModelSelection<'o> {
    let keys = keys.map(|key| RigKey::Effect { index: 0, key });
    let unknown = keys.into_iter().map(|key| Coordinate::for_key(&rig, key).unwrap()).collect();
    let DataSplit { fitted: all, beginnings, subset, which, .. } = split;
    let alone = ModelSelection { all, beginnings, subset, which, rig, unknown, angles: None };
    let (problem, found) = alone.null(Part::All).unwrap();
    ModelSelection { rig: problem.rig_at(&found.point.coordinates).unwrap(), angles: Some(found.point.angles), ..alone }
}

/// Apart from a load step, the pulses of a pit do not lie where they did.
#[test]
fn a_load_step_beside_a_pit_is_met() {
    let pit = [(ParameterKey::DepthM, 1.2e-6), (ParameterKey::WidthRad, 0.07), (ParameterKey::AngleRad, 1.0)];
    let pitted = nominal().with_effect(EffectEntry::new(EffectKind::InnerRaceDefect, &pit));
    let step = EffectEntry::new(EffectKind::LoadStep, &[(ParameterKey::TimeS, 0.2113), (ParameterKey::ChangeN, 120.0)]);
    let split = DataSplit::new(&recordings(&pitted.clone().with_effect(step), 14)).unwrap();
    let selection =
        selection_given(&split, pitted, [ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::AngleRad]);
    let guesses = InitialGuesses { times_s: vec![0.21], ..InitialGuesses::default() };
    let mut hypotheses = hypothesis::all(&selection.rig, split.load_n, &guesses);
    hypotheses.retain(|h| h.kind == EffectKind::LoadStep);
    let ranking = selection.run(&hypotheses, f64::NEG_INFINITY, &|_| ()).unwrap();
    let rig = ranking.candidates[0].rig().unwrap();
    let change = rig.effects[1].number(ParameterKey::ChangeN).unwrap();
    assert!((change / 120.0 - 1.0).abs() < 0.05, "{:?}", rig.effects);
}

/// The spin of a pitted ball goes with the angles: with that of all recordings and the angles of a part, a search starts where
/// nothing fits.
#[test]
fn what_is_beside_a_pitted_ball_is_met() {
    let pit = EffectEntry::new(
        EffectKind::BallDefect,
        &[(ParameterKey::DepthM, 1e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::SpinRad, 0.0)],
    );
    let pitted = nominal().with_effect(pit);
    let clearance = EffectEntry::new(EffectKind::ExcessClearance, &[(ParameterKey::RadialClearanceM, 6e-6)]);
    let split = DataSplit::new(&recordings(&pitted.clone().with_effect(clearance), 12)).unwrap();
    let selection =
        selection_given(&split, pitted, [ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::SpinRad]);
    let hypotheses = hypothesis::all(&selection.rig, split.load_n, &InitialGuesses::default());
    let of_clearance: Vec<_> = hypotheses.into_iter().filter(|h| h.kind == EffectKind::ExcessClearance).collect();
    let ranking = selection.run(&of_clearance, f64::NEG_INFINITY, &|_| ()).unwrap();
    let found = ranking.candidates[0].rig().unwrap().effects[1].number(ParameterKey::RadialClearanceM).unwrap();
    assert!((found / 6e-6 - 1.0).abs() < 0.01, "{found}");
}

/// Where the search starts says what slips: a hundredth less and the waveforms are no longer alike.
#[test]
fn a_cage_that_slips_is_told_by_how_much() {
    let outcome = diagnosed_alone(
        &nominal().with_effect(EffectEntry::new(EffectKind::CageSlip, &[(ParameterKey::Fraction, 0.021)])),
        8,
    );
    assert_eq!(outcome.diagnosis.causes[0].name, "cage-slip", "{:?}", outcome.diagnosis);
    assert!(
        (number(&outcome, ParameterKey::Fraction) / 0.021 - 1.0).abs() < 0.02,
        "{}",
        number(&outcome, ParameterKey::Fraction)
    );
}

/// Signals that swell and fade at a rate of their own: nothing in the vocabulary does that.
#[test]
fn what_nothing_explains_is_said_to_be_unexplained() {
    let mut made = recordings(&nominal(), 6);
    for recording in &mut made {
        let rate = recording.sample_rate_hz;
        for channel in &mut recording.channels {
            // Amplitude modulated at 13.7 Hz, whatever the shaft does.
            for (i, v) in channel.samples.iter_mut().enumerate() {
                *v *= 1.0 + 0.8 * (std::f64::consts::TAU * 13.7 * i as f64 / rate).sin();
            }
        }
    }
    let outcome = diagnosed(&nominal(), None, &made, 6);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
    assert!(outcome.diagnosis.causes.is_empty());
    // A fault of the sensor is told beside it, and that it is not all.
    made.iter_mut().for_each(|r| r.channels[0].samples.iter_mut().for_each(|v| *v += 0.05));
    let outcome = diagnosed(&nominal(), None, &made, 6);
    let names: Vec<_> = outcome.diagnosis.causes.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["sensor-bias"], "{:?}", outcome.diagnosis);
    let told = outcome.caveats.iter().any(|c| c.contains("nothing in the vocabulary explains"));
    assert!(told, "{:?}", outcome.caveats);
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
    let same = of(&healthy);
    assert_eq!(same.diagnosis.verdict, Verdict::NoMismatch, "{:?}", same.diagnosis);
}
