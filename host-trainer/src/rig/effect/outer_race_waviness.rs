//! Lobes on the outer race, at rest. Ball passes meet a lobe whose height is the same each time where the number of
//! lobes is a multiple of the number of balls, and one off gives radial motion: lines at multiples of BPFO
//! (F. P. Wardle, "Vibration forces produced by waviness of the rolling surfaces of thrust loaded ball bearings,
//! Part 1: theory", Proc. IMechE C 202 (1988) 305–312; S. P. Harsha et al., "Non-linear dynamic behaviors of rolling
//! element bearings due to surface waviness", J. Sound Vib. 272 (2004) 557–580). A load zone adds its own multiples.

use std::f64::consts::{PI, TAU};

use super::{Applies, Definition, Parameter, Scale, Usual};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "outer-race-waviness",
    applies_to: Applies::Bearing,
    parameters: &[
        Parameter::number("amplitude_m", "m", Domain::NotNegative, (1e-9, 1e-5), Scale::Log),
        Parameter::number("lobes", "", Domain::Whole(1, 1000), (2.0, 60.0), Scale::Each),
        Parameter::number("phase_rad", "rad", Domain::Any, (-PI, PI), Scale::Linear).usually(Usual::Number(0.0)),
    ],
    equation: |v| {
        let (amplitude, lobes, phase) = (v.number("amplitude_m"), v.number("lobes"), v.number("phase_rad"));
        format!("δ_j = … − c + {amplitude:.3e} m · cos({lobes}·φ_j + {phase:.3})")
    },
    apply: |v, plan| {
        let (amplitude, lobes, phase) = (v.number("amplitude_m"), v.number("lobes"), v.number("phase_rad"));
        if amplitude == 0.0 {
            return;
        }
        plan.profile(move |at, losses| {
            // From ball to ball by rotation: one sine and cosine for all.
            let (s_step, c_step) = (lobes * TAU / losses.len() as f64).sin_cos();
            let (mut s, mut c) = (lobes * (at.cage_rad) + phase).sin_cos();
            for loss in losses {
                *loss -= amplitude * c;
                (s, c) = (s * c_step + c * s_step, c * c_step - s * s_step);
            }
        });
    },
};
