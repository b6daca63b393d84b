//! A force against the motion that grows with the square of the speed, −d v |v|, as of a fluid pushed aside
//! (A. H. Nayfeh, D. T. Mook, "Nonlinear Oscillations", 1979, section 3.3).

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI};

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices, erf::erf,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "quadratic-drag",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::DragNS2PerM2, "N s²/m²", Domain::NotNegative, (1e-1, 1e9), Scale::Log),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("outer")),
    ],
    library: LibraryTerms::ODD,
    equation: |v| {
        format!("… + {:.4e} N s²/m² · q̇ |q̇| = …, q = {}", v.number(ParameterKey::DragNS2PerM2), v.component().symbols())
    },
    apply: |v, assembly| {
        let drag = v.number(ParameterKey::DragNS2PerM2);
        if drag != 0.0 {
            v.component().part_of(&assembly.machine).speed_law(
                assembly,
                move |v| -drag * v * v.abs(),
                |scatter| move |v| -drag * mean_square(v, scatter),
                // The mean's slope at rest, and the law's at a standard deviation.
                move |scatter| 2.0 * drag * scatter,
            );
        }
    },
};

/// Mean of v |v| over a normal distribution about v.
fn mean_square(v: f64, scatter: f64) -> f64 {
    if scatter == 0.0 {
        return v * v.abs();
    }
    let z = v / scatter;
    let density = (-0.5 * z * z).exp() * FRAC_2_PI.sqrt();
    scatter.powi(2) * ((z * z + 1.0) * erf(z * FRAC_1_SQRT_2) + z * density)
}
