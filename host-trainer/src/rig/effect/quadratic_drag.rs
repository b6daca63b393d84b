//! A force against the motion that grows with the square of the speed, −d v |v|, as of a fluid pushed aside
//! (A. H. Nayfeh, D. T. Mook, "Nonlinear Oscillations", 1979, section 3.3).

use super::{Applies, Definition, Parameter, Scale, Usual, component::Choices};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "quadratic-drag",
    applies_to: Applies::Both,
    deterministic: false,
    parameters: &[
        Parameter::number("drag_n_s2_per_m2", "N s²/m²", Domain::NotNegative, (1e-1, 1e9), Scale::Log),
        Parameter::component(Choices::Supported).usually(Usual::Name("outer")),
    ],
    equation: |v| {
        format!("… + {:.4e} N s²/m² · q̇ |q̇| = …, q = {}", v.number("drag_n_s2_per_m2"), v.component().symbols())
    },
    apply: |v, plan| {
        let drag = v.number("drag_n_s2_per_m2");
        if drag != 0.0 {
            plan.component(v.component()).law(plan, move |_, v| -drag * v * v.abs());
        }
    },
};
