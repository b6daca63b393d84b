//! The 5-DoF bearing rig: theory (28) to (41); linearised, theory (49) and (50).

mod kernel;
mod lanes;
mod phi;
mod prepare;
mod response;
mod rest;
mod setup;
mod step;

use pulp::{Arch, Simd, WithSimd};

pub use prepare::{GRAVITY, Turning};
pub(super) use prepare::{Prepared, contact_rad_per_s, process_force};

pub(super) use response::{
    Changing, Impulse, Linear, Passing, Tangent, Visited, along, at_rest, damping_along, slopes_at_rest,
};

use kernel::Kernel;
pub(super) use kernel::Signals;
use lanes::{Lanes, One, Wide};

use super::settings::{IntegrationSettings, LinearisationSettings};
use crate::stats::cancel;

const SETTINGS: IntegrationSettings = IntegrationSettings::DEFAULT;
const LINEARISATION: LinearisationSettings = LinearisationSettings::DEFAULT;

/// Signals of each run, from its preroll on.
///
/// All runs must be of one [`Shape`](prepare::Shape).
pub(super) fn integrate(runs: &[Prepared]) -> Vec<Signals> {
    cancel::check();
    Arch::new().dispatch(Integrate(runs))
}

/// Runs in a vector of this machine.
pub(super) fn runs_per_vector() -> usize {
    struct Width;
    impl WithSimd for Width {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    Arch::new().dispatch(Width)
}

struct Integrate<'a>(&'a [Prepared]);

impl WithSimd for Integrate<'_> {
    type Output = Vec<Signals>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut out = Vec::with_capacity(self.0.len());
        for group in self.0.chunks(S::F64_LANES.max(1)) {
            let rows = group[0].samples + group[0].preroll;
            let from = out.len();
            let of_force = if group[0].path_force { rows } else { 0 };
            out.resize_with(from + group.len(), || [rows, rows, of_force, of_force].map(Vec::with_capacity));
            let out = &mut out[from..];
            if group.len() >= SETTINGS.vector_from_runs {
                run::<S, _>(simd, Wide(simd), group, out);
            } else {
                for (run_, out) in group.chunks(1).zip(out.chunks_mut(1)) {
                    // Scalar code has no fused instruction to call, the other instruction sets all do.
                    if S::F64_LANES == 1 {
                        run::<S, _>(simd, One::<false>, run_, out);
                    } else {
                        run::<S, _>(simd, One::<true>, run_, out);
                    }
                }
            }
        }
        out
    }
}

/// A function of its own with the instruction set's features, so that kernels are not inlined into one another.
#[inline(always)]
fn run<S: Simd, L: Lanes>(simd: S, l: L, runs: &[Prepared], out: &mut [Signals]) {
    struct Call<'a, L>(L, &'a [Prepared], &'a mut [Signals]);
    impl<L: Lanes> pulp::NullaryFnOnce for Call<'_, L> {
        type Output = ();
        #[inline(always)]
        fn call(self) {
            if runs_have_hooks(self.1) {
                Kernel::<L, true>::new(self.0, self.1).run(self.2);
            } else {
                Kernel::<L, false>::new(self.0, self.1).run(self.2);
            }
        }
    }
    simd.vectorize(Call(l, runs, out));
}

fn runs_have_hooks(runs: &[Prepared]) -> bool {
    runs[0].shape().hooks
}
