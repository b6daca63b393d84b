//! Numbers of a group of runs as vectors, a run in each lane.

use super::{
    lanes::{Lanes, MAX_RUNS},
    prepare::Prepared,
    step::{STATES, Step},
};
use crate::rig::state::DOFS;

/// Matrices of one step, as in [`Step`].
pub(super) struct Block<V, const N: usize, const M: usize> {
    pub half: [[V; N]; N],
    pub full: [[V; N]; N],
    pub a: [[V; M]; N],
    pub c1: [[V; M]; N],
    pub b1: [[V; M]; N],
    pub b2: [[V; M]; N],
    pub b3: [[V; M]; N],
}

/// Rows for inner minus outer displacement.
pub(super) struct Relative<V, const N: usize, const M: usize> {
    pub half: [V; N],
    pub a: [V; M],
    pub c1: [V; M],
}

/// Constants of the loop.
pub(super) struct Setup<V> {
    pub x: Block<V, 4, 2>,
    pub y: Block<V, 6, 3>,
    pub relative_x: Relative<V, 4, 2>,
    pub relative_y: Relative<V, 6, 3>,
    /// Acceleration of each channel from states.
    pub measured: [[V; STATES]; 2],
    /// Acceleration of each channel from forces.
    pub direct: [[V; DOFS]; 2],
    pub clearance: V,
    pub stiffness: V,
    exponent: V,
    /// Whether all exponents are 1.5.
    pub hertzian: bool,
    /// Constant force F_load − m_s g.
    pub inner_y: V,
    /// Constant force −m_r g.
    pub resonator_y: V,
    /// Unbalance force m e ω².
    pub unbalance: V,
    /// Process force of the current sample.
    pub process: V,
}

/// One number of each run; the last run's fills the remaining lanes.
#[inline(always)]
pub(super) fn gather<L: Lanes>(l: L, runs: &[Prepared], of: impl Fn(&Prepared) -> f64) -> L::V {
    let lanes: [f64; MAX_RUNS] = std::array::from_fn(|r| of(&runs[r.min(runs.len() - 1)]));
    l.load(&lanes)
}

#[inline(always)]
fn matrix<L: Lanes, const R: usize, const C: usize>(
    l: L,
    runs: &[Prepared],
    of: impl Fn(&Prepared) -> &[[f64; C]; R],
) -> [[L::V; C]; R] {
    std::array::from_fn(|i| std::array::from_fn(|j| gather(l, runs, |run| of(run)[i][j])))
}

impl<V: Copy, const N: usize, const M: usize> Block<V, N, M> {
    #[inline(always)]
    fn new<L: Lanes<V = V>>(l: L, runs: &[Prepared], of: impl Fn(&Prepared) -> &Step<N, M>) -> Self {
        Self {
            half: matrix(l, runs, |run| &of(run).half),
            full: matrix(l, runs, |run| &of(run).full),
            a: matrix(l, runs, |run| &of(run).a),
            c1: matrix(l, runs, |run| &of(run).c1),
            b1: matrix(l, runs, |run| &of(run).b1),
            b2: matrix(l, runs, |run| &of(run).b2),
            b3: matrix(l, runs, |run| &of(run).b3),
        }
    }

    #[inline(always)]
    fn relative<L: Lanes<V = V>>(&self, l: L) -> Relative<V, N, M> {
        Relative {
            half: std::array::from_fn(|j| l.sub(self.half[0][j], self.half[1][j])),
            a: std::array::from_fn(|j| l.sub(self.a[0][j], self.a[1][j])),
            c1: std::array::from_fn(|j| l.sub(self.c1[0][j], self.c1[1][j])),
        }
    }
}

impl<V: Copy> Setup<V> {
    #[inline(always)]
    pub(super) fn new<L: Lanes<V = V>>(l: L, runs: &[Prepared]) -> Self {
        assert!(L::RUNS <= MAX_RUNS && (1..=L::RUNS).contains(&runs.len()));
        let x = Block::new(l, runs, |run| &run.x);
        let y = Block::new(l, runs, |run| &run.y);
        let number = |of: fn(&Prepared) -> f64| gather(l, runs, of);
        Self {
            relative_x: x.relative(l),
            relative_y: y.relative(l),
            x,
            y,
            measured: matrix(l, runs, |run| &run.measured),
            direct: matrix(l, runs, |run| &run.direct),
            clearance: number(|run| run.clearance),
            stiffness: number(|run| run.stiffness),
            exponent: number(|run| run.exponent),
            hertzian: runs[0].exponent == 1.5,
            inner_y: number(|run| run.inner_y),
            resonator_y: number(|run| run.resonator_y),
            unbalance: l.splat(0.0),
            process: l.splat(0.0),
        }
    }

    /// Power δ^p with each run's own p.
    #[inline(never)]
    pub(super) fn power<L: Lanes<V = V>>(&self, l: L, deflection: V) -> V {
        let (mut base, mut exponent) = ([0.0; MAX_RUNS], [0.0; MAX_RUNS]);
        l.store(deflection, &mut base);
        l.store(self.exponent, &mut exponent);
        for r in 0..L::RUNS {
            // 0^p would be slow, and most balls are unloaded.
            base[r] = if base[r] > 0.0 { base[r].powf(exponent[r]) } else { 0.0 };
        }
        l.load(&base)
    }
}
