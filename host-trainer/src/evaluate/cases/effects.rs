//! How strong an effect of the vocabulary is, from what an inspection would just miss to what nobody would.
//!
//! Sizes are shares of what the machine itself sets: its load, its deflections, its stiffnesses, its signal.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::machine::Drawn;
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::config::Support;

/// Effects by the place in the machine where they are; a pair is never of one group.
pub const GROUPS: [&[&str]; 5] = [
    &["outer-race-defect", "inner-race-defect", "ball-defect", "outer-race-waviness", "inner-race-waviness"],
    &["unbalance", "misalignment", "load-step", "constant-force", "shock", "speed-drift"],
    &["hardening-stiffness", "softening-stiffness", "asymmetric-stiffness", "excess-clearance", "contact-exponent"],
    &["coulomb-friction", "damping-change", "stiffness-change", "mass-change", "viscous-friction"],
    &["structural-resonance", "sensor-bias", "sensor-gain", "mains-interference"],
];

/// Draws an effect `share` of the way from its weakest to its strongest.
pub fn draw(name: &str, share: f64, drawn: &Drawn, without: &[Recording], rng: &mut ChaCha8Rng) -> EffectEntry {
    let log = |from: f64, to: f64| from * (to / from).powf(share);
    let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
    let machine = &drawn.machine;
    let entry = |numbers: &[(&str, f64)]| EffectEntry::new(name, numbers);
    let (load, static_m, seconds) = (drawn.load_n(), drawn.static_m(), drawn.seconds());
    let support = [("inner", &machine.inner), ("outer", &machine.outer)][usize::from(rng.random::<bool>())];
    let phase = rng.random_range(-PI..PI);
    match name {
        "outer-race-defect" | "inner-race-defect" | "ball-defect" => {
            let pit = entry(&[("depth_m", log(0.3e-6, 4e-6)), ("width_rad", rng.random_range(0.03..0.12))]);
            match name {
                "outer-race-defect" => pit.with_number("angle_rad", FRAC_PI_2 + rng.random_range(-0.4..0.4)),
                "inner-race-defect" => pit.with_number("angle_rad", phase),
                _ => pit.with_number("spin_rad", phase),
            }
        }
        "outer-race-waviness" | "inner-race-waviness" => {
            let lobes = rng.random_range(2..=2 * machine.bearing.balls + 1) as f64;
            entry(&[("amplitude_m", log(0.005, 0.08) * drawn.contact_m()), ("lobes", lobes), ("phase_rad", phase)])
        }
        "unbalance" => entry(&[("unbalance_kg_m", log(1.5, 8.0) * machine.excitation.unbalance_kg_m)]),
        "misalignment" => entry(&[("force_n", log(0.004, 0.1) * load), ("phase_rad", phase)]),
        "excess-clearance" => {
            let clearance = machine.bearing.radial_clearance_m + log(0.08, 1.5) * drawn.contact_m();
            entry(&[("radial_clearance_m", clearance)])
        }
        "hardening-stiffness" => curved(entry(&[]), "cubic_n_per_m3", log(0.03, 1.0), support, static_m),
        "softening-stiffness" => curved(entry(&[]), "cubic_n_per_m3", -log(0.03, 0.3), support, static_m),
        "asymmetric-stiffness" => curved(entry(&[]), "quadratic_n_per_m2", sign * log(0.03, 0.5), support, static_m),
        "stiffness-change" | "damping-change" | "mass-change" => linear(name, share, sign, drawn, rng),
        "coulomb-friction" => {
            let component = ["outer", "inner"][usize::from(rng.random_range(0..4) == 0)];
            entry(&[("force_n", log(2e-4, 4e-3) * load)]).with_text("component", component)
        }
        "viscous-friction" => entry(&[("damping_n_s_per_m", log(60.0, 1500.0))]),
        "quadratic-drag" => {
            // As much as the damper at some speed of the housing.
            let speed = log(1e-2, 2e-4);
            entry(&[("drag_n_s2_per_m2", machine.outer.damping_n_s_per_m / speed)])
        }
        "end-stop-contact" => entry(&[
            ("gap_m", rng.random_range(0.6..0.98) * static_m),
            ("stiffness_n_per_m", log(0.03, 1.0) * machine.outer.stiffness_n_per_m),
        ]),
        "backlash" => entry(&[("width_m", log(0.05, 1.0) * static_m)]).with_text("component", support.0),
        "constant-force" => entry(&[("force_n", sign * log(0.015, 0.3) * load)]),
        "structural-resonance" => entry(&[
            ("frequency_hz", 500.0 * 16f64.powf(rng.random())),
            ("damping_ratio", rng.random_range(0.01..0.05)),
            ("gain", sign * log(1.0, 25.0)),
        ]),
        "load-step" => {
            entry(&[("time_s", rng.random_range(0.15..0.85) * seconds), ("change_n", sign * log(0.03, 0.45) * load)])
        }
        "speed-drift" => entry(&[("rate_per_s", sign * log(0.004, 0.1))]),
        "shock" => entry(&[("time_s", rng.random_range(0.15..0.85) * seconds), ("impulse_n_s", log(2e-3, 0.2))]),
        "cage-slip" => entry(&[("fraction", log(0.003, 0.06))]),
        "contact-exponent" => entry(&[("exponent", machine.bearing.contact_exponent + sign * log(0.005, 0.08))]),
        "mains-interference" => {
            let frequency = [50.0, 60.0][usize::from(rng.random::<bool>())] + rng.random_range(-0.1..0.1);
            let amplitude = log(0.5, 10.0) * machine.sensor.noise_std_m_per_s2;
            entry(&[("frequency_hz", frequency), ("amplitude", amplitude), ("phase_rad", phase)])
        }
        "sensor-bias" => entry(&[("value", sign * log(0.5, 30.0) * machine.sensor.noise_std_m_per_s2)]),
        "sensor-gain" => {
            let channel = ["all", "ax", "ay"][rng.random_range(0..3)];
            entry(&[("value", (sign * log(0.03, 0.7)).exp())]).with_text("channel", channel)
        }
        "sensor-clipping" => entry(&[("value", log(0.9, 0.45) * greatest(without))]),
        "dropped-samples" => {
            entry(&[("time_s", rng.random_range(0.15..0.85) * seconds), ("count", log(1.0, 200.0).round())])
        }
        // An effect of the vocabulary without a line here is refused by the rig's own check, and by a test.
        _ => entry(&[]),
    }
}

/// A curved spring whose slope at the static deflection differs by a share of its stiffness.
fn curved(
    entry: EffectEntry,
    key: &str,
    share: f64,
    (component, support): (&str, &Support),
    static_m: f64,
) -> EffectEntry {
    let k = support.stiffness_n_per_m;
    let curvature = if key.starts_with("cubic") { k / (3.0 * static_m.powi(2)) } else { k / (2.0 * static_m) };
    entry.with_number(key, share * curvature).with_text("component", component)
}

fn linear(name: &str, share: f64, sign: f64, drawn: &Drawn, rng: &mut ChaCha8Rng) -> EffectEntry {
    let machine = &drawn.machine;
    let sections = [("inner", &machine.inner), ("outer", &machine.outer), ("resonator", &machine.resonator)];
    let (component, support) = sections[rng.random_range(0..sections.len())];
    let log = |from: f64, to: f64| (sign * from * (to / from).powf(share)).exp();
    let (component, value) = match name {
        "stiffness-change" if rng.random_range(0..4) == 0 => {
            ("bearing", machine.bearing.contact_stiffness_n_per_m1_5 * log(0.03, 0.5))
        }
        "stiffness-change" => (component, support.stiffness_n_per_m * log(0.02, 0.4)),
        "damping-change" => (component, support.damping_n_s_per_m * log(0.1, 1.0)),
        _ => (component, support.mass_kg * log(0.02, 0.3)),
    };
    EffectEntry::new(name, &[("value", value)]).with_text("component", component)
}

fn greatest(recordings: &[Recording]) -> f64 {
    let all = recordings.iter().filter_map(|r| r.channel("ay")).flat_map(|c| &c.samples);
    all.fold(0.0, |most: f64, v| most.max(v.abs()))
}

/// A name that is the same physics: more damping of a support is viscous friction of it.
pub fn same_as(entry: &EffectEntry) -> Option<&'static str> {
    (entry.name == "damping-change").then_some("viscous-friction")
}
