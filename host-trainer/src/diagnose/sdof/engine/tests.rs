use super::*;
use crate::identify::force_balance::testing;
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

/// 0.05 kg m² at 1 Hz, hanging.
fn pendulum() -> String {
    testing::LINEAR
        .replace("linear", "pendulum")
        .replace("800.0", "2.0")
        .replace("= 4.0", "= 0.2")
        .replace("2.0\n", "0.05\n")
}

fn names(finding: &Finding) -> Vec<EffectKind> {
    finding.causes.iter().map(|c| c.entry.kind).collect()
}

fn diagnosed(nominal: &Rig, effects: &[EffectEntry], seed: u64) -> Finding {
    let truth = effects.iter().fold(nominal.clone(), |rig, effect| rig.with_effect(effect.clone()));
    let recordings = testing::recordings(&truth, "q", 1.0, 0.01, 3000, seed);
    diagnose_sdof(nominal, None, &recordings, 1).unwrap()
}

/// At most one false alarm in twenty healthy cases, with parameters known or only guessed.
#[test]
fn null_healthy_machines_are_quiet() {
    let guess = "unknown = [\"stiffness_n_per_m\", \"damping_n_s_per_m\"]\n";
    let alarms = (0..20).filter(|seed| {
        let text = if seed % 2 == 0 { testing::LINEAR.to_owned() } else { testing::LINEAR.to_owned() + guess };
        let finding = diagnosed(&testing::rig(&text), &[], 500 + seed);
        finding.verdict != Verdict::NoMismatch
    });
    let alarms = alarms.count();
    assert!(alarms <= 1, "{alarms}");
}

/// Each effect alone, strong enough to matter, is named with its parameter within 10 %.
#[test]
fn invariant_single_effects_are_named_and_measured() {
    let effects = [
        (EffectKind::CoulombFriction, ParameterKey::ForceN, 0.5, None),
        (EffectKind::QuadraticDrag, ParameterKey::DragNS2PerM2, 60.0, None),
        (EffectKind::HardeningStiffness, ParameterKey::CubicNPerM3, 4e6, None),
        (EffectKind::AsymmetricStiffness, ParameterKey::QuadraticNPerM2, 8e3, None),
        (EffectKind::StiffnessChange, ParameterKey::Value, 900.0, None),
        (EffectKind::DampingChange, ParameterKey::Value, 7.0, None),
        (EffectKind::MassChange, ParameterKey::Value, 2.3, None),
        (EffectKind::EndStopContact, ParameterKey::StiffnessNPerM, 3000.0, Some((ParameterKey::GapM, 0.006))),
        (EffectKind::Backlash, ParameterKey::WidthM, 0.003, None),
        (EffectKind::SensorGain, ParameterKey::Value, 1.2, None),
    ];
    let nominal = testing::rig(testing::LINEAR);
    for (seed, (name, key, value, inner)) in effects.into_iter().enumerate() {
        let mut numbers = vec![(key, value)];
        numbers.extend(inner);
        let finding = diagnosed(&nominal, &[EffectEntry::new(name, &numbers)], seed as u64);
        assert_eq!(names(&finding), [name], "{finding:#?}");
        let cause = &finding.causes[0];
        let found = cause.parameters.iter().find(|p| p.name == key.name()).unwrap();
        assert!((found.value / value - 1.0).abs() < 0.1, "{name}: {found:?}");
        assert!(finding.fit.after < finding.fit.before && !cause.equation.is_empty());
        assert_eq!(finding.rig.effects.len(), 1);
    }
}

#[test]
fn invariant_two_effects_at_once() {
    let nominal = testing::rig(testing::LINEAR);
    let friction = EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 0.5)]);
    let spring = EffectEntry::new(EffectKind::HardeningStiffness, &[(ParameterKey::CubicNPerM3, 4e6)]);
    let finding = diagnosed(&nominal, &[friction, spring], 40);
    assert_eq!(names(&finding), [EffectKind::CoulombFriction, EffectKind::HardeningStiffness]);
}

/// Damping that the file has none of is viscous friction, whether or not the file calls it unknown.
#[test]
fn invariant_viscous_friction_is_named() {
    let none = testing::LINEAR.replace("damping_n_s_per_m = 4.0", "damping_n_s_per_m = 0.0");
    for unknown in ["", "unknown = [\"damping_n_s_per_m\"]\n", "unknown = [\"mass_kg\", \"damping_n_s_per_m\"]\n"] {
        let friction = EffectEntry::new(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, 4.0)]);
        let finding = diagnosed(&testing::rig(&(none.clone() + unknown)), &[friction], 50);
        assert_eq!(names(&finding), [EffectKind::ViscousFriction]);
        assert!((finding.causes[0].parameters[0].value / 4.0 - 1.0).abs() < 0.05, "{:?}", finding.causes);
    }
}

/// With healthy recordings a stiffness that is only guessed can still be seen to have changed.
#[test]
fn invariant_a_baseline_tells_a_change_of_what_is_unknown() {
    let nominal = testing::rig(testing::LINEAR);
    let guessed = testing::rig(&(testing::LINEAR.to_owned() + "unknown = [\"stiffness_n_per_m\"]\n"));
    let baseline = testing::recordings(&nominal, "q", 1.0, 0.01, 3000, 60);
    let changed = nominal.with_effect(EffectEntry::new(EffectKind::StiffnessChange, &[(ParameterKey::Value, 880.0)]));
    let recordings = testing::recordings(&changed, "q", 1.0, 0.01, 3000, 61);
    let finding = diagnose_sdof(&guessed, Some(&baseline), &recordings, 1).unwrap();
    assert_eq!(names(&finding), [EffectKind::StiffnessChange]);
    let quiet = diagnose_sdof(&guessed, Some(&baseline[..2]), &baseline[2..], 1).unwrap();
    assert_eq!(quiet.verdict, Verdict::NoMismatch);
}

/// A spring that stiffens and softens with time is outside the vocabulary.
#[test]
fn null_an_effect_without_a_name_is_unexplained() {
    let recordings: Vec<Recording> = (0..4).map(swinging).collect();
    let finding = diagnose_sdof(&testing::rig(testing::LINEAR), None, &recordings, 1).unwrap();
    assert_eq!((finding.verdict, finding.causes.len()), (Verdict::Unexplained, 0));
}

fn swinging(seed: u64) -> Recording {
    const PARTS: usize = 20;
    let input = testing::multisine(700 + seed, 1.0, 3000);
    let (mut q, mut v, mut out) = (0.0, 0.0, Vec::new());
    let h = 1.0 / (testing::RATE * PARTS as f64);
    for (k, u) in input.iter().enumerate() {
        out.push(q);
        for part in 0..PARTS {
            let t = k as f64 / testing::RATE + part as f64 * h;
            let stiffness = 800.0 * (1.0 + 0.25 * (1.7 * t).sin());
            // Leapfrog: the speed belongs to half a step later.
            v += h * (3.0 * u - 4.0 * v - stiffness * q) / 2.0;
            q += h * v;
        }
    }
    let noise = testing::white(900 + seed, 1e-5, out.len());
    let noisy = out.iter().zip(noise).map(|(x, e)| x + e).collect();
    testing::recording(&format!("r{seed}"), input, "q", noisy)
}

#[test]
fn null_a_healthy_pendulum_is_quiet_and_its_drag_is_found() {
    let nominal = testing::rig(&pendulum());
    assert_eq!(diagnosed(&nominal, &[], 80).verdict, Verdict::NoMismatch);
    let drag = EffectEntry::new(EffectKind::QuadraticDrag, &[(ParameterKey::DragNS2PerM2, 0.1)]);
    assert_eq!(names(&diagnosed(&nominal, &[drag], 81)), [EffectKind::QuadraticDrag]);
}

/// Same recordings, same seed: the same bits, whatever the number of threads.
#[test]
fn invariant_same_seed_same_finding() {
    let nominal = testing::rig(testing::LINEAR);
    let friction = EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 0.5)]);
    let [a, b] =
        [(); 2].map(|()| serde_json::to_string(&diagnosed(&nominal, std::slice::from_ref(&friction), 90)).unwrap());
    assert_eq!(a, b);
}

/// Janot, Gautier, Brunot, "Data set and reference models of EMPS" (2019): a rig without friction must find it, to within
/// 10 % of the published values, from either file's recording.
#[test]
fn literature_emps_friction_is_found() {
    let Some(recordings) = testing::emps() else { return };
    let text = "kind = \"sdof\"\nmass_kg = 80.0\ndamping_n_s_per_m = 0.0\nstiffness_n_per_m = 0.0\n\
                input_gain_n_per_unit = 35.15\nrestoring = \"linear\"\ngravity_n = 0.0\n\
                unknown = [\"mass_kg\", \"damping_n_s_per_m\"]\n";
    for recording in recordings {
        let finding = diagnose_sdof(&testing::rig(text), None, &[recording], 1).unwrap();
        let number =
            |kind: EffectKind| finding.causes.iter().find(|c| c.entry.kind == kind).map(|c| c.parameters[0].value);
        let near = |value: Option<f64>, published: f64| value.is_some_and(|v| (v / published - 1.0).abs() < 0.1);
        assert!(near(number(EffectKind::CoulombFriction), 20.39), "{:?}", finding.causes);
        assert!(near(number(EffectKind::ViscousFriction), 203.5), "{:?}", finding.causes);
        assert!(near(Some(finding.own[0].value), 95.11), "{:?}", finding.own);
    }
}
