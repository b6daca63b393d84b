//! A mass that differs from nominal: `value` is what it is. Its weight changes too where the rig has weight (Genta,
//! "Vibration of Structures and Machines", 1999).

use super::{
    Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::{Choices, Component},
};
use crate::rig::{config::Domain, config::Machine};

pub(super) const EFFECT: Definition = Definition {
    name: "mass-change",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::component(Choices::Sections),
        Parameter::number(ParameterKey::Value, "kg", Domain::Positive, (1e-3, 1e4), Scale::Log),
    ],
    library: LibraryTerms::LINEAR,
    equation: |v| {
        let value = v.number(ParameterKey::Value);
        format!("m = {value:.4e} kg of {}", v.component().name())
    },
    apply: |v, assembly| {
        let value = v.number(ParameterKey::Value);
        match (&mut assembly.machine, v.component()) {
            (Machine::Bearing(rig), Component::Inner) => rig.inner.mass_kg = value,
            (Machine::Bearing(rig), Component::Outer) => rig.outer.mass_kg = value,
            (Machine::Bearing(rig), Component::Resonator) => rig.resonator.mass_kg = value,
            (Machine::Sdof(rig), _) => rig.mass_kg = value,
            _ => {}
        }
    },
};
