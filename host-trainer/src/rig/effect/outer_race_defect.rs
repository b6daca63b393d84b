//! A defect in the outer race, fixed in space. Balls cross it at BPFO; no modulation, as load and path are constant
//! (McFadden and Smith, J. Sound Vib. 96 (1984) 69–82).

use std::f64::consts::PI;

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    local_defect::LocalDefect,
};
use crate::rig::config::Domain;

pub(super) const DEPTH: Parameter =
    Parameter::number(ParameterKey::DepthM, "m", Domain::NotNegative, (1e-7, 1e-4), Scale::Log);
/// Width: searched up to the widest defects that Case Western Reserve University seeded on a ball, 0.028 in or 0.18 rad. A far
/// wider one is a wave, not a defect.
pub(super) const WIDTH: Parameter =
    Parameter::number(ParameterKey::WidthRad, "rad", Domain::Between(0.0, 6.3), (5e-3, 0.2), Scale::Log);

/// Share of the width that each flank takes; more than a half counts as a half, a raised cosine.
pub(super) const FLANK: Parameter =
    Parameter::number(ParameterKey::Flank, "", Domain::NotNegative, (0.05, 0.5), Scale::Log)
        .usually(ParameterDefault::Number(0.0));

pub(super) const EFFECT: Definition = Definition {
    name: "outer-race-defect",
    rigs: Rigs::Bearing,
    site: Site::Contact,
    timing: Timing::Persistent,
    phase: Phase::Cage,
    is_deterministic: true,
    parameters: &[
        DEPTH,
        WIDTH,
        // +y, the direction of the load, is at π/2.
        Parameter::number(ParameterKey::AngleRad, "rad", Domain::Any, (-PI, PI), Scale::Linear),
        FLANK,
    ],
    library: LibraryTerms::ANGLE,
    equation: |v| {
        let angle = v.number(ParameterKey::AngleRad);
        format!("δ_j = … − c − d(φ_j − {angle:.4}), {}", LocalDefect::new(v).equation())
    },
    apply: |v, assembly| {
        let angle = v.number(ParameterKey::AngleRad);
        let pit = LocalDefect::new(v);
        let Some(rig) = assembly.bearing() else { return };
        let ftf = rig.bearing.geometry().orders().ftf;
        if v.number(ParameterKey::DepthM) > 0.0 {
            assembly.declare_order(ftf * pit.rate());
            assembly.defect(move |moments, balls, passages| pit.pass_all(|_| angle, moments, balls, passages));
        }
    },
};
