use crate::rig::effect::EffectKind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::case_spec::{CaseSpec, Hidden, Kind, Severity, round};
use super::outside::Outside;
use super::*;
use crate::rig::assembly::Assembly;

fn spec(hidden: Hidden) -> CaseSpec {
    CaseSpec { hidden, loud: false, tachometer: true, guessed: false }
}

fn draw(hidden: Hidden, seed: u64) -> Case {
    Case::draw(&spec(hidden), Simulator::Shared, 0.2, seed).unwrap()
}

#[test]
fn every_effect_of_the_vocabulary_is_drawn_as_one_that_a_rig_can_have() {
    for seed in 0..4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let drawn = machine::draw(seed % 2 == 0, 0.2, 1, &mut rng).unwrap();
        let without = vec![simulate(&drawn.rig, &drawn.conditions[0], &Start::seeded(seed)).unwrap()];
        for name in EffectKind::ALL.iter().copied() {
            for share in [0.0, 0.5, 1.0] {
                let entry = effects::draw(name, share, &drawn, &without, &mut rng);
                drawn.rig.clone().with_effect(entry).check().unwrap();
            }
        }
    }
}

#[test]
fn the_same_brief_and_seed_give_the_same_case_and_others_another() {
    let hidden = Hidden::Effects(vec![(EffectKind::Unbalance, Severity::Plain)]);
    let case = draw(hidden.clone(), 5);
    let again = draw(hidden.clone(), 5);
    assert_eq!((&case.recordings, &case.truth), (&again.recordings, &again.truth));
    assert_ne!(case.recordings, draw(hidden, 6).recordings);
}

#[test]
fn null_a_control_has_nothing_hidden_and_everything_else_has() {
    let control = draw(Hidden::Nothing, 1);
    assert_eq!((control.truth.causes.len(), control.truth.change), (0, 0.0));
    for kind in Outside::ALL {
        let case = draw(Hidden::Outside(kind), 2);
        assert_eq!(case.truth.causes, ["unexplained"]);
        assert!(case.truth.change > 0.01, "{}: {}", kind.name(), case.truth.change);
    }
    let case = draw(Hidden::Effects(vec![(EffectKind::OuterRaceDefect, Severity::Severe)]), 3);
    assert!(case.truth.change > 0.05, "{}", case.truth.change);
}

/// Recordings of a case: no two have the same noise, impacts at the same times, or a tone in the same phase.
#[test]
fn what_is_random_outside_the_vocabulary_is_another_in_every_recording() {
    for kind in [Outside::RandomImpacts, Outside::ForeignTone, Outside::SwellingNoise] {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let drawn = machine::draw(false, 0.2, 1, &mut rng).unwrap();
        let run = |alter: &dyn Fn(&mut Assembly)| {
            let recording = simulate_altered(&drawn.rig, &drawn.conditions[0], &Start::seeded(1), alter).unwrap();
            recording.channel("ay").unwrap().samples.clone()
        };
        let without = simulate(&drawn.rig, &drawn.conditions[0], &Start::seeded(1)).unwrap();
        let alter = outside::draw(kind, &drawn, &[without], &mut rng);
        let plain = run(&|_| ());
        let [first, second] = [0, 1].map(|n| run(&|assembly| alter(n, assembly)));
        let added = |with: &[f64]| with.iter().zip(&plain).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (first, second) = (added(&first), added(&second));
        let alike = product(&first, &second) / (product(&first, &first) * product(&second, &second)).sqrt();
        assert!(alike < 0.99, "{}: {alike}", kind.name());
    }
}

#[test]
fn what_is_written_holds_nothing_of_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let hidden = Hidden::Effects(vec![(EffectKind::SensorGain, Severity::Severe)]);
    let case =
        Case::draw(&CaseSpec { tachometer: false, guessed: true, ..spec(hidden) }, Simulator::Shared, 0.2, 4).unwrap();
    case.write(folder.path()).unwrap();
    let mut names: Vec<String> =
        std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["baseline", "r01.csv", "r02.csv", "r03.csv", "r04.csv", "recordings.toml", "rig.toml"]);
    let rig = std::fs::read_to_string(folder.path().join("rig.toml")).unwrap();
    assert!(rig.contains("unknown") && !rig.contains("effect"), "{rig}");
    assert!(std::fs::read_to_string(folder.path().join("r01.csv")).unwrap().starts_with("ax,ay\n"));
}

#[test]
fn a_round_has_every_effect_at_every_severity_and_pairs_of_two_groups() {
    let specs = round(0, Simulator::Shared);
    let of = |kind: Kind| specs.iter().filter(|b| b.kind() == kind).count();
    assert_eq!(of(Kind::Single), 3 * EffectKind::vocabulary().count());
    assert_eq!((of(Kind::Control), of(Kind::Pair), of(Kind::Outside)), (20, 10, 16));
    for spec in specs.iter().filter(|b| b.kind() == Kind::Pair) {
        let Hidden::Effects(names) = &spec.hidden else { unreachable!() };
        let group = |kind: EffectKind| effects::GROUPS.iter().position(|g| g.contains(&kind));
        assert_ne!(group(names[0].0), group(names[1].0));
    }
    assert_ne!(specs, round(1, Simulator::Shared));
}
