use super::{super::testing, *};
use crate::rig::effect::{EffectKind, ParameterKey};

const TRUTH: [(&str, f64); 3] = [("mass_kg", 2.0), ("damping_n_s_per_m", 4.0), ("stiffness_n_per_m", 800.0)];

fn guessed() -> Rig {
    let text = testing::LINEAR
        .replace("mass_kg = 2.0", "mass_kg = 2.6")
        .replace("damping_n_s_per_m = 4.0", "damping_n_s_per_m = 2.0")
        .replace("stiffness_n_per_m = 800.0", "stiffness_n_per_m = 640.0");
    testing::rig(&(text + "unknown = [\"mass_kg\", \"damping_n_s_per_m\", \"stiffness_n_per_m\"]\n"))
}

/// Intervals of 95 % hold the truth in at least 90 of 100 repeats, for each parameter, for position and (fewer repeats)
/// acceleration.
#[test]
fn invariant_intervals_hold_the_truth() {
    for (channel, repeats) in [("q", 100), ("qdd", 50)] {
        let mut held = [0; 3];
        for seed in 0..repeats {
            let recordings = testing::recordings(&testing::rig(testing::LINEAR), channel, 1.0, 0.03, 1000, seed);
            let found = calibrate_sdof(&guessed(), &recordings[..2]).unwrap();
            for (held, (key, truth)) in held.iter_mut().zip(TRUTH) {
                let estimate = found.estimates.iter().find(|e| e.key == key).unwrap();
                *held += i32::from(estimate.interval95[0] <= truth && truth <= estimate.interval95[1]);
            }
        }
        eprintln!("intervals that hold the truth, {channel}: {held:?} of {repeats}");
        assert!(held.iter().all(|held| 10 * *held >= 9 * repeats as i32), "{channel} {held:?}");
    }
}

/// Published parameters of EMPS within 10 %, friction given as effects of known kind.
#[test]
fn literature_emps_without_friction_and_with_it() {
    let Some(recordings) = testing::emps() else { return };
    let rig = testing::rig(
        "kind = \"sdof\"\nmass_kg = 50.0\ndamping_n_s_per_m = 50.0\nstiffness_n_per_m = 0.0\n\
         input_gain_n_per_unit = 35.15\nrestoring = \"linear\"\ngravity_n = 0.0\n\
         unknown = [\"mass_kg\", \"damping_n_s_per_m\", \"gravity_n\"]\n",
    );
    let friction = crate::rig::EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 20.39)]);
    let found = calibrate_sdof(&rig.with_effect(friction), &recordings[..1]).unwrap();
    eprintln!("{:?} by {:?}; held out {:?}", found.estimates, found.method, found.held_out);
    for (key, published) in [("mass_kg", 95.11), ("damping_n_s_per_m", 203.5)] {
        let estimate = found.estimates.iter().find(|e| e.key == key).unwrap();
        assert!((estimate.value / published - 1.0).abs() < 0.1, "{estimate:?}");
    }
}

#[test]
fn invariant_what_cannot_be_determined_is_named() {
    let recordings = testing::recordings(&testing::rig(testing::LINEAR), "q", 1.0, 0.01, 1500, 1);
    let all = "unknown = [\"mass_kg\", \"damping_n_s_per_m\", \"stiffness_n_per_m\", \"input_gain_n_per_unit\"]\n";
    let found = calibrate_sdof(&testing::rig(&(testing::LINEAR.to_owned() + all)), &recordings).unwrap();
    assert!(found.undetermined[0].contains("ratios of mass_kg"), "{:?}", found.undetermined);
    assert_eq!(found.estimates.len(), 3);
}

#[test]
fn golden_refusals() {
    let recordings = testing::recordings(&testing::rig(testing::LINEAR), "q", 1.0, 0.01, 1500, 1);
    let refused = |rig: &Rig, recordings: &[Recording]| calibrate_sdof(rig, recordings).unwrap_err().to_string();
    assert!(refused(&testing::rig(testing::LINEAR), &recordings).contains("`unknown`"));
    assert!(refused(&guessed(), &[]).contains("no recordings"));
    let mut without = recordings[0].clone();
    without.channels.remove(0);
    assert!(refused(&guessed(), &[without]).contains("no channel u"));
}
