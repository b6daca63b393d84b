//! A sensor whose zero is off: the same value added to every sample (ISO 5347; a charge amplifier that drifts).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{assembly::Stage, config::Domain};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-bias",
    rigs: Rigs::Both,
    site: Site::Acquisition,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::Value, "unit of the signal", Domain::Any, (-10.0, 10.0), Scale::Linear),
        Parameter::channel("all"),
    ],
    library: LibraryTerms::SENSOR,
    equation: |v| format!("a = … + {:.4e}", v.number(ParameterKey::Value)),
    apply: |v, assembly| {
        let (value, concerns) = (v.number(ParameterKey::Value), v.channels());
        if value != 0.0 {
            assembly.signal(Stage::Transducer, move |at, signal| {
                if concerns(at.channel) {
                    signal.iter_mut().for_each(|sample| *sample += value);
                }
            });
        }
    },
};
