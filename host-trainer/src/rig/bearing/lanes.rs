//! Several runs side by side, one in each lane of a vector; or one run alone.
//!
//! Both do the same roundings, so a run gives the same bits alone and among others.

use pulp::{Simd, bytemuck};

/// Lanes of the widest vector (AVX-512).
pub(super) const MAX_RUNS: usize = 8;

/// Arithmetic on a vector of runs.
pub(super) trait Lanes: Copy {
    /// One number for each run.
    type V: Copy + Send + Sync;
    /// Runs in a vector.
    const RUNS: usize;

    /// One number for all runs.
    fn splat(self, value: f64) -> Self::V;
    /// One number for each run from the first `RUNS` of a slice.
    fn load(self, values: &[f64]) -> Self::V;
    /// Each run's number.
    fn store(self, v: Self::V, values: &mut [f64]);
    /// Sum a + b.
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// Difference a − b.
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// Product a · b.
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// Product and sum a · b + c.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// Positive part max(a, 0).
    fn positive(self, a: Self::V) -> Self::V;
    /// Whether any run's number is above 0.
    fn any_positive(self, a: Self::V) -> bool;
    /// Square root.
    fn sqrt(self, a: Self::V) -> Self::V;
}

/// A run in each lane of the instruction set's vectors.
#[derive(Clone, Copy)]
pub(super) struct Wide<S>(pub S);

impl<S: Simd> Lanes for Wide<S> {
    type V = S::f64s;
    const RUNS: usize = S::F64_LANES;

    #[inline(always)]
    fn splat(self, value: f64) -> S::f64s {
        self.0.splat_f64s(value)
    }
    #[inline(always)]
    fn load(self, values: &[f64]) -> S::f64s {
        S::as_simd_f64s(values).0[0]
    }
    #[inline(always)]
    fn store(self, v: S::f64s, values: &mut [f64]) {
        values[..Self::RUNS].copy_from_slice(bytemuck::cast_slice::<S::f64s, f64>(&[v]));
    }
    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }
    #[inline(always)]
    fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.sub_f64s(a, b)
    }
    #[inline(always)]
    fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }
    #[inline(always)]
    fn mul_add(self, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
        self.0.mul_add_e_f64s(a, b, c)
    }
    #[inline(always)]
    fn positive(self, a: S::f64s) -> S::f64s {
        self.0.max_f64s(a, self.0.splat_f64s(0.0))
    }
    #[inline(always)]
    fn any_positive(self, a: S::f64s) -> bool {
        let mask = self.0.greater_than_f64s(a, self.0.splat_f64s(0.0));
        self.0.first_true_m64s(mask) < Self::RUNS
    }
    #[inline(always)]
    fn sqrt(self, a: S::f64s) -> S::f64s {
        self.0.sqrt_f64s(a)
    }
}

/// One run. `FUSED` where the vectors of [`Wide`] multiply and add in one rounding.
#[derive(Clone, Copy)]
pub(super) struct One<const FUSED: bool>;

impl<const FUSED: bool> Lanes for One<FUSED> {
    type V = f64;
    const RUNS: usize = 1;

    #[inline(always)]
    fn splat(self, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn load(self, values: &[f64]) -> f64 {
        values[0]
    }
    #[inline(always)]
    fn store(self, v: f64, values: &mut [f64]) {
        values[0] = v;
    }
    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f64, b: f64) -> f64 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f64, b: f64) -> f64 {
        a * b
    }
    #[inline(always)]
    fn mul_add(self, a: f64, b: f64, c: f64) -> f64 {
        if FUSED { a.mul_add(b, c) } else { a * b + c }
    }
    #[inline(always)]
    fn positive(self, a: f64) -> f64 {
        if a > 0.0 { a } else { 0.0 }
    }
    #[inline(always)]
    fn any_positive(self, a: f64) -> bool {
        a > 0.0
    }
    #[inline(always)]
    fn sqrt(self, a: f64) -> f64 {
        a.sqrt()
    }
}
