use super::{DefaultValue, Definition, REGISTRY, Scale, ValueKind, Values};
use crate::rig::{
    EffectEntry, Rig, Start, Value, simulate,
    test_support::{SDOF, condition, nominal, parse},
};

/// The vocabulary of causes with its parameters, `unexplained` apart, which is no effect.
const VOCABULARY: &str = "\
outer-race-defect: depth_m, width_rad, angle_rad
inner-race-defect: depth_m, width_rad
ball-defect: depth_m, width_rad
outer-race-waviness: amplitude_m, lobes
inner-race-waviness: amplitude_m, lobes
unbalance: unbalance_kg_m
misalignment: force_n
excess-clearance: radial_clearance_m
hardening-stiffness: cubic_n_per_m3, component
softening-stiffness: cubic_n_per_m3, component
asymmetric-stiffness: quadratic_n_per_m2, component
stiffness-change: component, value
damping-change: component, value
mass-change: component, value
coulomb-friction: force_n, component
viscous-friction: damping_n_s_per_m
quadratic-drag: drag_n_s2_per_m2
end-stop-contact: gap_m, stiffness_n_per_m
backlash: width_m
constant-force: force_n
structural-resonance: frequency_hz, damping_ratio
load-step: time_s, change_n
speed-drift: rate_per_s
shock: time_s
cage-slip: fraction
contact-exponent: exponent
mains-interference: frequency_hz, amplitude
sensor-bias: value
sensor-gain: value
sensor-clipping: value
dropped-samples: time_s, count
";

#[test]
fn golden_registry_is_the_vocabulary() {
    let lines = REGISTRY.iter().map(|d| {
        let names: Vec<_> = d.parameters.iter().filter(|p| p.in_vocabulary()).map(|p| p.name).collect();
        format!("{}: {}\n", d.name, names.join(", "))
    });
    let mut got: Vec<_> = lines.collect();
    let mut expected: Vec<_> = VOCABULARY.lines().map(|line| format!("{line}\n")).collect();
    got.sort();
    expected.sort();
    assert_eq!(got.concat(), expected.concat());
}

/// Within twice the range that a search looks in, or beyond it; of what has a dimension any size.
#[test]
fn numbers_without_a_dimension_are_implausible_far_from_where_a_search_looks() {
    let with = |name: &str, key: &str, value: f64| EffectEntry::new(name, &[(key, value)]).is_plausible();
    for (name, key, good, bad) in [
        ("ball-defect", "width_rad", 0.35, 0.5),
        ("structural-resonance", "gain", -45.0, -106.0),
        ("structural-resonance", "damping_ratio", 0.45, 0.99),
        ("cage-slip", "fraction", -0.4, 0.8),
        ("sensor-gain", "value", 0.06, 24.0),
    ] {
        assert!(with(name, key, good) && !with(name, key, bad), "{name} {key}");
    }
    assert!(with("constant-force", "force_n", 1e6) && with("ball-defect", "spin_rad", 40.0));
}

/// Each parameter in the middle of where a search would look, the first of its names.
fn middle(definition: &Definition, kind: &str) -> EffectEntry {
    let mut entry = EffectEntry::new(definition.name, &[]);
    for parameter in definition.parameters {
        let (low, high) = parameter.search_range;
        let value = match (parameter.value_kind, parameter.scale) {
            (ValueKind::Name(choices), _) => Value::Text(choices.names(kind)[0].into()),
            (_, Scale::Linear) => Value::Number(low + 0.6 * (high - low)),
            (_, Scale::Log) => Value::Number(low.signum() * (low * high).sqrt()),
            (_, Scale::Each) => Value::Number((0.5 * (low + high)).round()),
        };
        if !matches!(parameter.default_for(kind), Some(DefaultValue::Number(_))) {
            entry.parameters.insert(parameter.name.into(), value);
        }
    }
    // Where springs that can let go are plain, not where the mass falls out of them.
    let (cubic, quadratic) = if kind == "sdof" { (-10.0, 10.0) } else { (-1e13, 1e9) };
    for (key, value, name) in
        [("cubic_n_per_m3", cubic, "softening-stiffness"), ("quadratic_n_per_m2", quadratic, "asymmetric-stiffness")]
    {
        if definition.name == name {
            entry.set_number(key, value);
        }
    }
    entry
}

fn all_for(kind: &str) -> impl Iterator<Item = &'static Definition> {
    REGISTRY.iter().copied().filter(move |d| d.applies_to.has(kind))
}

#[test]
fn invariant_plausible_effects_run_and_state_their_term() {
    for definition in all_for("bearing-5dof") {
        let entry = middle(definition, "bearing-5dof");
        let text = (definition.equation)(&Values::new(&entry, "bearing-5dof").expect(definition.name));
        assert!(text.contains(|c: char| c.is_ascii_digit()) && !text.contains("NaN"), "{text}");
        let rig = nominal().with_effect(entry);
        let start = Start { settle_s: 0.01, ..Start::seeded(1) };
        let recording = simulate(&rig, &condition(30.0, 500.0, 200), &start).expect(definition.name);
        assert!(recording.channels.iter().all(|c| c.samples.len() == 200), "{}", definition.name);
    }
}

#[test]
fn invariant_sdof_effects_run_and_state_their_term() {
    for definition in all_for("sdof") {
        let entry = middle(definition, "sdof");
        let text = (definition.equation)(&Values::new(&entry, "sdof").expect(definition.name));
        assert!(text.contains(|c: char| c.is_ascii_digit()) && !text.contains("NaN"), "{text}");
        let input: Vec<f64> = (0..400).map(|k| (k as f64 * 0.05).sin()).collect();
        let drive = crate::rig::sdof::Drive { input: &input, sample_rate_hz: 1000.0, ..Default::default() };
        crate::rig::sdof::simulate(&parse(SDOF).with_effect(entry), &drive).expect(definition.name);
    }
}

fn run(rig: &Rig) -> crate::recording::Recording {
    simulate(rig, &condition(30.0, 500.0, 400), &Start { settle_s: 0.02, ..Start::seeded(5) }).unwrap()
}

#[test]
fn null_zero_strength_is_no_effect_to_the_bit() {
    let nominal = nominal();
    let expected = run(&nominal);
    let zero = |name: &str, key: &str, value: f64| {
        let definition = super::definition(name).unwrap();
        let mut entry = middle(definition, "bearing-5dof");
        entry.set_number(key, value);
        assert_eq!(run(&nominal.clone().with_effect(entry)), expected, "{name}");
    };
    for (name, key) in [
        ("outer-race-defect", "depth_m"),
        ("inner-race-defect", "depth_m"),
        ("ball-defect", "depth_m"),
        ("outer-race-waviness", "amplitude_m"),
        ("inner-race-waviness", "amplitude_m"),
        ("misalignment", "force_n"),
        ("hardening-stiffness", "cubic_n_per_m3"),
        ("softening-stiffness", "cubic_n_per_m3"),
        ("asymmetric-stiffness", "quadratic_n_per_m2"),
        ("coulomb-friction", "force_n"),
        ("viscous-friction", "damping_n_s_per_m"),
        ("quadratic-drag", "drag_n_s2_per_m2"),
        ("end-stop-contact", "stiffness_n_per_m"),
        ("backlash", "width_m"),
        ("constant-force", "force_n"),
        ("structural-resonance", "gain"),
        ("load-step", "change_n"),
        ("speed-drift", "rate_per_s"),
        ("shock", "impulse_n_s"),
        ("cage-slip", "fraction"),
        ("mains-interference", "amplitude"),
        ("sensor-bias", "value"),
        ("dropped-samples", "count"),
    ] {
        zero(name, key, 0.0);
    }
    // Those that state a value: at the nominal one.
    for (name, key, of) in [
        ("unbalance", "unbalance_kg_m", "excitation.unbalance_kg_m"),
        ("excess-clearance", "radial_clearance_m", "bearing.radial_clearance_m"),
        ("stiffness-change", "value", "outer.stiffness_n_per_m"),
        ("damping-change", "value", "outer.damping_n_s_per_m"),
        ("mass-change", "value", "outer.mass_kg"),
        ("contact-exponent", "exponent", "bearing.contact_exponent"),
    ] {
        zero(name, key, nominal.get(of).unwrap());
    }
    zero("sensor-gain", "value", 1.0);
    zero("sensor-clipping", "value", 1e4);
}
