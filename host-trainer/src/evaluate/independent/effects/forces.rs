//! Forces of the rotation, rotation itself, and modes.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Context, Effect, FORMS, Strength, log_within, one_of, sign, truth, within};
use crate::evaluate::independent::motion::Drift;
use crate::evaluate::independent::outside::{self, Outside};
use crate::evaluate::independent::plant::{INNER_X, INNER_Y, Mode, OUTER_X, OUTER_Y, Source};
use crate::evaluate::independent::settings::OutsideSettings;
use crate::rig::effect::{EffectKind, ParameterKey};

/// A further mass on the shaft, at an angle of its own to the known one.
pub fn unbalance(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let (known, angle) = (context.drawn.machine.excitation.unbalance_kg_m, within([-PI, PI], rng));
    let (s, c) = angle.sin_cos();
    Effect::new(
        EffectKind::Unbalance,
        context,
        // What adds up to less than the known one is no unbalance: at least twice it.
        Strength::Lasting([2.0 * known, 300.0 * known]),
        move |more, _, plant| {
            plant.unbalance[0] += more * c;
            plant.unbalance[1] += more * s;
        },
        move |more| {
            let total = (known + more * c).hypot(more * s);
            let form = format!("further mass at {angle:.2} rad from the known one");
            truth(EffectKind::Unbalance, &[(ParameterKey::UnbalanceKgM, total)], None, &form)
        },
    )
}

/// A random force on the outer race, of a level that changes once a turn.
pub fn random(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let kind = EffectKind::RandomForce;
    let (strength, apply) = outside::draw(Outside::FlowNoise, context, rng);
    let told = move |size: f64| {
        // The mean of (1 + cos ψ)² is 3/2.
        let psd = 1.5 * size.powi(2) / (0.5 * OutsideSettings::DEFAULT.flow_rate_hz);
        truth(kind, &[(ParameterKey::PsdN2PerHz, psd)], Some((ParameterKey::Component, "outer")), "")
    };
    Effect::new(kind, context, strength, apply, told)
}

/// A force at twice the shaft's speed, its size and phase of their own in each direction, sometimes with parts at once and three
/// times the speed.
pub fn misalignment(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let angle = within([0.0, FRAC_PI_2], rng);
    let direction = one_of(&[[1.0, 0.0], [0.0, 1.0], [angle.cos(), angle.sin()], [angle.cos(), angle.sin()]], rng);
    let parts = rng.random_bool(FORMS.misalignment_orders);
    let mut part = |order: f64, size: f64| (order, [0, 1].map(|axis| (size * direction[axis], within([-PI, PI], rng))));
    let mut orders = vec![part(2.0, 1.0)];
    if parts {
        orders.push(part(1.0, 0.5 * (FORMS.misalignment_parts[0] + FORMS.misalignment_parts[1])));
        orders.push(part(3.0, FORMS.misalignment_parts[0]));
    }
    let form = format!(
        "{:.2} of the force in x, {:.2} in y{}",
        direction[0],
        direction[1],
        if parts { ", with parts at orders 1 and 3" } else { "" }
    );
    let load = context.drawn.load_n();
    Effect::new(
        EffectKind::Misalignment,
        context,
        Strength::Lasting([1e-4 * load, 1.5 * load]),
        move |force, _, plant| {
            let orders = orders.clone();
            plant.forces.push(Box::new(move |m, _, _, f| {
                for (order, axes) in &orders {
                    for (dof, (size, phase)) in [INNER_X, INNER_Y].into_iter().zip(axes) {
                        f[dof] += force * size * (order * m.shaft_rad + phase).cos();
                    }
                }
            }));
        },
        move |force| truth(EffectKind::Misalignment, &[], None, &format!("{force:.3} N, {form}")),
    )
}

/// A constant force on shaft or housing, in a drawn direction.
pub fn constant(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let (dofs, names) =
        one_of(&[([INNER_X, INNER_Y], ["inner-x", "inner-y"]), ([OUTER_X, OUTER_Y], ["outer-x", "outer-y"])], rng);
    let oblique = within([-PI, PI], rng);
    let angle = one_of(&[FRAC_PI_2, -FRAC_PI_2, 0.0, PI, oblique, oblique], rng);
    let (s, c) = angle.sin_cos();
    let load = context.drawn.load_n();
    Effect::new(
        EffectKind::ConstantForce,
        context,
        Strength::Lasting([0.02 * load, 0.7 * load]),
        move |force, _, plant| {
            plant.constant[dofs[0]] += force * c;
            plant.constant[dofs[1]] += force * s;
        },
        move |force| {
            let form = format!("{force:.3} N at {angle:.3} rad on {} and {}", names[0], names[1]);
            let axis = if s.abs() > 0.999_999 { Some((1, s)) } else { (c.abs() > 0.999_999).then_some((0, c)) };
            let (numbers, at) = match axis {
                Some((axis, sign)) => {
                    (vec![(ParameterKey::ForceN, force * sign.signum())], Some((ParameterKey::Component, names[axis])))
                }
                None => (Vec::new(), None),
            };
            truth(EffectKind::ConstantForce, &numbers, at, &form)
        },
    )
}

/// A shaft that changes its speed evenly, along half a cosine, or towards a final speed.
pub fn drift(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let rate = sign(rng) * context.by_severity(FORMS.drift_per_s);
    let (seconds, whole) = (context.seconds(), rate * context.seconds());
    let from_s = within([0.0, 0.4], rng) * seconds;
    let to_s = from_s + within([0.3, 0.6], rng) * seconds;
    let drift = one_of(
        &[
            Drift::Even { rate_per_s: rate },
            Drift::Smooth { size: whole, from_s, to_s },
            Drift::Approach { size: whole, time_s: 0.4 * seconds },
        ],
        rng,
    );
    let numbers = match drift {
        Drift::Even { .. } => vec![(ParameterKey::RatePerS, rate)],
        _ => Vec::new(),
    };
    Effect::new(
        EffectKind::SpeedDrift,
        context,
        Strength::Fixed,
        move |_, _, plant| plant.pace.drift = Some(drift),
        move |_| truth(EffectKind::SpeedDrift, &numbers, None, &format!("{drift:?}")),
    )
}

/// A cage that slips.
pub fn slip(context: &Context) -> Effect {
    let fraction = context.by_severity(FORMS.cage_slip);
    Effect::new(
        EffectKind::CageSlip,
        context,
        Strength::Fixed,
        move |_, _, plant| plant.pace.slip = 1.0 - (1.0 - plant.pace.slip) * (1.0 - fraction),
        move |_| {
            let form = "in addition to the slip of a healthy cage";
            truth(EffectKind::CageSlip, &[(ParameterKey::Fraction, fraction)], None, form)
        },
    )
}

/// A mode of the structure, from a drawn force to a drawn channel.
pub fn resonance(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let (frequency_hz, damping_ratio) = (log_within(FORMS.mode_hz, rng), log_within(FORMS.mode_damping, rng));
    let source = one_of(
        &[Source::ContactX, Source::ContactY, Source::ContactY, Source::HousingX, Source::HousingY, Source::Process],
        rng,
    );
    let weak = within([0.1, 0.6], rng) * sign(rng);
    let (share, channel) = one_of(&[([1.0, 0.0], "ax"), ([0.0, 1.0], "ay"), ([weak, 1.0], ""), ([1.0, weak], "")], rng);
    let sign = sign(rng);
    let form = format!("from {source:?} to ax and ay by {:.2} and {:.2}", share[0], share[1]);
    Effect::new(
        EffectKind::StructuralResonance,
        context,
        Strength::Lasting([1e-3, 1e4]),
        move |gain, _, plant| {
            let gains = share.map(|s| sign * gain * s);
            plant.modes.push(Mode { frequency_hz, damping_ratio, source, gains });
        },
        move |_| {
            let numbers = [(ParameterKey::FrequencyHz, frequency_hz), (ParameterKey::DampingRatio, damping_ratio)];
            let at = (!channel.is_empty()).then_some((ParameterKey::Channel, channel));
            truth(EffectKind::StructuralResonance, &numbers, at, &form)
        },
    )
}
