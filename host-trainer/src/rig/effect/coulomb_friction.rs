//! Dry friction of constant size against the motion, F tanh(v/v₀) in each direction.
//!
//! The step at v = 0 is rounded at v₀ (B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models,
//! analysis tools and compensation methods for the control of machines with friction", Automatica 30 (1994)
//! 1083–1138). Karnopp's dead band (J. Dyn. Syst. Meas. Control 107 (1985) 100–103) would hold the mass at true rest,
//! but switches the equations, which costs a smooth integrator its order; tanh creeps at v₀ · artanh(load/F) instead,
//! far below what is measured if v₀ is far below the speeds of the motion. The step is chosen by F/(m v₀).
//!
//! Noise that shakes the mass rounds the step by much more ("dither"): the mean of sign(v + η) over η of a standard
//! deviation σ is erf(v/(√2 σ)) (statistical linearisation: J. B. Roberts, P. D. Spanos, "Random
//! Vibration and Statistical Linearization", 1990).

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI};

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices, erf::erf,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "coulomb-friction",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::ForceN, "N", Domain::NotNegative, (1e-3, 1e3), Scale::Log),
        Parameter::component(Choices::Supported),
        // Vibration of a bearing housing is of the order of 10 to 1000 µm/s, positioning systems move at cm/s.
        Parameter::number(ParameterKey::RegularisationMPerS, "m/s", Domain::Positive, (1e-7, 1e-3), Scale::Log)
            .usually(ParameterDefault::ByKind(2e-6, 1e-4)),
    ],
    library: LibraryTerms::ODD,
    equation: |v| {
        let (force, scale) = (v.number(ParameterKey::ForceN), v.number(ParameterKey::RegularisationMPerS));
        format!("… + c q̇ + {force:.4} N · tanh(q̇ / {scale:.1e} m/s) = …, q = {}", v.component().symbols())
    },
    apply: |v, assembly| {
        let (size, rounded) = (v.number(ParameterKey::ForceN), v.number(ParameterKey::RegularisationMPerS));
        if size == 0.0 {
            return;
        }
        // The error function that has the slope of tanh(v/v₀) at 0 is the mean of sign v over a deviation of √(2/π) v₀.
        let own = FRAC_2_PI * rounded.powi(2);
        let deviation = |scatter: f64| (own + scatter.powi(2)).sqrt();
        v.component().part_of(&assembly.machine).speed_law(
            assembly,
            move |v| -size * tanh(v / rounded),
            |scatter| {
                let per_speed = FRAC_1_SQRT_2 / deviation(scatter);
                move |v| -size * erf(v * per_speed)
            },
            |scatter| size * FRAC_2_PI.sqrt() / deviation(scatter),
        );
    },
};

/// tanh x with an absolute error of 1e-16; a relative one takes longer, and the force near standstill does not need it.
fn tanh(x: f64) -> f64 {
    let size = 1.0 - 2.0 / ((2.0 * x.abs()).exp() + 1.0);
    size.copysign(x)
}
