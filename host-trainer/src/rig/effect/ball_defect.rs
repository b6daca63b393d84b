//! A defect in ball 0, which spins at BSF and turns with the cage: it meets the outer and, half a turn later, the inner
//! race, so it strikes at 2 × BSF, as hard as the load where the ball then is: sidebands at the cage's speed
//! (Randall and Antoni, MSSP 25 (2011) 485–520, section 2).

use std::f64::consts::{PI, TAU};

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    local_defect::LocalDefect,
    outer_race_defect::{DEPTH, FLANK, WIDTH},
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "ball-defect",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Ball,
    is_deterministic: true,
    parameters: &[
        DEPTH,
        WIDTH,
        // Angle of the defect from the outer race at shaft angle 0.
        Parameter::number(ParameterKey::SpinRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
        FLANK,
    ],
    library: LibraryTerms::ANGLE,
    equation: |v| {
        let depth = LocalDefect::new(v).equation();
        format!("δ_1 = … − c − d(β) − d(β − π), β = ½ D_p/D_b (1 − (D_b cos α/D_p)²) ψ, {depth}")
    },
    apply: |v, assembly| {
        let spin0 = v.number(ParameterKey::SpinRad);
        let Some(rig) = assembly.bearing() else { return };
        let pit = LocalDefect::new(v);
        let spin = rig.bearing.geometry().orders().bsf;
        if v.number(ParameterKey::DepthM) > 0.0 {
            assembly.declare_order(spin * pit.rate());
            assembly.defect(move |moments, _, passages| {
                let [from, to] = moments.each_ref().map(|at| (spin * at.shaft_rad + spin0) / TAU);
                // Outer and inner race, half a turn apart.
                for place in [0.0, 0.5] {
                    let nearest = (from - place).round() + place;
                    pit.pass(0, [from, to].map(|turns| (turns - nearest) * TAU), passages);
                }
            });
        }
    },
};
