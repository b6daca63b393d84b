//! A contact that is not Hertz's of a ball: k_b δ^p. 10/9 for a roller's line contact (A. Palmgren, "Ball and Roller
//! Bearing Engineering", 1959; T. A. Harris, M. N. Kotzalas, "Essential Concepts of Bearing Technology", 2006). k_b keeps
//! its number in N/m^p, which is the nominal force at 1 m, unless another deflection is given at which the force is nominal.

use super::{Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "contact-exponent",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::Exponent, "", Domain::Between(0.9, 4.0), (1.0, 2.5), Scale::Linear),
        Parameter::number(ParameterKey::DeflectionM, "m", Domain::Positive, (1e-7, 1.0), Scale::Log)
            .usually(ParameterDefault::Number(1.0)),
    ],
    library: LibraryTerms::EVEN,
    equation: |v| match (v.number(ParameterKey::Exponent), v.number(ParameterKey::DeflectionM)) {
        (exponent, 1.0) => format!("contact force k_b δ_j^{exponent:.4}"),
        (exponent, same) => format!("contact force k_b δ₀^(p−p′) δ_j^p′, p′ = {exponent:.4}, δ₀ = {same:.3e} m"),
    },
    apply: |v, assembly| {
        if let Some(rig) = assembly.bearing() {
            let (exponent, deflection_m) = (v.number(ParameterKey::Exponent), v.number(ParameterKey::DeflectionM));
            let bearing = &mut rig.bearing;
            bearing.contact_stiffness_n_per_m1_5 *= deflection_m.powf(bearing.contact_exponent - exponent);
            bearing.contact_exponent = exponent;
        }
    },
};
