//! Angles of cage and shaft by rotation.

use super::Kernel;
use crate::rig::bearing::lanes::{Lanes, MAX_RUNS};

/// Cosine and sine of the cage's and the shaft's angle.
#[derive(Clone, Copy)]
pub(super) struct Angles<V> {
    pub cage: [V; 2],
    pub shaft: [V; 2],
}

impl<V: Copy> Angles<V> {
    #[inline(always)]
    pub(super) fn turned<L: Lanes<V = V>>(self, l: L, by: &Self) -> Self {
        let turn = |a: [V; 2], b: [V; 2]| {
            let c = l.sub(l.mul(a[0], b[0]), l.mul(a[1], b[1]));
            [c, l.mul_add(a[0], b[1], l.mul(a[1], b[0]))]
        };
        Self { cage: turn(self.cage, by.cage), shaft: turn(self.shaft, by.shaft) }
    }
}

impl<L: Lanes, const HOOKS: bool> Kernel<'_, L, HOOKS> {
    /// Angles at the start of a sample, and the rotation of half a step in it.
    pub(super) fn exact_angles(&mut self, sample: usize) -> (Angles<L::V>, Angles<L::V>) {
        self.advance_angles(sample);
        let l = self.l;
        let run_of = |r: usize| r.min(self.runs.len() - 1);
        let halves = 0.5 / self.runs[0].substeps as f64;
        let pitch = std::f64::consts::TAU / self.runs[0].balls as f64;
        let mut lanes = [[0.0; MAX_RUNS]; 9];
        // An index, as it goes into several arrays.
        #[allow(clippy::needless_range_loop)]
        for r in 0..L::RUNS {
            let run = &self.runs[run_of(r)];
            let time_s = (sample as f64 - run.settle as f64) / run.sample_rate_hz;
            let shaft = run.turning.shaft(time_s);
            let cage = run.turning.cage(time_s);
            let turned = (cage / pitch).floor();
            self.pitches[r] = turned.rem_euclid(run.balls as f64) as usize;
            let gain = self.gains[run_of(r)];
            for (k, angle) in [cage - turned * pitch, shaft, gain[1] * halves, gain[0] * halves].iter().enumerate() {
                let (s, c) = angle.sin_cos();
                (lanes[2 * k][r], lanes[2 * k + 1][r]) = (c, s);
            }
            lanes[8][r] = run.unbalance * run.turning.speed(time_s).powi(2);
        }
        if HOOKS && self.uneven {
            self.place_balls();
        }
        let v = |k: usize| l.load(&lanes[k]);
        self.setup.unbalance = v(8);
        let now = Angles { cage: [v(0), v(1)], shaft: [v(2), v(3)] };
        (now, Angles { cage: [v(4), v(5)], shaft: [v(6), v(7)] })
    }

    /// Moves the balls into the slots that the turn of each run's cage gives them.
    fn place_balls(&mut self) {
        let balls = self.runs[0].balls;
        for r in 0..L::RUNS {
            let angles = &self.runs[r.min(self.runs.len() - 1)].balls_rad;
            for slot in 0..balls {
                let ball = (slot + balls - self.pitches[r]) % balls;
                let even = std::f64::consts::TAU * slot as f64 / balls as f64;
                let (s, c) = (even + angles.get(ball).copied().unwrap_or(0.0)).sin_cos();
                let [cos, sin] = &mut self.uneven_slots;
                (cos[slot * L::RUNS + r], sin[slot * L::RUNS + r]) = (c, s);
            }
        }
    }

    pub(super) fn advance_angles(&mut self, sample: usize) {
        for (r, run) in self.runs.iter().enumerate() {
            let time_s = (sample as f64 - run.settle as f64) / run.sample_rate_hz;
            let next = time_s + 1.0 / run.sample_rate_hz;
            let (shaft, cage) = (run.turning.shaft(time_s), run.turning.cage(time_s));
            self.angles0[r] = [shaft, cage];
            self.gains[r] = [run.turning.shaft(next) - shaft, run.turning.cage(next) - cage];
        }
    }
}
