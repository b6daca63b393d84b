//! Integration of several runs side by side. Nothing is allocated in the loop.
//!
//! The contact force is summed in the cage's frame, theory (37), and needs no angle of a single ball. θ and ψ follow
//! rotation recurrences, set from the exact angles every `exact_angles_every` samples. θ is kept within one pitch of
//! balls, so that the loaded balls have the same index in all runs and the unloaded ones are skipped.

mod angles;
mod hooks;

use angles::Angles;

use super::{
    SETTINGS,
    lanes::{Lanes, MAX_RUNS},
    prepare::Prepared,
    setup::{Setup, gather},
    step::STATES,
};
use crate::rig::{
    effect::local_defect::Passage,
    state::{DOFS, Instant, OUTER_X, OUTER_Y},
};

/// Acceleration of the horizontal and the vertical sensor, m/s², and, if asked for, the force on the outer race in x and y
/// without the process force, N.
pub(in crate::rig) type Signals = [Vec<f64>; 4];
/// First index of the horizontal states.
const X: usize = 0;
/// First index of the vertical states.
const Y: usize = 4;
/// Index of each degree of freedom's position.
const POSITIONS: [usize; DOFS] = [X, X + 1, Y, Y + 1, Y + 2];
/// Index of each degree of freedom's velocity.
const VELOCITIES: [usize; DOFS] = [X + 2, X + 3, Y + 3, Y + 4, Y + 5];
/// Instants of a step at which forces are computed, in steps.
const INSTANTS: [f64; 3] = [0.0, 0.5, 1.0];
/// Index of the losses at the start of a step as they are, where the step itself uses the parabola of theory (45).
const AS_IT_IS: usize = 3;

#[inline(always)]
fn dot<L: Lanes, const N: usize>(l: L, row: &[L::V; N], z: &[L::V]) -> L::V {
    let mut sum = l.mul(row[0], z[0]);
    for k in 1..N {
        sum = l.mul_add(row[k], z[k], sum);
    }
    sum
}

#[inline(always)]
fn plus_dot<L: Lanes, const N: usize>(l: L, row: &[L::V; N], z: &[L::V], mut sum: L::V) -> L::V {
    for k in 0..N {
        sum = l.mul_add(row[k], z[k], sum);
    }
    sum
}

/// One group of runs with equal counts. `HOOKS`: effects act on forces or contact geometry.
pub(super) struct Kernel<'a, L: Lanes, const HOOKS: bool> {
    l: L,
    runs: &'a [Prepared],
    setup: Setup<L::V>,
    /// Ball pitch angles cos α_j, sin α_j.
    slots: Vec<[f64; 2]>,
    /// Whether the balls of any run are unevenly spaced.
    uneven: bool,
    /// Cosine and sine of the angle of the ball in each slot of each run, where balls are uneven.
    uneven_slots: [Vec<f64>; 2],
    /// Loss of deflection in each slot, at the three instants of a step, and [`AS_IT_IS`] where that begins.
    losses: [Vec<f64>; 4],
    /// Loss of deflection of each ball of one run.
    ball_losses: Vec<f64>,
    /// Balls of one run that pass a local defect in the step.
    passages: Vec<Passage>,
    /// Whether a ball of any run passes a local defect in the step.
    passing: bool,
    /// Angles of shaft and cage of each run at the start of the sample, rad.
    angles0: [[f64; 2]; MAX_RUNS],
    /// Gains of these angles over the sample, rad.
    gains: [[f64; 2]; MAX_RUNS],
    /// Ball pitches that each run's cage has turned.
    pitches: [usize; MAX_RUNS],
    /// Instants of a step, for each run.
    moments: [[Instant; INSTANTS.len()]; MAX_RUNS],
    /// Whether there are forces of effects in any run.
    forced: bool,
    /// Sample from the start of settling.
    sample: usize,
    /// Scratch for the states that forces of effects read.
    lanes_of_states: [[f64; MAX_RUNS]; STATES],
    /// Scratch for the forces that they add to.
    lanes_of_forces: [[f64; MAX_RUNS]; DOFS],
}

impl<'a, L: Lanes, const HOOKS: bool> Kernel<'a, L, HOOKS> {
    /// Kernel of at least one run, at most [`Lanes::RUNS`].
    #[inline(always)]
    pub(super) fn new(l: L, runs: &'a [Prepared]) -> Self {
        let balls = runs[0].balls;
        let slots = (0..balls).map(|j| {
            let (s, c) = (std::f64::consts::TAU * j as f64 / balls as f64).sin_cos();
            [c, s]
        });
        let losses = || vec![0.0; if HOOKS { balls * L::RUNS } else { 0 }];
        Self {
            l,
            runs,
            setup: Setup::new(l, runs),
            slots: slots.collect(),
            uneven: runs.iter().any(|run| !run.balls_rad.is_empty()),
            uneven_slots: [losses(), losses()],
            losses: [losses(), losses(), losses(), losses()],
            ball_losses: vec![0.0; balls],
            passages: Vec::new(),
            passing: false,
            angles0: [[0.0; 2]; MAX_RUNS],
            gains: [[0.0; 2]; MAX_RUNS],
            pitches: [0; MAX_RUNS],
            moments: [[Instant::default(); INSTANTS.len()]; MAX_RUNS],
            forced: runs.iter().any(Prepared::is_forced),
            sample: 0,
            lanes_of_states: [[0.0; MAX_RUNS]; STATES],
            lanes_of_forces: [[0.0; MAX_RUNS]; DOFS],
        }
    }

    /// Runs from rest under the load to the end; writes accelerations, m/s², from the preroll on. Where all runs have diverged it ends, with
    /// accelerations that are no numbers.
    #[inline(always)]
    pub(super) fn run(&mut self, out: &mut [Signals]) {
        let l = self.l;
        let first = &self.runs[0];
        let (settle, total) = (first.settle, first.settle + first.samples);
        let block = if first.drifting { 1 } else { SETTINGS.exact_angles_every };
        let mut z = [l.splat(0.0); STATES];
        for (dof, position) in POSITIONS.into_iter().enumerate() {
            z[position] = gather(l, self.runs, |run| run.rest_m[dof]);
        }
        let mut angles = Angles { cage: [l.splat(0.0); 2], shaft: [l.splat(0.0); 2] };
        let mut half_step = angles;
        for sample in 0..total {
            if sample % SETTINGS.exact_angles_every == 0 && self.have_diverged(&z) {
                // What follows is no number either.
                out.iter_mut().flat_map(|signals| &mut signals[..2]).for_each(|signal| signal.push(f64::NAN));
                return;
            }
            if sample % block == 0 {
                (angles, half_step) = self.exact_angles(sample);
            } else if HOOKS {
                self.advance_angles(sample);
            }
            self.sample = sample;
            self.setup.process = gather(l, self.runs, |run| run.process.get(sample).copied().unwrap_or(0.0));
            for substep in 0..first.substeps {
                if HOOKS {
                    self.prepare_step(sample, substep, sample % block == 0 && substep == 0);
                }
                let n0 = self.forces(0, angles, &z);
                if substep == 0 && sample + first.preroll >= settle {
                    let n = if HOOKS && self.passing { self.forces(AS_IT_IS, angles, &z) } else { n0 };
                    self.record(&z, &n, out);
                }
                (z, angles) = self.step(&z, n0, angles, &half_step);
            }
        }
    }

    /// Whether no run has a finite state.
    #[inline(always)]
    fn have_diverged(&self, z: &[L::V; STATES]) -> bool {
        let sum = z.iter().fold(self.l.splat(0.0), |sum, v| self.l.add(sum, *v));
        let mut lanes = [0.0; MAX_RUNS];
        self.l.store(sum, &mut lanes);
        !lanes[..self.runs.len()].iter().any(|sum| sum.is_finite())
    }

    #[inline(always)]
    fn step(
        &mut self,
        z: &[L::V; STATES],
        n0: [L::V; DOFS],
        angles: Angles<L::V>,
        half_step: &Angles<L::V>,
    ) -> ([L::V; STATES], Angles<L::V>) {
        let l = self.l;
        let middle = angles.turned(l, half_step);
        let end = middle.turned(l, half_step);

        // e^{Ah/2} z and e^{Ah} z. Without hooks the stages need only the relative displacements.
        let mut half = [l.splat(0.0); STATES];
        let mut full = half;
        let set = &self.setup;
        for i in 0..4 {
            full[X + i] = dot(l, &set.x.full[i], &z[X..]);
            if HOOKS {
                half[X + i] = dot(l, &set.x.half[i], &z[X..]);
            }
        }
        for i in 0..6 {
            full[Y + i] = dot(l, &set.y.full[i], &z[Y..]);
            if HOOKS {
                half[Y + i] = dot(l, &set.y.half[i], &z[Y..]);
            }
        }
        if !HOOKS {
            // Kept as x_s − x_p with x_p = 0, and so in y.
            half[X] = dot(l, &set.relative_x.half, &z[X..]);
            half[Y] = dot(l, &set.relative_y.half, &z[Y..]);
        }

        let a = self.stage_a(&half, &n0);
        let na = self.forces(1, middle, &a);
        let b = self.stage_a(&half, &na);
        let nb = self.forces(1, middle, &b);
        let c = self.stage_c(&full, &n0, &nb);
        let nc = self.forces(2, end, &c);
        let nab: [L::V; DOFS] = std::array::from_fn(|k| l.add(na[k], nb[k]));
        let set = &self.setup;
        for i in 0..4 {
            let sum = plus_dot(l, &set.x.b1[i], &n0[..2], full[X + i]);
            let sum = plus_dot(l, &set.x.b2[i], &nab[..2], sum);
            full[X + i] = plus_dot(l, &set.x.b3[i], &nc[..2], sum);
        }
        for i in 0..6 {
            let sum = plus_dot(l, &set.y.b1[i], &n0[2..], full[Y + i]);
            let sum = plus_dot(l, &set.y.b2[i], &nab[2..], sum);
            full[Y + i] = plus_dot(l, &set.y.b3[i], &nc[2..], sum);
        }
        (full, end)
    }

    /// Stages a and b: e^{Ah/2} z + A₂₁ n.
    #[inline(always)]
    fn stage_a(&self, half: &[L::V; STATES], n: &[L::V; DOFS]) -> [L::V; STATES] {
        let (l, set) = (self.l, &self.setup);
        let mut z = *half;
        if HOOKS {
            for i in 0..4 {
                z[X + i] = plus_dot(l, &set.x.a[i], &n[..2], z[X + i]);
            }
            for i in 0..6 {
                z[Y + i] = plus_dot(l, &set.y.a[i], &n[2..], z[Y + i]);
            }
        } else {
            z[X] = plus_dot(l, &set.relative_x.a, &n[..2], z[X]);
            z[Y] = plus_dot(l, &set.relative_y.a, &n[2..], z[Y]);
        }
        z
    }

    /// Stage c: e^{Ah} z + c₁ n(z) + 2 A₂₁ n(b).
    #[inline(always)]
    fn stage_c(&self, full: &[L::V; STATES], n0: &[L::V; DOFS], nb: &[L::V; DOFS]) -> [L::V; STATES] {
        let (l, set) = (self.l, &self.setup);
        let twice: [L::V; DOFS] = std::array::from_fn(|k| l.add(nb[k], nb[k]));
        let mut z = *full;
        if HOOKS {
            for i in 0..4 {
                let sum = plus_dot(l, &set.x.c1[i], &n0[..2], z[X + i]);
                z[X + i] = plus_dot(l, &set.x.a[i], &twice[..2], sum);
            }
            for i in 0..6 {
                let sum = plus_dot(l, &set.y.c1[i], &n0[2..], z[Y + i]);
                z[Y + i] = plus_dot(l, &set.y.a[i], &twice[2..], sum);
            }
        } else {
            let zero = l.splat(0.0);
            let sum = plus_dot(l, &set.relative_x.c1, &n0[..2], l.sub(z[X], z[X + 1]));
            z[X] = plus_dot(l, &set.relative_x.a, &twice[..2], sum);
            let sum = plus_dot(l, &set.relative_y.c1, &n0[2..], l.sub(z[Y], z[Y + 1]));
            z[Y] = plus_dot(l, &set.relative_y.a, &twice[2..], sum);
            (z[X + 1], z[Y + 1]) = (zero, zero);
        }
        z
    }

    /// Forces on the degrees of freedom, theory (29) to (37): contact, unbalance, constants, hooks.
    #[inline(always)]
    fn forces(&mut self, instant: usize, angles: Angles<L::V>, z: &[L::V; STATES]) -> [L::V; DOFS] {
        let (l, set) = (self.l, &self.setup);
        let (x, y) = (l.sub(z[X], z[X + 1]), l.sub(z[Y], z[Y + 1]));
        let [c, s] = angles.cage;
        let u = l.mul_add(x, c, l.mul(y, s));
        let w = l.sub(l.mul(y, c), l.mul(x, s));
        let zero = l.splat(0.0);
        let (mut fu, mut fw) = (zero, zero);
        for (j, &[cos, sin]) in self.slots.iter().enumerate() {
            let (cos, sin) = if HOOKS && self.uneven {
                let [cos, sin] = &self.uneven_slots;
                (l.load(&cos[j * L::RUNS..]), l.load(&sin[j * L::RUNS..]))
            } else {
                (l.splat(cos), l.splat(sin))
            };
            let mut deflection = l.sub(l.mul_add(u, cos, l.mul(w, sin)), set.clearance);
            if HOOKS {
                deflection = l.sub(deflection, l.load(&self.losses[instant][j * L::RUNS..]));
            }
            if l.any_positive(deflection) {
                let deflection = l.positive(deflection);
                let force = if set.hertzian { l.mul(deflection, l.sqrt(deflection)) } else { set.power(l, deflection) };
                fu = l.mul_add(force, cos, fu);
                fw = l.mul_add(force, sin, fw);
            }
        }
        let (fu, fw) = (l.mul(fu, set.stiffness), l.mul(fw, set.stiffness));
        let fx = l.sub(l.mul(fu, c), l.mul(fw, s));
        let fy = l.mul_add(fu, s, l.mul(fw, c));
        let [cos, sin] = angles.shaft;
        let forces = [
            l.sub(l.mul(set.unbalance, cos), fx),
            fx,
            l.add(l.sub(l.mul(set.unbalance, sin), fy), set.inner_y),
            l.add(fy, set.process),
            set.resonator_y,
        ];
        // Forces of effects do not depend on losses: the true start is the start.
        let instant = if instant == AS_IT_IS { 0 } else { instant };
        if HOOKS { self.hooks(forces, z, instant) } else { forces }
    }

    #[inline(always)]
    fn record(&self, z: &[L::V; STATES], n: &[L::V; DOFS], out: &mut [Signals]) {
        let l = self.l;
        let mut push = |channel: usize, v: L::V| {
            let mut lanes = [0.0; MAX_RUNS];
            l.store(v, &mut lanes);
            for (signals, value) in out.iter_mut().zip(lanes) {
                signals[channel].push(value);
            }
        };
        for channel in 0..2 {
            let a = dot(l, &self.setup.measured[channel], z);
            push(channel, plus_dot(l, &self.setup.direct[channel], n, a));
        }
        if self.runs[0].path_force {
            push(2, n[OUTER_X]);
            push(3, l.sub(n[OUTER_Y], self.setup.process));
        }
    }
}
