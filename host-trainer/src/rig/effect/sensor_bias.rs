//! A sensor whose zero is off: the same value added to every sample (ISO 5347; a charge amplifier that drifts).

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::{config::Domain, assembly::Stage};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-bias",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::number("value", "unit of the signal", Domain::Any, (-10.0, 10.0), Scale::Linear),
        Parameter::channel("all"),
    ],
    equation: |v| format!("a = … + {:.4e}", v.number("value")),
    apply: |v, plan| {
        let (value, concerns) = (v.number("value"), v.channels());
        if value != 0.0 {
            plan.signal(Stage::Transducer, move |at, signal| {
                if concerns(at.channel) {
                    signal.iter_mut().for_each(|sample| *sample += value);
                }
            });
        }
    },
};
