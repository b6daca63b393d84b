//! A measuring chain whose gain is off: every sample times the value, noise included (ISO 16063-21).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{assembly::Stage, config::Domain};

pub(super) const EFFECT: Definition = Definition {
    name: "sensor-gain",
    rigs: Rigs::Both,
    site: Site::Acquisition,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::Value, "", Domain::Positive, (0.1, 10.0), Scale::Log),
        Parameter::channel("all"),
    ],
    library: LibraryTerms::SENSOR,
    equation: |v| format!("a = {:.5} · …", v.number(ParameterKey::Value)),
    apply: |v, assembly| {
        let (value, concerns) = (v.number(ParameterKey::Value), v.channels());
        if value != 1.0 {
            assembly.signal(Stage::Amplifier, move |at, signal| {
                if concerns(at.channel) {
                    signal.iter_mut().for_each(|sample| *sample *= value);
                }
            });
        }
    },
};
