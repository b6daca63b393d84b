//! A pit in the inner race, turning with the shaft. Balls cross it at BPFI, as hard as the load where it then stands:
//! sidebands at the shaft speed (McFadden and Smith, J. Sound Vib. 96 (1984) 69–82).

use std::f64::consts::PI;

use super::{
    Applies, Definition, Parameter, Scale, ParameterDefault,
    outer_race_defect::{DEPTH, WIDTH},
    local_defect::LocalDefect,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "inner-race-defect",
    applies_to: Applies::Bearing,
    is_deterministic: true,
    parameters: &[
        DEPTH,
        WIDTH,
        // From the mark that the shaft angle counts from.
        Parameter::number("angle_rad", "rad", Domain::Any, (-PI, PI), Scale::Linear).usually(ParameterDefault::Number(0.0)),
    ],
    equation: |v| {
        let (depth, width, angle) = (v.number("depth_m"), v.number("width_rad"), v.number("angle_rad"));
        format!("δ_j = … − c − d(φ_j − ψ − {angle:.4}), d(θ) = {depth:.4e} m · cos(πθ/{width:.5}) for |θ| < {width:.5}/2")
    },
    apply: |v, plan| {
        let angle = v.number("angle_rad");
        let pit = LocalDefect::new(v.number("depth_m"), v.number("width_rad"));
        let Some(rig) = plan.bearing() else { return };
        let ftf = rig.bearing.geometry().orders().ftf;
        if v.number("depth_m") > 0.0 {
            plan.declare_order((1.0 - ftf) * pit.rate());
            plan.defect(move |moments, balls, passages| pit.pass_all(|at| angle + at.shaft_rad, moments, balls, passages));
        }
    },
};
