//! Events: what happens in some recordings, at times of their own.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Context, Effect, FORMS, Strength, log_within, one_of, sign, some, truth, within};
use crate::evaluate::cases::HiddenEffect;
use crate::evaluate::independent::plant::{INNER_X, INNER_Y, OUTER_X, OUTER_Y, Plant, Stage};
use crate::rig::effect::{EffectKind, ParameterKey};

/// An effect that is told once for each recording that has it.
fn event(
    kind: EffectKind,
    context: &Context,
    strength: Strength,
    present: Vec<bool>,
    apply: impl Fn(f64, usize, &mut Plant) + 'static,
    told: impl Fn(f64, usize) -> HiddenEffect + 'static,
) -> Effect {
    let there: Vec<usize> = (0..present.len()).filter(|n| present[*n]).collect();
    let mut effect = Effect::new(kind, context, strength, apply, |_| truth(EffectKind::Shock, &[], None, ""));
    effect.told = Box::new(move |strength| {
        let each = |n: &usize| HiddenEffect { recordings: vec![n + 1], ..told(strength, *n) };
        there.iter().map(each).collect()
    });
    effect.in_some(present)
}

/// Course of a load step over its rise.
#[derive(Clone, Copy, Debug)]
enum Rise {
    Even,
    Cosine,
    Exponential,
}

impl Rise {
    /// Share of the step at a time from its start, in rise times.
    fn at(self, x: f64) -> f64 {
        match self {
            _ if x <= 0.0 => 0.0,
            Self::Even => x.min(1.0),
            Self::Cosine => 0.5 * (1.0 - (PI * x.min(1.0)).cos()),
            // Nine tenths within the rise time.
            Self::Exponential => 1.0 - (-2.3 * x).exp(),
        }
    }

    /// Time of half of the step, in rise times.
    fn middle(self) -> f64 {
        match self {
            Self::Even | Self::Cosine => 0.5,
            Self::Exponential => 0.301,
        }
    }
}

/// A load that changes with a rise time and a course, in a direction near its own.
pub fn load_step(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let present = some(context.recordings, rng);
    let times: Vec<f64> = present.iter().map(|_| context.time_s(rng)).collect();
    let (rise_s, rise) = (log_within(FORMS.rise_s, rng), one_of(&[Rise::Even, Rise::Cosine, Rise::Exponential], rng));
    let tilt = one_of(&[0.0, 0.0, 0.2, -0.2], rng);
    let (s, c) = (FRAC_PI_2 + tilt).sin_cos();
    let (sign, load) = (sign(rng), context.drawn.load_n());
    let starts = times.clone();
    let form = format!("{rise:?} rise of {rise_s:.2e} s, {tilt:.1} rad from the load");
    event(
        EffectKind::LoadStep,
        context,
        Strength::Event([5e-3 * load, 0.7 * load], times.clone()),
        present,
        move |change, n, plant| {
            let start = starts[n];
            plant.forces.push(Box::new(move |m, _, _, f| {
                let share = rise.at((m.time_s - start) / rise_s);
                f[INNER_X] += sign * change * share * c;
                f[INNER_Y] += sign * change * share * s;
            }));
        },
        move |change, n| {
            let numbers =
                [(ParameterKey::TimeS, times[n] + rise.middle() * rise_s), (ParameterKey::ChangeN, sign * change)];
            truth(EffectKind::LoadStep, &numbers, None, &form)
        },
    )
}

/// A half-sine pulse on shaft or housing, of a drawn duration and direction.
pub fn shock(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let present = some(context.recordings, rng);
    let times: Vec<f64> = present.iter().map(|_| context.time_s(rng)).collect();
    let duration = log_within(FORMS.shock_s, rng);
    let (dofs, part) = one_of(&[([INNER_X, INNER_Y], "inner"), ([OUTER_X, OUTER_Y], "outer")], rng);
    let angle = within([-PI, PI], rng);
    let (s, c) = angle.sin_cos();
    let starts = times.clone();
    let form = format!("half sine of {duration:.2e} s on {part} at {angle:.2} rad");
    event(
        EffectKind::Shock,
        context,
        Strength::Event([1e-6, 10.0], times.clone()),
        present,
        move |impulse, n, plant| {
            let start = starts[n];
            let peak = FRAC_PI_2 * impulse / duration;
            plant.forces.push(Box::new(move |m, _, _, f| {
                let x = (m.time_s - start) / duration;
                if (0.0..1.0).contains(&x) {
                    let force = peak * (PI * x).sin();
                    f[dofs[0]] += force * c;
                    f[dofs[1]] += force * s;
                }
            }));
        },
        move |impulse, n| {
            let form = format!("{impulse:.2e} N s, {form}");
            truth(EffectKind::Shock, &[(ParameterKey::TimeS, times[n])], None, &form)
        },
    )
}

/// Samples that the logger loses, of another count in each recording.
pub fn dropped(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let present = some(context.recordings, rng);
    let size = context.by_severity(FORMS.dropped);
    let gaps: Vec<(f64, usize)> = present
        .iter()
        .map(|_| (context.time_s(rng), (size * rng.random_range(0.7..1.4)).round().max(1.0) as usize))
        .collect();
    let told = gaps.clone();
    event(
        EffectKind::DroppedSamples,
        context,
        Strength::Fixed,
        present,
        move |_, n, plant| {
            let (time_s, count) = gaps[n];
            plant.surplus += count;
            plant.signals.push((
                Stage::Logger,
                Box::new(move |_, rate, samples| {
                    let first = ((time_s * rate).round() as usize).min(samples.len());
                    samples.drain(first..(first + count).min(samples.len()));
                }),
            ));
        },
        move |_, n| {
            let (time_s, count) = told[n];
            let numbers = [(ParameterKey::TimeS, time_s), (ParameterKey::Count, count as f64)];
            truth(EffectKind::DroppedSamples, &numbers, None, "")
        },
    )
}
