use crate::rig::config::ModelKey;
use crate::rig::effect::{EffectKind, ParameterKey};
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::config::BearingRig;
use super::noise;
use super::simulate::simulate_altered;
use super::state::{DOFS, INNER_X, INNER_Y, OUTER_X, OUTER_Y};
use super::{
    EffectEntry, OperatingCondition, Rig, RigError, Run, Start, simulate, simulate_many,
    test_support::{RATE, condition, noise_free, nominal, parse, rms, samples, with},
};
use crate::recording::reference_data;

/// Trajectories of an independent implementation at 64 steps of RK4 a sample; each file's first line holds its
/// operating condition and start. Exact to 1e-8 m/s².
#[test]
fn golden_reference_trajectories() {
    let Some(folder) = reference_data::folder("rig-reference") else {
        return;
    };
    for name in ["rigA_0", "rigA_1", "rigB_0", "rigB_1"] {
        let rig = Rig::read(&folder.join(format!("{}.toml", &name[..4]))).unwrap();
        let text = fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
        let stated = |key: &str| -> f64 {
            let (_, rest) = text.split_once(&format!("{key}=")).unwrap();
            rest.split([' ', '\n']).next().unwrap().parse().unwrap()
        };
        let rows: Vec<Vec<f64>> =
            text.lines().skip(2).map(|row| row.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        let condition = OperatingCondition {
            shaft_hz: stated("shaft_hz"),
            load_n: stated("load_n"),
            sample_rate_hz: RATE,
            samples: rows.len(),
        };
        let error = |substeps| {
            let start = Start { substeps, ..Start::noise_free(stated("cage_angle0_rad"), stated("shaft_angle0_rad")) };
            let recording = simulate(&rig, &condition, &start).unwrap();
            [("ay", 1), ("ax", 2)].map(|(channel, column)| {
                let pairs = samples(&recording, channel).iter().zip(&rows);
                rms(&pairs.map(|(v, row)| v - row[column]).collect::<Vec<_>>())
            })
        };
        let chosen = error(None);
        assert!(chosen.iter().all(|e| *e < 6e-7), "{name}: {chosen:?}");
        let fine = error(Some(16));
        assert!(fine.iter().all(|e| *e < 1.2e-8), "{name}: {fine:?}");
    }
}

/// Local defects that a ball passes in 70 µs, less than two samples, and in four: one step a sample follows them.
#[test]
fn invariant_a_narrow_pit_is_as_fine_steps_have_it() {
    for (name, width) in
        [(EffectKind::BallDefect, 0.03), (EffectKind::OuterRaceDefect, 0.012), (EffectKind::InnerRaceDefect, 0.05)]
    {
        let mut pit = EffectEntry::new(name, &[(ParameterKey::DepthM, 1e-6), (ParameterKey::WidthRad, width)]);
        if name != EffectKind::BallDefect {
            pit = pit.with_number(ParameterKey::AngleRad, 1.6);
        }
        let rig = nominal().with_effect(pit);
        let run = |substeps| {
            let start = Start { substeps, ..Start::noise_free(0.3, 0.7) };
            samples(&simulate(&rig, &condition(30.0, 500.0, 6400), &start).unwrap(), "ay").to_vec()
        };
        let fine = run(Some(64));
        let error = |of: &[f64]| rms(&of.iter().zip(&fine).map(|(a, b)| a - b).collect::<Vec<_>>()) / rms(&fine);
        assert!(error(&run(Some(1))) < 0.003, "{name}: {}", error(&run(Some(1))));
    }
}

#[test]
fn invariant_side_by_side_is_one_after_the_other() {
    let mut rigs = vec![nominal(); 11];
    for (k, rig) in rigs.iter_mut().enumerate() {
        rig.set(ModelKey::OuterMass, 10.0 + k as f64).unwrap();
    }
    rigs[4] = rigs[4].clone().with_effect(EffectEntry::new(EffectKind::Misalignment, &[(ParameterKey::ForceN, 20.0)]));
    rigs[5] = rigs[5].clone().with_effect(EffectEntry::new(EffectKind::SpeedDrift, &[(ParameterKey::RatePerS, 0.1)]));
    rigs[6].set(ModelKey::ContactExponent, 1.4).unwrap();
    rigs[7].set(ModelKey::Balls, 8.0).unwrap();
    let runs: Vec<_> = rigs
        .iter()
        .enumerate()
        .map(|(k, rig)| Run {
            rig,
            condition: condition(25.0 + k as f64, 450.0, 700),
            start: Start { settle_s: 0.02, ..Start::seeded(k as u64) },
        })
        .collect();
    let many = simulate_many(&runs).unwrap();
    for (run, recording) in runs.iter().zip(&many) {
        assert_eq!(&simulate(run.rig, &run.condition, &run.start).unwrap(), recording, "{:?}", run.start);
    }
}

#[test]
fn invariant_the_seed_is_the_run() {
    let run = |seed| simulate(&nominal(), &condition(30.0, 500.0, 600), &Start::seeded(seed)).unwrap();
    assert_eq!(run(3), run(3));
    assert_ne!(samples(&run(3), "ax"), samples(&run(4), "ax"));
    // Sensor noise does not depend on the process force.
    let mut quiet = nominal();
    quiet.set(ModelKey::ProcessForce, 0.0).unwrap();
    let noisy = simulate(&quiet, &condition(30.0, 500.0, 4000), &Start::seeded(3)).unwrap();
    let clean = simulate(&quiet, &condition(30.0, 500.0, 4000), &Start { noise: false, ..Start::seeded(3) }).unwrap();
    let noise: Vec<_> = samples(&noisy, "ax").iter().zip(samples(&clean, "ax")).map(|(a, b)| a - b).collect();
    assert!((rms(&noise) / 0.02 - 1.0).abs() < 0.05, "{}", rms(&noise));
}

/// Above its resonances the housing is a free mass: its acceleration has the force's spectrum over m².
#[test]
fn literature_process_force_has_its_density() {
    let mut rig = parse(&super::test_support::RIG.replace("\"resonator-y\"", "\"outer-y\""));
    for (key, value) in [(ModelKey::SensorNoise, 0.0), (ModelKey::ProcessForce, 4e-3)] {
        rig.set(key, value).unwrap();
    }
    // A soft resonator leaves the housing alone.
    rig.set(ModelKey::ResonatorStiffness, 1e3).unwrap();
    rig.set(ModelKey::ResonatorDamping, 0.0).unwrap();
    let count = 16_384;
    let recording = simulate(&rig, &condition(0.0, 500.0, count), &Start::seeded(1)).unwrap();
    let ay = samples(&recording, "ay");
    let bins: Vec<f64> =
        (2500..3500).map(|k| super::test_support::line(ay, RATE, k as f64 * RATE / count as f64).powi(2)).collect();
    // A Hann-windowed line amplitude A of noise: E[A²] = 4 · 1.5 · PSD · rate / N / 2.
    let density = bins.iter().sum::<f64>() / bins.len() as f64 * count as f64 / (RATE * 3.0);
    let expected = 4e-3 / 12.638f64.powi(2);
    // A free mass has the force's own value at the start of each sample, so the hold costs nothing. The springs still
    // add 1 % at these frequencies.
    assert!((density / expected - 1.0).abs() < 0.1, "{}", density / expected);
}

#[test]
fn invariant_tachometer_marks_each_turn() {
    let recording = noise_free(&nominal());
    let marks: Vec<usize> =
        samples(&recording, "tacho").iter().enumerate().filter(|(_, v)| **v == 1.0).map(|(i, _)| i).collect();
    assert_eq!(marks.len(), 15);
    // 0.7 rad at t = 0: the first turn ends (2π − 0.7)/(2π · 30 Hz) later, the others 853⅓ samples apart.
    assert_eq!(marks[0], 759);
    assert!(marks.windows(2).all(|w| w[1] - w[0] == 853 || w[1] - w[0] == 854));
}

#[test]
fn invariant_energy_decays_without_excitation() {
    // Shaft at rest, a blow to the housing: nothing feeds the rig after it.
    let rig = nominal().with_effect(EffectEntry::new(
        EffectKind::Shock,
        &[(ParameterKey::TimeS, 0.0), (ParameterKey::ImpulseNS, 0.05)],
    ));
    let recording = simulate(&rig, &condition(0.0, 500.0, 12_800), &Start::noise_free(0.3, 0.7)).unwrap();
    let windows: Vec<f64> = samples(&recording, "ay").chunks(1280).map(rms).collect();
    assert!(windows.windows(2).take(4).all(|w| w[1] < 0.1 * w[0]), "{windows:?}");
    assert!(windows[9] < 1e-10 * windows[0], "{windows:?}");
}

/// A load that comes at once swings a softening spring past its summit.
#[test]
fn invariant_a_run_starts_where_the_rig_rests() {
    let softening = EffectEntry::new(EffectKind::SofteningStiffness, &[(ParameterKey::CubicNPerM3, -4.5e15)])
        .with_text(ParameterKey::Component, "outer");
    let pushed = with(EffectKind::ConstantForce, &[(ParameterKey::ForceN, 200.0), (ParameterKey::AngleRad, 0.5)]);
    for rig in [nominal(), nominal().with_effect(softening), pushed] {
        let start = Start { settle_s: 0.0, ..Start::noise_free(0.3, 0.7) };
        let recording = simulate(&rig, &condition(0.0, 500.0, 2000), &start).unwrap();
        // Without effects the balance is that in y; a load that comes at once shakes the housing with 100 m/s².
        let most = |channel| samples(&recording, channel).iter().fold(0.0, |most: f64, a| most.max(a.abs()));
        let bound = if rig.effects.is_empty() { 1.0 } else { 1e-6 };
        assert!(most("ax") < bound && most("ay") < bound, "{} {}", most("ax"), most("ay"));
    }
}

#[test]
fn golden_impossible_conditions_are_refused() {
    let refused = |condition| simulate(&nominal(), &condition, &Start::seeded(0)).unwrap_err().to_string();
    let good = condition(30.0, 500.0, 10);
    assert!(refused(OperatingCondition { samples: 0, ..good }).contains("samples: found 0, expected at least 1"));
    assert!(refused(OperatingCondition { shaft_hz: -1.0, ..good }).contains("shaft_hz: found -1"));
    assert!(refused(OperatingCondition { load_n: f64::NAN, ..good }).contains("load_n: found NaN"));
    let sdof = parse(super::test_support::SDOF);
    let error = simulate(&sdof, &good, &Start::seeded(0)).unwrap_err().to_string();
    assert!(error.contains("recorded input"), "{error}");
}

#[test]
fn invariant_divergence_is_an_error() {
    let runaway = EffectEntry::new(EffectKind::SofteningStiffness, &[(ParameterKey::CubicNPerM3, -1e18)])
        .with_text(ParameterKey::Component, "outer");
    let error = simulate(&nominal().with_effect(runaway), &condition(30.0, 500.0, 6000), &Start::seeded(0));
    assert!(error.unwrap_err().to_string().contains("diverged"));
}

/// Contact force on the inner race in x and y, N: theory (29) and (30) of balls at given angles.
fn contact_n(rig: &BearingRig, q: &[f64; DOFS], balls: impl Iterator<Item = (f64, f64)>) -> [f64; 2] {
    let (x, y) = (q[INNER_X] - q[OUTER_X], q[INNER_Y] - q[OUTER_Y]);
    balls.fold([0.0; 2], |[fx, fy], (angle, size)| {
        let (s, c) = angle.sin_cos();
        let deflection = (x * c + y * s - rig.bearing.radial_clearance_m + size).max(0.0);
        let force = rig.bearing.contact_stiffness_n_per_m1_5 * deflection.powf(rig.bearing.contact_exponent);
        [fx - force * c, fy - force * s]
    })
}

/// Holds uneven balls, by angle and size less their means, against a force of their contacts less that of even balls, over several
/// turns of the cage.
fn assert_as_by_contact_forces(start: Start) {
    let (rig, condition) = (nominal(), condition(30.0, 500.0, 8000));
    let drawn = |stream: u64, deviation: f64| {
        let drawn = noise::white(start.seed, stream, deviation, 9);
        let mean = drawn.iter().sum::<f64>() / 9.0;
        drawn.into_iter().map(|v| v - mean).collect::<Vec<f64>>()
    };
    let (places, sizes) = (drawn(noise::BALLS, start.ball_std_rad), drawn(noise::BALL_SIZES, start.ball_std_m));
    let machine = rig.bearing().unwrap().clone();
    let alike = Start { ball_std_rad: 0.0, ball_std_m: 0.0, ..start };
    let by_force = simulate_altered(&rig, &condition, &alike, &|assembly| {
        let (machine, places, sizes) = (machine.clone(), places.clone(), sizes.clone());
        assembly.force(move |at, q, _, forces| {
            let even = |ball: usize| at.cage_rad + std::f64::consts::TAU * ball as f64 / 9.0;
            let uneven = contact_n(&machine, q, (0..9).map(|ball| (even(ball) + places[ball], sizes[ball])));
            let even = contact_n(&machine, q, (0..9).map(|ball| (even(ball), 0.0)));
            for (axis, [inner, outer]) in [[INNER_X, OUTER_X], [INNER_Y, OUTER_Y]].into_iter().enumerate() {
                forces[inner] += uneven[axis] - even[axis];
                forces[outer] -= uneven[axis] - even[axis];
            }
        });
    })
    .unwrap();
    let own = simulate(&rig, &condition, &start).unwrap();
    let even = simulate(&rig, &condition, &alike).unwrap();
    for channel in ["ax", "ay"] {
        let off = |other: &_| {
            rms(&samples(&own, channel).iter().zip(samples(other, channel)).map(|(a, b)| a - b).collect::<Vec<_>>())
        };
        assert!(off(&by_force) < 1e-3 * off(&even), "{channel}: {} of {}", off(&by_force), off(&even));
    }
}

/// A force that drives the housing away without bound is asked for no longer than until there are no numbers.
#[test]
fn invariant_a_run_that_has_diverged_ends() {
    let asked = Arc::new(AtomicUsize::new(0));
    let start = Start { substeps: Some(4), ..Start::noise_free(0.3, 0.7) };
    let counted = Arc::clone(&asked);
    let error = simulate_altered(&nominal(), &condition(30.0, 500.0, 8000), &start, &|assembly| {
        let asked = Arc::clone(&counted);
        assembly.force(move |_, q, _, forces| {
            asked.fetch_add(1, Ordering::Relaxed);
            forces[OUTER_Y] += 1e30 * q[OUTER_Y].powi(3);
        });
    });
    assert!(matches!(error, Err(RigError::Diverged { .. })));
    // Four a step, of 4 × 8000 and those of the settling.
    let asked = asked.load(Ordering::Relaxed);
    assert!(asked < 4 * 4 * 8000 / 10, "{asked}");
}

#[test]
fn invariant_uneven_balls_are_where_their_contact_forces_put_them() {
    let start = Start { substeps: Some(4), ..Start::noise_free(0.3, 0.7) };
    assert_as_by_contact_forces(Start { ball_std_rad: 3e-3, ..start });
    assert_as_by_contact_forces(Start { ball_std_m: 1e-7, ..start });
}
