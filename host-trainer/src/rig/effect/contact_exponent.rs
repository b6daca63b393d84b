//! A contact that is not Hertz's of a ball: k_b δ^p. 10/9 for a roller's line contact (A. Palmgren, "Ball and Roller
//! Bearing Engineering", 1959; T. A. Harris, M. N. Kotzalas, "Essential Concepts of Bearing Technology", 2006). k_b keeps
//! its number in N/m^p.

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "contact-exponent",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[Parameter::number(ParameterKey::Exponent, "", Domain::Between(0.9, 4.0), (1.0, 2.5), Scale::Linear)],
    library: LibraryTerms::EVEN,
    equation: |v| format!("contact force k_b δ_j^{:.4}", v.number(ParameterKey::Exponent)),
    apply: |v, assembly| {
        if let Some(rig) = assembly.bearing() {
            rig.bearing.contact_exponent = v.number(ParameterKey::Exponent);
        }
    },
};
