//! A sensor whose sensitivity is off: every sample times the value (ISO 16063-21).

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::{config::Domain, assembly::Stage};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-gain",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::number("value", "", Domain::Positive, (0.1, 10.0), Scale::Log),
        Parameter::channel("all"),
    ],
    equation: |v| format!("a = {:.5} · …", v.number("value")),
    apply: |v, plan| {
        let (value, concerns) = (v.number("value"), v.channels());
        if value != 1.0 {
            plan.signal(Stage::Transducer, move |at, signal| {
                if concerns(at.channel) {
                    signal.iter_mut().for_each(|sample| *sample *= value);
                }
            });
        }
    },
};
