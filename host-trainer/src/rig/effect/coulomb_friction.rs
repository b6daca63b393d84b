//! Dry friction of constant size against the motion, F tanh(v/v₀) in each direction.
//!
//! The step at v = 0 is rounded at v₀ (B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models,
//! analysis tools and compensation methods for the control of machines with friction", Automatica 30 (1994)
//! 1083–1138). Karnopp's dead band (J. Dyn. Syst. Meas. Control 107 (1985) 100–103) would hold the mass at true rest,
//! but switches the equations, which costs a smooth integrator its order; tanh creeps at v₀ · artanh(load/F) instead,
//! far below what is measured if v₀ is far below the speeds of the motion. The step is chosen by F/(m v₀).

use super::{Applies, Definition, Parameter, Scale, Usual, component::Choices};
use crate::rig::config::Domain;

pub(super) const EFFECT: Definition = Definition {
    name: "coulomb-friction",
    applies_to: Applies::Both,
    deterministic: false,
    parameters: &[
        Parameter::number("force_n", "N", Domain::NotNegative, (1e-3, 1e3), Scale::Log),
        Parameter::component(Choices::Supported),
        // Vibration of a bearing housing is of the order of 10 to 1000 µm/s, positioning systems move at cm/s.
        Parameter::number("regularisation_m_per_s", "m/s", Domain::Positive, (1e-7, 1e-3), Scale::Log)
            .usually(Usual::ByKind(2e-6, 1e-4)),
    ],
    equation: |v| {
        let (force, scale) = (v.number("force_n"), v.number("regularisation_m_per_s"));
        format!("… + c q̇ + {force:.4} N · tanh(q̇ / {scale:.1e} m/s) = …, q = {}", v.component().symbols())
    },
    apply: |v, plan| {
        let (size, per_speed) = (v.number("force_n"), 1.0 / v.number("regularisation_m_per_s"));
        if size == 0.0 {
            return;
        }
        let part = plan.component(v.component());
        plan.declare_rate(size * per_speed / part.mass);
        part.law(plan, move |_, v| -size * (v * per_speed).tanh());
    },
};
