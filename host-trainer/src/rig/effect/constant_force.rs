//! A steady force that the rig leaves out: an offset, weight, an error of the load. Along the load on the inner race, or
//! along +q.

use super::{Applies, Definition, Parameter, Scale, ParameterDefault, component::Choices};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "constant-force",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::number("force_n", "N", Domain::Any, (-1e4, 1e4), Scale::Linear),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("inner-y")),
    ],
    equation: |v| format!("m q̈ + … = … + {:.4} N, q = {}", v.number("force_n"), v.component().symbols()),
    apply: |v, plan| {
        let size = v.number("force_n");
        if size != 0.0 {
            (v.component()).part_of(&plan.machine).law(plan, move |_, _| size);
        }
    },
};
