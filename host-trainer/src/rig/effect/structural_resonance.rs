//! A mode that the rig has not, between the measured mass and the sensor: a bracket, a cover.
//!
//! The mode is driven by the measured mass and too light to act back on it: with a its acceleration and η the mode's
//! displacement relative to it, η̈ + 2ζω₀ η̇ + ω₀² η = −a, and the sensor gives a + g η̈ (D. J. Ewins, "Modal Testing",
//! 2000, section 2.4; C. M. Harris, A. G. Piersol, "Shock and Vibration Handbook", chapter 2). g is how much of the
//! mode the sensor sees: the vocabulary leaves it out, 1 is the whole of it. The recurrence is exact for an
//! acceleration that goes in a straight line from one sample to the next.

use std::f64::consts::TAU;

use super::{Applies, Definition, Parameter, Scale, Usual};
use crate::rig::{config::Domain, plan::Stage};

/// Time constants of the mode that are passed before the first sample.
const SETTLED: f64 = 12.0;

pub(super) const EFFECT: Definition = Definition {
    name: "structural-resonance",
    applies_to: Applies::Both,
    parameters: &[
        Parameter::number("frequency_hz", "Hz", Domain::Positive, (10.0, 2e4), Scale::Log),
        Parameter::number("damping_ratio", "", Domain::Between(0.0, 1.0), (1e-3, 0.3), Scale::Log),
        Parameter::number("gain", "", Domain::Any, (-10.0, 10.0), Scale::Linear).usually(Usual::Number(1.0)),
    ],
    equation: |v| {
        let (frequency, ratio, gain) = (v.number("frequency_hz"), v.number("damping_ratio"), v.number("gain"));
        format!("a becomes a + {gain:.4} η̈, η̈ + 2 · {ratio:.5} ω₀ η̇ + ω₀² η = −a, ω₀ = 2π · {frequency:.2} Hz")
    },
    apply: |v, plan| {
        let (frequency, ratio, gain) = (v.number("frequency_hz"), v.number("damping_ratio"), v.number("gain"));
        if gain == 0.0 {
            return;
        }
        plan.preroll_s = plan.preroll_s.max(SETTLED / (ratio * TAU * frequency));
        plan.signal(Stage::Structure, move |at, signal| {
            let mode = Mode::new(frequency, ratio, 1.0 / at.sample_rate_hz);
            let (mut state, mut last) = ([0.0, 0.0], signal.first().copied().unwrap_or_default());
            for value in signal {
                let a = *value;
                state = mode.step(state, last, a);
                *value = a + gain * mode.acceleration(state, a);
                last = a;
            }
        });
    },
};

/// η and η̇ from sample to sample: exact for an input that is linear between samples.
struct Mode {
    omega: f64,
    ratio: f64,
    transition: [[f64; 2]; 2],
    slope: [[f64; 2]; 2],
}

impl Mode {
    fn new(frequency: f64, ratio: f64, h: f64) -> Self {
        let omega = TAU * frequency;
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        let decay = (-ratio * omega * h).exp();
        let (s, c) = (damped * h).sin_cos();
        let along = ratio * omega / damped;
        let transition =
            [[decay * (c + along * s), decay * s / damped], [-decay * omega * omega * s / damped, decay * (c - along * s)]];
        // Weights of the input at the start and the end of the step. With the particular solution
        // η = −(a − 2ζ ȧ/ω₀)/ω₀² of a linear input, x⁺ = p⁺ + T (x − p).
        let square = omega * omega;
        let lag = 2.0 * ratio / omega;
        let particular = |at: f64, rate: f64| [-(at - lag * rate) / square, -rate / square];
        let weight = |from: f64, to: f64| {
            let rate = (to - from) / h;
            let (p, q) = (particular(from, rate), particular(to, rate));
            std::array::from_fn(|i| q[i] - transition[i][0] * p[0] - transition[i][1] * p[1])
        };
        Self { omega, ratio, transition, slope: [weight(1.0, 0.0), weight(0.0, 1.0)] }
    }

    fn step(&self, x: [f64; 2], from: f64, to: f64) -> [f64; 2] {
        std::array::from_fn(|i| {
            let free = self.transition[i][0] * x[0] + self.transition[i][1] * x[1];
            free + self.slope[0][i] * from + self.slope[1][i] * to
        })
    }

    fn acceleration(&self, x: [f64; 2], a: f64) -> f64 {
        -a - 2.0 * self.ratio * self.omega * x[1] - self.omega * self.omega * x[0]
    }
}
