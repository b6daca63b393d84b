//! Faults of sensor, cable and converter.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Context, Effect, FORMS, Strength, one_of, sign, some, truth, within};
use crate::evaluate::independent::outside::{self, Outside};
use crate::evaluate::independent::plant::Stage;
use crate::rig::effect::{EffectKind, ParameterKey};

/// Channels that a fault is in.
fn channels(rng: &mut ChaCha8Rng) -> (&'static str, [bool; 2]) {
    one_of(&[("all", [true; 2]), ("ax", [true, false]), ("ay", [false, true])], rng)
}

/// RMS of the loudest of some channels.
fn loudest(context: &Context, there: [bool; 2]) -> f64 {
    context.rms.iter().zip(there).filter(|(_, there)| *there).map(|(rms, _)| *rms).fold(0.0, f64::max)
}

/// Adds an alteration of some channels' samples, by index and value, to an effect of a number.
fn fault(
    kind: EffectKind,
    context: &Context,
    (channel, there): (&'static str, [bool; 2]),
    (key, value): (ParameterKey, f64),
    (stage, form): (Stage, String),
    alter: impl Fn(f64, f64, usize) -> f64 + Clone + Send + Sync + 'static,
    rng: &mut ChaCha8Rng,
) -> Effect {
    let comes_and_goes = rng.random_bool(FORMS.fault_comes_and_goes);
    let present = if comes_and_goes { some(context.recordings, rng) } else { vec![true; context.recordings] };
    let effect = Effect::new(
        kind,
        context,
        Strength::Fixed,
        move |_, _, plant| {
            let alter = alter.clone();
            plant.signals.push((
                stage,
                Box::new(move |index, rate, samples| {
                    if there.get(index).copied().unwrap_or(false) {
                        let altered = |(i, v): (usize, &mut f64)| *v = alter(*v, i as f64 / rate, index);
                        samples.iter_mut().enumerate().for_each(altered);
                    }
                }),
            ));
        },
        move |_| truth(kind, &[(key, value)], Some((ParameterKey::Channel, channel)), &form),
    );
    effect.in_some(present)
}

/// The electrical line with drawn harmonics and phases, unequal in the two channels.
pub fn mains(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let there = channels(rng);
    let hz = one_of(&[50.0, 60.0], rng) + within([-0.1, 0.1], rng);
    let amplitude = context.by_severity(FORMS.mains) * 2f64.sqrt() * loudest(context, there.1);
    let lines: Vec<[f64; 3]> = [1.0, 2.0, 3.0, 5.0, 7.0]
        .iter()
        .map(|n| {
            let size = if *n == 1.0 { 1.0 } else { FORMS.mains_harmonics * rng.random::<f64>() / n };
            [*n, amplitude * size, within([-PI, PI], rng)]
        })
        .collect();
    let weaker = within([0.3, 1.0], rng);
    let form = format!("{amplitude:.3e} m/s², harmonics and phases of their own, {weaker:.2} of it in ax");
    let alter = move |v: f64, t: f64, index: usize| {
        let size = if index == 0 { weaker } else { 1.0 };
        v + size * lines.iter().map(|[n, a, phase]| a * (TAU * n * hz * t + phase).sin()).sum::<f64>()
    };
    let numbers = (ParameterKey::FrequencyHz, hz);
    fault(EffectKind::MainsInterference, context, there, numbers, (Stage::Cable, form), alter, rng)
}

/// A zero that is off.
pub fn bias(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let there = channels(rng);
    let value = sign(rng) * context.by_severity(FORMS.bias) * loudest(context, there.1);
    let alter = move |v: f64, _: f64, _: usize| v + value;
    let numbers = (ParameterKey::Value, value);
    fault(EffectKind::SensorBias, context, there, numbers, (Stage::Cable, String::new()), alter, rng)
}

/// A gain that is off, of signal and noise alike.
pub fn gain(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let there = channels(rng);
    let value = (sign(rng) * context.by_severity(FORMS.gain)).exp();
    let alter = move |v: f64, _: f64, _: usize| v * value;
    let form = "of signal and noise".to_owned();
    fault(EffectKind::SensorGain, context, there, (ParameterKey::Value, value), (Stage::Sensor, form), alter, rng)
}

/// A share of one channel in the other.
pub fn transverse(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let kind = EffectKind::TransverseSensitivity;
    let (strength, apply) = outside::draw(Outside::CrossTalk, context, rng);
    let told = move |share: f64| truth(kind, &[(ParameterKey::Value, share)], None, "");
    Effect::new(kind, context, strength, apply, told)
}

/// A ceiling that some share of the samples reaches, at both sides or at one.
pub fn clipping(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let there = one_of(&[("all", [true; 2]), ("ax", [true, false]), ("ay", [false, true])], rng);
    let clipped = context.by_severity(FORMS.clipped);
    let loud = usize::from(!there.1[0] || (there.1[1] && context.rms[1] > context.rms[0]));
    let sizes = context.sizes[loud];
    let value = sizes[(((1.0 - clipped) * sizes.len() as f64) as usize).min(sizes.len() - 1)];
    let one_sided = rng.random_range(0..4) == 0;
    let least = if one_sided { f64::NEG_INFINITY } else { -value };
    let alter = move |v: f64, _: f64, _: usize| v.clamp(least, value);
    let form = if one_sided { "at the upper side only".to_owned() } else { String::new() };
    fault(
        EffectKind::SensorClipping,
        context,
        there,
        (ParameterKey::Value, value),
        (Stage::Converter, form),
        alter,
        rng,
    )
}
