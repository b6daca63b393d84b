//! A support spring that is stiffer one way than the other: k q + k₂ q² (A. H. Nayfeh, D. T. Mook, "Nonlinear
//! Oscillations", 1979, section 4.1: a steady shift and even harmonics), or k q + k₂ q²/(1 + s q²) where that saturates.

use super::{
    Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing, component::Choices,
    hardening_stiffness::saturated,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "asymmetric-stiffness",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::QuadraticNPerM2, "N/m²", Domain::Any, (1e5, 1e13), Scale::Log),
        Parameter::component(Choices::Supported),
        Parameter::saturation(),
    ],
    library: LibraryTerms::QUADRATIC,
    equation: |v| {
        let quadratic = v.number(ParameterKey::QuadraticNPerM2);
        format!("… + k q + {quadratic:.4e} N/m² · q²{} = …, q = {}", saturated(v, "q²"), v.component().symbols())
    },
    apply: |v, assembly| {
        let (quadratic, saturation) =
            (v.number(ParameterKey::QuadraticNPerM2), v.number(ParameterKey::SaturationPerM2));
        if quadratic == 0.0 {
            return;
        }
        let part = v.component().part_of(&assembly.machine);
        assembly.declare_rate(2.0 * (part.stiffness / part.mass).sqrt());
        part.law(assembly, move |q, _| -quadratic * q * q / (1.0 + saturation * q * q));
    },
};
