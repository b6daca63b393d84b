//! Effects of springs, dampers, masses and what rubs on them.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Context, Effect, FORMS, Strength, log_within, one_of, sign, truth, within};
use crate::evaluate::independent::plant::{Each, INNER_X, INNER_Y, OUTER_X, OUTER_Y, SENSOR_Y};
use crate::rig::effect::{EffectKind, ParameterKey};

/// Part of the machine that an effect acts on.
#[derive(Clone, Copy, Debug)]
struct Place {
    name: &'static str,
    dofs: &'static [usize],
}

const INNER: Place = Place { name: "inner", dofs: &[INNER_X, INNER_Y] };
const OUTER: Place = Place { name: "outer", dofs: &[OUTER_X, OUTER_Y] };
const AXES: [Place; 4] = [
    Place { name: "inner-x", dofs: &[INNER_X] },
    Place { name: "inner-y", dofs: &[INNER_Y] },
    Place { name: "outer-x", dofs: &[OUTER_X] },
    Place { name: "outer-y", dofs: &[OUTER_Y] },
];

/// Shaft or housing, in both directions or in one.
fn place(rng: &mut ChaCha8Rng) -> Place {
    one_of(&[INNER, OUTER, INNER, OUTER, AXES[1], AXES[2], AXES[3], AXES[3]], rng)
}

fn at(place: Place) -> Option<(ParameterKey, &'static str)> {
    Some((ParameterKey::Component, place.name))
}

fn outer_spring(context: &Context) -> f64 {
    context.drawn.machine.outer.stiffness_n_per_m
}

/// Spring of a place's part, N/m.
fn spring(context: &Context, place: Place) -> f64 {
    let machine = &context.drawn.machine;
    if place.name.starts_with("inner") { machine.inner.stiffness_n_per_m } else { machine.outer.stiffness_n_per_m }
}

/// A cubic spring, in each direction by itself or by the distance from the middle.
pub fn cubic(kind: EffectKind, context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let place = place(rng);
    let radial = place.dofs.len() == 2 && rng.random_range(0..3) == 0;
    let unit = spring(context, place) / (3.0 * context.drawn.static_m().powi(2));
    let (sign, most) = if kind == EffectKind::HardeningStiffness { (1.0, 5.0) } else { (-1.0, 0.5) };
    let form = if radial { "force along the displacement, by its cube" } else { "" };
    Effect::new(
        kind,
        context,
        Strength::Lasting([1e-3, most]),
        move |share, _, plant| {
            let k3 = sign * share * unit;
            plant.forces.push(Box::new(move |_, q: &Each, _, f| {
                let square: f64 = place.dofs.iter().map(|i| q[*i] * q[*i]).sum();
                place.dofs.iter().for_each(|i| f[*i] -= k3 * q[*i] * if radial { square } else { q[*i] * q[*i] });
            }));
        },
        move |share| {
            let numbers = [(ParameterKey::CubicNPerM3, sign * share * unit)];
            truth(kind, if radial { &[] } else { &numbers }, at(place), form)
        },
    )
}

/// A quadratic spring.
pub fn quadratic(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let (place, sign) = (place(rng), sign(rng));
    let unit = spring(context, place) / (2.0 * context.drawn.static_m());
    Effect::new(
        EffectKind::AsymmetricStiffness,
        context,
        Strength::Lasting([1e-3, 0.7]),
        move |share, _, plant| {
            let k2 = sign * share * unit;
            plant.forces.push(Box::new(move |_, q: &Each, _, f| {
                place.dofs.iter().for_each(|i| f[*i] -= k2 * q[*i] * q[*i]);
            }));
        },
        move |share| {
            let numbers = [(ParameterKey::QuadraticNPerM2, sign * share * unit)];
            truth(EffectKind::AsymmetricStiffness, &numbers, at(place), "")
        },
    )
}

/// A spring, damper or mass that is another, sometimes in one direction only.
pub fn linear(kind: EffectKind, context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    const RESONATOR: Place = Place { name: "resonator", dofs: &[SENSOR_Y] };
    const CONTACT: Place = Place { name: "bearing", dofs: &[] };
    let machine = &context.drawn.machine;
    let (place, part) = match (kind, rng.random_range(0..8)) {
        (EffectKind::StiffnessChange, 0) => (CONTACT, &machine.inner),
        (_, 0..3) => (RESONATOR, &machine.resonator),
        (_, 3..5) => (INNER, &machine.inner),
        _ => (OUTER, &machine.outer),
    };
    // A mass moves in both directions.
    let one_way = kind != EffectKind::MassChange && place.dofs.len() == 2 && rng.random_range(0..3) == 0;
    let dofs: Vec<usize> = if one_way { vec![place.dofs[rng.random_range(0..2)]] } else { place.dofs.to_vec() };
    let sign = sign(rng);
    let nominal = match kind {
        EffectKind::StiffnessChange if place.dofs.is_empty() => machine.bearing.contact_stiffness_n_per_m1_5,
        EffectKind::StiffnessChange => part.stiffness_n_per_m,
        EffectKind::DampingChange => part.damping_n_s_per_m,
        _ => part.mass_kg,
    };
    let most = if kind == EffectKind::DampingChange { 1.4 } else { 0.6 };
    let form = if one_way { "in one direction only" } else { "" };
    let effect = Effect::new(
        kind,
        context,
        Strength::Lasting([0.01, most]),
        move |log, _, plant| {
            let factor = (sign * log).exp();
            if place.dofs.is_empty() {
                plant.rig.bearing.contact_stiffness_n_per_m1_5 *= factor;
            }
            let numbers = match kind {
                EffectKind::StiffnessChange => &mut plant.stiffness,
                EffectKind::DampingChange => &mut plant.damping,
                _ => &mut plant.mass,
            };
            dofs.iter().for_each(|i| numbers[*i] *= factor);
        },
        move |log| {
            let numbers = [(ParameterKey::Value, nominal * (sign * log).exp())];
            truth(kind, if one_way { &[] } else { &numbers }, at(place), form)
        },
    );
    // More damping of a support is viscous friction of it.
    let more = kind == EffectKind::DampingChange && sign > 0.0;
    effect.accepting(more.then_some(EffectKind::ViscousFriction))
}

/// Dry friction, rounded near rest, with or without a static part.
pub fn friction(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let place = one_of(&[OUTER, OUTER, INNER, AXES[2], AXES[3]], rng);
    let rounding = log_within(FORMS.rounding_m_per_s, rng);
    let stribeck = rng.random::<bool>();
    let (ratio, speed) = (within(FORMS.stribeck_ratio, rng), rounding * log_within(FORMS.stribeck_speed, rng));
    let ratio = if stribeck { ratio } else { 1.0 };
    let load = context.drawn.load_n();
    let form = format!("rounded below {rounding:.1e} m/s, static over sliding {ratio:.2} below {speed:.1e} m/s");
    Effect::new(
        EffectKind::CoulombFriction,
        context,
        Strength::Lasting([1e-5 * load, 2e-2 * load]),
        move |force, _, plant| {
            let least = place.dofs.iter().map(|i| plant.mass[*i]).fold(f64::INFINITY, f64::min);
            // A step of a fifth of the rounding's rate is stable and exact enough.
            plant.fastest = plant.fastest.max(0.2 * ratio * force / (rounding * least));
            plant.forces.push(Box::new(move |_, _, v: &Each, f| {
                for i in place.dofs {
                    let rub = 1.0 + (ratio - 1.0) * (-(v[*i] / speed).powi(2)).exp();
                    f[*i] -= force * rub * (v[*i] / rounding).tanh();
                }
            }));
        },
        move |force| {
            let numbers = [(ParameterKey::ForceN, force)];
            truth(EffectKind::CoulombFriction, if stribeck { &[] } else { &numbers }, at(place), &form)
        },
    )
}

/// Damping between the races, or of shaft or housing to the ground.
pub fn viscous(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let place = one_of(&[None, None, None, Some(INNER), Some(OUTER), Some(AXES[3])], rng);
    let effect = Effect::new(
        EffectKind::ViscousFriction,
        context,
        Strength::Lasting([1.0, 2e4]),
        move |damping, _, plant| {
            plant.fastest = plant.fastest.max(0.2 * damping / plant.mass[INNER_X]);
            plant.forces.push(Box::new(move |_, _, v: &Each, f| match place {
                Some(place) => place.dofs.iter().for_each(|i| f[*i] -= damping * v[*i]),
                None => {
                    for (a, b) in [(INNER_X, OUTER_X), (INNER_Y, OUTER_Y)] {
                        let force = damping * (v[a] - v[b]);
                        f[a] -= force;
                        f[b] += force;
                    }
                }
            }));
        },
        move |damping| {
            let name = place.map_or("bearing", |p| p.name);
            let numbers = [(ParameterKey::DampingNSPerM, damping)];
            truth(EffectKind::ViscousFriction, &numbers, Some((ParameterKey::Component, name)), "")
        },
    );
    effect.accepting(place.map(|_| EffectKind::DampingChange))
}

/// Drag by the square of the speed: of each direction by itself, or of the whole speed against the motion.
pub fn drag(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let place = one_of(&[OUTER, OUTER, AXES[3], AXES[2], INNER], rng);
    let whole = place.dofs.len() == 2 && rng.random::<bool>();
    let form = if whole { "against the motion, by the square of the whole speed" } else { "" };
    Effect::new(
        EffectKind::QuadraticDrag,
        context,
        Strength::Lasting([1e4, 1e9]),
        move |drag, _, plant| {
            plant.forces.push(Box::new(move |_, _, v: &Each, f| {
                let speed = place.dofs.iter().map(|i| v[*i] * v[*i]).sum::<f64>().sqrt();
                place.dofs.iter().for_each(|i| f[*i] -= drag * v[*i] * if whole { speed } else { v[*i].abs() });
            }));
        },
        move |drag| {
            let numbers = [(ParameterKey::DragNS2PerM2, drag)];
            truth(EffectKind::QuadraticDrag, if whole { &[] } else { &numbers }, at(place), form)
        },
    )
}

/// A one-sided stop that also damps.
pub fn stop(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let place = one_of(&[AXES[3], AXES[3], AXES[1]], rng);
    let gap = within(FORMS.stop_gap, rng) * context.drawn.static_m();
    let delay = log_within(FORMS.stop_damping_s, rng);
    let form = format!("damping of {delay:.1e} s times its stiffness");
    let unit = outer_spring(context);
    Effect::new(
        EffectKind::EndStopContact,
        context,
        Strength::Lasting([1e-3, 8.0]),
        move |share, _, plant| {
            let (stiffness, dof) = (share * unit, place.dofs[0]);
            plant.fastest = plant.fastest.max(3.0 * (stiffness / plant.mass[dof]).sqrt());
            plant.forces.push(Box::new(move |_, q: &Each, v: &Each, f| {
                let into = q[dof] - gap;
                if into > 0.0 {
                    // A stop pushes and never pulls.
                    f[dof] -= (stiffness * (into + delay * v[dof])).max(0.0);
                }
            }));
        },
        move |share| {
            let numbers = [(ParameterKey::GapM, gap), (ParameterKey::StiffnessNPerM, share * unit)];
            truth(EffectKind::EndStopContact, &numbers, at(place), &form)
        },
    )
}

/// A dead zone of a support's spring, with rounded edges.
pub fn backlash(context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    let place = one_of(&[INNER, OUTER, OUTER, AXES[2], AXES[0]], rng);
    let form = format!("edges rounded over {:.2} of the half width", FORMS.backlash_rounding);
    let static_m = context.drawn.static_m();
    Effect::new(
        EffectKind::Backlash,
        context,
        Strength::Lasting([0.003 * static_m, 1.5 * static_m]),
        move |width, _, plant| {
            let half = 0.5 * width;
            let rounding = FORMS.backlash_rounding * half;
            let springs: Vec<(usize, f64)> = place.dofs.iter().map(|i| (*i, plant.stiffness[*i])).collect();
            plant.forces.push(Box::new(move |_, q: &Each, _, f| {
                // The spring's own force comes back, as far as the zone is dead.
                let root = |x: f64| (x * x + rounding * rounding).sqrt();
                for (i, k) in &springs {
                    f[*i] += 0.5 * k * (root(q[*i] + half) - root(q[*i] - half));
                }
            }));
        },
        move |width| truth(EffectKind::Backlash, &[(ParameterKey::WidthM, width)], at(place), &form),
    )
}
