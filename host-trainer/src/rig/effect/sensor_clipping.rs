//! A sensor or converter out of its range: samples stop at ± the value (IEEE Std 1241, full-scale range).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{assembly::Stage, config::Domain};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-clipping",
    rigs: Rigs::Both,
    site: Site::Acquisition,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::Value, "unit of the signal", Domain::Positive, (1e-3, 1e4), Scale::Log),
        Parameter::channel("all"),
    ],
    library: LibraryTerms::SENSOR,
    equation: |v| format!("a = clamp(…, ±{:.4e})", v.number(ParameterKey::Value)),
    apply: |v, assembly| {
        let (value, concerns) = (v.number(ParameterKey::Value), v.channels());
        assembly.signal(Stage::Converter, move |at, signal| {
            if concerns(at.channel) {
                signal.iter_mut().for_each(|sample| *sample = sample.clamp(-value, value));
            }
        });
    },
};
