//! The load changes at a time within the recording, from one sample to the next.

use super::{Applies, Definition, Parameter, Scale};
use crate::rig::{
    config::Domain,
    plan::{INNER_Y, MASS, Machine},
};

pub(super) const EFFECT: Definition = Definition {
    name: "load-step",
    applies_to: Applies::Both,
    deterministic: true,
    parameters: &[
        Parameter::number("time_s", "s", Domain::Any, (0.0, 10.0), Scale::Linear),
        Parameter::number("change_n", "N", Domain::Any, (-1e4, 1e4), Scale::Linear),
    ],
    equation: |v| {
        let (time, change) = (v.number("time_s"), v.number("change_n"));
        format!("F_load becomes F_load + {change:.4} N from t = {time:.4} s")
    },
    apply: |v, plan| {
        let (time, change) = (v.number("time_s"), v.number("change_n"));
        let dof = if matches!(plan.machine, Machine::Sdof(_)) { MASS } else { INNER_Y };
        if change != 0.0 {
            plan.force(move |at, _, _, force| force[dof] += if at.time_s >= time { change } else { 0.0 });
        }
    },
};
