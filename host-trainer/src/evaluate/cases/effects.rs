//! How strong an effect of the vocabulary is, from what an inspection would just miss to what nobody would.
//!
//! Sizes are shares of what the machine itself sets: its load, its deflections, its stiffnesses, its signal.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::{FRAC_PI_2, PI};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::machine::Drawn;
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::config::Support;

/// Effects by the place in the machine where they are; a pair is never of one group.
pub const GROUPS: [&[EffectKind]; 5] = [
    &[
        EffectKind::OuterRaceDefect,
        EffectKind::InnerRaceDefect,
        EffectKind::BallDefect,
        EffectKind::OuterRaceWaviness,
        EffectKind::InnerRaceWaviness,
    ],
    &[
        EffectKind::Unbalance,
        EffectKind::Misalignment,
        EffectKind::LoadStep,
        EffectKind::ConstantForce,
        EffectKind::Shock,
        EffectKind::SpeedDrift,
    ],
    &[
        EffectKind::HardeningStiffness,
        EffectKind::SofteningStiffness,
        EffectKind::AsymmetricStiffness,
        EffectKind::ExcessClearance,
        EffectKind::ContactExponent,
    ],
    &[
        EffectKind::CoulombFriction,
        EffectKind::DampingChange,
        EffectKind::StiffnessChange,
        EffectKind::MassChange,
        EffectKind::ViscousFriction,
    ],
    &[EffectKind::StructuralResonance, EffectKind::SensorBias, EffectKind::SensorGain, EffectKind::MainsInterference],
];

/// Draws an effect `share` of the way from its weakest to its strongest.
pub fn draw(kind: EffectKind, share: f64, drawn: &Drawn, without: &[Recording], rng: &mut ChaCha8Rng) -> EffectEntry {
    let log = |from: f64, to: f64| from * (to / from).powf(share);
    let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
    let machine = &drawn.machine;
    let entry = |numbers: &[(ParameterKey, f64)]| EffectEntry::new(kind, numbers);
    let (load, static_m, seconds) = (drawn.load_n(), drawn.static_m(), drawn.seconds());
    let support = [("inner", &machine.inner), ("outer", &machine.outer)][usize::from(rng.random::<bool>())];
    let phase = rng.random_range(-PI..PI);
    match kind {
        EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect => {
            let pit = entry(&[
                (ParameterKey::DepthM, log(0.3e-6, 4e-6)),
                (ParameterKey::WidthRad, rng.random_range(0.03..0.12)),
            ]);
            match kind {
                EffectKind::OuterRaceDefect => {
                    pit.with_number(ParameterKey::AngleRad, FRAC_PI_2 + rng.random_range(-0.4..0.4))
                }
                EffectKind::InnerRaceDefect => pit.with_number(ParameterKey::AngleRad, phase),
                _ => pit.with_number(ParameterKey::SpinRad, phase),
            }
        }
        EffectKind::OuterRaceWaviness | EffectKind::InnerRaceWaviness => {
            let lobes = rng.random_range(2..=2 * machine.bearing.balls + 1) as f64;
            entry(&[
                (ParameterKey::AmplitudeM, log(0.005, 0.08) * drawn.contact_m()),
                (ParameterKey::Lobes, lobes),
                (ParameterKey::PhaseRad, phase),
            ])
        }
        EffectKind::Unbalance => {
            entry(&[(ParameterKey::UnbalanceKgM, log(1.5, 8.0) * machine.excitation.unbalance_kg_m)])
        }
        EffectKind::Misalignment => {
            entry(&[(ParameterKey::ForceN, log(0.004, 0.1) * load), (ParameterKey::PhaseRad, phase)])
        }
        EffectKind::ExcessClearance => {
            let clearance = machine.bearing.radial_clearance_m + log(0.08, 1.5) * drawn.contact_m();
            entry(&[(ParameterKey::RadialClearanceM, clearance)])
        }
        EffectKind::HardeningStiffness => {
            curved(entry(&[]), ParameterKey::CubicNPerM3, log(0.03, 1.0), support, static_m)
        }
        EffectKind::SofteningStiffness => {
            curved(entry(&[]), ParameterKey::CubicNPerM3, -log(0.03, 0.3), support, static_m)
        }
        EffectKind::AsymmetricStiffness => {
            curved(entry(&[]), ParameterKey::QuadraticNPerM2, sign * log(0.03, 0.5), support, static_m)
        }
        EffectKind::StiffnessChange | EffectKind::DampingChange | EffectKind::MassChange => {
            linear(kind, share, sign, drawn, rng)
        }
        EffectKind::CoulombFriction => {
            let component = ["outer", "inner"][usize::from(rng.random_range(0..4) == 0)];
            entry(&[(ParameterKey::ForceN, log(2e-4, 4e-3) * load)]).with_text(ParameterKey::Component, component)
        }
        EffectKind::ViscousFriction => entry(&[(ParameterKey::DampingNSPerM, log(60.0, 1500.0))]),
        EffectKind::QuadraticDrag => {
            // As much as the damper at some speed of the housing.
            let speed = log(1e-2, 2e-4);
            entry(&[(ParameterKey::DragNS2PerM2, machine.outer.damping_n_s_per_m / speed)])
        }
        EffectKind::EndStopContact => entry(&[
            (ParameterKey::GapM, rng.random_range(0.6..0.98) * static_m),
            (ParameterKey::StiffnessNPerM, log(0.03, 1.0) * machine.outer.stiffness_n_per_m),
        ]),
        EffectKind::Backlash => {
            entry(&[(ParameterKey::WidthM, log(0.05, 1.0) * static_m)]).with_text(ParameterKey::Component, support.0)
        }
        EffectKind::ConstantForce => entry(&[(ParameterKey::ForceN, sign * log(0.015, 0.3) * load)]),
        EffectKind::StructuralResonance => entry(&[
            (ParameterKey::FrequencyHz, 500.0 * 16f64.powf(rng.random())),
            (ParameterKey::DampingRatio, rng.random_range(0.01..0.05)),
            (ParameterKey::Gain, sign * log(1.0, 25.0)),
        ]),
        EffectKind::LoadStep => entry(&[
            (ParameterKey::TimeS, rng.random_range(0.15..0.85) * seconds),
            (ParameterKey::ChangeN, sign * log(0.03, 0.45) * load),
        ]),
        EffectKind::SpeedDrift => entry(&[(ParameterKey::RatePerS, sign * log(0.004, 0.1))]),
        EffectKind::Shock => entry(&[
            (ParameterKey::TimeS, rng.random_range(0.15..0.85) * seconds),
            (ParameterKey::ImpulseNS, log(2e-3, 0.2)),
        ]),
        EffectKind::CageSlip => entry(&[(ParameterKey::Fraction, log(0.003, 0.06))]),
        EffectKind::LubricantFilm => entry(&[(ParameterKey::ViscosityPaS, log(0.01, 1.0))]),
        EffectKind::ContactExponent => {
            entry(&[(ParameterKey::Exponent, machine.bearing.contact_exponent + sign * log(0.005, 0.08))])
        }
        EffectKind::MainsInterference => {
            let frequency = [50.0, 60.0][usize::from(rng.random::<bool>())] + rng.random_range(-0.1..0.1);
            let amplitude = log(0.5, 10.0) * machine.sensor.noise_std_m_per_s2;
            entry(&[
                (ParameterKey::FrequencyHz, frequency),
                (ParameterKey::Amplitude, amplitude),
                (ParameterKey::PhaseRad, phase),
            ])
        }
        EffectKind::SensorBias => {
            entry(&[(ParameterKey::Value, sign * log(0.5, 30.0) * machine.sensor.noise_std_m_per_s2)])
        }
        EffectKind::SensorGain => {
            let channel = ["all", "ax", "ay"][rng.random_range(0..3)];
            entry(&[(ParameterKey::Value, (sign * log(0.03, 0.7)).exp())]).with_text(ParameterKey::Channel, channel)
        }
        EffectKind::RandomForce => {
            entry(&[(ParameterKey::PsdN2PerHz, log(0.3, 30.0) * machine.excitation.process_force_psd_n2_per_hz)])
        }
        EffectKind::TransverseSensitivity => entry(&[(ParameterKey::Value, sign * log(0.05, 0.5))]),
        EffectKind::SensorClipping => entry(&[(ParameterKey::Value, log(0.9, 0.45) * greatest(without))]),
        EffectKind::DroppedSamples => entry(&[
            (ParameterKey::TimeS, rng.random_range(0.15..0.85) * seconds),
            (ParameterKey::Count, log(1.0, 200.0).round()),
        ]),
    }
}

/// A curved spring whose slope at the static deflection differs by a share of its stiffness.
fn curved(
    entry: EffectEntry,
    key: ParameterKey,
    share: f64,
    (component, support): (&str, &Support),
    static_m: f64,
) -> EffectEntry {
    let k = support.stiffness_n_per_m;
    let curvature = if key == ParameterKey::CubicNPerM3 { k / (3.0 * static_m.powi(2)) } else { k / (2.0 * static_m) };
    entry.with_number(key, share * curvature).with_text(ParameterKey::Component, component)
}

fn linear(kind: EffectKind, share: f64, sign: f64, drawn: &Drawn, rng: &mut ChaCha8Rng) -> EffectEntry {
    let machine = &drawn.machine;
    let sections = [("inner", &machine.inner), ("outer", &machine.outer), ("resonator", &machine.resonator)];
    let (component, support) = sections[rng.random_range(0..sections.len())];
    let log = |from: f64, to: f64| (sign * from * (to / from).powf(share)).exp();
    let (component, value) = match kind {
        EffectKind::StiffnessChange if rng.random_range(0..4) == 0 => {
            ("bearing", machine.bearing.contact_stiffness_n_per_m1_5 * log(0.03, 0.5))
        }
        EffectKind::StiffnessChange => (component, support.stiffness_n_per_m * log(0.02, 0.4)),
        EffectKind::DampingChange => (component, support.damping_n_s_per_m * log(0.1, 1.0)),
        _ => (component, support.mass_kg * log(0.02, 0.3)),
    };
    EffectEntry::new(kind, &[(ParameterKey::Value, value)]).with_text(ParameterKey::Component, component)
}

fn greatest(recordings: &[Recording]) -> f64 {
    let all = recordings.iter().filter_map(|r| r.channel("ay")).flat_map(|c| &c.samples);
    all.fold(0.0, |most: f64, v| most.max(v.abs()))
}

/// A name that is the same physics: more damping of a support is viscous friction of it.
pub fn same_as(entry: &EffectEntry) -> Option<EffectKind> {
    (entry.kind == EffectKind::DampingChange).then_some(EffectKind::ViscousFriction)
}
