use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::{PI, TAU};

use super::{Drive, Interpolation, simulate};
use crate::recording::{LoadOptions, load, reference_data};
use crate::rig::{
    EffectEntry, Rig,
    test_support::{SDOF, parse, rms, samples},
};

const RATE: f64 = 1000.0;

fn free(rig: &Rig, position: f64, count: usize) -> Vec<f64> {
    let drive = Drive { input: &vec![0.0; count], sample_rate_hz: RATE, position, ..Drive::default() };
    samples(&simulate(rig, &drive).unwrap(), "q").to_vec()
}

/// First index at which the motion comes back through zero upwards, between samples.
fn period(q: &[f64]) -> f64 {
    let ups: Vec<f64> =
        (1..q.len()).filter(|&k| q[k - 1] < 0.0 && q[k] >= 0.0).map(|k| k as f64 - q[k] / (q[k] - q[k - 1])).collect();
    (ups[1] - ups[0]) / RATE
}

/// Free oscillation of 2 kg on 800 N/m: 20 rad/s.
#[test]
fn literature_linear_oscillator() {
    let q = free(&parse(SDOF), 0.1, 2000);
    let worst = q.iter().enumerate().map(|(k, q)| (q - 0.1 * (20.0 * k as f64 / RATE).cos()).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-7, "{worst}");
    // A constant force and a held input shift the rest position: (gain u + gravity)/k.
    let rig = parse(
        &SDOF
            .replace("gravity_n = 0.0", "gravity_n = 2.0")
            .replace("damping_n_s_per_m = 0.0", "damping_n_s_per_m = 60.0"),
    );
    let drive = Drive { input: &vec![2.0; 4000], sample_rate_hz: RATE, ..Drive::default() };
    let recording = simulate(&rig, &drive).unwrap();
    assert!((samples(&recording, "q")[3999] - 8.0 / 800.0).abs() < 1e-12);
    assert!(samples(&recording, "qdd")[0] == 4.0 && samples(&recording, "qdd")[3999].abs() < 1e-9);
}

/// Period of a pendulum let go at 90°: 1.180 340 6 that of small swings (2K(sin 45°)/π, Abramowitz and Stegun 17.3).
#[test]
fn literature_pendulum_period() {
    let rig = parse(&SDOF.replace("linear", "pendulum"));
    assert!((period(&free(&rig, 0.5 * PI, 2000)) / (TAU / 20.0) - 1.180_340_6).abs() < 2e-5);
    assert!((period(&free(&rig, 1e-3, 2000)) / (TAU / 20.0) - 1.0).abs() < 2e-5);
}

/// Dry friction takes 4 F/k of the amplitude each period, and stops the mass within F/k of zero (Den Hartog, 1931).
#[test]
fn literature_coulomb_decay() {
    let friction = EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 4.0)]);
    let q = free(&parse(SDOF).with_effect(friction), 0.1, 4000);
    let a_period = (TAU / 20.0 * RATE).round() as usize;
    assert!((q[0] - q[a_period] - 0.02).abs() < 3e-4, "{}", q[0] - q[a_period]);
    assert!((q[a_period] - q[2 * a_period] - 0.02).abs() < 3e-4);
    assert!(q[3000..].iter().all(|q| q.abs() < 0.0055));
}

/// Thrown against a stop, a free mass is back after half a period of mass and stop: π √(m/k) (Shaw and Holmes, 1983).
#[test]
fn literature_time_at_a_stop() {
    let rig = parse(&SDOF.replace("stiffness_n_per_m = 800.0", "stiffness_n_per_m = 0.0"));
    let rig = rig.with_effect(EffectEntry::new(
        EffectKind::EndStopContact,
        &[(ParameterKey::GapM, 0.01), (ParameterKey::StiffnessNPerM, 5000.0)],
    ));
    let drive = Drive { input: &[0.0; 300], sample_rate_hz: RATE, velocity: 0.2, ..Drive::default() };
    let recording = simulate(&rig, &drive).unwrap();
    let touching = samples(&recording, "qdd").iter().filter(|a| **a != 0.0).count() as f64 / RATE;
    assert!((touching - PI * (2.0f64 / 5000.0).sqrt()).abs() < 1.5e-3, "{touching}");
    assert!((samples(&recording, "qd")[299] + 0.2).abs() < 1e-5);
}

/// A stop with a damper that does not pull gives back the share exp[−(β/ω)(π − arctan(2βω/(ω² − β²)))] of the speed, β = c/2m and
/// ω² = k/m − β² (T. Schwager, T. Pöschel, "Coefficient of restitution and linear-dashpot model revisited", Granular Matter 9
/// (2007) 465–469).
#[test]
fn literature_restitution_of_a_damped_stop() {
    let rig = parse(&SDOF.replace("stiffness_n_per_m = 800.0", "stiffness_n_per_m = 0.0"));
    let numbers =
        [(ParameterKey::GapM, 0.01), (ParameterKey::StiffnessNPerM, 5000.0), (ParameterKey::DampingNSPerM, 40.0)];
    let rig = rig.with_effect(EffectEntry::new(EffectKind::EndStopContact, &numbers));
    let drive = Drive { input: &[0.0; 300], sample_rate_hz: RATE, velocity: 0.2, ..Drive::default() };
    let recording = simulate(&rig, &drive).unwrap();
    let beta = 40.0 / (2.0 * 2.0);
    let omega = (5000.0f64 / 2.0 - beta * beta).sqrt();
    let share = (-beta / omega * (PI - (2.0 * beta * omega / (omega * omega - beta * beta)).atan())).exp();
    let back = -samples(&recording, "qd")[299] / 0.2;
    assert!((back - share).abs() < 2e-3, "{back} {share}");
    assert!(samples(&recording, "qdd").iter().all(|a| *a <= 0.0));
}

#[test]
fn invariant_input_is_held_or_drawn_straight() {
    let rig = parse(&SDOF.replace("stiffness_n_per_m = 800.0", "stiffness_n_per_m = 0.0"));
    let speed = |interpolation| {
        let drive = Drive { input: &[0.0, 2.0, 2.0], sample_rate_hz: RATE, interpolation, ..Drive::default() };
        samples(&simulate(&rig, &drive).unwrap(), "qd").to_vec()
    };
    let one = 3.0 * 2.0 / 2.0 / RATE;
    let near = |a: Vec<f64>, b: [f64; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15), "{a:?}");
    near(speed(Interpolation::Hold), [0.0, 0.0, one]);
    near(speed(Interpolation::Linear), [0.0, 0.5 * one, 1.5 * one]);
}

#[test]
fn golden_refusals() {
    let refused = |rig: &Rig, input: &[f64]| {
        simulate(rig, &Drive { input, sample_rate_hz: RATE, ..Drive::default() }).unwrap_err().to_string()
    };
    assert!(refused(&parse(SDOF), &[]).contains("input: found no samples"));
    assert!(refused(&parse(SDOF), &[f64::NAN]).contains("input"));
    assert!(refused(&parse(crate::rig::test_support::RIG), &[0.0]).contains("rig.kind: found \"bearing-5dof\""));
}

/// Janot, Gautier, Brunot, "Data set and reference models of EMPS" (2019): M 95.11 kg, F_v 203.5 N s/m, F_c 20.39 N,
/// offset −3.16 N explain the recorded motion. Driven open loop over 25 s, the speed follows the measured one.
#[test]
fn literature_emps_parameters_follow_the_recording() {
    let Some(folder) = reference_data::folder("emps") else {
        return;
    };
    let path = folder.join("DATA_EMPS.mat");
    let read = |variable: &str| {
        let options =
            LoadOptions { variable: Some(variable.into()), sample_rate_hz: Some(RATE), ..LoadOptions::default() };
        load(std::slice::from_ref(&path), &options).unwrap().recordings.remove(0).channels.remove(0).samples
    };
    let (u, position) = (read("vir"), read("qm"));
    let rig = parse(
        "kind = \"sdof\"\nmass_kg = 95.11\ndamping_n_s_per_m = 203.5\nstiffness_n_per_m = 0.0\n\
         input_gain_n_per_unit = 35.15\nrestoring = \"linear\"\ngravity_n = 3.16\n",
    );
    let rig = rig.with_effect(EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 20.39)]));
    let drive = Drive { input: &u, sample_rate_hz: RATE, position: position[0], ..Drive::default() };
    let recording = simulate(&rig, &drive).unwrap();
    let difference: Vec<f64> = samples(&recording, "q")
        .windows(21)
        .zip(position.windows(21))
        .map(|(a, b)| ((a[20] - a[0]) - (b[20] - b[0])) * RATE / 20.0)
        .collect();
    let measured: Vec<f64> = position.windows(21).map(|b| (b[20] - b[0]) * RATE / 20.0).collect();
    let relative = rms(&difference) / rms(&measured);
    assert!(relative < 0.1, "{relative}");
}
