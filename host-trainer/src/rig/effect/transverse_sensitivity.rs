//! A sensor that is sensitive across its axis, or cables that talk: a channel has a share of the acceleration of the other one
//! (ISO 16063-31; healthy sensors have up to 5 %).

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{assembly::Stage, config::Domain};

pub(super) const EFFECT: Definition = Definition {
    name: "transverse-sensitivity",
    rigs: Rigs::Bearing,
    site: Site::Acquisition,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::Value, "", Domain::Any, (-1.0, 1.0), Scale::Linear),
        Parameter::channel("ay"),
    ],
    library: LibraryTerms::SENSOR,
    equation: |v| format!("a becomes a + {:.5} a_⊥", v.number(ParameterKey::Value)),
    apply: |v, assembly| {
        let (value, concerns) = (v.number(ParameterKey::Value), v.channels());
        if value != 0.0 {
            assembly.signal(Stage::Transducer, move |at, signal| {
                if concerns(at.channel) {
                    signal.iter_mut().zip(at.across).for_each(|(sample, across)| *sample += value * across);
                }
            });
        }
    },
};
