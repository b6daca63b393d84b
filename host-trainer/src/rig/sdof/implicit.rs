//! Implicit integration of stiff force laws: steep friction, a mass of almost nothing.
//!
//! The singly diagonally implicit Runge–Kutta method of order two, L-stable and stiffly accurate (R. Alexander, SIAM J.
//! Numer. Anal. 14 (1977) 1006–1021). With one degree of freedom each stage is one equation for one acceleration, which a
//! bracketing method always solves: a dissipative force falls with the velocity.

use super::Law;

/// γ = 1 − 1/√2.
pub(super) const GAMMA: f64 = 0.292_893_218_813_452_5;
/// Most evaluations of a stage's bracketing.
const MAX_EVALUATIONS: usize = 60;
/// Error of a stage's velocity at which it is solved, relative to its change.
const TOLERANCE: f64 = 1e-8;

impl Law {
    /// One implicit step of length `h` from `time_s`; the input is a line through `u`, its values at the stages.
    pub(super) fn implicit_step(&self, time_s: f64, u: [f64; 2], h: f64, [q, v]: [f64; 2], guess: f64) -> [f64; 3] {
        let part = GAMMA * h;
        let first = self.stage(time_s + part, u[0], part, [q, v], guess);
        let (v1, a1) = (v + part * first, first);
        let rest = (1.0 - GAMMA) * h;
        // Positions of a stage follow from its velocity.
        let base = [q + rest * v1, v + rest * a1];
        let last = self.stage(time_s + h, u[1], part, base, a1);
        let v2 = base[1] + part * last;
        [base[0] + part * v2, v2, last]
    }

    /// Acceleration A that is its own force law's at v + part·A and q + part·(v + part·A).
    fn stage(&self, time_s: f64, u: f64, part: f64, [q, v]: [f64; 2], guess: f64) -> f64 {
        let surplus = |a: f64| {
            let speed = v + part * a;
            self.acceleration(time_s, u, q + part * speed, speed) - a
        };
        let (mut low, mut f_low) = (guess, surplus(guess));
        let scale = v.abs() / part + guess.abs() + f_low.abs();
        if f_low == 0.0 || !f_low.is_finite() {
            return low;
        }
        // Towards the root, with growing steps.
        let mut step = f_low / 2.0;
        let (mut high, mut f_high) = (low + step, surplus(low + step));
        for _ in 0..MAX_EVALUATIONS {
            if f_low * f_high <= 0.0 || !f_high.is_finite() {
                break;
            }
            (low, f_low) = (high, f_high);
            step *= 2.0;
            (high, f_high) = (low + step, surplus(low + step));
        }
        // Regula falsi of Illinois.
        let mut side = 0;
        for _ in 0..MAX_EVALUATIONS {
            let middle = (low * f_high - high * f_low) / (f_high - f_low);
            if !middle.is_finite() || (high - low).abs() < TOLERANCE * scale {
                break;
            }
            let f = surplus(middle);
            if f == 0.0 || f.abs() < TOLERANCE * scale {
                return middle;
            }
            if f * f_high > 0.0 {
                (high, f_high) = (middle, f);
                if side == -1 {
                    f_low *= 0.5;
                }
                side = -1;
            } else {
                (low, f_low) = (middle, f);
                if side == 1 {
                    f_high *= 0.5;
                }
                side = 1;
            }
        }
        0.5 * (low + high)
    }
}
