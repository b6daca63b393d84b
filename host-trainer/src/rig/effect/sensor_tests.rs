use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::random_part::{Asked, random_parts};
use crate::rig::{
    EffectEntry, Rig,
    test_support::{RATE, condition, line, noise_free, nominal, rms, samples, with},
};

fn change(kind: EffectKind, numbers: &[(ParameterKey, f64)]) -> Vec<f64> {
    let (before, after) = (noise_free(&nominal()), noise_free(&with(kind, numbers)));
    samples(&after, "ay").iter().zip(samples(&before, "ay")).map(|(a, b)| a - b).collect()
}

#[test]
fn invariant_clipping_clips_its_channel_and_nothing_else() {
    let clipping = EffectEntry::new(EffectKind::SensorClipping, &[(ParameterKey::Value, 0.01)])
        .with_text(ParameterKey::Channel, "ay");
    let (before, after) = (noise_free(&nominal()), noise_free(&nominal().with_effect(clipping)));
    let expected: Vec<f64> = samples(&before, "ay").iter().map(|v| v.clamp(-0.01, 0.01)).collect();
    assert!(samples(&before, "ay").iter().any(|v| v.abs() > 0.01), "nothing to clip");
    assert_eq!(samples(&after, "ay"), expected);
    assert_eq!(samples(&after, "ax"), samples(&before, "ax"));
}

#[test]
fn invariant_bias_adds_and_gain_scales() {
    assert!(change(EffectKind::SensorBias, &[(ParameterKey::Value, 0.25)]).iter().all(|v| (v - 0.25).abs() < 1e-12));
    let before = noise_free(&nominal());
    let after = noise_free(&with(EffectKind::SensorGain, &[(ParameterKey::Value, 1.5)]));
    let pairs = samples(&after, "ax").iter().zip(samples(&before, "ax"));
    assert!(pairs.clone().all(|(a, b)| *a == 1.5 * b));
}

/// In a run without noise, and in the response to noise.
#[test]
fn invariant_a_transverse_sensor_adds_a_share_of_the_other_channel() {
    let transverse = EffectEntry::new(EffectKind::TransverseSensitivity, &[(ParameterKey::Value, -0.25)])
        .with_text(ParameterKey::Channel, "ax");
    let rig = nominal().with_effect(transverse);
    let is_shared = |[ax, ay]: [&[f64]; 2], [after_x, after_y]: [&[f64]; 2]| {
        let share = |((x, y), after): ((&f64, &f64), &f64)| (x - 0.25 * y - after).abs() < 1e-12;
        ax.iter().zip(ay).zip(after_x).all(share) && ay == after_y && ay.iter().any(|v| *v != 0.0)
    };
    let (before, after) = (noise_free(&nominal()), noise_free(&rig));
    let of = |recording| ["ax", "ay"].map(|channel| samples(recording, channel));
    assert!(is_shared(of(&before), of(&after)));
    let condition = condition(30.0, 500.0, 2000);
    let response = |rig: &Rig| random_parts(&[Asked { rig, condition, known: None }]).remove(0).unwrap();
    let (before, after) = (response(&nominal()), response(&rig));
    assert!(is_shared(
        before.process.responses[0].each_ref().map(|r| &**r),
        after.process.responses[0].each_ref().map(|r| &**r)
    ));
    assert_eq!(before.noise_gain, after.noise_gain);
}

#[test]
fn invariant_dropped_samples_skip_and_say_nothing() {
    let (before, after) = (
        noise_free(&nominal()),
        noise_free(&with(EffectKind::DroppedSamples, &[(ParameterKey::TimeS, 0.25), (ParameterKey::Count, 100.0)])),
    );
    for channel in ["ax", "ay", "tacho"] {
        let (before, after) = (samples(&before, channel), samples(&after, channel));
        assert_eq!(after.len(), before.len());
        assert_eq!(after[..6400], before[..6400], "{channel}");
        assert_eq!(after[6400..12_700], before[6500..], "{channel}");
    }
    // The end is what the rig did next, not a repetition.
    let ax = samples(&after, "ax");
    assert!(ax[12_700..].iter().any(|v| *v != ax[12_699]));
}

/// A rectifier's load on the line: odd harmonics, 1/n of the fundamental (Arrillaga and Watson, 2003).
#[test]
fn literature_mains_lines() {
    let mains =
        change(EffectKind::MainsInterference, &[(ParameterKey::FrequencyHz, 50.0), (ParameterKey::Amplitude, 0.3)]);
    for (frequency, expected) in [(50.0, 0.3), (100.0, 0.0), (150.0, 0.1), (250.0, 0.06), (350.0, 0.0)] {
        assert!((line(&mains, RATE, frequency) - expected).abs() < 1e-4, "{frequency} Hz");
    }
}

#[test]
fn invariant_unmodelled_mode_rises_at_its_frequency() {
    // The bearing passes little force on at 3 kHz unless something excites it.
    let pit = EffectEntry::new(
        EffectKind::OuterRaceDefect,
        &[(ParameterKey::DepthM, 1e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.5)],
    );
    let mode = EffectEntry::new(
        EffectKind::StructuralResonance,
        &[(ParameterKey::FrequencyHz, 3000.0), (ParameterKey::DampingRatio, 0.02)],
    );
    let rig = nominal().with_effect(pit);
    let (before, after) = (noise_free(&rig), noise_free(&rig.clone().with_effect(mode)));
    let band = |recording, channel, from: usize| {
        (0..40).map(|k| line(samples(recording, channel), RATE, (from + 5 * k) as f64).powi(2)).sum::<f64>()
    };
    assert!(band(&after, "ay", 2900) > 5.0 * band(&before, "ay", 2900));
    assert!((band(&after, "ay", 300) / band(&before, "ay", 300) - 1.0).abs() < 0.3);
    // The bearing knows nothing of it.
    assert_eq!(samples(&after, "tacho"), samples(&before, "tacho"));
}

/// The force across one sensor is that along the other; a mode that motion drives is linear in it and stays in its channel.
#[test]
fn invariant_a_mode_follows_its_source() {
    let before = noise_free(&nominal());
    let change_in_both = |channel: &str, source: &str, [gain, across]: [f64; 2]| {
        let numbers = [
            (ParameterKey::FrequencyHz, 900.0),
            (ParameterKey::DampingRatio, 0.02),
            (ParameterKey::Gain, gain),
            (ParameterKey::GainAcross, across),
        ];
        let mode = EffectEntry::new(EffectKind::StructuralResonance, &numbers)
            .with_text(ParameterKey::Channel, channel)
            .with_text(ParameterKey::Source, source);
        let after = noise_free(&nominal().with_effect(mode));
        ["ax", "ay"]
            .map(|c| -> Vec<f64> { samples(&after, c).iter().zip(samples(&before, c)).map(|(a, b)| a - b).collect() })
    };
    let change = |channel: &str, source: &str, gain: f64| change_in_both(channel, source, [gain, 0.0]);
    let alike = |a: &[f64], b: &[f64], factor: f64| {
        let most = rms(a).max(1e-9);
        a.iter().zip(b).all(|(a, b)| (a - factor * b).abs() < 1e-9 * most)
    };
    let ([ax, _], [still, across]) = (change("ax", "along", 1.0), change("ay", "across", 1.0));
    assert!(alike(&across, &ax, 1.0) && rms(&ax) > 1e-4 && rms(&still) == 0.0);
    let [_, along] = change("ay", "along", 1.0);
    assert!(!alike(&across, &along, 1.0));
    let ([still, once], [_, twice]) = (change("ay", "motion", 0.5), change("ay", "motion", 1.0));
    assert!(alike(&twice, &once, 2.0) && rms(&once) > 1e-4 && rms(&still) == 0.0);
    // The same mode at the other sensor.
    for source in ["along", "across", "motion"] {
        let ([still, once], [other, both]) = (change("ay", source, 1.0), change_in_both("ay", source, [1.0, -0.5]));
        assert!(rms(&still) == 0.0 && both == once && alike(&other, &once, -0.5), "{source}");
    }
}
