//! A support spring that is stiffer one way than the other: k q + k₂ q² (A. H. Nayfeh, D. T. Mook, "Nonlinear
//! Oscillations", 1979, section 4.1: a steady shift and even harmonics).

use super::{Applies, Definition, Parameter, Scale, component::Choices};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "asymmetric-stiffness",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::number("quadratic_n_per_m2", "N/m²", Domain::Any, (1e5, 1e13), Scale::Log),
        Parameter::component(Choices::Supported),
    ],
    equation: |v| {
        let quadratic = v.number("quadratic_n_per_m2");
        format!("… + k q + {quadratic:.4e} N/m² · q² = …, q = {}", v.component().symbols())
    },
    apply: |v, plan| {
        let quadratic = v.number("quadratic_n_per_m2");
        if quadratic == 0.0 {
            return;
        }
        let part = (v.component()).part_of(&plan.machine);
        plan.declare_rate(2.0 * (part.stiffness / part.mass).sqrt());
        part.law(plan, move |q, _| -quadratic * q * q);
    },
};
