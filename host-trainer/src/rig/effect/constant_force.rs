//! A steady force that the rig leaves out: an offset, weight, an error of the load. Along the load on the inner race, or
//! along +q.

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "constant-force",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::ForceN, "N", Domain::Any, (-1e4, 1e4), Scale::Linear),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("inner-y")),
    ],
    library: LibraryTerms::CONSTANT,
    equation: |v| format!("m q̈ + … = … + {:.4} N, q = {}", v.number(ParameterKey::ForceN), v.component().symbols()),
    apply: |v, assembly| {
        let size = v.number(ParameterKey::ForceN);
        if size != 0.0 {
            v.component().part_of(&assembly.machine).law(assembly, move |_, _| size);
        }
    },
};
