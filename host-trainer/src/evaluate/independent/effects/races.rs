//! Effects of races, balls and their contact.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Context, Effect, FORMS, Strength, log_within, one_of, truth, within};
use crate::evaluate::independent::motion::Moment;
use crate::evaluate::independent::plant::Plant;
use crate::rig::effect::{EffectKind, ParameterKey};

/// Shape of a pit over its width.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    HalfSine,
    Trapezoid { flank: f64 },
    RaisedCosine,
    Asymmetric { deepest: f64 },
}

impl Shape {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        match rng.random_range(0..4) {
            0 => Self::HalfSine,
            1 => Self::Trapezoid { flank: within(FORMS.flank, rng) },
            2 => Self::RaisedCosine,
            _ => {
                let deepest = within(FORMS.deepest, rng);
                Self::Asymmetric { deepest: if rng.random::<bool>() { deepest } else { 1.0 - deepest } }
            }
        }
    }

    /// Depth at a place from 0 to 1 across the pit, as a share of the deepest.
    fn depth(self, place: f64) -> f64 {
        if !(0.0..=1.0).contains(&place) {
            return 0.0;
        }
        let half = |x: f64| 0.5 * (1.0 - (PI * x).cos());
        match self {
            Self::HalfSine => (PI * place).sin(),
            Self::Trapezoid { flank } => (place.min(1.0 - place) / flank).min(1.0),
            Self::RaisedCosine => half(2.0 * place),
            Self::Asymmetric { deepest } if place < deepest => half(place / deepest),
            Self::Asymmetric { deepest } => half((1.0 - place) / (1.0 - deepest)),
        }
    }

    fn words(self) -> String {
        match self {
            Self::HalfSine => "half sine".into(),
            Self::Trapezoid { flank } => format!("trapezoid with flanks of {flank:.2} of its width"),
            Self::RaisedCosine => "raised cosine".into(),
            Self::Asymmetric { deepest } => format!("asymmetric, deepest at {deepest:.2} of its width"),
        }
    }
}

/// Angle brought into −π to π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// A pit of a drawn shape on a race or on one ball.
pub fn pit(kind: EffectKind, context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let shape = Shape::draw(rng);
    let width = log_within(FORMS.pit_width_rad, rng);
    let angle = match kind {
        EffectKind::OuterRaceDefect => FRAC_PI_2 + within([-FORMS.pit_from_load_rad, FORMS.pit_from_load_rad], rng),
        _ => within([-PI, PI], rng),
    };
    let ball = rng.random_range(0..context.drawn.machine.bearing.balls);
    // A pit of a ball is not equally deep to the two races, whose radii differ.
    let other = within([0.6, 1.0], rng);
    let spin = Plant::spin_ratio(&context.drawn.machine);
    let form = format!("{}, {width:.4} rad wide", shape.words());
    Effect::new(
        kind,
        context,
        Strength::Lasting([1e-8, 3e-5]),
        move |depth, _, plant| {
            let across = move |angle: f64| depth * shape.depth(wrapped(angle) / width + 0.5);
            plant.losses.push(match kind {
                EffectKind::OuterRaceDefect => Box::new(move |_, _, at| across(at - angle)),
                EffectKind::InnerRaceDefect => Box::new(move |m: &Moment, _, at| across(at - m.shaft_rad - angle)),
                _ => Box::new(move |m: &Moment, j, _| {
                    if j != ball {
                        return 0.0;
                    }
                    let turned = spin * m.shaft_rad + angle;
                    across(turned) + other * across(turned - PI)
                }),
            });
        },
        move |depth| {
            let mut numbers = Vec::new();
            if shape == Shape::HalfSine {
                numbers.extend([(ParameterKey::DepthM, depth), (ParameterKey::WidthRad, width)]);
            }
            if kind == EffectKind::OuterRaceDefect && !matches!(shape, Shape::Asymmetric { .. }) {
                numbers.push((ParameterKey::AngleRad, angle));
            }
            truth(kind, &numbers, None, &format!("{form}, {depth:.3e} m deep"))
        },
    )
}

/// Waves on a race: a main one and two neighbours.
pub fn waviness(kind: EffectKind, context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let lobes = rng.random_range(3..=2 * context.drawn.machine.bearing.balls + 1) as f64;
    let waves: Vec<[f64; 3]> = [(lobes, 1.0), (lobes - 1.0, 0.0), (lobes + 1.0, 0.0)]
        .iter()
        .map(|(lobes, size)| {
            let size = if *size > 0.0 { *size } else { within(FORMS.side_waves, rng) };
            [*lobes, size, within([-PI, PI], rng)]
        })
        .collect();
    let form = format!("{lobes} lobes, and neighbours of {:.2} and {:.2} of their size", waves[1][1], waves[2][1]);
    Effect::new(
        kind,
        context,
        Strength::Lasting([1e-10, 3e-6]),
        move |size, _, plant| {
            let waves = waves.clone();
            let high = move |angle: f64| -> f64 {
                waves.iter().map(|[lobes, share, phase]| size * share * (lobes * angle + phase).cos()).sum()
            };
            plant.losses.push(match kind {
                EffectKind::OuterRaceWaviness => Box::new(move |_, _, at| -high(at)),
                _ => Box::new(move |m: &Moment, _, at| -high(at - m.shaft_rad)),
            });
        },
        move |size| truth(kind, &[(ParameterKey::AmplitudeM, size), (ParameterKey::Lobes, lobes)], None, &form),
    )
}

/// More clearance.
pub fn clearance(kind: EffectKind, context: &Context) -> Effect {
    let nominal = context.drawn.machine.bearing.radial_clearance_m;
    let (sign, form) =
        if kind == EffectKind::LubricantFilm { (-1.0, "one thickness at all speeds") } else { (1.0, "") };
    Effect::new(
        kind,
        context,
        Strength::Lasting([1e-8, 4e-5]),
        move |more, _, plant| plant.rig.bearing.radial_clearance_m += sign * more,
        move |more| truth(kind, &[(ParameterKey::RadialClearanceM, nominal + sign * more)], None, form),
    )
}

/// Another exponent of the contact; sometimes with the stiffness that bears the load at the same deflection.
pub fn exponent(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let bearing = &context.drawn.machine.bearing;
    let (nominal, contact_m) = (bearing.contact_exponent, context.drawn.contact_m());
    let (sign, same_load) = (one_of(&[-1.0, 1.0], rng), rng.random_range(0..3) == 0);
    let form = if same_load { "as stiff as nominal under the load" } else { "" };
    Effect::new(
        EffectKind::ContactExponent,
        context,
        Strength::Lasting([0.002, 0.3]),
        move |more, _, plant| {
            let bearing = &mut plant.rig.bearing;
            bearing.contact_exponent += sign * more;
            if same_load {
                bearing.contact_stiffness_n_per_m1_5 *= contact_m.powf(-sign * more);
            }
        },
        move |more| {
            let numbers = [(ParameterKey::Exponent, nominal + sign * more)];
            truth(EffectKind::ContactExponent, if same_load { &[] } else { &numbers }, None, form)
        },
    )
}
