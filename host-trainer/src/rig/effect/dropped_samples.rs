//! Samples that never reached the file: those after the time are from `count` samples later, and nothing in the file
//! says so. The tachometer loses them too.

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::{config::Domain, assembly::Stage};

pub(super) const EFFECT: Definition = Definition {
    name: "dropped-samples",
    applies_to: Applies::Both,
    is_deterministic: false,
    parameters: &[
        Parameter::number("time_s", "s", Domain::NotNegative, (0.0, 10.0), Scale::Linear),
        Parameter::number("count", "", Domain::Whole(0, 10_000_000), (1.0, 10_000.0), Scale::Log),
    ],
    equation: |v| {
        let (time, count) = (v.number("time_s"), v.number("count"));
        format!("a(t) becomes a(t + {count}/f_s) from t = {time:.5} s")
    },
    apply: |v, plan| {
        let (time, count) = (v.number("time_s"), v.number("count") as usize);
        if count == 0 {
            return;
        }
        plan.surplus += count;
        plan.signal(Stage::Logger, move |at, signal| {
            let first = at.preroll + (time * at.sample_rate_hz).round() as usize;
            let first = first.min(signal.len());
            signal.drain(first..(first + count).min(signal.len()));
        });
    },
};
