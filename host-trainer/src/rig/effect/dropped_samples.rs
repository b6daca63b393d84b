//! Samples that never reached the file: those after the time are from `count` samples later, and nothing in the file
//! says so. The tachometer loses them too.

use super::{Definition, LibraryTerms, Parameter, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{assembly::Stage, config::Domain};

pub(super) const EFFECT: Definition = Definition {
    name: "dropped-samples",
    rigs: Rigs::Both,
    site: Site::Acquisition,
    timing: Timing::Event,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::TimeS, "s", Domain::NotNegative, (0.0, 10.0), Scale::Linear),
        Parameter::number(ParameterKey::Count, "", Domain::Whole(0, 10_000_000), (1.0, 10_000.0), Scale::Log),
    ],
    library: LibraryTerms::SENSOR,
    equation: |v| {
        let (time, count) = (v.number(ParameterKey::TimeS), v.number(ParameterKey::Count));
        format!("a(t) becomes a(t + {count}/f_s) from t = {time:.5} s")
    },
    apply: |v, assembly| {
        let (time, count) = (v.number(ParameterKey::TimeS), v.number(ParameterKey::Count) as usize);
        if count == 0 {
            return;
        }
        assembly.surplus += count;
        assembly.signal(Stage::Logger, move |at, signal| {
            let first = at.preroll + (time * at.sample_rate_hz).round() as usize;
            let first = first.min(signal.len());
            signal.drain(first..(first + count).min(signal.len()));
        });
    },
};
