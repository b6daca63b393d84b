//! A coupling out of line pushes the shaft around twice a turn (M. Xu, R. D. Marangoni, "Vibration analysis of a
//! motor-flexible coupling-rotor system subject to misalignment and unbalance, part I", J. Sound Vib. 176 (1994)
//! 663–679): a force of constant size on the inner race, at 2ψ from x.

use std::f64::consts::PI;

use super::{Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing};
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
    ],
    library: LibraryTerms::ANGLE,
    equation: |v| {
        let (force, phase) = (v.number(ParameterKey::ForceN), v.number(ParameterKey::PhaseRad));
        format!(
            "m_s ẍ_s + … = … + {force:.4} N · cos(2ψ + {phase:.3}), m_s ÿ_s + … = … + {force:.4} N · sin(2ψ + {phase:.3})"
        )
    },
    apply: |v, assembly| {
        let (amplitude, phase) = (v.number(ParameterKey::ForceN), v.number(ParameterKey::PhaseRad));
        if amplitude != 0.0 {
            assembly.force(move |at, _, _, force| {
                let (s, c) = (2.0 * at.shaft_rad + phase).sin_cos();
                force[INNER_X] += amplitude * c;
                force[INNER_Y] += amplitude * s;
            });
        }
    },
};
