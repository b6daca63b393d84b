//! Action of effects within the loop, run by run in plain numbers.

use super::{INSTANTS, Kernel, POSITIONS, STATES, VELOCITIES};
use crate::rig::{bearing::lanes::Lanes, state::DOFS};

impl<L: Lanes, const HOOKS: bool> Kernel<'_, L, HOOKS> {
    /// Prepares a step for the effects: its instants, and the losses of deflection.
    #[inline(never)]
    pub(super) fn prepare_step(&mut self, sample: usize, substep: usize, first: bool) {
        for (r, run) in self.runs.iter().enumerate() {
            for (moment, later) in self.moments[r].iter_mut().zip(INSTANTS) {
                *moment = run.moment(self.angles0[r], self.gains[r], sample, substep as f64 + later);
            }
        }
        self.lose(first);
    }

    /// Adds the effects' forces, run by run.
    #[inline(always)]
    pub(super) fn hooks(&mut self, mut forces: [L::V; DOFS], z: &[L::V; STATES], instant: usize) -> [L::V; DOFS] {
        if !self.forced {
            return forces;
        }
        let (l, states, sums) = (self.l, &mut self.lanes_of_states, &mut self.lanes_of_forces);
        z.iter().zip(&mut *states).for_each(|(v, lanes)| l.store(*v, lanes));
        forces.iter().zip(&mut *sums).for_each(|(v, lanes)| l.store(*v, lanes));
        // Filled in place: copies of arrays that were just written number by number stall.
        let (mut q, mut v, mut sum) = ([0.0; DOFS], [0.0; DOFS], [0.0; DOFS]);
        for (r, run) in self.runs.iter().enumerate().filter(|(_, run)| run.is_forced()) {
            for k in 0..DOFS {
                (q[k], v[k], sum[k]) = (states[POSITIONS[k]][r], states[VELOCITIES[k]][r], sums[k][r]);
            }
            for force in &run.forces {
                force(&self.moments[r][instant], &q, &v, &mut sum);
            }
            if let Some(random) = run.random.get(self.sample) {
                sum.iter_mut().zip(random).for_each(|(sum, force)| *sum += force);
            }
            sums.iter_mut().zip(&sum).for_each(|(lanes, value)| lanes[r] = *value);
        }
        forces.iter_mut().zip(&*sums).for_each(|(v, lanes)| *v = l.load(lanes));
        forces
    }

    /// Fills in the losses of deflection of a step; its start is the end of the step before, except for the `first`.
    fn lose(&mut self, first: bool) {
        if self.runs.iter().any(|run| !run.defects.is_empty()) {
            return self.pass();
        }
        if first {
            self.lose_at(0);
        } else {
            self.losses.swap(0, 2);
        }
        self.lose_at(1);
        self.lose_at(2);
    }

    /// Fills in the losses of deflection of a step with local defects, theory (44) and (45).
    fn pass(&mut self) {
        let smooth = self.runs.iter().any(|run| !run.profiles.is_empty());
        if self.passing || smooth {
            self.losses.iter_mut().for_each(|losses| losses.fill(0.0));
        }
        if smooth {
            (0..INSTANTS.len()).for_each(|instant| self.lose_at(instant));
            let [start, .., as_it_is] = &mut self.losses;
            as_it_is.copy_from_slice(start);
        }
        self.passing = false;
        for (r, run) in self.runs.iter().enumerate().filter(|(_, run)| !run.defects.is_empty()) {
            let [from, _, to] = self.moments[r];
            self.passages.clear();
            for defect in &run.defects {
                defect(&[from, to], run.balls, &mut self.passages);
            }
            for passage in &self.passages {
                self.passing = true;
                let [start, middle, end] = passage.over_step();
                let slot = self.slot(r, passage.ball);
                for (losses, loss) in self.losses.iter_mut().zip([start, middle, end, passage.at_start()]) {
                    losses[slot] += loss;
                }
            }
        }
    }

    /// Fills in the loss of deflection at one instant of a step.
    fn lose_at(&mut self, instant: usize) {
        for (r, run) in self.runs.iter().enumerate().filter(|(_, run)| !run.profiles.is_empty()) {
            self.ball_losses.fill(0.0);
            for profile in &run.profiles {
                profile(&self.moments[r][instant], &mut self.ball_losses);
            }
            for (ball, loss) in self.ball_losses.iter().enumerate() {
                let slot = self.slot(r, ball);
                self.losses[instant][slot] = *loss;
            }
        }
    }

    /// Index of a ball's losses, by the turn of its run's cage.
    fn slot(&self, r: usize, ball: usize) -> usize {
        let balls = self.slots.len();
        let slot = ball + self.pitches[r];
        L::RUNS * if slot < balls { slot } else { slot - balls } + r
    }
}
