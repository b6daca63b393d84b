//! A steady force that the rig leaves out: an offset, weight, the pull of a belt, an error of the load. Along the load on the inner
//! race, or along +q; on one direction of a race it may be turned towards the other one.

use std::f64::consts::PI;

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing, Values,
    component::{Choices, Component},
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
        Parameter::number(ParameterKey::AngleRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
    ],
    library: LibraryTerms::CONSTANT,
    equation: |v| {
        let parts =
            parts(v).map(|(component, force)| format!("m q̈ + … = … + {force:.4} N, q = {}", component.symbols()));
        parts.collect::<Vec<_>>().join(", ")
    },
    apply: |v, assembly| {
        for (component, force) in parts(v).filter(|(_, force)| *force != 0.0) {
            component.part_of(&assembly.machine).law(assembly, move |_, _| force);
        }
    },
};

/// Components that the force acts on, each with its part of it, N. What moves one way only, or is named for both directions, has no
/// other one to turn to.
fn parts(v: &Values) -> impl Iterator<Item = (Component, f64)> {
    let (size, component) = (v.number(ParameterKey::ForceN), v.component());
    let across = component.across();
    let (sin, cos) = across.map_or((0.0, 1.0), |_| v.number(ParameterKey::AngleRad).sin_cos());
    let turned = across.map(|across| (across, size * sin)).filter(|(_, force)| *force != 0.0);
    std::iter::once((component, size * cos)).chain(turned)
}
