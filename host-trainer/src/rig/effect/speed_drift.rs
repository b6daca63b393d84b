//! The shaft speed changes evenly over a recording: ω (1 + r t) from t = 0. Every order smears in proportion to itself
//! (R. B. Randall, "Vibration-based Condition Monitoring", 2011, section 3.6).

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "speed-drift",
    applies_to: Applies::Bearing,
    is_deterministic: true,
    parameters: &[Parameter::number("rate_per_s", "1/s", Domain::Any, (-0.5, 0.5), Scale::Linear)],
    equation: |v| format!("ω_shaft becomes ω_shaft (1 + {:.5}/s · t)", v.number("rate_per_s")),
    apply: |v, plan| plan.speed_rate_per_s += v.number("rate_per_s"),
};
