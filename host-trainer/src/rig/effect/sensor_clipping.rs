//! A sensor or converter out of its range: samples stop at ± the value (IEEE Std 1241, full-scale range).

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::{config::Domain, assembly::Stage};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-clipping",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::number("value", "unit of the signal", Domain::Positive, (1e-3, 1e4), Scale::Log),
        Parameter::channel("all"),
    ],
    equation: |v| format!("a = clamp(…, ±{:.4e})", v.number("value")),
    apply: |v, plan| {
        let (value, concerns) = (v.number("value"), v.channels());
        plan.signal(Stage::Converter, move |at, signal| {
            if concerns(at.channel) {
                signal.iter_mut().for_each(|sample| *sample = sample.clamp(-value, value));
            }
        });
    },
};
