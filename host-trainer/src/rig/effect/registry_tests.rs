use super::{DefaultValue, Scale, ValueKind, Values};
use crate::rig::config::ModelKey;
use crate::rig::config::RigKind;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{
    EffectEntry, Rig, Start, Value, simulate,
    test_support::{SDOF, condition, nominal, parse},
};

/// Each parameter in the middle of where a search would look, the first of its names.
fn middle(effect: EffectKind, kind: RigKind) -> EffectEntry {
    let mut entry = EffectEntry::new(effect, &[]);
    for parameter in effect.definition().parameters {
        let (low, high) = parameter.search_range;
        let value = match (parameter.value_kind, parameter.scale) {
            (ValueKind::Name(choices), _) => Value::Text(choices.names(kind)[0].into()),
            (_, Scale::Linear) => Value::Number(low + 0.6 * (high - low)),
            (_, Scale::Log) => Value::Number(low.signum() * (low * high).sqrt()),
            (_, Scale::Each) => Value::Number((0.5 * (low + high)).round()),
        };
        if !matches!(parameter.default_for(kind), Some(DefaultValue::Number(_))) {
            entry.parameters.insert(parameter.key, value);
        }
    }
    // Where springs that can let go are plain, not where the mass falls out of them.
    let (cubic, quadratic) = if kind == RigKind::Sdof { (-10.0, 10.0) } else { (-1e13, 1e9) };
    for (key, value, curved) in [
        (ParameterKey::CubicNPerM3, cubic, EffectKind::SofteningStiffness),
        (ParameterKey::QuadraticNPerM2, quadratic, EffectKind::AsymmetricStiffness),
    ] {
        if effect == curved {
            entry.set_number(key, value);
        }
    }
    entry
}

fn all_for(rig: RigKind) -> impl Iterator<Item = EffectKind> {
    EffectKind::ALL.iter().copied().filter(move |kind| kind.definition().rigs.include(rig))
}

#[test]
fn invariant_plausible_effects_run_and_state_their_term() {
    for kind in all_for(RigKind::Bearing5Dof) {
        let entry = middle(kind, RigKind::Bearing5Dof);
        let text = Values::new(&entry, RigKind::Bearing5Dof).unwrap().equation();
        assert!(text.contains(|c: char| c.is_ascii_digit()) && !text.contains("NaN"), "{text}");
        let rig = nominal().with_effect(entry);
        let start = Start { settle_s: 0.01, ..Start::seeded(1) };
        let recording = simulate(&rig, &condition(30.0, 500.0, 200), &start).unwrap();
        assert!(recording.channels.iter().all(|c| c.samples.len() == 200), "{kind}");
    }
}

#[test]
fn invariant_sdof_effects_run_and_state_their_term() {
    for kind in all_for(RigKind::Sdof) {
        let entry = middle(kind, RigKind::Sdof);
        let text = Values::new(&entry, RigKind::Sdof).unwrap().equation();
        assert!(text.contains(|c: char| c.is_ascii_digit()) && !text.contains("NaN"), "{text}");
        let input: Vec<f64> = (0..400).map(|k| (k as f64 * 0.05).sin()).collect();
        let drive = crate::rig::sdof::Drive { input: &input, sample_rate_hz: 1000.0, ..Default::default() };
        crate::rig::sdof::simulate(&parse(SDOF).with_effect(entry), &drive).unwrap();
    }
}

fn run(rig: &Rig) -> crate::recording::Recording {
    simulate(rig, &condition(30.0, 500.0, 400), &Start { settle_s: 0.02, ..Start::seeded(5) }).unwrap()
}

/// Parameter and value at which an effect changes nothing.
fn nothing(kind: EffectKind, nominal: &Rig) -> (ParameterKey, f64) {
    // Effects that state a value: the nominal one.
    let of = |key: ModelKey| nominal.get(key).unwrap();
    match kind {
        EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect => {
            (ParameterKey::DepthM, 0.0)
        }
        EffectKind::OuterRaceWaviness | EffectKind::InnerRaceWaviness => (ParameterKey::AmplitudeM, 0.0),
        EffectKind::Unbalance => (ParameterKey::UnbalanceKgM, of(ModelKey::Unbalance)),
        EffectKind::Misalignment | EffectKind::CoulombFriction | EffectKind::ConstantForce => {
            (ParameterKey::ForceN, 0.0)
        }
        EffectKind::RandomForce => (ParameterKey::PsdN2PerHz, 0.0),
        EffectKind::ExcessClearance => (ParameterKey::RadialClearanceM, of(ModelKey::RadialClearance)),
        EffectKind::HardeningStiffness | EffectKind::SofteningStiffness => (ParameterKey::CubicNPerM3, 0.0),
        EffectKind::AsymmetricStiffness => (ParameterKey::QuadraticNPerM2, 0.0),
        EffectKind::StiffnessChange => (ParameterKey::Value, of(ModelKey::OuterStiffness)),
        EffectKind::DampingChange => (ParameterKey::Value, of(ModelKey::OuterDamping)),
        EffectKind::MassChange => (ParameterKey::Value, of(ModelKey::OuterMass)),
        EffectKind::ViscousFriction => (ParameterKey::DampingNSPerM, 0.0),
        EffectKind::QuadraticDrag => (ParameterKey::DragNS2PerM2, 0.0),
        EffectKind::EndStopContact => (ParameterKey::StiffnessNPerM, 0.0),
        EffectKind::Backlash => (ParameterKey::WidthM, 0.0),
        EffectKind::StructuralResonance => (ParameterKey::Gain, 0.0),
        EffectKind::LoadStep => (ParameterKey::ChangeN, 0.0),
        EffectKind::SpeedDrift => (ParameterKey::RatePerS, 0.0),
        EffectKind::Shock => (ParameterKey::ImpulseNS, 0.0),
        EffectKind::CageSlip => (ParameterKey::Fraction, 0.0),
        EffectKind::LubricantFilm => (ParameterKey::ViscosityPaS, 0.0),
        EffectKind::ContactExponent => (ParameterKey::Exponent, of(ModelKey::ContactExponent)),
        EffectKind::MainsInterference => (ParameterKey::Amplitude, 0.0),
        EffectKind::SensorBias => (ParameterKey::Value, 0.0),
        EffectKind::SensorGain => (ParameterKey::Value, 1.0),
        EffectKind::TransverseSensitivity => (ParameterKey::Value, 0.0),
        EffectKind::SensorClipping => (ParameterKey::Value, 1e4),
        EffectKind::DroppedSamples => (ParameterKey::Count, 0.0),
    }
}

#[test]
fn null_zero_strength_is_no_effect_to_the_bit() {
    let nominal = nominal();
    let expected = run(&nominal);
    for kind in EffectKind::ALL {
        let (key, value) = nothing(*kind, &nominal);
        let mut entry = middle(*kind, RigKind::Bearing5Dof);
        entry.set_number(key, value);
        assert_eq!(run(&nominal.clone().with_effect(entry)), expected, "{kind}");
    }
}

#[test]
fn a_negative_term_is_subtracted() {
    let bias = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, -18.791)]);
    let equation = Values::new(&bias, RigKind::Sdof).unwrap().equation();
    assert!(equation.contains("… − 1.8791e1"), "{equation}");
}
