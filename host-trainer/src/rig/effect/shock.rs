//! A single impact: a half-sine pulse of force (IEC 60068-2-27), down on the housing of a bearing rig.
//!
//! The vocabulary states only its time. Its impulse, and how long it takes, have usual values and can be fitted.

use std::f64::consts::PI;

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Choices,
};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "shock",
    rigs: Rigs::Both,
    site: Site::Force,
    timing: Timing::Event,
    phase: Phase::Free,
    is_deterministic: true,
    parameters: &[
        Parameter::number(ParameterKey::TimeS, "s", Domain::Any, (0.0, 10.0), Scale::Linear),
        Parameter::number(ParameterKey::ImpulseNS, "N s", Domain::Any, (1e-4, 1e2), Scale::Log)
            .usually(ParameterDefault::ByKind(0.01, 1.0)),
        Parameter::number(ParameterKey::DurationS, "s", Domain::Positive, (5e-5, 1e-2), Scale::Log)
            .usually(ParameterDefault::ByKind(2e-4, 5e-3)),
        Parameter::component(Choices::Supported).usually(ParameterDefault::Name("outer-y")),
    ],
    library: LibraryTerms::OUTSIDE,
    equation: |v| {
        let (time, impulse, duration) =
            (v.number(ParameterKey::TimeS), v.number(ParameterKey::ImpulseNS), v.number(ParameterKey::DurationS));
        format!(
            "m q̈ + … = … + {:.4e} N · sin(π (t − {time:.5} s)/{duration:.2e} s) for {duration:.2e} s, q = {}",
            0.5 * PI * impulse / duration,
            v.component().symbols()
        )
    },
    apply: |v, assembly| {
        let (time, impulse, duration) =
            (v.number(ParameterKey::TimeS), v.number(ParameterKey::ImpulseNS), v.number(ParameterKey::DurationS));
        if impulse == 0.0 {
            return;
        }
        let peak = 0.5 * PI * impulse / duration;
        let part = v.component().part_of(&assembly.machine);
        assembly.declare_rate(PI / duration);
        assembly.force(move |at, _, _, force| {
            let phase = (at.time_s - time) / duration;
            if (0.0..1.0).contains(&phase) {
                for motion in &part.motions {
                    motion.push(peak * (PI * phase).sin(), force);
                }
            }
        });
    },
};
