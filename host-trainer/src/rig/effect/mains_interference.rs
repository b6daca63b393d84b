//! The electrical line in the cable: its frequency and the odd harmonics that a rectifier's load gives it, 1/n of the
//! fundamental (J. Arrillaga, N. R. Watson, "Power System Harmonics", 2003), in step in all channels.

use std::f64::consts::{PI, TAU};

use super::{Definition, LibraryTerms, Parameter, ParameterDefault, ParameterKey, Phase, Rigs, Scale, Site, Timing};
use crate::rig::{assembly::Stage, config::Domain};

/// Harmonics in addition to the fundamental.
const HARMONICS: [f64; 3] = [1.0, 3.0, 5.0];

pub(super) const EFFECT: Definition = Definition {
    name: "mains-interference",
    rigs: Rigs::Both,
    site: Site::Acquisition,
    timing: Timing::Persistent,
    phase: Phase::Free,
    is_deterministic: false,
    parameters: &[
        Parameter::number(ParameterKey::FrequencyHz, "Hz", Domain::Positive, (45.0, 65.0), Scale::Linear),
        Parameter::number(ParameterKey::Amplitude, "unit of the signal", Domain::NotNegative, (1e-4, 1e2), Scale::Log),
        Parameter::number(ParameterKey::PhaseRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
            .usually(ParameterDefault::Number(0.0)),
        Parameter::channel("all"),
    ],
    library: LibraryTerms::SENSOR,
    equation: |v| {
        let (frequency, amplitude) = (v.number(ParameterKey::FrequencyHz), v.number(ParameterKey::Amplitude));
        format!("a = … + {amplitude:.4e} · Σ sin(n · 2π · {frequency:.3} Hz · t)/n, n = 1, 3, 5")
    },
    apply: |v, assembly| {
        let (frequency, amplitude, phase) =
            (v.number(ParameterKey::FrequencyHz), v.number(ParameterKey::Amplitude), v.number(ParameterKey::PhaseRad));
        if amplitude == 0.0 {
            return;
        }
        let concerns = v.channels();
        assembly.signal(Stage::Cable, move |at, signal| {
            if !concerns(at.channel) {
                return;
            }
            for (index, value) in signal.iter_mut().enumerate() {
                let angle = TAU * frequency * at.time_s(index) + phase;
                *value += amplitude * HARMONICS.iter().map(|n| (n * angle).sin() / n).sum::<f64>();
            }
        });
    },
};
