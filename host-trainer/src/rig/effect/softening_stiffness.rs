//! A support spring that yields: k q + k₃ q³ with k₃ < 0, or k q + k₃ |q|² q along the displacement (I. Kovacic,
//! M. J. Brennan, "The Duffing Equation", 2011). k₃ is written with its sign.

use super::{
    Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices,
    hardening_stiffness::{apply, equation},
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "softening-stiffness",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::CubicNPerM3, "N/m³", Domain::NotPositive, (-1e18, -1e9), Scale::Log),
        Parameter::component(Choices::Supported),
        Parameter::symmetry(),
        Parameter::saturation(),
    ],
    library: LibraryTerms::CUBIC,
    equation,
    apply,
};
