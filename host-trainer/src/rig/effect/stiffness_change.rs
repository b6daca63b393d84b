//! A stiffness that differs from nominal: `value` is what it is. For component `bearing` it is that of the contact, k_b
//! (Genta, "Vibration of Structures and Machines", 1999).

use super::{
    Applies, Definition, Parameter, Scale,
    component::{Choices, Component},
};
use crate::rig::{config::Domain, config::Machine};

pub(super) const EFFECT: Definition = Definition {
    name: "stiffness-change",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::component(Choices::SectionsAndContact),
        Parameter::number("value", "N/m", Domain::NotNegative, (1e3, 1e10), Scale::Log),
    ],
    equation: |v| {
        let value = v.number("value");
        match v.component() {
            Component::Bearing => format!("f = {value:.4e} N/m^p · δ_j^p"),
            component => format!("k = {value:.4e} N/m of {}", component.name()),
        }
    },
    apply: |v, plan| {
        let value = v.number("value");
        match (&mut plan.machine, v.component()) {
            (Machine::Bearing(rig), Component::Bearing) => rig.bearing.contact_stiffness_n_per_m1_5 = value,
            (Machine::Bearing(rig), Component::Inner) => rig.inner.stiffness_n_per_m = value,
            (Machine::Bearing(rig), Component::Outer) => rig.outer.stiffness_n_per_m = value,
            (Machine::Bearing(rig), Component::Resonator) => rig.resonator.stiffness_n_per_m = value,
            (Machine::Sdof(rig), _) => rig.stiffness_n_per_m = value,
            _ => {}
        }
    },
};
