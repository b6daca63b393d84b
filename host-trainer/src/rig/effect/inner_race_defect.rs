//! A defect in the inner race, turning with the shaft. Balls cross it at BPFI, as hard as the load where it then stands:
//! sidebands at the shaft speed (McFadden and Smith, J. Sound Vib. 96 (1984) 69–82).

use std::f64::consts::PI;

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    local_defect::LocalDefect,
    outer_race_defect::{DEPTH, FLANK, WIDTH},
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "inner-race-defect",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Shaft,
    is_deterministic: true,
    parameters: &[
        DEPTH,
        WIDTH,
        // From the mark that the shaft angle counts from.
        Parameter::number(ParameterKey::AngleRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
        FLANK,
    ],
    library: LibraryTerms::ANGLE,
    equation: |v| {
        let angle = v.number(ParameterKey::AngleRad);
        format!("δ_j = … − c − d(φ_j − ψ − {angle:.4}), {}", LocalDefect::new(v).equation())
    },
    apply: |v, assembly| {
        let angle = v.number(ParameterKey::AngleRad);
        let pit = LocalDefect::new(v);
        let Some(rig) = assembly.bearing() else { return };
        let ftf = rig.bearing.geometry().orders().ftf;
        if v.number(ParameterKey::DepthM) > 0.0 {
            assembly.declare_order((1.0 - ftf) * pit.rate());
            assembly.defect(move |moments, balls, passages| {
                pit.pass_all(|at| angle + at.shaft_rad, moments, balls, passages)
            });
        }
    },
};
