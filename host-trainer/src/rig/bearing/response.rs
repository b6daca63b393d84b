//! Response of the sensors to the process force: the rig linearised about its motion, theory (49) and (50).
//!
//! Statistical linearisation (J. B. Roberts, P. D. Spanos, "Random Vibration and Statistical Linearization", 1990,
//! chapter 5): each force counts by the mean of its slopes, so that the random part of the motion is that of a
//! time-invariant system of known spectrum. For the contact alone that is the mean over one pitch of the cage where the races
//! rest ([`at_rest`]); with forces of effects it is the mean over the visited states of a run ([`along`]). As balls pass, the
//! contact's slope changes ([`Passing`]), and where damping changes along the run, its mean is no measure
//! ([`damping_along`]): the system then varies with time.

use std::f64::consts::TAU;

use super::{
    LINEARISATION,
    prepare::{masses, system_x, system_y},
    rest::{balanced_m, contact_at, normals},
    step::Step,
};
use crate::rig::{
    assembly::Force,
    config::BearingRig,
    state::{DOFS, INNER_X, INNER_Y, Instant, OUTER_X, OUTER_Y, RESONATOR_Y},
};

/// Slopes of the forces outside the rig's linear part; rows are the degrees of freedom that the force acts on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::rig) struct Tangent {
    /// Stiffness −∂F/∂q, N/m.
    pub stiffness: [[f64; DOFS]; DOFS],
    /// Damping −∂F/∂q̇, N s/m.
    pub damping: [[f64; DOFS]; DOFS],
}

/// A state of a run: instant, positions and velocities.
pub(in crate::rig) type Visited = (Instant, [f64; DOFS], [f64; DOFS]);

/// Response to 1 N during one sample.
pub(in crate::rig) struct Impulse {
    /// Accelerations of `ax` and `ay`, m/s², and force on the outer race in x and y, N: contact and effects.
    pub signals: [Vec<f64>; 4],
    /// Sums over all samples of products of velocities, m²/s²; where damping changes along the run, weighted by
    /// [`Damping::weights`]: noise changes a force law where its slope is.
    pub velocities: [[f64; DOFS]; DOFS],
}

/// Damping by the forces of effects at one sample of a run.
#[derive(Clone, Copy, Debug)]
pub(in crate::rig) struct Damping {
    /// Slopes −∂F/∂q̇, N s/m.
    slopes: [[f64; DOFS]; DOFS],
    /// Matrix that takes the velocities through half a step of this damping.
    left: [[f64; DOFS]; DOFS],
    /// Root of the damping over its mean over all samples, for each velocity.
    weights: [f64; DOFS],
}

/// What changes along a run, at one sample.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::rig) struct Changing<'d> {
    /// Damping by the forces of effects; `None` where it is in the tangent.
    pub damping: Option<&'d Damping>,
    /// Slope of the contact beyond its mean, N/m.
    pub contact: [[f64; 2]; 2],
}

/// Slope of the contact beyond its mean as balls pass.
#[derive(Clone, Debug)]
pub(in crate::rig) struct Passing {
    /// At positions of the cage over a pitch, N/m; none where the contact hardly changes.
    slopes: Vec<[[f64; 2]; 2]>,
    /// Pitch of the balls, rad.
    pitch_rad: f64,
    /// Turn of the cage from one sample to the next, rad.
    turn_rad: f64,
}

impl Passing {
    /// Where the cage turns by an angle from one sample to the next, of slopes over a pitch.
    pub(in crate::rig) fn new(rig: &BearingRig, slopes: &[[[f64; 2]; 2]], turn_rad: f64) -> Self {
        let mean = mean_slope(slopes);
        let beyond = |slope: &[[f64; 2]; 2]| std::array::from_fn(|i| std::array::from_fn(|j| slope[i][j] - mean[i][j]));
        let mut slopes: Vec<[[f64; 2]; 2]> = slopes.iter().map(beyond).collect();
        let greatest = slopes.iter().flatten().flatten().fold(0.0f64, |most, s| most.max(s.abs()));
        let is_constant = greatest <= LINEARISATION.least_passing * mean[0][0].max(mean[1][1]);
        if is_constant {
            slopes.clear();
        }
        Self { slopes, pitch_rad: TAU / rig.bearing.balls as f64, turn_rad }
    }

    /// Whether the contact hardly changes.
    pub(in crate::rig) fn is_constant(&self) -> bool {
        self.slopes.is_empty()
    }

    /// Pitch of the balls, rad.
    pub(in crate::rig) fn pitch_rad(&self) -> f64 {
        self.pitch_rad
    }

    /// Sample by sample from an angle of the cage on, rad.
    pub(in crate::rig) fn from(&self, cage_rad: f64) -> impl Iterator<Item = [[f64; 2]; 2]> + Clone {
        (0..).map(move |sample| self.at(cage_rad + f64::from(sample) * self.turn_rad))
    }

    fn at(&self, cage_rad: f64) -> [[f64; 2]; 2] {
        if self.is_constant() {
            return [[0.0; 2]; 2];
        }
        let count = self.slopes.len();
        let place = (cage_rad / self.pitch_rad).rem_euclid(1.0) * count as f64;
        let (index, part) = (place as usize, place.fract());
        let [from, to] = [0, 1].map(|ahead| &self.slopes[(index + ahead) % count]);
        std::array::from_fn(|i| std::array::from_fn(|j| from[i][j] + part * (to[i][j] - from[i][j])))
    }
}

impl Damping {
    fn half_a_step(&self, z: &mut [f64; 10]) {
        let speeds: [f64; DOFS] = std::array::from_fn(|k| z[DOFS + k]);
        self.left.iter().zip(&mut z[DOFS..]).for_each(|(row, v)| *v = dot(row, &speeds));
    }
}

/// A rig linearised, sample by sample.
pub(in crate::rig) struct Linear {
    system: [[f64; 10]; 10],
    step: Step<10, 5>,
    /// Steps a sample.
    steps: usize,
    /// Length of a step, s.
    step_s: f64,
    mass: [f64; DOFS],
    sensors: [usize; 2],
    tangent: Tangent,
}

impl Linear {
    /// Linearised rig in `steps` steps a sample.
    pub(in crate::rig) fn new(rig: &BearingRig, tangent: &Tangent, sample_rate_hz: f64, steps: usize) -> Self {
        let (mass, system) = (masses(rig), coupled(rig, tangent));
        let step_s = 1.0 / (steps as f64 * sample_rate_hz);
        let step = Step::new(&system, &mass.map(|m| 1.0 / m), step_s);
        let sensors = [rig.sensor.horizontal, rig.sensor.vertical].map(|location| location.dof());
        Self { system, step, steps, step_s, mass, sensors, tangent: *tangent }
    }

    /// Response to 1 N during the first sample, `direction` on each degree of freedom: at most `samples` samples, fewer once it
    /// has decayed to the share `decayed` of its greatest value. What `changing` has acts in addition, sample by sample.
    pub(in crate::rig) fn impulse<'d>(
        &self,
        direction: &[f64; DOFS],
        samples: usize,
        decayed: f64,
        changing: impl Iterator<Item = Changing<'d>>,
    ) -> Impulse {
        let Self { system, step, steps, step_s, mass, sensors, tangent } = self;
        let held = |i: usize| {
            let of = |k: usize| step.b1[i][k] + 2.0 * step.b2[i][k] + step.b3[i][k];
            direction.iter().enumerate().map(|(k, share)| share * of(k)).sum::<f64>()
        };
        let mut z: [f64; 10] = [0.0; 10];
        let mut signals = [(); 4].map(|()| Vec::with_capacity(samples));
        let mut velocities = [[0.0; DOFS]; DOFS];
        let (mut greatest, mut recent) = (0.0f64, 0.0f64);
        let half_s = 0.5 * step_s;
        for (sample, Changing { damping, contact }) in (0..samples).zip(changing) {
            let speeds: [f64; DOFS] = std::array::from_fn(|k| z[DOFS + k]);
            let passing = between_races(&contact, &z);
            for (signal, &dof) in signals.iter_mut().zip(sensors) {
                let free = dot(&system[DOFS + dof], &z);
                let dragged = damping.map_or(0.0, |d| dot(&d.slopes[dof], &speeds) / mass[dof]);
                let direct = if sample == 0 { direction[dof] / mass[dof] } else { 0.0 };
                let sensed = free - dragged + direct + passing[dof] / mass[dof];
                signal.push(sensed);
                recent = recent.max(sensed.abs());
            }
            let weighted: [f64; DOFS] = std::array::from_fn(|k| speeds[k] * damping.map_or(1.0, |d| d.weights[k]));
            for (row, one) in velocities.iter_mut().zip(weighted) {
                row.iter_mut().zip(weighted).for_each(|(sum, other)| *sum += one * other);
            }
            let places: [f64; DOFS] = std::array::from_fn(|k| z[k]);
            for (signal, dof) in signals[2..].iter_mut().zip([OUTER_X, OUTER_Y]) {
                let dragged =
                    dot(&tangent.damping[dof], &speeds) + damping.map_or(0.0, |d| dot(&d.slopes[dof], &speeds));
                signal.push(passing[dof] - dot(&tangent.stiffness[dof], &places) - dragged);
            }
            let push = |z: &mut [f64; 10]| {
                let force = between_races(&contact, z);
                (0..DOFS).for_each(|k| z[DOFS + k] += half_s * force[k] / mass[k]);
            };
            for _ in 0..*steps {
                // Half a step of what changes before and half after (G. Strang, SIAM J. Numer. Anal. 5 (1968) 506–517).
                damping.inspect(|d| d.half_a_step(&mut z));
                push(&mut z);
                z = std::array::from_fn(|i| dot(&step.full[i], &z) + if sample == 0 { held(i) } else { 0.0 });
                push(&mut z);
                damping.inspect(|d| d.half_a_step(&mut z));
            }
            if sample % LINEARISATION.decay_check_samples == LINEARISATION.decay_check_samples - 1 {
                greatest = greatest.max(recent);
                if recent < decayed * greatest {
                    break;
                }
                recent = 0.0;
            }
        }
        Impulse { signals, velocities }
    }
}

/// Force of a slope between the races, N, at positions.
fn between_races(slope: &[[f64; 2]; 2], z: &[f64; 10]) -> [f64; DOFS] {
    let apart = [z[INNER_X] - z[OUTER_X], z[INNER_Y] - z[OUTER_Y]];
    let [x, y] = slope.map(|row| dot(&row, &apart));
    let mut force = [0.0; DOFS];
    (force[INNER_X], force[OUTER_X], force[INNER_Y], force[OUTER_Y]) = (-x, x, -y, y);
    force
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Damping by the forces of effects at every visited state of a noise-free run, sample by sample, and the steps a sample that
/// follow it: for damping that changes so fast that its mean is no measure.
pub(in crate::rig) fn damping_along(
    rig: &BearingRig,
    forces: &[Force],
    visited: &[Visited],
    sample_rate_hz: f64,
) -> (Vec<Damping>, usize) {
    let mass = masses(rig);
    let spans = deviations(visited, |s| &s.2);
    let slopes_at = |state: &Visited| {
        let mut slopes = [[0.0; DOFS]; DOFS];
        for k in 0..DOFS {
            let of_k = slope(forces, state, LINEARISATION.noise_free_difference_std * spans[k], |_, v| &mut v[k]);
            slopes.iter_mut().zip(of_k).for_each(|(row, slope)| row[k] = slope);
        }
        slopes
    };
    let slopes: Vec<[[f64; DOFS]; DOFS]> = visited.iter().map(slopes_at).collect();
    let rates = slopes.iter().flat_map(|s| (0..DOFS).map(|k| s[k][k] / mass[k]));
    let per_sample = rates.fold(0.0, f64::max) / (sample_rate_hz * LINEARISATION.damping_rate_per_step);
    let steps = per_sample.ceil().clamp(1.0, LINEARISATION.max_damping_steps);
    let of = |slopes: [[f64; DOFS]; DOFS]| {
        // An implicit step, stable at any length.
        let implicit = std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                f64::from(u8::from(i == k)) + 0.5 * slopes[i][k] / (mass[i] * steps * sample_rate_hz)
            })
        });
        Damping { slopes, left: inverse(implicit), weights: [1.0; DOFS] }
    };
    let mut damping: Vec<Damping> = slopes.into_iter().map(of).collect();
    for k in 0..DOFS {
        let mean = damping.iter().map(|d| d.slopes[k][k]).sum::<f64>() / damping.len().max(1) as f64;
        if mean > 0.0 {
            damping.iter_mut().for_each(|d| d.weights[k] = (d.slopes[k][k] / mean).max(0.0).sqrt());
        }
    }
    (damping, steps as usize)
}

/// Inverse by Gauss–Jordan elimination without pivoting, for a matrix that is diagonal but for relative motions.
pub(super) fn inverse(mut a: [[f64; DOFS]; DOFS]) -> [[f64; DOFS]; DOFS] {
    for k in 0..DOFS {
        let pivot = 1.0 / a[k][k];
        a[k][k] = 1.0;
        a[k].iter_mut().for_each(|x| *x *= pivot);
        let row = a[k];
        for (_, other) in a.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = std::mem::take(&mut other[k]);
            other.iter_mut().zip(row).for_each(|(x, r)| *x -= factor * r);
        }
    }
    a
}

/// Slope −∂F/∂x of all forces together, by a difference of twice `step` in the coordinate or velocity x; 0 for no step.
pub(super) fn slope(
    forces: &[Force],
    (at, q, v): &Visited,
    step: f64,
    x: impl for<'a> Fn(&'a mut [f64; DOFS], &'a mut [f64; DOFS]) -> &'a mut f64,
) -> [f64; DOFS] {
    if step <= 0.0 {
        return [0.0; DOFS];
    }
    let moved = |by: f64| {
        let (mut q, mut v, mut sum) = (*q, *v, [0.0; DOFS]);
        *x(&mut q, &mut v) += by;
        forces.iter().for_each(|force| force(at, &q, &v, &mut sum));
        sum
    };
    let (up, down) = (moved(step), moved(-step));
    std::array::from_fn(|i| (down[i] - up[i]) / (2.0 * step))
}

/// Standard deviation of each coordinate over visited states.
fn deviations(visited: &[Visited], of: fn(&Visited) -> &[f64; DOFS]) -> [f64; DOFS] {
    let count = visited.len().max(1) as f64;
    std::array::from_fn(|k| {
        let mean = visited.iter().map(|s| of(s)[k]).sum::<f64>() / count;
        (visited.iter().map(|s| (of(s)[k] - mean).powi(2)).sum::<f64>() / count).sqrt()
    })
}

/// Matrix A of ż = A z of all five degrees of freedom (positions, then velocities), theory (50).
pub(super) fn coupled(rig: &BearingRig, tangent: &Tangent) -> [[f64; 10]; 10] {
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
    /// Tangent without the damping by forces of effects.
    pub(in crate::rig) fn undamped(self) -> Self {
        Self { damping: [[0.0; DOFS]; DOFS], ..self }
    }

    pub(super) fn of_contact(contact: [[f64; 2]; 2]) -> Self {
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
        Self { stiffness, damping: [[0.0; DOFS]; DOFS] }
    }
}

/// Mean slopes of the contact and of the forces of effects over the visited states of a run, theory (49).
pub(in crate::rig) fn along(rig: &BearingRig, forces: &[Force], visited: &[Visited]) -> Tangent {
    let count = visited.len().max(1) as f64;
    let mut contact = [[0.0; 2]; 2];
    for (at, q, _) in visited {
        let relative = [q[INNER_X] - q[OUTER_X], q[INNER_Y] - q[OUTER_Y]];
        let (_, slope) = contact_at(&rig.bearing, relative, normals(&rig.bearing, at.cage_rad));
        for (sum, row) in contact.iter_mut().flatten().zip(slope.into_iter().flatten()) {
            *sum += row / count;
        }
    }
    let mut tangent = Tangent::of_contact(contact);
    let (of_q, of_v) = (deviations(visited, |s| &s.1), deviations(visited, |s| &s.2));
    for state in visited {
        for k in 0..DOFS {
            let by_q = slope(forces, state, LINEARISATION.difference_std * of_q[k], |q, _| &mut q[k]);
            let by_v = slope(forces, state, LINEARISATION.difference_std * of_v[k], |_, v| &mut v[k]);
            for i in 0..DOFS {
                tangent.stiffness[i][k] += by_q[i] / count;
                tangent.damping[i][k] += by_v[i] / count;
            }
        }
    }
    tangent
}

/// Mean slope of the contact over positions of the cage, theory (49).
pub(in crate::rig) fn at_rest(slopes: &[[[f64; 2]; 2]]) -> Tangent {
    Tangent::of_contact(mean_slope(slopes))
}

fn mean_slope(slopes: &[[[f64; 2]; 2]]) -> [[f64; 2]; 2] {
    let mean = |i: usize, j: usize| slopes.iter().map(|s| s[i][j]).sum::<f64>() / slopes.len().max(1) as f64;
    std::array::from_fn(|i| std::array::from_fn(|j| mean(i, j)))
}

/// Slopes of the contact, N/m, at positions of the cage over one pitch, where the races rest under the load and the forces of effects.
pub(in crate::rig) fn slopes_at_rest(rig: &BearingRig, load_n: f64, forces: &[Force]) -> Vec<[[f64; 2]; 2]> {
    let pitch = TAU / rig.bearing.balls as f64;
    let count = LINEARISATION.cage_positions;
    let slope = |position: usize| {
        let at = Instant { cage_rad: pitch * position as f64 / count as f64, ..Instant::default() };
        let q = balanced_m(rig, load_n, &at, forces);
        let apart = [q[INNER_X] - q[OUTER_X], q[INNER_Y] - q[OUTER_Y]];
        contact_at(&rig.bearing, apart, normals(&rig.bearing, at.cage_rad)).1
    };
    (0..count).map(slope).collect()
}
