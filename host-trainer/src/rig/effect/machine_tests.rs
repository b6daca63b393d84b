//! What the other causes must show in a bearing rig.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::recording::Recording;
use crate::rig::config::{ModelKey, RigKind};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::simulate::assemble_in_noise;
use crate::rig::state::{DOFS, Instant, OUTER_X, OUTER_Y, VelocityCovariance};
use crate::rig::{
    EffectEntry, Rig, Start, simulate,
    test_support::{RATE, condition, line, noise_free, nominal, peak, rms, samples, with},
};

fn at_speed(rig: &Rig, shaft_hz: f64) -> Vec<f64> {
    let recording = simulate(rig, &condition(shaft_hz, 500.0, 12_800), &Start::noise_free(0.3, 0.7)).unwrap();
    samples(&recording, "ax").to_vec()
}

/// Frequency at which the housing rings after a blow, shaft at rest: nothing but the mode is in the spectrum.
fn ringing(rig: &Rig, load_n: f64) -> f64 {
    let blow = EffectEntry::new(EffectKind::Shock, &[(ParameterKey::TimeS, 0.0), (ParameterKey::ImpulseNS, 0.002)]);
    let rig = rig.clone().with_effect(blow);
    let recording = simulate(&rig, &condition(0.0, load_n, 4096), &Start::noise_free(0.3, 0.7)).unwrap();
    peak(samples(&recording, "ay"), RATE, 100.0, 500.0)
}

/// Genta (2005): m e ω²; far below resonance the displacement follows the force, the acceleration has ω² more.
#[test]
fn literature_unbalance_grows_with_speed_squared() {
    let response = |unbalance, shaft| {
        let rig = with(EffectKind::Unbalance, &[(ParameterKey::UnbalanceKgM, unbalance)]);
        line(&at_speed(&rig, shaft), RATE, shaft) / (shaft * shaft)
    };
    let ratio = response(1e-3, 20.0) / response(1e-3, 10.0);
    assert!((ratio / 4.0 - 1.0).abs() < 0.05, "{ratio}");
    let ratio = response(1e-3, 20.0) / response(5e-4, 20.0);
    assert!((ratio / 2.0 - 1.0).abs() < 0.02, "{ratio}");
}

/// Xu and Marangoni (1994): twice the shaft speed.
#[test]
fn literature_misalignment_is_at_twice_the_shaft() {
    let (before, after) =
        (at_speed(&nominal(), 30.0), at_speed(&with(EffectKind::Misalignment, &[(ParameterKey::ForceN, 20.0)]), 30.0));
    assert!(line(&after, RATE, 60.0) > 20.0 * line(&before, RATE, 60.0));
    assert!((line(&after, RATE, 30.0) / line(&before, RATE, 30.0) - 1.0).abs() < 0.1);
}

/// Kovacic and Brennan (2011): the slope of a cubic spring rises with the static deflection. The contact's does so
/// too, as Hertz has it, and clearance hardly moves it.
#[test]
fn literature_hardening_raises_the_resonance_with_load() {
    let shift = |rig: &Rig| ringing(rig, 900.0) - ringing(rig, 300.0);
    let cubic = |name, value| {
        nominal().with_effect(
            EffectEntry::new(name, &[(ParameterKey::CubicNPerM3, value)]).with_text(ParameterKey::Component, "outer"),
        )
    };
    let (plain, hard) = (shift(&nominal()), shift(&cubic(EffectKind::HardeningStiffness, 3e15)));
    let (soft, wide) = (
        shift(&cubic(EffectKind::SofteningStiffness, -8e14)),
        shift(&with(EffectKind::ExcessClearance, &[(ParameterKey::RadialClearanceM, 1e-5)])),
    );
    assert!(hard > plain + 20.0, "{hard} beside {plain} Hz");
    assert!(soft < plain - 5.0, "{soft} beside {plain} Hz");
    assert!((wide - plain).abs() < 3.0, "{wide} beside {plain} Hz");
}

/// Nayfeh and Mook (1979): stiffer one way than the other.
#[test]
fn literature_asymmetric_spring_follows_the_sign() {
    let shift = |quadratic| {
        let spring = EffectEntry::new(EffectKind::AsymmetricStiffness, &[(ParameterKey::QuadraticNPerM2, quadratic)]);
        ringing(&nominal().with_effect(spring.with_text(ParameterKey::Component, "outer-y")), 500.0)
            - ringing(&nominal(), 500.0)
    };
    let (up, down) = (shift(1e11), shift(-1e11));
    assert!(up > 5.0 && down < -5.0, "{up} and {down} Hz");
}

#[test]
fn invariant_changed_parameters_are_the_rigs_own() {
    for (name, component, value, key) in [
        (EffectKind::StiffnessChange, "outer", 1.2e7, ModelKey::OuterStiffness),
        (EffectKind::StiffnessChange, "bearing", 9e9, ModelKey::ContactStiffness),
        (EffectKind::DampingChange, "resonator", 3000.0, ModelKey::ResonatorDamping),
        (EffectKind::MassChange, "inner", 1.5, ModelKey::InnerMass),
    ] {
        let mut rig = nominal();
        rig.set(key, value).unwrap();
        let effect =
            EffectEntry::new(name, &[(ParameterKey::Value, value)]).with_text(ParameterKey::Component, component);
        assert_eq!(noise_free(&nominal().with_effect(effect)), noise_free(&rig), "{name} {component}");
        assert_ne!(noise_free(&nominal()), noise_free(&rig), "{name} {component}");
    }
}

/// What is changed in x and in y, one after the other, is changed in both; in one alone it is not.
#[test]
fn invariant_changes_in_each_direction_are_that_of_both() {
    for (kind, component, value) in [
        (EffectKind::StiffnessChange, "outer", 1.2e7),
        (EffectKind::StiffnessChange, "inner", 9e6),
        (EffectKind::DampingChange, "outer", 9000.0),
        (EffectKind::ViscousFriction, "inner", 2000.0),
    ] {
        let key = if kind == EffectKind::ViscousFriction { ParameterKey::DampingNSPerM } else { ParameterKey::Value };
        let on = |rig: Rig, place: &str| {
            rig.with_effect(EffectEntry::new(kind, &[(key, value)]).with_text(ParameterKey::Component, place))
        };
        let in_x = on(nominal(), &format!("{component}-x"));
        let both = on(nominal(), component);
        let [in_x, in_each, both] = [&in_x, &on(in_x.clone(), &format!("{component}-y")), &both].map(noise_free);
        let far = |a: &Recording, b: &Recording, channel: &str| {
            let pairs = samples(a, channel).iter().zip(samples(b, channel));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / rms(samples(b, channel))
        };
        for channel in ["ax", "ay"] {
            let apart = far(&in_each, &both, channel);
            assert!(apart < 1e-6, "{kind} {component} {channel}: {apart}");
        }
        assert!(far(&in_x, &both, "ay") > 1e-3, "{kind} {component}");
    }
}

/// A force between two directions is its parts along them.
#[test]
fn invariant_an_oblique_force_is_its_parts() {
    let force = |rig: Rig, place: &str, force_n: f64, angle_rad: f64| {
        let numbers = [(ParameterKey::ForceN, force_n), (ParameterKey::AngleRad, angle_rad)];
        rig.with_effect(EffectEntry::new(EffectKind::ConstantForce, &numbers).with_text(ParameterKey::Component, place))
    };
    let oblique = noise_free(&force(nominal(), "inner-x", 200.0, 0.7));
    let parts = force(force(nominal(), "inner-x", 200.0 * 0.7f64.cos(), 0.0), "inner-y", 200.0 * 0.7f64.sin(), 0.0);
    assert_eq!(oblique, noise_free(&parts));
    assert_ne!(oblique, noise_free(&force(nominal(), "inner-x", 200.0, 0.0)));
    let equation = |rig: &Rig| rig.effects[0].equation(RigKind::Bearing5Dof);
    assert!(equation(&force(nominal(), "inner-x", 0.0, 0.0)).contains("0.0000 N, q = x_s"));
    let both = equation(&force(nominal(), "inner-x", 200.0, 0.7));
    assert!(both.contains("q = x_s") && both.contains("q = y_s"), "{both}");
}

#[test]
fn invariant_friction_and_drag_take_energy_out() {
    let decay = |effect: Option<EffectEntry>| {
        let blow = EffectEntry::new(EffectKind::Shock, &[(ParameterKey::TimeS, 0.0), (ParameterKey::ImpulseNS, 0.02)]);
        let mut rig = nominal().with_effect(blow);
        rig.effects.extend(effect);
        let recording = simulate(&rig, &condition(0.0, 500.0, 2000), &Start::noise_free(0.3, 0.7)).unwrap();
        rms(&samples(&recording, "ay")[500..])
    };
    let free = decay(None);
    for (name, key, value) in [
        (EffectKind::CoulombFriction, ParameterKey::ForceN, 2.0),
        (EffectKind::ViscousFriction, ParameterKey::DampingNSPerM, 2000.0),
        (EffectKind::QuadraticDrag, ParameterKey::DragNS2PerM2, 5e6),
    ] {
        let damped = decay(Some(EffectEntry::new(name, &[(key, value)]).with_text(ParameterKey::Component, "outer")));
        assert!(damped < 0.8 * free, "{name}: {damped} beside {free}");
    }
    // The film of oil is between the races, where the housing's mode hardly moves.
    let film = decay(Some(EffectEntry::new(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, 2000.0)])));
    assert!(film < free && film > 0.8 * free, "{film} beside {free}");
}

#[test]
fn invariant_a_load_step_rings_at_its_time() {
    let (before, after) = (
        noise_free(&nominal()),
        noise_free(&with(EffectKind::LoadStep, &[(ParameterKey::TimeS, 0.25), (ParameterKey::ChangeN, -200.0)])),
    );
    let [before, after] = [&before, &after].map(|r| samples(r, "ay").to_vec());
    // At the time itself, sample 6400, half of it has come.
    let early: Vec<f64> = after[..6400].iter().zip(&before).map(|(a, b)| a - b).collect();
    assert!(rms(&early) < 1e-10, "{}", rms(&early));
    assert!(rms(&after[6401..6500]) > 100.0 * rms(&before[6401..6500]));
    // From then on the rig is the one under 300 N.
    let lighter = simulate(&nominal(), &condition(30.0, 300.0, 12_800), &Start::noise_free(0.3, 0.7)).unwrap();
    let late: Vec<f64> = after.iter().zip(samples(&lighter, "ay")).skip(11_800).map(|(a, b)| a - b).collect();
    assert!(rms(&late) < 1e-5, "{}", rms(&late));
}

#[test]
fn invariant_a_load_that_changes_slowly_comes_evenly_about_its_time_and_hardly_rings() {
    let step = |rise_s| {
        let entry = with(
            EffectKind::LoadStep,
            &[(ParameterKey::TimeS, 0.25), (ParameterKey::ChangeN, -200.0), (ParameterKey::RiseS, rise_s)],
        );
        let (before, after) = (noise_free(&nominal()), noise_free(&entry));
        let pairs = samples(&after, "ay").iter().zip(samples(&before, "ay"));
        pairs.map(|(a, b)| a - b).collect::<Vec<_>>()
    };
    let (sudden, slow) = (step(4e-5), step(0.02));
    // It begins 10 ms, 256 samples, before its time.
    assert!(rms(&slow[..6144]) < 1e-10 && rms(&slow[6146..6200]) > 1e-6, "{}", rms(&slow[6146..6200]));
    assert!(
        rms(&slow[6144..6900]) < 0.2 * rms(&sudden[6144..6900]),
        "{} {}",
        rms(&slow[6144..6900]),
        rms(&sudden[6144..6900])
    );
}

#[test]
fn invariant_a_constant_force_along_the_load_is_load() {
    let more = simulate(&nominal(), &condition(30.0, 540.0, 2000), &Start::noise_free(0.3, 0.7)).unwrap();
    let pushed = simulate(
        &with(EffectKind::ConstantForce, &[(ParameterKey::ForceN, 40.0)]),
        &condition(30.0, 500.0, 2000),
        &Start::noise_free(0.3, 0.7),
    );
    let pushed = pushed.unwrap();
    let pairs = samples(&more, "ay").iter().zip(samples(&pushed, "ay"));
    let difference: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
    assert!(rms(&difference) < 1e-6 * rms(samples(&more, "ay")).max(1.0), "{}", rms(&difference));
}

#[test]
fn invariant_speed_drift_brings_turns_closer() {
    let marks = |rig: &Rig| -> Vec<usize> {
        let recording = noise_free(rig);
        samples(&recording, "tacho").iter().enumerate().filter(|(_, v)| **v == 1.0).map(|(i, _)| i).collect()
    };
    let turns = marks(&with(EffectKind::SpeedDrift, &[(ParameterKey::RatePerS, 0.2)]));
    let gaps: Vec<usize> = turns.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(gaps.windows(2).all(|w| w[1] < w[0]), "{gaps:?}");
    // After half a second 10 % faster.
    let last = *gaps.last().unwrap() as f64;
    assert!((last * 30.0 * 1.1 / RATE - 1.0).abs() < 0.01, "{last}");
}

/// Shaw and Holmes (1983): past the gap the stop's spring joins in.
#[test]
fn literature_stop_stiffens_and_play_softens() {
    let plain = ringing(&nominal(), 500.0);
    // 500 N less some weight on 15.1 N/µm and the inner support: some 25 µm.
    let stop = ringing(
        &with(EffectKind::EndStopContact, &[(ParameterKey::GapM, 1e-5), (ParameterKey::StiffnessNPerM, 2e7)]),
        500.0,
    );
    let far = ringing(
        &with(EffectKind::EndStopContact, &[(ParameterKey::GapM, 1e-3), (ParameterKey::StiffnessNPerM, 2e7)]),
        500.0,
    );
    assert!(stop > plain + 20.0, "{stop} beside {plain}");
    assert!((far - plain).abs() < 0.6, "{far} beside {plain}");
    // Deeper in its play than the load pushes it, the housing hangs on the shaft's support alone.
    let play = ringing(&with(EffectKind::Backlash, &[(ParameterKey::WidthM, 1e-3)]), 500.0);
    assert!(play < plain - 30.0, "{play} beside {plain}");
}

/// Corners ring the modes; along half a cosine the load comes to the same without them.
#[test]
fn invariant_a_smooth_step_of_the_load_rings_less() {
    let before = noise_free(&nominal());
    let change = |shape: &str| -> Vec<f64> {
        let numbers = [(ParameterKey::TimeS, 0.25), (ParameterKey::ChangeN, 200.0), (ParameterKey::RiseS, 0.02)];
        let step = EffectEntry::new(EffectKind::LoadStep, &numbers).with_text(ParameterKey::Shape, shape);
        let after = noise_free(&nominal().with_effect(step));
        samples(&after, "ay").iter().zip(samples(&before, "ay")).map(|(a, b)| a - b).collect()
    };
    let (straight, smooth) = (change("straight"), change("smooth"));
    let during = 6100..6700;
    assert!(rms(&straight[..6100]) < 1e-6 && rms(&smooth[..6100]) < 1e-6, "nothing before");
    assert!(rms(&smooth[during.clone()]) < 0.7 * rms(&straight[during]), "{} {}", rms(&smooth), rms(&straight));
    let apart: Vec<f64> = straight[11_000..].iter().zip(&smooth[11_000..]).map(|(a, b)| a - b).collect();
    assert!(rms(&apart) < 0.1 * rms(&straight[11_000..]), "the same load in the end");
}

/// Force of a law of inner or outer race on it in both directions, at a displacement and speed `at`, with the noise's covariance.
fn force_of(effect: EffectEntry, at: [f64; 2], noise: Option<VelocityCovariance>) -> [f64; 2] {
    let assembly = assemble_in_noise(&nominal().with_effect(effect), noise);
    let (mut motion, mut force) = ([0.0; DOFS], [0.0; DOFS]);
    (motion[OUTER_X], motion[OUTER_Y]) = (at[0], at[1]);
    assembly.forces.iter().for_each(|law| law(&Instant::default(), &motion, &motion, &mut force));
    [force[OUTER_X], force[OUTER_Y]]
}

/// Laws of the outer race that can be the same in every direction.
fn symmetric(kind: EffectKind, symmetry: &str) -> EffectEntry {
    let size = match kind {
        EffectKind::QuadraticDrag => (ParameterKey::DragNS2PerM2, 5e6),
        EffectKind::HardeningStiffness => (ParameterKey::CubicNPerM3, 5e12),
        _ => (ParameterKey::CubicNPerM3, -5e12),
    };
    let outer = EffectEntry::new(kind, &[size]).with_text(ParameterKey::Component, "outer");
    outer.with_text(ParameterKey::Symmetry, symmetry)
}

#[test]
fn invariant_an_isotropic_law_turns_with_the_motion_and_is_that_of_an_axis_along_it() {
    for kind in [EffectKind::QuadraticDrag, EffectKind::HardeningStiffness, EffectKind::SofteningStiffness] {
        let along = force_of(symmetric(kind, "isotropic"), [2e-5, 0.0], None);
        let axis = force_of(symmetric(kind, "axes"), [2e-5, 0.0], None);
        assert!((along[0] / axis[0] - 1.0).abs() < 1e-12 && along[1] == 0.0, "{kind}: {along:?} {axis:?}");
        for angle in [0.3, 1.0, 2.5] {
            let (sin, cos) = f64::sin_cos(angle);
            let turned = force_of(symmetric(kind, "isotropic"), [2e-5 * cos, 2e-5 * sin], None);
            let expected = [along[0] * cos, along[0] * sin];
            let off = (turned[0] - expected[0]).hypot(turned[1] - expected[1]);
            assert!(off < 1e-12 * along[0].abs(), "{kind} {angle}: {turned:?} {expected:?}");
            assert!(force_of(symmetric(kind, "axes"), [2e-5 * cos, 2e-5 * sin], None) != turned, "{kind}");
        }
    }
}

#[test]
fn invariant_an_isotropic_drag_in_noise_is_its_mean_over_the_noise() {
    let [x, y, xy] = [4e-10, 1e-10, 1e-10];
    let mut covariance = VelocityCovariance([[0.0; DOFS]; DOFS]);
    covariance.0[OUTER_X][OUTER_X] = x;
    covariance.0[OUTER_Y][OUTER_Y] = y;
    (covariance.0[OUTER_X][OUTER_Y], covariance.0[OUTER_Y][OUTER_X]) = (xy, xy);
    let drag = symmetric(EffectKind::QuadraticDrag, "isotropic");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let draws: Vec<[f64; 2]> = (0..200_000)
        .map(|_| {
            let [a, b]: [f64; 2] = [rng.sample(StandardNormal), rng.sample(StandardNormal)];
            [x.sqrt() * a, xy / x.sqrt() * a + (y - xy * xy / x).sqrt() * b]
        })
        .collect();
    for at in [[3e-6, 2e-6], [2e-5, -1e-5], [-1e-5, 4e-5], [1e-4, 1e-4]] {
        let found = force_of(drag.clone(), at, Some(covariance));
        let mut mean = [0.0; 2];
        for draw in &draws {
            let v = [at[0] + draw[0], at[1] + draw[1]];
            let factor = -5e6 * v[0].hypot(v[1]) / draws.len() as f64;
            mean[0] += factor * v[0];
            mean[1] += factor * v[1];
        }
        // The law has no coupling by the noise's correlation, and another curve between rest and high speed.
        let off = (found[0] - mean[0]).hypot(found[1] - mean[1]) / mean[0].hypot(mean[1]);
        assert!(off < 0.12, "{at:?}: {found:?} {mean:?}");
    }
}
