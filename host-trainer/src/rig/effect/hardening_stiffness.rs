//! A support spring that stiffens: k q + k₃ q³ with k₃ > 0 in each direction, or k q + k₃ |q|² q along the displacement
//! (I. Kovacic, M. J. Brennan, "The Duffing Equation", 2011). Its slope k + 3 k₃ q² rises with the static deflection, hence the resonance with the load.

use super::Values;
use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing, component::Choices};
use crate::rig::assembly::Assembly;
use crate::rig::config::Domain;

/// The force −k₃ q³, or −k₃ |q|² q.
pub(super) fn apply(v: &Values, assembly: &mut Assembly) {
    let cubic = v.number(ParameterKey::CubicNPerM3);
    if cubic == 0.0 {
        return;
    }
    let part = v.component().part_of(&assembly.machine);
    // No static deflection is known here, but one that doubles the stiffness is where the effect is plain.
    assembly.declare_rate(2.0 * (part.stiffness / part.mass).sqrt());
    if v.is_isotropic() {
        part.isotropic_law(assembly, move |square| -cubic * square);
    } else {
        part.law(assembly, move |q, _| -cubic * q * q * q);
    }
}

/// The term, on the left side.
pub(super) fn equation(v: &Values) -> String {
    let cubic = v.number(ParameterKey::CubicNPerM3);
    let law = if v.is_isotropic() { "|q|² q" } else { "q³" };
    format!("… + k q + {cubic:.4e} N/m³ · {law} = …, q = {}", v.component().symbols())
}

pub(super) const EFFECT: Definition = Definition {
    name: "hardening-stiffness",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::CubicNPerM3, "N/m³", Domain::NotNegative, (1e9, 1e18), Scale::Log),
        Parameter::component(Choices::Supported),
        Parameter::symmetry(),
    ],
    library: LibraryTerms::CUBIC,
    equation,
    apply,
};
