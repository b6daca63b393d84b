//! A damping that differs from nominal, in both directions or one: `value` is what it is (Genta, "Vibration of Structures and
//! Machines", 1999).

use super::{
    Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::{Choices, Component},
};
use crate::rig::{config::Domain, config::Machine};

pub(super) const EFFECT: Definition = Definition {
    name: "damping-change",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::component(Choices::Supported),
        Parameter::number(ParameterKey::Value, "N s/m", Domain::NotNegative, (1e-1, 1e6), Scale::Log),
    ],
    library: LibraryTerms::LINEAR,
    equation: |v| {
        let value = v.number(ParameterKey::Value);
        format!("c = {value:.4e} N s/m of {}", v.component().name())
    },
    apply: |v, assembly| {
        let value = v.number(ParameterKey::Value);
        match (&mut assembly.machine, v.component()) {
            (Machine::Bearing(rig), Component::Inner) => rig.inner.damping_n_s_per_m = value,
            (Machine::Bearing(rig), Component::Outer) => rig.outer.damping_n_s_per_m = value,
            (Machine::Bearing(rig), Component::Resonator) => rig.resonator.damping_n_s_per_m = value,
            (Machine::Sdof(rig), _) => rig.damping_n_s_per_m = value,
            (machine, one_direction) => {
                let part = one_direction.part_of(machine);
                let more = value - part.damping;
                assembly.declare_rate(2.0 * value / part.mass);
                part.law(assembly, move |_, v| -more * v);
            }
        }
    },
};
