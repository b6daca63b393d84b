//! Where effects act within the loop, run by run in plain numbers.

use super::{Kernel, STATES};
use crate::rig::{
    bearing::{lanes::Lanes, setup::MAX_RUNS},
    plan::{DOFS, Moment},
};

impl<L: Lanes, const HOOKS: bool> Kernel<'_, L, HOOKS> {
    /// Adds the effects' forces, run by run.
    #[inline(never)]
    pub(super) fn hooks(
        &self,
        mut forces: [L::V; DOFS],
        z: &[L::V; STATES],
        sample: usize,
        substep: f64,
    ) -> [L::V; DOFS] {
        if self.runs.iter().all(|run| run.forces.is_empty()) {
            return forces;
        }
        let mut states = [[0.0; MAX_RUNS]; STATES];
        let mut sums = [[0.0; MAX_RUNS]; DOFS];
        for (v, lanes) in z.iter().zip(&mut states) {
            self.l.store(*v, lanes);
        }
        for (v, lanes) in forces.iter().zip(&mut sums) {
            self.l.store(*v, lanes);
        }
        for (r, run) in self.runs.iter().enumerate() {
            let at = self.moment(r, sample, substep);
            let q = [0, 1, 4, 5, 6].map(|k| states[k][r]);
            let v = [2, 3, 7, 8, 9].map(|k| states[k][r]);
            let mut sum = std::array::from_fn(|k| sums[k][r]);
            for force in &run.forces {
                force(&at, &q, &v, &mut sum);
            }
            for (lanes, value) in sums.iter_mut().zip(sum) {
                lanes[r] = value;
            }
        }
        for (v, lanes) in forces.iter_mut().zip(&sums) {
            *v = self.l.load(lanes);
        }
        forces
    }

    /// Fills in the losses of deflection of a step; its beginning is the end of the step before, but for the `first`.
    pub(super) fn lose(&mut self, sample: usize, substep: usize, first: bool) {
        let substep = substep as f64;
        if self.runs.iter().any(|run| !run.pits.is_empty()) {
            return self.pass(sample, substep);
        }
        if first {
            self.lose_at(0, sample, substep);
        } else {
            self.losses.swap(0, 2);
        }
        self.lose_at(1, sample, substep + 0.5);
        self.lose_at(2, sample, substep + 1.0);
    }

    /// The same where there are pits.
    #[inline(never)]
    fn pass(&mut self, sample: usize, substep: f64) {
        let smooth = self.runs.iter().any(|run| !run.profiles.is_empty());
        if self.passing || smooth {
            self.losses.iter_mut().for_each(|losses| losses.fill(0.0));
        }
        if smooth {
            for (instant, later) in [0.0, 0.5, 1.0].into_iter().enumerate() {
                self.lose_at(instant, sample, substep + later);
            }
            let [start, .., as_it_is] = &mut self.losses;
            as_it_is.copy_from_slice(start);
        }
        self.passing = false;
        for r in 0..self.runs.len() {
            let (pits, balls) = (&self.runs[r].pits, self.runs[r].balls);
            if pits.is_empty() {
                continue;
            }
            let moments = [0.0, 1.0].map(|later| self.moment(r, sample, substep + later));
            self.passages.clear();
            for pit in pits {
                pit(&moments, balls, &mut self.passages);
            }
            for passage in &self.passages {
                self.passing = true;
                let [start, middle, end] = passage.over_step();
                let slot = (passage.ball + self.pitches[r]) % balls * L::RUNS + r;
                for (losses, loss) in self.losses.iter_mut().zip([start, middle, end, passage.at_start()]) {
                    losses[slot] += loss;
                }
            }
        }
    }

    /// Fills in the loss of deflection at one instant of a step.
    #[inline(never)]
    fn lose_at(&mut self, instant: usize, sample: usize, substep: f64) {
        for r in 0..self.runs.len() {
            if self.runs[r].profiles.is_empty() {
                continue;
            }
            let at = self.moment(r, sample, substep);
            self.ball_losses.fill(0.0);
            for profile in &self.runs[r].profiles {
                profile(&at, &mut self.ball_losses);
            }
            let balls = self.ball_losses.len();
            for (ball, loss) in self.ball_losses.iter().enumerate() {
                let slot = (ball + self.pitches[r]) % balls;
                self.losses[instant][slot * L::RUNS + r] = *loss;
            }
        }
    }

    fn moment(&self, r: usize, sample: usize, substep: f64) -> Moment {
        let run = &self.runs[r];
        let fraction = substep / run.substeps as f64;
        let time_s = (sample as f64 - run.settle as f64 + fraction) / run.sample_rate_hz;
        let [shaft, cage] = self.angles0[r];
        Moment {
            time_s,
            shaft_rad: shaft + fraction * self.gains[r][0],
            shaft_rad_per_s: run.turning.speed(time_s),
            cage_rad: cage + fraction * self.gains[r][1],
        }
    }
}
