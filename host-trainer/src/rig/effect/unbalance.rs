//! A rotating mass beyond the known one: m e is what it is altogether, and the force m e ω² grows with the square of
//! the speed (ISO 21940-2; Genta, "Dynamics of Rotating Systems", 2005, section 2.4).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "unbalance",
    rigs: Rigs::Bearing,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Shaft,
    is_deterministic: true,
    parameters: &[Parameter::number(ParameterKey::UnbalanceKgM, "kg m", Domain::NotNegative, (1e-6, 1e-1), Scale::Log)],
    library: LibraryTerms::ANGLE,
    equation: |v| {
        let total = v.number(ParameterKey::UnbalanceKgM);
        format!("m_s ẍ_s + … = {total:.4e} kg m · ω² cos ψ, m_s ÿ_s + … = … + {total:.4e} kg m · ω² sin ψ")
    },
    apply: |v, assembly| {
        if let Some(rig) = assembly.bearing() {
            rig.excitation.unbalance_kg_m = v.number(ParameterKey::UnbalanceKgM);
        }
    },
};
