//! Balls that slide turn the cage slower than rolling would: ω_c (1 − s), typically 1 to 2 % (Randall and Antoni, MSSP 25
//! (2011) 485–520, section 2.1). Spin and shaft stay as they are.

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "cage-slip",
    rigs: Rigs::Bearing,
    site: Site::Kinematics,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: true,
    parameters: &[Parameter::number(ParameterKey::Fraction, "", Domain::Between(-1.0, 1.0), (1e-3, 0.3), Scale::Log)],
    library: LibraryTerms::PACE,
    equation: |v| format!("ω_c = ½ (1 − D_b cos α / D_p) · (1 − {:.5}) · ω_shaft", v.number(ParameterKey::Fraction)),
    apply: |v, assembly| assembly.cage_factor *= 1.0 - v.number(ParameterKey::Fraction),
};
