//! Film of lubricant between balls and races, elastohydrodynamic: the balls are thicker by it (Hamrock and Dowson, see
//! [`film`](crate::rig::film)). A bearing with film has less clearance, the less the faster it turns; at one speed and load the
//! film is nothing else. Damping by squeezing it is `viscous-friction` of the component `bearing`.

use super::{Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;
use crate::rig::film::Lubricant;

pub(super) const EFFECT: Definition = Definition {
    name: "lubricant-film",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::ViscosityPaS, "Pa s", Domain::NotNegative, (1e-3, 1.0), Scale::Log),
        Parameter::number(ParameterKey::PressureViscosityPerPa, "1/Pa", Domain::Positive, (5e-9, 5e-8), Scale::Log)
            .usually(ParameterDefault::Number(2e-8)),
    ],
    library: LibraryTerms::FILM,
    equation: |v| {
        format!(
            "δ_j = … − c + h_i + h_o, h by Hamrock and Dowson with η₀ = {:.4e} Pa s",
            v.number(ParameterKey::ViscosityPaS)
        )
    },
    apply: |v, assembly| {
        assembly.lubricant = Some(Lubricant {
            viscosity_pa_s: v.number(ParameterKey::ViscosityPaS),
            pressure_viscosity_per_pa: v.number(ParameterKey::PressureViscosityPerPa),
        });
    },
};
