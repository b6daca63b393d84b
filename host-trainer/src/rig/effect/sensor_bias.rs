//! A sensor whose zero is off: the same value added to every sample (ISO 5347; a charge amplifier that drifts).

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::{config::Domain, plan::Stage};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-bias",
    applies_to: Applies::Both,
    parameters: &[Parameter::number("value", "unit of the signal", Domain::Any, (-10.0, 10.0), Scale::Linear)],
    equation: |v| format!("a = … + {:.4e}", v.number("value")),
    apply: |v, plan| {
        let value = v.number("value");
        if value != 0.0 {
            plan.signal(Stage::Transducer, move |_, signal| {
                for sample in signal {
                    *sample += value;
                }
            });
        }
    },
};
