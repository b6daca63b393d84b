//! A rotating mass beyond the known one: m e is what it is altogether, and the force m e ω² grows with the square of
//! the speed (ISO 21940-2; Genta, "Dynamics of Rotating Systems", 2005, section 2.4).

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "unbalance",
    applies_to: Applies::Bearing,
    is_deterministic: true,
    parameters: &[Parameter::number("unbalance_kg_m", "kg m", Domain::NotNegative, (1e-6, 1e-1), Scale::Log)],
    equation: |v| {
        let total = v.number("unbalance_kg_m");
        format!("m_s ẍ_s + … = {total:.4e} kg m · ω² cos ψ, m_s ÿ_s + … = … + {total:.4e} kg m · ω² sin ψ")
    },
    apply: |v, plan| {
        if let Some(rig) = plan.bearing() {
            rig.excitation.unbalance_kg_m = v.number("unbalance_kg_m");
        }
    },
};
