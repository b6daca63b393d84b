//! A pit in the outer race, fixed in space. Balls cross it at BPFO; no modulation, as load and path are constant
//! (McFadden and Smith, J. Sound Vib. 96 (1984) 69–82).

use std::f64::consts::PI;

use super::{Applies, Definition, Parameter, Scale, local_defect::LocalDefect};
use crate::rig::config::Domain;

pub(super) const DEPTH: Parameter = Parameter::number("depth_m", "m", Domain::NotNegative, (1e-7, 1e-4), Scale::Log);
/// A search looks up to the widest pits that Case Western Reserve University has made on a ball, 0.028 in or 0.18 rad. What is far
/// wider is no pit but a wave.
pub(super) const WIDTH: Parameter =
    Parameter::number("width_rad", "rad", Domain::Between(0.0, 6.3), (5e-3, 0.2), Scale::Log);

pub(super) const EFFECT: Definition = Definition {
    name: "outer-race-defect",
    applies_to: Applies::Bearing,
    is_deterministic: true,
    parameters: &[
        DEPTH,
        WIDTH,
        // +y, the direction of the load, is at π/2.
        Parameter::number("angle_rad", "rad", Domain::Any, (-PI, PI), Scale::Linear),
    ],
    equation: |v| {
        let (depth, width, angle) = (v.number("depth_m"), v.number("width_rad"), v.number("angle_rad"));
        format!("δ_j = … − c − d(φ_j − {angle:.4}), d(θ) = {depth:.4e} m · cos(πθ/{width:.5}) for |θ| < {width:.5}/2")
    },
    apply: |v, plan| {
        let angle = v.number("angle_rad");
        let pit = LocalDefect::new(v.number("depth_m"), v.number("width_rad"));
        let Some(rig) = plan.bearing() else { return };
        let ftf = rig.bearing.geometry().orders().ftf;
        if v.number("depth_m") > 0.0 {
            plan.declare_order(ftf * pit.rate());
            plan.defect(move |moments, balls, passages| pit.pass_all(|_| angle, moments, balls, passages));
        }
    },
};
