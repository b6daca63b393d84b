//! A coupling out of line pushes the shaft around twice a turn (M. Xu, R. D. Marangoni, "Vibration analysis of a
//! motor-flexible coupling-rotor system subject to misalignment and unbalance, part I", J. Sound Vib. 176 (1994)
//! 663–679): a force of constant size on the inner race, which rotates at 2ψ from x or, where the support is stiffer one way,
//! follows an ellipse or a line.

use std::f64::consts::{FRAC_PI_4, PI};

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing, Values,
};
use crate::rig::{
    config::Domain,
    state::{INNER_X, INNER_Y},
};

pub(super) const EFFECT: Definition = Definition {
    name: "misalignment",
    rigs: Rigs::Bearing,
    site: Site::Force,
    timing: Timing::Persistent,
    phase: Phase::Shaft,
    is_deterministic: true,
    parameters: &[
        Parameter::number(ParameterKey::ForceN, "N", Domain::NotNegative, (1e-1, 1e4), Scale::Log),
        // Which way the coupling is out of line.
        Parameter::number(ParameterKey::PhaseRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
        // The force's ellipse: a rotating force, or a force along one direction, as the support lets it.
        Parameter::number(ParameterKey::AngleRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(FRAC_PI_4)),
        Parameter::number(ParameterKey::PhaseYRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
    ],
    library: LibraryTerms::ANGLE,
    equation: |v| {
        let Ellipse { x, y, phase, phase_y } = Ellipse::new(v);
        format!(
            "m_s ẍ_s + … = … + {x:.4} N · cos(2ψ + {phase:.3}), m_s ÿ_s + … = … + {y:.4} N · sin(2ψ + {phase_y:.3})"
        )
    },
    apply: |v, assembly| {
        let Ellipse { x, y, phase, phase_y } = Ellipse::new(v);
        if x != 0.0 || y != 0.0 {
            assembly.force(move |at, _, _, force| {
                force[INNER_X] += x * (2.0 * at.shaft_rad + phase).cos();
                force[INNER_Y] += y * (2.0 * at.shaft_rad + phase_y).sin();
            });
        }
    },
};

/// Force at twice the shaft's speed by its amplitudes and phases; `force_n` is the greater amplitude.
struct Ellipse {
    x: f64,
    y: f64,
    phase: f64,
    phase_y: f64,
}

impl Ellipse {
    fn new(v: &Values) -> Self {
        let (force, phase) = (v.number(ParameterKey::ForceN), v.number(ParameterKey::PhaseRad));
        let (sin, cos) = v.number(ParameterKey::AngleRad).sin_cos();
        let scale = force / sin.abs().max(cos.abs());
        Self { x: scale * cos, y: scale * sin, phase, phase_y: phase + v.number(ParameterKey::PhaseYRad) }
    }
}
