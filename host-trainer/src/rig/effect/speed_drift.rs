//! The shaft speed changes evenly over a recording: ω (1 + r t) from t = 0. Every order smears in proportion to itself
//! (R. B. Randall, "Vibration-based Condition Monitoring", 2011, section 3.6).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "speed-drift",
    rigs: Rigs::Bearing,
    site: Site::Kinematics,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: true,
    parameters: &[Parameter::number(ParameterKey::RatePerS, "1/s", Domain::Any, (-0.5, 0.5), Scale::Linear)],
    library: LibraryTerms::PACE,
    equation: |v| format!("ω_shaft becomes ω_shaft (1 + {:.5}/s · t)", v.number(ParameterKey::RatePerS)),
    apply: |v, assembly| assembly.speed_rate_per_s += v.number(ParameterKey::RatePerS),
};
