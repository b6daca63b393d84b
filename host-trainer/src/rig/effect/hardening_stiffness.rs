//! A support spring that stiffens: k q + k₃ q³ with k₃ > 0 in each direction, or k q + k₃ |q|² q along the displacement
//! (I. Kovacic, M. J. Brennan, "The Duffing Equation", 2011). Its slope k + 3 k₃ q² rises with the static deflection, hence the
//! resonance with the load. A spring that far from its middle is another straight one, as between two clamps, has a cubic part
//! that saturates: k₃ q³/(1 + s q²).

use super::Values;
use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing, component::Choices};
use crate::rig::assembly::Assembly;
use crate::rig::config::Domain;

/// The force −k₃ q³, or −k₃ |q|² q, over 1 + s |q|².
pub(super) fn apply(v: &Values, assembly: &mut Assembly) {
    let (cubic, saturation) = (v.number(ParameterKey::CubicNPerM3), v.number(ParameterKey::SaturationPerM2));
    if cubic == 0.0 {
        return;
    }
    let part = v.component().part_of(&assembly.machine);
    // No static deflection is known here, but one that doubles the stiffness is where the effect is plain.
    assembly.declare_rate(2.0 * (part.stiffness / part.mass).sqrt());
    if v.is_isotropic() {
        part.isotropic_law(assembly, move |square| -cubic * square / (1.0 + saturation * square));
    } else {
        part.law(assembly, move |q, _| -cubic * q * q * q / (1.0 + saturation * q * q));
    }
}

/// The term, on the left side.
pub(super) fn equation(v: &Values) -> String {
    let cubic = v.number(ParameterKey::CubicNPerM3);
    let (law, square) = if v.is_isotropic() { ("|q|² q", "|q|²") } else { ("q³", "q²") };
    format!("… + k q + {cubic:.4e} N/m³ · {law}{} = …, q = {}", saturated(v, square), v.component().symbols())
}

/// The divisor 1 + s q² of an equation; nothing where the law does not saturate.
pub(super) fn saturated(v: &Values, square: &str) -> String {
    let saturation = v.number(ParameterKey::SaturationPerM2);
    if saturation > 0.0 { format!("/(1 + {saturation:.4e} 1/m² · {square})") } else { String::new() }
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
        Parameter::saturation(),
    ],
    library: LibraryTerms::CUBIC,
    equation,
    apply,
};
