//! What one thread of this machine can do at best.

use std::hint::black_box;
use std::time::Instant;

use ballrace::model::sindy_nn::layout::Layout;
use ballrace::model::sindy_nn::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Operations a second of one thread.
pub struct Floor {
    /// Multiply-adds.
    pub multiply_adds: f64,
    /// Sigmoids.
    pub sigmoids: f64,
}

impl Floor {
    /// Least seconds for `samples` samples' losses and gradients on `threads` threads.
    pub fn seconds(&self, layout: &Layout, samples: f64, threads: usize) -> f64 {
        let each = layout.multiply_adds() as f64 / self.multiply_adds + layout.sigmoids() as f64 / self.sigmoids;
        samples * each / threads as f64
    }
}

const ROUNDS: usize = 20_000;

struct MultiplyAdds;

impl WithSimd for MultiplyAdds {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let (a, b) = (simd.splat_f32s(black_box(0.999)), simd.splat_f32s(black_box(1e-3)));
        let mut sums = [simd.splat_f32s(0.0); 16];
        for _ in 0..ROUNDS {
            for sum in &mut sums {
                *sum = simd.mul_add_e_f32s(a, *sum, b);
            }
        }
        black_box(sums);
        ROUNDS * sums.len() * S::F32_LANES
    }
}

struct Sigmoids;

impl WithSimd for Sigmoids {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let mut values = [simd.splat_f32s(black_box(0.3)); 64];
        for _ in 0..ROUNDS / 64 {
            for v in &mut values {
                *v = <f32 as Real>::sigmoid(simd, *v);
            }
        }
        black_box(values);
        ROUNDS / 64 * values.len() * S::F32_LANES
    }
}

/// Best of several short runs: short enough that some are not interrupted.
pub fn measure() -> Floor {
    let arch = Arch::new();
    let best = |run: &dyn Fn() -> usize| {
        (0..200)
            .map(|_| {
                let start = Instant::now();
                let count = run();
                count as f64 / start.elapsed().as_secs_f64()
            })
            .fold(0.0, f64::max)
    };
    Floor { multiply_adds: best(&|| arch.dispatch(MultiplyAdds)), sigmoids: best(&|| arch.dispatch(Sigmoids)) }
}
