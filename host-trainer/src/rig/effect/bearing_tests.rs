//! What the faults of a bearing must show in a spectrum.

use std::f64::consts::FRAC_PI_2;

use crate::recording::Recording;
use crate::rig::config::ModelKey;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::film::Lubricant;
use crate::rig::random_part::{Asked, random_parts};
use crate::rig::{
    EffectEntry, Machine, Rig, Start, simulate,
    test_support::{RATE, condition, envelope, line, noise_free, nominal, rms, samples, with},
};
use crate::signal::kinematics::Orders;

const SHAFT: f64 = 30.0;

fn orders() -> Orders {
    let Machine::Bearing(rig) = nominal().model else { panic!("a bearing") };
    rig.bearing.geometry().orders()
}

/// Squared envelope of the resonator's band, as envelope analysis demodulates it.
fn demodulated(recording: &Recording) -> Vec<f64> {
    envelope(samples(recording, "ay"), RATE, 4400.0, 6400.0)
}

/// A line's height over the median of its surroundings.
fn prominence(signal: &[f64], frequency: f64) -> f64 {
    let mut around: Vec<f64> = (4..24)
        .flat_map(|k| [frequency - 2.0 * f64::from(k), frequency + 2.0 * f64::from(k)])
        .map(|f| line(signal, RATE, f))
        .collect();
    around.sort_by(f64::total_cmp);
    line(signal, RATE, frequency) / around[around.len() / 2]
}

/// McFadden and Smith (1984): a fixed pit under a fixed load strikes at BPFO, all strikes alike.
#[test]
fn literature_outer_pit_gives_bpfo_and_harmonics() {
    let pit = with(
        EffectKind::OuterRaceDefect,
        &[(ParameterKey::DepthM, 1.2e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.5)],
    );
    let (before, after) = (demodulated(&noise_free(&nominal())), demodulated(&noise_free(&pit)));
    let bpfo = orders().bpfo * SHAFT;
    for harmonic in 1..=4 {
        let frequency = f64::from(harmonic) * bpfo;
        assert!(prominence(&after, frequency) > 20.0, "{harmonic}");
        assert!(line(&after, RATE, frequency) > 100.0 * line(&before, RATE, frequency), "{harmonic}");
    }
    assert!(line(&after, RATE, bpfo) > 10.0 * line(&after, RATE, bpfo + SHAFT), "no shaft sidebands");
    // A pit that no loaded ball crosses is silent.
    let above = with(
        EffectKind::OuterRaceDefect,
        &[(ParameterKey::DepthM, 1.2e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, -1.5)],
    );
    assert!((rms(samples(&noise_free(&above), "ay")) / rms(samples(&noise_free(&nominal()), "ay")) - 1.0).abs() < 1e-6);
}

/// McFadden and Smith (1984): a pit that turns through the load zone strikes at BPFI, modulated by the shaft.
#[test]
fn literature_inner_pit_gives_bpfi_with_shaft_sidebands() {
    let after = demodulated(&noise_free(&with(
        EffectKind::InnerRaceDefect,
        &[(ParameterKey::DepthM, 1.2e-6), (ParameterKey::WidthRad, 0.05)],
    )));
    let bpfi = orders().bpfi * SHAFT;
    for frequency in [SHAFT, bpfi, bpfi - SHAFT, bpfi + SHAFT, 2.0 * bpfi] {
        assert!(prominence(&after, frequency) > 8.0, "{frequency}");
    }
    assert!(line(&after, RATE, bpfi) > 5.0 * line(&after, RATE, orders().bpfo * SHAFT));
}

/// Randall and Antoni (2011), section 2: strikes at 2 × BSF, modulated by the cage.
#[test]
fn literature_ball_pit_gives_twice_bsf_with_cage_sidebands() {
    let after = demodulated(&noise_free(&with(
        EffectKind::BallDefect,
        &[(ParameterKey::DepthM, 1.2e-6), (ParameterKey::WidthRad, 0.2)],
    )));
    let (strikes, cage) = (orders().ball_strikes() * SHAFT, orders().ftf * SHAFT);
    for frequency in [strikes, strikes - cage, strikes + cage] {
        assert!(prominence(&after, frequency) > 8.0, "{frequency}");
    }
    // Only one ball, so the load zone goes by once a turn of the cage.
    assert!(line(&after, RATE, cage) > 5.0 * line(&after, RATE, 1.5 * cage));
}

/// The same as three numbers of lobes.
#[test]
fn invariant_neighbours_are_one_lobe_less_and_more() {
    use ParameterKey::{AboveCos, AboveSin, AmplitudeM, BelowCos, BelowSin, Lobes, PhaseRad};
    let lobes = |rig: Rig, numbers: &[(ParameterKey, f64)]| {
        rig.with_effect(EffectEntry::new(EffectKind::InnerRaceWaviness, numbers))
    };
    let main = [(AmplitudeM, 4e-7), (Lobes, 11.0), (PhaseRad, 0.3)];
    let (s, c) = 0.7f64.sin_cos();
    let beside = [(BelowCos, 0.0), (BelowSin, 0.25), (AboveCos, 0.5 * c), (AboveSin, -0.5 * s)];
    let together = noise_free(&lobes(nominal(), &[main.as_slice(), &beside].concat()));
    // sin x = cos(x − π/2).
    let apart = lobes(nominal(), &main);
    let apart = lobes(apart, &[(AmplitudeM, 1e-7), (Lobes, 10.0), (PhaseRad, -FRAC_PI_2)]);
    let apart = noise_free(&lobes(apart, &[(AmplitudeM, 2e-7), (Lobes, 12.0), (PhaseRad, 0.7)]));
    let pairs = samples(&together, "ay").iter().zip(samples(&apart, "ay"));
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-9) && pairs.clone().any(|(a, _)| a.abs() > 1e-3));
}

/// Wardle (1988), table 1: lobes of a multiple of the number of balls, or one off.
#[test]
fn literature_waviness_lines() {
    let before = noise_free(&nominal());
    let (bpfo, bpfi) = (orders().bpfo * SHAFT, orders().bpfi * SHAFT);
    for (name, lobes, frequency) in [
        (EffectKind::OuterRaceWaviness, 9.0, bpfo),
        (EffectKind::OuterRaceWaviness, 18.0, 2.0 * bpfo),
        (EffectKind::OuterRaceWaviness, 10.0, bpfo),
        (EffectKind::InnerRaceWaviness, 9.0, bpfi),
        (EffectKind::InnerRaceWaviness, 10.0, bpfi + SHAFT),
        (EffectKind::InnerRaceWaviness, 8.0, bpfi - SHAFT),
    ] {
        let after = noise_free(&with(name, &[(ParameterKey::AmplitudeM, 1e-6), (ParameterKey::Lobes, lobes)]));
        let [after, before] = [&after, &before]
            .map(|r| line(samples(r, "ax"), RATE, frequency) + line(samples(r, "ay"), RATE, frequency));
        assert!(after > 5.0 * before, "{name} of {lobes} at {frequency} Hz: {after} beside {before}");
    }
}

/// Tiwari et al. (2000): more clearance, a narrower load zone, more vibration at BPFO.
#[test]
fn literature_clearance_raises_bpfo() {
    let bpfo = orders().bpfo * SHAFT;
    let at = |clearance| {
        line(
            samples(
                &noise_free(&with(EffectKind::ExcessClearance, &[(ParameterKey::RadialClearanceM, clearance)])),
                "ax",
            ),
            RATE,
            bpfo,
        )
    };
    let heights = [2e-6, 1e-5, 3e-5].map(at);
    assert!(heights[0] < heights[1] && heights[1] < heights[2], "{heights:?}");
}

#[test]
fn invariant_cage_slip_moves_bpfo_and_leaves_the_shaft() {
    let pit = EffectEntry::new(
        EffectKind::OuterRaceDefect,
        &[(ParameterKey::DepthM, 1.2e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.5)],
    );
    let slip = EffectEntry::new(EffectKind::CageSlip, &[(ParameterKey::Fraction, 0.1)]);
    let rig = nominal().with_effect(pit);
    let (before, after) = (noise_free(&rig), noise_free(&rig.clone().with_effect(slip)));
    let bpfo = orders().bpfo * SHAFT;
    let (old, new) = (demodulated(&before), demodulated(&after));
    assert!(prominence(&old, bpfo) > 20.0 && prominence(&old, 0.9 * bpfo) < 5.0);
    assert!(prominence(&new, 0.9 * bpfo) > 20.0 && prominence(&new, bpfo) < 5.0);
    assert_eq!(samples(&after, "tacho"), samples(&before, "tacho"));
}

/// At one speed and load a film is so much less clearance, in a run and in the linearised rig.
#[test]
fn invariant_a_film_is_less_clearance() {
    let condition = condition(SHAFT, 500.0, 2000);
    let Machine::Bearing(machine) = nominal().model else { panic!("a bearing") };
    let oil = Lubricant { viscosity_pa_s: 0.1, pressure_viscosity_per_pa: 2e-8 };
    let films = oil.thickness_m(&machine.bearing, condition.shaft_hz, condition.load_n);
    assert!(films[0] > 1e-7 && films[1] > films[0], "{films:?}");
    let film = with(EffectKind::LubricantFilm, &[(ParameterKey::ViscosityPaS, 0.1)]);
    let left = machine.bearing.radial_clearance_m - (films[0] + films[1]);
    let tight = with(EffectKind::ExcessClearance, &[(ParameterKey::RadialClearanceM, left)]);
    let run = |rig: &Rig| simulate(rig, &condition, &Start::seeded(3)).unwrap();
    assert_eq!(run(&film), run(&tight));
    assert_ne!(run(&film), run(&nominal()));
    let random =
        |rig: &Rig| random_parts(&[Asked { rig, condition, known: None }]).remove(0).unwrap().process.responses;
    assert_eq!(random(&film), random(&tight));
}

#[test]
fn invariant_contact_exponent_is_the_rigs_own() {
    let mut rig = nominal();
    rig.set(ModelKey::ContactExponent, 1.3).unwrap();
    assert_eq!(noise_free(&with(EffectKind::ContactExponent, &[(ParameterKey::Exponent, 1.3)])), noise_free(&rig));
    // With the nominal force at 20 µm.
    let stiffness = nominal().bearing().unwrap().bearing.contact_stiffness_n_per_m1_5;
    rig.set(ModelKey::ContactStiffness, stiffness * 2e-5f64.powf(1.5 - 1.3)).unwrap();
    let numbers = [(ParameterKey::Exponent, 1.3), (ParameterKey::DeflectionM, 2e-5)];
    assert_eq!(noise_free(&with(EffectKind::ContactExponent, &numbers)), noise_free(&rig));
    // A power by another way, next to the square root.
    let near = noise_free(&with(EffectKind::ContactExponent, &[(ParameterKey::Exponent, 1.5 + 1e-13)]));
    let same = noise_free(&nominal());
    let pairs = samples(&near, "ay").iter().zip(samples(&same, "ay"));
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-9));
}
