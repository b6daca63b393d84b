//! The load changes at a time within the recording.
//!
//! The vocabulary states when, which is the time of half the change, and by how much. How long it takes has a usual value of about
//! one sample, and how: evenly, along half a cosine without corners, or as a lag of first order or of second order at critical
//! damping follows a step, by its time constant. What a machine rings with after it depends on that.

use super::{Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{
    config::Domain,
    config::Machine,
    state::{INNER_Y, MASS},
};

pub(super) const EFFECT: Definition = Definition {
    name: "load-step",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Event,
    phase: Phase::Free,
    is_deterministic: true,
    parameters: &[
        Parameter::number(ParameterKey::TimeS, "s", Domain::Any, (0.0, 10.0), Scale::Linear),
        Parameter::number(ParameterKey::ChangeN, "N", Domain::Any, (-1e4, 1e4), Scale::Linear),
        Parameter::number(ParameterKey::RiseS, "s", Domain::Positive, (1e-6, 1e-1), Scale::Log)
            .usually(ParameterDefault::Number(4e-5)),
        Parameter::shape(),
    ],
    library: LibraryTerms::OUTSIDE,
    equation: |v| {
        let (time, change) = (v.number(ParameterKey::TimeS), v.number(ParameterKey::ChangeN));
        format!("F_load becomes F_load + {change:.4} N from t = {time:.4} s")
    },
    apply: |v, assembly| {
        let (time, change, rise) =
            (v.number(ParameterKey::TimeS), v.number(ParameterKey::ChangeN), v.number(ParameterKey::RiseS));
        let course = v.course();
        let dof = if matches!(assembly.machine, Machine::Sdof(_)) { MASS } else { INNER_Y };
        if change != 0.0 {
            assembly.force(move |at, _, _, force| force[dof] += change * course.share((at.time_s - time) / rise));
        }
    },
};
