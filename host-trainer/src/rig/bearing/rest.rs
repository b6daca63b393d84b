//! Contact of the races at a displacement, and where they rest under a load.

use std::f64::consts::TAU;

use super::{
    GRAVITY, LINEARISATION,
    prepare::masses,
    response::{Tangent, coupled, inverse, slope},
};
use crate::rig::{
    assembly::Force,
    config::{Bearing, BearingRig},
    state::{DOFS, INNER_X, INNER_Y, Instant, OUTER_X, OUTER_Y, RESONATOR_Y},
};

/// Displacements, m, where the rig rests at an instant under a load: balance of load, weights, springs, contact and the forces of
/// effects, by Newton's method from the balance in y without these forces; that alone where there are none. Where the forces leave
/// no balance, the displacements that leave least of them.
pub(super) fn rest_m(rig: &BearingRig, load_n: f64, at: &Instant, forces: &[Force]) -> [f64; DOFS] {
    if forces.is_empty() { in_y_m(rig, load_n, at.cage_rad) } else { balanced_m(rig, load_n, at, forces) }
}

/// Displacements, m, of a balance in x and y.
pub(super) fn balanced_m(rig: &BearingRig, load_n: f64, at: &Instant, forces: &[Force]) -> [f64; DOFS] {
    let balance = Balance { rig, load_n, at, forces };
    let mut rest = balance.at(in_y_m(rig, load_n, at.cage_rad));
    for _ in 0..LINEARISATION.newton_steps {
        let step = balance.newton_step_m(&rest);
        let shares = (0..LINEARISATION.newton_halvings).map(|n| 0.5f64.powi(n));
        let mut tried = shares.map(|share| balance.at(std::array::from_fn(|i| rest.q[i] + share * step[i])));
        let Some(next) = tried.find(|next| next.left_n < rest.left_n) else { break };
        rest = next;
    }
    rest.q
}

/// Balance of all forces on a rig at an instant.
struct Balance<'r> {
    rig: &'r BearingRig,
    load_n: f64,
    at: &'r Instant,
    forces: &'r [Force],
}

/// Displacements and what is left of the balance of forces there.
struct Resting {
    /// Displacements, m.
    q: [f64; DOFS],
    /// Sum of forces on each degree of freedom over its mass, m/s².
    acceleration: [f64; DOFS],
    /// Magnitudes of all sums of forces, N.
    left_n: f64,
    /// Slope of the contact, N/m.
    contact: [[f64; 2]; 2],
}

impl Balance<'_> {
    fn at(&self, q: [f64; DOFS]) -> Resting {
        let apart = [q[INNER_X] - q[OUTER_X], q[INNER_Y] - q[OUTER_Y]];
        let normals = normals(&self.rig.bearing, self.at.cage_rad);
        let ([fx, fy], contact) = contact_at(&self.rig.bearing, apart, normals);
        let mass = masses(self.rig);
        let mut force = [0.0; DOFS];
        self.forces.iter().for_each(|add| add(self.at, &q, &[0.0; DOFS], &mut force));
        let outside = [-fx, fx, self.load_n - mass[INNER_Y] * GRAVITY - fy, fy, -mass[RESONATOR_Y] * GRAVITY];
        let springs = coupled(self.rig, &Tangent::default());
        let acceleration: [f64; DOFS] = std::array::from_fn(|i| {
            let of_springs: f64 = springs[DOFS + i].iter().zip(q).map(|(a, q)| a * q).sum();
            of_springs + (outside[i] + force[i]) / mass[i]
        });
        let left_n = acceleration.iter().zip(mass).map(|(a, m)| (a * m).abs()).sum();
        Resting { q, acceleration, left_n, contact }
    }

    fn newton_step_m(&self, from: &Resting) -> [f64; DOFS] {
        let mut tangent = Tangent::of_contact(from.contact);
        let state = (*self.at, from.q, [0.0; DOFS]);
        let span = from.q.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
        for k in 0..DOFS {
            let slope = slope(self.forces, &state, LINEARISATION.noise_free_difference_std * span, |q, _| &mut q[k]);
            tangent.stiffness.iter_mut().zip(slope).for_each(|(row, slope)| row[k] += slope);
        }
        let of_all = coupled(self.rig, &tangent);
        let inverse = inverse(std::array::from_fn(|i| std::array::from_fn(|j| -of_all[DOFS + i][j])));
        inverse.map(|row| row.iter().zip(from.acceleration).map(|(i, a)| i * a).sum())
    }
}

/// Displacements, m, where the rig rests under a load in y, with its cage at an angle.
fn in_y_m(rig: &BearingRig, load_n: f64, cage_rad: f64) -> [f64; DOFS] {
    let normals: Vec<[f64; 2]> = normals(&rig.bearing, cage_rad).collect();
    let contact = Contact { bearing: &rig.bearing, normals: &normals };
    let apart = contact.apart_at_rest_m(rig, load_n);
    let force = contact.at(apart).0[1];
    let (inner, outer, resonator) =
        (rig.inner.stiffness_n_per_m, rig.outer.stiffness_n_per_m, rig.resonator.stiffness_n_per_m);
    let weight = rig.resonator.mass_kg * GRAVITY;
    // By the stiffer support: the balance of a soft one is a small difference of great forces.
    let outer_y = if outer > inner {
        (force - weight) / outer
    } else {
        (load_n - rig.inner.mass_kg * GRAVITY - force) / inner.max(1.0) - apart
    };
    let mut rest = [0.0; DOFS];
    [rest[INNER_Y], rest[OUTER_Y], rest[RESONATOR_Y]] =
        [outer_y + apart, outer_y, outer_y - weight / resonator.max(1.0)];
    rest
}

/// Contact of a bearing's balls.
struct Contact<'b> {
    bearing: &'b Bearing,
    /// Directions of the balls.
    normals: &'b [[f64; 2]],
}

impl Contact<'_> {
    /// Force, N, and its slope, N/m, where the inner race is displaced in y against the outer, m.
    fn at(&self, apart_m: f64) -> ([f64; 2], [[f64; 2]; 2]) {
        contact_at(self.bearing, [0.0, apart_m], self.normals.iter().copied())
    }

    /// Displacement of the inner race against the outer in y, m, at rest under a load: Newton's method for the balance of
    /// contact force and load.
    fn apart_at_rest_m(&self, rig: &BearingRig, load_n: f64) -> f64 {
        let soft = |k: f64| 1.0 / k.max(1.0);
        let (inner, outer) = (soft(rig.inner.stiffness_n_per_m), soft(rig.outer.stiffness_n_per_m));
        // Distance of the races in y without contact, m, and their approach for 1 N of contact, m/N.
        let open = (load_n - rig.inner.mass_kg * GRAVITY) * inner + rig.resonator.mass_kg * GRAVITY * outer;
        let compliance = inner + outer;
        let guess =
            (load_n.abs() / self.bearing.contact_stiffness_n_per_m1_5).powf(1.0 / self.bearing.contact_exponent);
        let clearance = self.bearing.radial_clearance_m;
        // The balance falls with the displacement: bracket it, then Newton's steps inside the bracket.
        let side = if open < 0.0 { -1.0 } else { 1.0 };
        let (mut low, mut high) = (0.0, open.abs());
        let mut at = (clearance + guess).clamp(low, high.max(low));
        for _ in 0..LINEARISATION.newton_steps {
            let (force, slope) = self.at(side * at);
            let balance = at - open.abs() + side * force[1] * compliance;
            if balance > 0.0 {
                high = at;
            } else {
                low = at;
            }
            let newton = at - balance / (1.0 + slope[1][1] * compliance);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if next == at {
                break;
            }
            at = next;
        }
        side * at
    }
}

/// Directions of the balls from the centre, at an angle of ball 0.
pub(super) fn normals(bearing: &Bearing, cage_rad: f64) -> impl Iterator<Item = [f64; 2]> {
    let pitch = TAU / bearing.balls as f64;
    (0..bearing.balls).map(move |ball| {
        let (s, c) = (cage_rad + pitch * ball as f64).sin_cos();
        [c, s]
    })
}

/// Contact force in x and y, N, and its slope, N/m, at a relative displacement, m, of balls in directions `normals`:
/// theory (29), (30) and (49).
pub(super) fn contact_at(
    bearing: &Bearing,
    displacement: [f64; 2],
    normals: impl Iterator<Item = [f64; 2]>,
) -> ([f64; 2], [[f64; 2]; 2]) {
    let (mut force, mut slope) = ([0.0; 2], [[0.0; 2]; 2]);
    for normal in normals {
        let deflection = displacement[0] * normal[0] + displacement[1] * normal[1] - bearing.radial_clearance_m;
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
