//! A stiffness that differs from nominal: `value` is what it is. For component `bearing` it is that of the contact, k_b
//! (Genta, "Vibration of Structures and Machines", 1999). A loose foot or a cracked pedestal gives way in one direction: `inner-x` to
//! `outer-y`.

use super::{
    Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::{Choices, Component},
};
use crate::rig::{config::Domain, config::Machine};

pub(super) const EFFECT: Definition = Definition {
    name: "stiffness-change",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::component(Choices::SupportedAndContact),
        Parameter::number(ParameterKey::Value, "N/m", Domain::NotNegative, (1e3, 1e10), Scale::Log),
    ],
    library: LibraryTerms::LINEAR,
    equation: |v| {
        let value = v.number(ParameterKey::Value);
        match v.component() {
            Component::Bearing => format!("f = {value:.4e} N/m^p · δ_j^p"),
            component => format!("k = {value:.4e} N/m of {}", component.name()),
        }
    },
    apply: |v, assembly| {
        let value = v.number(ParameterKey::Value);
        match (&mut assembly.machine, v.component()) {
            (Machine::Bearing(rig), Component::Bearing) => rig.bearing.contact_stiffness_n_per_m1_5 = value,
            (Machine::Bearing(rig), Component::Inner) => rig.inner.stiffness_n_per_m = value,
            (Machine::Bearing(rig), Component::Outer) => rig.outer.stiffness_n_per_m = value,
            (Machine::Bearing(rig), Component::Resonator) => rig.resonator.stiffness_n_per_m = value,
            (Machine::Sdof(rig), _) => rig.stiffness_n_per_m = value,
            (machine, one_direction) => {
                let part = one_direction.part_of(machine);
                let more = value - part.stiffness;
                assembly.declare_rate((value / part.mass).sqrt());
                part.law(assembly, move |q, _| -more * q);
            }
        }
    },
};
