use crate::rig::config::{ModelKey, RigKey};
use crate::rig::effect::{EffectKind, ParameterKey};
use std::path::Path;

use crate::rig::{
    EffectEntry, Rig,
    test_support::{RIG, SDOF, nominal, parse},
};

fn error(text: &str) -> String {
    Rig::parse(text, Path::new("rig.toml")).unwrap_err().to_string()
}

#[test]
fn golden_errors_name_file_key_found_and_expected() {
    let edit = |from: &str, to: &str| RIG.replace(from, to);
    for (text, expected) in [
        (edit("mass_kg = 1.2638", "mass_kg = -1.0"), "rig.toml, inner.mass_kg: found -1.0, expected a number above 0"),
        (edit("mass_kg = 1.2638\n", ""), "rig.toml, inner.mass_kg: found nothing, expected a number above 0"),
        (edit("balls = 9", "balls = 8.5"), "rig.toml, bearing.balls: found 8.5, expected a whole number from 1 to 200"),
        (
            edit("balls = 9", "balls = \"9\""),
            "rig.toml, bearing.balls: found \"9\", expected a whole number from 1 to 200",
        ),
        (
            edit("[inner]", "[inner]\nmass_g = 3"),
            "rig.toml, inner.mass_g: found an unknown key, expected one of mass_kg",
        ),
        (edit("[inner]", "[middle]"), "rig.toml, middle: found an unknown key, expected one of kind, unknown, effect"),
        (edit("= \"outer-x\"", "= \"roof\""), "rig.toml, sensor.horizontal: found \"roof\", expected one of inner-x"),
        (edit("noise_std_m_per_s2 = 0.02", "noise_std_m_per_s2 = nan"), "found nan, expected a number, not negative"),
        (
            format!("kind = \"gearbox\"\n{RIG}"),
            "rig.toml, kind: found \"gearbox\", expected \"bearing-5dof\" or \"sdof\"",
        ),
        (format!("unknown = [\"outer\", \"moon\"]\n{RIG}"), "rig.toml, unknown: found \"moon\", expected a list"),
        (
            edit("0.0385", "0.005"),
            "rig.toml, bearing.ball_diameter_m: found 0.00794, expected a number below pitch_diameter_m",
        ),
        (
            format!("{RIG}[[effect]]\nname = \"gremlins\"\n"),
            "rig.toml, effect[1].name: found \"gremlins\", expected one of outer",
        ),
        (
            format!("{RIG}[[effect]]\nname = \"unbalance\"\n"),
            "rig.toml, effect[1].unbalance_kg_m: found nothing, expected",
        ),
        (
            format!("{RIG}[[effect]]\nname = \"cage-slip\"\nfraction = 0.1\nslip = 2\n"),
            "rig.toml, effect[1].slip: found an unknown key, expected one of fraction",
        ),
        (
            format!("{RIG}[[effect]]\nname = \"coulomb-friction\"\nforce_n = 1.0\ncomponent = \"roof\"\n"),
            "rig.toml, effect[1].component: found \"roof\", expected one of outer, inner, resonator",
        ),
        (
            format!("{SDOF}[[effect]]\nname = \"cage-slip\"\nfraction = 0.1\n"),
            "rig.toml, effect[1].name: found \"cage-slip\", expected an effect that a rig of kind \"sdof\" can have",
        ),
        (edit("[outer]", "[outer"), "rig.toml, row 14: found unclosed table"),
    ] {
        let message = error(&text);
        assert!(message.contains(expected), "{message}\nlacks\n{expected}");
    }
}

#[test]
fn invariant_written_back_as_it_was_read() {
    for text in [RIG.to_owned(), format!("unknown = [\"outer\"] # a guess\n{RIG}"), SDOF.to_owned()] {
        assert_eq!(parse(&text).to_toml(), text);
    }
}

#[test]
fn invariant_changes_are_written_and_comments_kept() {
    let mut rig = nominal();
    rig.set(ModelKey::BallDiameter, 0.008).unwrap();
    rig.unknown = vec!["outer".into()];
    let friction = EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 0.76)])
        .with_text(ParameterKey::Component, "outer");
    rig = rig
        .with_effect(friction)
        .with_effect(EffectEntry::new(EffectKind::Unbalance, &[(ParameterKey::UnbalanceKgM, 1e-3)]));
    let text = rig.to_toml();
    assert!(text.contains("ball_diameter_m = 0.008  # from the catalogue"), "{text}");
    assert!(text.contains("# nominal rig"), "{text}");
    assert_eq!(parse(&text), rig);
    // And once more from what was written, with an effect less.
    let mut again = parse(&text);
    again.effects.remove(0);
    assert_eq!(parse(&again.to_toml()), again);
}

#[test]
fn invariant_a_rig_made_in_memory_reads_back() {
    for text in [RIG, SDOF] {
        let rig = Rig::new(parse(text).model);
        assert_eq!(parse(&rig.to_toml()), rig);
    }
}

#[test]
fn invariant_every_number_is_reached_by_its_name() {
    for text in [RIG, SDOF] {
        let mut rig = parse(text).with_effect(EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, 1.0)]));
        for key in rig.keys() {
            let value = if key == ModelKey::Balls.into() { 12.0 } else { 1.25 };
            rig.set(key, value).unwrap();
            assert_eq!(rig.get(key), Some(value), "{key}");
        }
        let other = if rig.bearing().is_some() { ModelKey::Mass } else { ModelKey::OuterMass };
        assert!(rig.set(other, 1.0).is_err() && rig.get(other).is_none());
        assert!(rig.set(RigKey::Effect { index: 1, key: ParameterKey::Value }, 1.0).is_err());
    }
    assert!(nominal().set(ModelKey::OuterMass, 0.0).is_err());
}

#[test]
fn golden_unknown_sections_are_spelled_out() {
    let rig = parse(&format!("unknown = [\"outer\", \"resonator.damping_n_s_per_m\", \"outer.mass_kg\"]\n{RIG}"));
    let expected = [ModelKey::OuterMass, ModelKey::OuterStiffness, ModelKey::OuterDamping, ModelKey::ResonatorDamping];
    assert_eq!(rig.unknown_keys(), expected);
}
