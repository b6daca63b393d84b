//! Damping that the nominal model lacks, −d v: of an oil film across the bearing (component `bearing`: between the
//! races; J. S. Rao, "Rotor Dynamics", 1996) or of one mass against the ground.

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::{Choices, Component, Motion},
};
use crate::rig::{
    config::Domain,
    state::{INNER_X, INNER_Y, OUTER_X, OUTER_Y},
};

pub(super) const EFFECT: Definition = Definition {
    name: "viscous-friction",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::DampingNSPerM, "N s/m", Domain::NotNegative, (1e-1, 1e6), Scale::Log),
        Parameter::component(Choices::SupportedAndContact).usually(ParameterDefault::Name("bearing")),
    ],
    library: LibraryTerms::LINEAR,
    equation: |v| {
        let damping = v.number(ParameterKey::DampingNSPerM);
        match v.component() {
            Component::Bearing => {
                format!("f_x = … + {damping:.4e} N s/m · (ẋ_s − ẋ_p), f_y = … + {damping:.4e} N s/m · (ẏ_s − ẏ_p)")
            }
            part => format!("… + {damping:.4e} N s/m · q̇ = …, q = {}", part.symbols()),
        }
    },
    apply: |v, assembly| {
        let damping = v.number(ParameterKey::DampingNSPerM);
        if damping == 0.0 {
            return;
        }
        let mut part = v.component().part_of(&assembly.machine);
        if v.component() == Component::Bearing {
            part.motions =
                [(INNER_X, OUTER_X), (INNER_Y, OUTER_Y)].map(|(dof, base)| Motion { dof, base: Some(base) }).into();
            part.mass = assembly.bearing().map_or(1.0, |rig| rig.inner.mass_kg.min(rig.outer.mass_kg));
        }
        assembly.declare_rate(2.0 * damping / part.mass);
        part.law(assembly, move |_, v| -damping * v);
    },
};
