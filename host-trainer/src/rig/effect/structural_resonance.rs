//! A mode of the structure that the rig has not, of the housing or a bracket on it, theory (48).
//!
//! The bearing's force excites it in addition to the rig's modes, and its acceleration at the sensor adds to theirs:
//! modal superposition (D. J. Ewins, "Modal Testing: Theory, Practice and Application", 2000, section 2.4). With f the
//! force that the bearing passes to the housing in the sensor's direction and m_p the housing's mass,
//! η̈ + 2ζω₀ η̇ + ω₀² η = f/m_p, and the sensor gives a + g η̈. g, the modal constant as a multiple of 1/m_p, has either
//! sign, as sensor and bearing can be on two sides of a node; the vocabulary leaves it out. The mode does not act back
//! on the bearing. Its source may also be the bearing's force across the sensor, or the sensor's own acceleration, as of
//! a bracket that the sensor sits on. The sensor across may have the same η by a constant of its own. For an sdof rig f/m_p is q̈, and the sensor gives q + g η, q̇ + g η̇ or q̈ + g η̈. The recurrence is exact for a force that goes in a straight line from
//! one sample to the next.

use std::f64::consts::TAU;

use super::{
    Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing,
    component::Component,
};
use crate::rig::{
    assembly::Stage,
    config::{Domain, RigKind},
};

/// Time constants of the mode that pass before the first sample.
const SETTLED: f64 = 12.0;

pub(super) const EFFECT: Definition = Definition {
    name: "structural-resonance",
    rigs: Rigs::Both,
    site: Site::Structure,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::FrequencyHz, "Hz", Domain::Positive, (10.0, 2e4), Scale::Log),
        Parameter::number(ParameterKey::DampingRatio, "", Domain::Between(0.0, 1.0), (1e-3, 0.3), Scale::Log),
        Parameter::number(ParameterKey::Gain, "", Domain::Any, (-30.0, 30.0), Scale::Linear)
            .usually(ParameterDefault::Number(1.0)),
        Parameter::number(ParameterKey::GainAcross, "", Domain::Any, (-30.0, 30.0), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
        Parameter::channel("ay"),
        Parameter::source(),
    ],
    library: LibraryTerms::MODE,
    equation: |v| {
        let (frequency, ratio, gain) =
            (v.number(ParameterKey::FrequencyHz), v.number(ParameterKey::DampingRatio), v.number(ParameterKey::Gain));
        let across = match v.number(ParameterKey::GainAcross) {
            0.0 => String::new(),
            across => format!(", a_⊥ becomes a_⊥ + {across:.4} η̈"),
        };
        format!(
            "a becomes a + {gain:.4} η̈{across}, η̈ + 2 · {ratio:.5} ω₀ η̇ + ω₀² η = f/m_p, ω₀ = 2π · {frequency:.2} Hz"
        )
    },
    apply: |v, assembly| {
        let (frequency, ratio, gain) =
            (v.number(ParameterKey::FrequencyHz), v.number(ParameterKey::DampingRatio), v.number(ParameterKey::Gain));
        let gain_across = v.number(ParameterKey::GainAcross);
        if gain == 0.0 && gain_across == 0.0 {
            return;
        }
        let (concerns, source) = (v.channels(), v.source());
        let carrier = if v.kind() == RigKind::Sdof { Component::Mass } else { Component::Outer };
        let per_mass = 1.0 / carrier.part_of(&assembly.machine).mass;
        assembly.needs_path_force = true;
        assembly.preroll_s = assembly.preroll_s.max(SETTLED / (ratio * TAU * frequency));
        assembly.signal(Stage::Structure, move |at, signal| {
            let is_own = concerns(at.channel);
            let gain = if is_own { gain } else { gain_across };
            if gain == 0.0 || at.channel == "u" {
                return;
            }
            let mode = Mode::new(frequency, ratio, 1.0 / at.sample_rate_hz);
            let accelerations = |forces: &[f64]| forces.iter().map(|f| f * per_mass).collect();
            // Along the other sensor is across this one.
            let driving: Vec<f64> = match (source, is_own) {
                (Source::Along, true) | (Source::Across, false) => accelerations(at.path_force),
                (Source::Across, true) | (Source::Along, false) => accelerations(at.across_force),
                (Source::Motion, true) => signal.clone(),
                (Source::Motion, false) => at.across.to_vec(),
            };
            // From rest under the first force, or its static part would ring.
            let mut last = driving.first().copied().unwrap_or_default();
            let mut state = [last / (mode.omega * mode.omega), 0.0];
            for (value, force) in signal.iter_mut().zip(driving) {
                state = mode.step(state, last, force);
                *value += gain
                    * match at.channel {
                        "q" => state[0],
                        "qd" => state[1],
                        _ => mode.acceleration(state, force),
                    };
                last = force;
            }
        });
    },
};

/// What excites a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The bearing's force in the sensor's direction.
    Along,
    /// The bearing's force across it.
    Across,
    /// The sensor's own acceleration.
    Motion,
}

/// η and η̇ from sample to sample.
struct Mode {
    omega: f64,
    ratio: f64,
    transition: [[f64; 2]; 2],
    /// Weights of the force at the start and the end of the step.
    weights: [[f64; 2]; 2],
}

impl Mode {
    fn new(frequency: f64, ratio: f64, h: f64) -> Self {
        let omega = TAU * frequency;
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        let decay = (-ratio * omega * h).exp();
        let (s, c) = (damped * h).sin_cos();
        let along = ratio * omega / damped;
        let transition = [
            [decay * (c + along * s), decay * s / damped],
            [-decay * omega * omega * s / damped, decay * (c - along * s)],
        ];
        // x⁺ = p⁺ + T (x − p) with the particular solution η = (f − 2ζ ḟ/ω₀)/ω₀² of a linear force.
        let square = omega * omega;
        let particular = |f: f64, rate: f64| [(f - 2.0 * ratio / omega * rate) / square, rate / square];
        let weight = |from: f64, to: f64| {
            let rate = (to - from) / h;
            let (p, q) = (particular(from, rate), particular(to, rate));
            std::array::from_fn(|i| q[i] - transition[i][0] * p[0] - transition[i][1] * p[1])
        };
        Self { omega, ratio, transition, weights: [weight(1.0, 0.0), weight(0.0, 1.0)] }
    }

    fn step(&self, x: [f64; 2], from: f64, to: f64) -> [f64; 2] {
        std::array::from_fn(|i| {
            let free = self.transition[i][0] * x[0] + self.transition[i][1] * x[1];
            free + self.weights[0][i] * from + self.weights[1][i] * to
        })
    }

    fn acceleration(&self, x: [f64; 2], force: f64) -> f64 {
        force - 2.0 * self.ratio * self.omega * x[1] - self.omega * self.omega * x[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At resonance the acceleration is 1/(2ζ) of the force, a quarter turn ahead (Ewins, section 2.2).
    #[test]
    fn literature_mode_at_resonance() {
        let (frequency, ratio, rate) = (500.0, 0.02, 100_000.0);
        let mode = Mode::new(frequency, ratio, 1.0 / rate);
        let (mut x, mut last, mut peak) = ([0.0; 2], 0.0, 0.0f64);
        for k in 1..100_000 {
            let force = (TAU * frequency * k as f64 / rate).sin();
            x = mode.step(x, last, force);
            last = force;
            if k > 90_000 {
                peak = peak.max(mode.acceleration(x, force));
            }
        }
        assert!((peak * 2.0 * ratio - 1.0).abs() < 2e-3, "{peak}");
    }
}
