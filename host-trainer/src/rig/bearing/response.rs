//! What the process force becomes at the sensors: the rig linearised about its motion.
//!
//! Statistical linearisation (J. B. Roberts, P. D. Spanos, "Random Vibration and Statistical Linearization", 1990,
//! chapter 5): each force counts by the mean of its slopes, so that the random part of the motion is that of a
//! time-invariant system, and its spectrum known. Of the contact alone that is the mean over one pitch of the cage at the
//! mean displacement ([`at_rest`]); with forces of effects it is the mean over states that a run with its noise has visited
//! ([`along`]), for dry friction has its slope where the noise takes it.

use std::f64::consts::TAU;

use super::{
    GRAVITY,
    prepare::{masses, system_x, system_y},
    step::Step,
};
use crate::rig::{
    config::{Bearing, BearingRig},
    plan::{DOFS, Force, INNER_X, INNER_Y, Moment, OUTER_X, OUTER_Y, RESONATOR_Y},
};

/// Slopes of the forces that the rig's linear part has not: −∂F/∂q, N/m, and −∂F/∂q̇, N s/m, row by row the degree of
/// freedom that the force acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::rig) struct Tangent {
    /// −∂F/∂q.
    pub stiffness: [[f64; DOFS]; DOFS],
    /// −∂F/∂q̇.
    pub damping: [[f64; DOFS]; DOFS],
    /// The contact's part of it, for what the bearing passes on.
    contact: [[f64; 2]; 2],
}

/// A state of a run: when, positions and velocities.
pub(in crate::rig) type Visited = (Moment, [f64; DOFS], [f64; DOFS]);

/// Share of a coordinate's scatter over which its slope is taken.
const SPAN: f64 = 0.3;

/// Positions of the cage that the contact is averaged over.
const PHASES: usize = 48;
/// Newton's method on a convex, smooth force: quadratic from its first steps on.
const NEWTON_STEPS: usize = 60;
/// The response ends where it has come down to this share of its greatest, looked at every so many samples.
const DECAYED: f64 = 1e-9;
const LOOKED_AT_EVERY: usize = 256;

/// Response of the accelerations that `ax` and `ay` measure, m/s², and of the force that the bearing passes to the
/// housing in x and y, N, to 1 N of process force during the first sample; at most `samples` of them, fewer where the
/// response has died away.
pub(in crate::rig) fn to_process_force(
    rig: &BearingRig,
    tangent: &Tangent,
    sample_rate_hz: f64,
    samples: usize,
) -> [Vec<f64>; 4] {
    let contact = tangent.contact;
    let mass = masses(rig);
    let system = coupled(rig, tangent);
    let step = Step::<10, 5>::new(&system, &mass.map(|m| 1.0 / m), 1.0 / sample_rate_hz);
    let sensors = [rig.sensor.horizontal, rig.sensor.vertical].map(|location| location.dof());
    let held = |i: usize| step.b1[i][OUTER_Y] + 2.0 * step.b2[i][OUTER_Y] + step.b3[i][OUTER_Y];
    let mut z: [f64; 10] = [0.0; 10];
    let mut out = [(); 4].map(|()| Vec::with_capacity(samples));
    let (mut greatest, mut recent) = (0.0f64, 0.0f64);
    for sample in 0..samples {
        for (signal, dof) in out.iter_mut().zip(sensors) {
            let free: f64 = (0..10).map(|j| system[DOFS + dof][j] * z[j]).sum();
            let direct = if sample == 0 && dof == OUTER_Y { 1.0 / mass[OUTER_Y] } else { 0.0 };
            signal.push(free + direct);
            recent = recent.max((free + direct).abs());
        }
        let relative = [z[INNER_X] - z[OUTER_X], z[INNER_Y] - z[OUTER_Y]];
        for axis in 0..2 {
            out[2 + axis].push(contact[axis][0] * relative[0] + contact[axis][1] * relative[1]);
        }
        z = std::array::from_fn(|i| {
            let free: f64 = (0..10).map(|j| step.full[i][j] * z[j]).sum();
            free + if sample == 0 { held(i) } else { 0.0 }
        });
        if sample % LOOKED_AT_EVERY == LOOKED_AT_EVERY - 1 {
            greatest = greatest.max(recent);
            if recent < DECAYED * greatest {
                break;
            }
            recent = 0.0;
        }
    }
    out
}

/// ż = A z of all five degrees of freedom (positions, then velocities).
fn coupled(rig: &BearingRig, tangent: &Tangent) -> [[f64; 10]; 10] {
    let (x, y) = (system_x(rig), system_y(rig));
    let mass = masses(rig);
    let mut a = [[0.0; 10]; 10];
    let (of_x, of_y) = ([INNER_X, OUTER_X], [INNER_Y, OUTER_Y, RESONATOR_Y]);
    for (i, &row) in of_x.iter().enumerate() {
        a[row][DOFS + row] = 1.0;
        for (j, &column) in of_x.iter().enumerate() {
            (a[DOFS + row][column], a[DOFS + row][DOFS + column]) = (x[2 + i][j], x[2 + i][2 + j]);
        }
    }
    for (i, &row) in of_y.iter().enumerate() {
        a[row][DOFS + row] = 1.0;
        for (j, &column) in of_y.iter().enumerate() {
            (a[DOFS + row][column], a[DOFS + row][DOFS + column]) = (y[3 + i][j], y[3 + i][3 + j]);
        }
    }
    for i in 0..DOFS {
        for j in 0..DOFS {
            a[DOFS + i][j] -= tangent.stiffness[i][j] / mass[i];
            a[DOFS + i][DOFS + j] -= tangent.damping[i][j] / mass[i];
        }
    }
    a
}

impl Tangent {
    fn of_contact(contact: [[f64; 2]; 2]) -> Self {
        let mut stiffness = [[0.0; DOFS]; DOFS];
        let (inner, outer) = ([INNER_X, INNER_Y], [OUTER_X, OUTER_Y]);
        for i in 0..2 {
            for j in 0..2 {
                for (row, sign) in [(inner[i], 1.0), (outer[i], -1.0)] {
                    stiffness[row][inner[j]] += sign * contact[i][j];
                    stiffness[row][outer[j]] -= sign * contact[i][j];
                }
            }
        }
        Self { stiffness, damping: [[0.0; DOFS]; DOFS], contact }
    }
}

/// Mean slopes over states that a run has visited, of the contact and of the forces of effects.
pub(in crate::rig) fn along(rig: &BearingRig, forces: &[Force], visited: &[Visited]) -> Tangent {
    let count = visited.len().max(1) as f64;
    let mut contact = [[0.0; 2]; 2];
    for (at, q, _) in visited {
        let relative = [q[INNER_X] - q[OUTER_X], q[INNER_Y] - q[OUTER_Y]];
        let (_, slope) = contact_at(&rig.bearing, relative, at.cage_rad);
        for (sum, row) in contact.iter_mut().flatten().zip(slope.into_iter().flatten()) {
            *sum += row / count;
        }
    }
    let mut tangent = Tangent::of_contact(contact);
    let scatter = |of: fn(&Visited) -> &[f64; DOFS]| -> [f64; DOFS] {
        std::array::from_fn(|k| {
            let mean = visited.iter().map(|s| of(s)[k]).sum::<f64>() / count;
            (visited.iter().map(|s| (of(s)[k] - mean).powi(2)).sum::<f64>() / count).sqrt()
        })
    };
    let (of_q, of_v) = (scatter(|s| &s.1), scatter(|s| &s.2));
    let total = |at: &Moment, q: &[f64; DOFS], v: &[f64; DOFS]| {
        let mut sum = [0.0; DOFS];
        forces.iter().for_each(|force| force(at, q, v, &mut sum));
        sum
    };
    for (at, q, v) in visited {
        for k in 0..DOFS {
            for (slopes, span, moves_q) in
                [(&mut tangent.stiffness, of_q[k], true), (&mut tangent.damping, of_v[k], false)]
            {
                let step = SPAN * span;
                if step <= 0.0 {
                    continue;
                }
                let moved = |by: f64| {
                    let (mut q, mut v) = (*q, *v);
                    if moves_q {
                        q[k] += by
                    } else {
                        v[k] += by
                    }
                    total(at, &q, &v)
                };
                let (up, down) = (moved(step), moved(-step));
                for i in 0..DOFS {
                    slopes[i][k] -= (up[i] - down[i]) / (2.0 * step * count);
                }
            }
        }
    }
    tangent
}

/// The contact's mean slope where the races rest under the load: Newton's method for the mean contact force that balances
/// it.
pub(in crate::rig) fn at_rest(rig: &BearingRig, load_n: f64) -> Tangent {
    let soft = |k: f64| 1.0 / k.max(1.0);
    let (inner, outer) = (soft(rig.inner.stiffness_n_per_m), soft(rig.outer.stiffness_n_per_m));
    // What the races would be apart in y without contact, and how far 1 N of contact brings them together.
    let open = (load_n - rig.inner.mass_kg * GRAVITY) * inner + rig.resonator.mass_kg * GRAVITY * outer;
    let compliance = inner + outer;
    let guess = (load_n.abs() / rig.bearing.contact_stiffness_n_per_m1_5).powf(1.0 / rig.bearing.contact_exponent);
    let clearance = rig.bearing.radial_clearance_m;
    // The balance falls with the displacement: bracket it, then Newton's steps inside the bracket.
    let side = if open < 0.0 { -1.0 } else { 1.0 };
    let (mut low, mut high) = (0.0, open.abs());
    let mut at = (clearance + guess).clamp(low, high.max(low));
    for _ in 0..NEWTON_STEPS {
        let (force, slope) = mean_contact(&rig.bearing, side * at);
        let balance = at - open.abs() + side * force * compliance;
        if balance > 0.0 {
            high = at;
        } else {
            low = at;
        }
        let newton = at - balance / (1.0 + slope[1][1] * compliance);
        at = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    Tangent::of_contact(mean_contact(&rig.bearing, side * at).1)
}

/// Contact force in y, N, and slope of the contact force in x and y, N/m, at a relative displacement in y, m; means
/// over one pitch of the cage.
fn mean_contact(bearing: &Bearing, displacement: f64) -> (f64, [[f64; 2]; 2]) {
    let pitch = TAU / bearing.balls as f64;
    let (mut force, mut slope) = (0.0, [[0.0; 2]; 2]);
    for phase in 0..PHASES {
        let (f, k) = contact_at(bearing, [0.0, displacement], pitch * phase as f64 / PHASES as f64);
        force += f[1] / PHASES as f64;
        for (sum, value) in slope.iter_mut().flatten().zip(k.into_iter().flatten()) {
            *sum += value / PHASES as f64;
        }
    }
    (force, slope)
}

/// Contact force in x and y, N, and its slope, N/m, at a relative displacement, m, and an angle of ball 0.
fn contact_at(bearing: &Bearing, displacement: [f64; 2], cage_rad: f64) -> ([f64; 2], [[f64; 2]; 2]) {
    let (mut force, mut slope) = ([0.0; 2], [[0.0; 2]; 2]);
    let pitch = TAU / bearing.balls as f64;
    for ball in 0..bearing.balls {
        let (s, c) = (cage_rad + pitch * ball as f64).sin_cos();
        let normal = [c, s];
        let deflection = displacement[0] * c + displacement[1] * s - bearing.radial_clearance_m;
        if deflection > 0.0 {
            let root = deflection.powf(bearing.contact_exponent - 1.0);
            let stiffness = bearing.contact_exponent * bearing.contact_stiffness_n_per_m1_5 * root;
            for i in 0..2 {
                force[i] += bearing.contact_stiffness_n_per_m1_5 * root * deflection * normal[i];
                for j in 0..2 {
                    slope[i][j] += stiffness * normal[i] * normal[j];
                }
            }
        }
    }
    (force, slope)
}
