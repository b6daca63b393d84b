//! `docs/vocabulary.md` is what the registry of effects says. `BALLRACE_BLESS=1` writes it anew.

use std::fmt::Write;
use std::path::Path;

use ballrace::rig::config::{Domain, RigKind};
use ballrace::rig::effect::{Adds, DefaultValue, EffectKind, Parameter, ParameterKey, Rigs, Scale, ValueKind};
use ballrace::rig::{EffectEntry, Value};

const HEAD: &str = "\
# Vocabulary of causes

Made from the registry of effects (`host-trainer/src/rig/effect`); a test holds it. [theory](theory.md), section 9, has the
equations, [CONTRIBUTING](../CONTRIBUTING.md) says how to add an effect.

A parameter marked * belongs to the vocabulary: a diagnosis states it, and `[[effect]]` must give it. The others have the
default shown. *Searched* is the range that a search covers. `unexplained` is a verdict, not an effect.
";

/// Middle of the range that a search covers.
fn example(kind: EffectKind, rig: RigKind) -> EffectEntry {
    let mut entry = EffectEntry::new(kind, &[]);
    for parameter in kind.definition().parameters {
        let (low, high) = parameter.search_range;
        let value = match (parameter.value_kind, parameter.scale) {
            (ValueKind::Name(choices), _) => Value::Text(choices.names(rig)[0].into()),
            (ValueKind::Number(Domain::Whole(..)), _) => Value::Number((low * high).abs().sqrt().round()),
            (_, Scale::Log) => Value::Number(low.signum() * (low * high).sqrt()),
            (_, Scale::Linear | Scale::Each) => Value::Number(low + 0.6 * (high - low)),
        };
        entry.parameters.insert(parameter.key, value);
    }
    entry
}

fn row(parameter: &Parameter, rig: RigKind) -> String {
    let mark = if parameter.in_vocabulary() { "*" } else { "" };
    let (low, high) = parameter.search_range;
    let (values, searched) = match parameter.value_kind {
        ValueKind::Number(domain) => (
            domain.describe(),
            format!("{low:?} to {high:?}{}", if parameter.scale == Scale::Log { ", log" } else { "" }),
        ),
        ValueKind::Name(choices) => (choices.names(rig).join(", "), "each".into()),
    };
    let default = match parameter.default_for(rig) {
        Some(DefaultValue::Number(number)) => format!("{number:?}"),
        Some(DefaultValue::Name(name)) => name.into(),
        None => "–".into(),
    };
    format!("| `{}`{mark} | {} | {values} | {searched} | {default} |\n", parameter.key, parameter.unit)
}

fn section(kind: EffectKind) -> String {
    let definition = kind.definition();
    let rig = RigKind::Bearing5Dof;
    let rigs = match definition.rigs {
        Rigs::Bearing => "bearing-5dof",
        Rigs::Both => "bearing-5dof, sdof",
    };
    let adds = match definition.library.adds {
        Adds::Degree(degree) => format!("monomials up to degree {degree}"),
        Adds::Powers => "powers of two thirds".into(),
        Adds::Mode => "states of one more mode".into(),
        Adds::Nothing => "nothing".into(),
    };
    let mut out = format!("\n## {kind}\n\n");
    let (site, timing, phase) = (definition.site, definition.timing, definition.phase);
    if !kind.in_vocabulary() {
        out += "Of a rig only: no diagnosis names it.\n\n";
    }
    writeln!(out, "Rigs {rigs}. Site {site:?}, timing {timing:?}, phase {phase:?}.\n").unwrap();
    writeln!(out, "For example: {}\n", example(kind, rig).equation(rig)).unwrap();
    out += "| parameter | unit | values | searched | default |\n|---|---|---|---|---|\n";
    out.extend(definition.parameters.iter().map(|parameter| row(parameter, rig)));
    writeln!(out, "\nLibrary of a fit: {adds} ({}).", definition.library.why).unwrap();
    out
}

#[test]
fn golden_the_page_is_what_the_registry_says() {
    let page: String = std::iter::once(HEAD.to_owned()).chain(EffectKind::ALL.iter().map(|k| section(*k))).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/vocabulary.md");
    if std::env::var_os("BALLRACE_BLESS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap() == page, "BALLRACE_BLESS=1 writes docs/vocabulary.md anew");
}

/// Names and parameters that the outside relies on, `unexplained` apart.
#[test]
fn golden_names_and_parameters_are_the_published_ones() {
    let lines = EffectKind::vocabulary().map(|kind| {
        let stated = kind.definition().parameters.iter().filter(|p| p.in_vocabulary());
        let names: Vec<_> = stated.map(|p| p.key.name()).collect();
        format!("{kind}: {}", names.join(", "))
    });
    let mut lines: Vec<String> = lines.collect();
    lines.sort();
    let mut published: Vec<&str> = VOCABULARY.lines().collect();
    published.sort_unstable();
    assert_eq!(lines, published);
    assert!(ParameterKey::ALL.iter().all(|key| ParameterKey::parse(key.name()) == Some(*key)));
}

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
