//! Scalars of the kernel: `f32` to train, `f64` to check gradients against finite differences.
//!
//! One kernel source for both and for every instruction set: pulp picks AVX-512, AVX2 or NEON at run time.

use pulp::{Simd, bytemuck};

/// A scalar with its SIMD vector.
pub trait Real:
    Copy + Send + Sync + Default + PartialEq + PartialOrd + std::ops::AddAssign + std::fmt::Debug + 'static
{
    /// Vector of the instruction set `S`.
    type V<S: Simd>: Copy + Send + Sync + std::fmt::Debug;

    /// Zero.
    const ZERO: Self;
    /// Rounds a double.
    fn from_f64(value: f64) -> Self;
    /// Value as a double.
    fn to_f64(self) -> f64;
    /// Lanes of a vector.
    fn lanes<S: Simd>() -> usize;
    /// Slice as vectors; a remainder is left out.
    fn vectors<S: Simd>(slice: &[Self]) -> &[Self::V<S>];
    /// Mutable slice as vectors; a remainder is left out.
    fn vectors_mut<S: Simd>(slice: &mut [Self]) -> &mut [Self::V<S>];
    /// Vector with one value in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::V<S>;
    /// Sum a + b.
    fn add<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Difference a − b.
    fn sub<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Product a · b.
    fn mul<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// Fused a · b + c.
    fn mul_add<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>, c: Self::V<S>) -> Self::V<S>;
    /// Sum of the lanes.
    fn sum<S: Simd>(simd: S, a: Self::V<S>) -> Self;
    /// Sigmoid 1 / (1 + e⁻ᵃ); for `f32` to 2e-7.
    fn sigmoid<S: Simd>(simd: S, a: Self::V<S>) -> Self::V<S>;
    /// Sine and cosine of a; for `f32` to 3e-7 up to |a| = 1e4.
    fn sin_cos<S: Simd>(simd: S, a: Self::V<S>) -> (Self::V<S>, Self::V<S>);
}

macro_rules! arithmetic {
    ($lanes:ident, $as_simd:ident, $as_mut_simd:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $fma:ident, $sum:ident) => {
        #[inline(always)]
        fn lanes<S: Simd>() -> usize {
            S::$lanes
        }
        #[inline(always)]
        fn vectors<S: Simd>(slice: &[Self]) -> &[Self::V<S>] {
            S::$as_simd(slice).0
        }
        #[inline(always)]
        fn vectors_mut<S: Simd>(slice: &mut [Self]) -> &mut [Self::V<S>] {
            S::$as_mut_simd(slice).0
        }
        #[inline(always)]
        fn splat<S: Simd>(simd: S, value: Self) -> Self::V<S> {
            simd.$splat(value)
        }
        #[inline(always)]
        fn add<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S> {
            simd.$add(a, b)
        }
        #[inline(always)]
        fn sub<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S> {
            simd.$sub(a, b)
        }
        #[inline(always)]
        fn mul<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S> {
            simd.$mul(a, b)
        }
        #[inline(always)]
        fn mul_add<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>, c: Self::V<S>) -> Self::V<S> {
            simd.$fma(a, b, c)
        }
        #[inline(always)]
        fn sum<S: Simd>(simd: S, a: Self::V<S>) -> Self {
            simd.$sum(a)
        }
    };
}

/// Rounding constant 1.5·2²³: added to a small float, it puts the nearest integer into the low mantissa bits.
const ROUNDER: f32 = 12_582_912.0;

impl Real for f32 {
    type V<S: Simd> = S::f32s;
    const ZERO: Self = 0.0;

    fn from_f64(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        self.into()
    }

    arithmetic!(
        F32_LANES,
        as_simd_f32s,
        as_mut_simd_f32s,
        splat_f32s,
        add_f32s,
        sub_f32s,
        mul_f32s,
        mul_add_e_f32s,
        reduce_sum_f32s
    );

    #[inline(always)]
    fn sigmoid<S: Simd>(simd: S, a: Self::V<S>) -> Self::V<S> {
        let c = |v| simd.splat_f32s(v);
        // e^y = 2^n e^r with y = −a, r = y − n ln 2, |r| ≤ ln 2 / 2; the clamp keeps 2^n normal.
        let y = simd.min_f32s(simd.max_f32s(simd.sub_f32s(c(0.0), a), c(-87.0)), c(87.0));
        let shifted = simd.mul_add_e_f32s(y, c(std::f32::consts::LOG2_E), c(ROUNDER));
        let n = simd.sub_f32s(shifted, c(ROUNDER));
        let r = simd.mul_add_e_f32s(n, c(-0.693_359_4), y);
        let r = simd.mul_add_e_f32s(n, c(2.121_944_4e-4), r);
        // Minimax polynomial of (e^r − 1 − r)/r² on that interval (Cephes expf).
        let mut p = c(1.987_569_1e-4);
        for k in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1] {
            p = simd.mul_add_e_f32s(p, r, c(k));
        }
        let e_r = simd.add_f32s(simd.mul_add_e_f32s(p, simd.mul_f32s(r, r), r), c(1.0));
        let exponent = simd.wrapping_dyn_shl_u32s(simd.transmute_u32s_f32s(shifted), simd.splat_u32s(23));
        let e_y = simd.transmute_f32s_u32s(simd.add_u32s(simd.transmute_u32s_f32s(e_r), exponent));
        simd.div_f32s(c(1.0), simd.add_f32s(c(1.0), e_y))
    }

    #[inline(always)]
    fn sin_cos<S: Simd>(simd: S, a: Self::V<S>) -> (Self::V<S>, Self::V<S>) {
        let c = |v| simd.splat_f32s(v);
        // a = n π/2 + r, |r| ≤ π/4, π/2 in three parts (Cody and Waite).
        let shifted = simd.mul_add_e_f32s(a, c(std::f32::consts::FRAC_2_PI), c(ROUNDER));
        let n = simd.sub_f32s(shifted, c(ROUNDER));
        let mut r = a;
        for part in [-1.570_312_5, -4.837_513e-4, -7.549_79e-8] {
            r = simd.mul_add_e_f32s(n, c(part), r);
        }
        let r2 = simd.mul_f32s(r, r);
        // Cephes sinf and cosf on ±π/4.
        let mut s = c(-1.951_529_6e-4);
        for k in [8.332_161e-3, -1.666_665_5e-1] {
            s = simd.mul_add_e_f32s(s, r2, c(k));
        }
        let s = simd.mul_add_e_f32s(simd.mul_f32s(s, r2), r, r);
        let mut k = c(2.443_315_7e-5);
        for v in [-1.388_731_6e-3, 4.166_664_6e-2] {
            k = simd.mul_add_e_f32s(k, r2, c(v));
        }
        let k = simd.mul_add_e_f32s(simd.mul_f32s(k, r2), r2, simd.mul_add_e_f32s(r2, c(-0.5), c(1.0)));
        // Quadrant: odd swaps sine and cosine, the second bit negates.
        let bits = simd.transmute_u32s_f32s(shifted);
        let odd = simd.wrapping_dyn_shl_u32s(bits, simd.splat_u32s(31));
        let swap = simd.equal_u32s(odd, simd.splat_u32s(1 << 31));
        let sine = simd.select_f32s(swap, k, s);
        let cosine = simd.select_f32s(swap, s, k);
        let sign = |bits| {
            let second = simd.and_u32s(bits, simd.splat_u32s(2));
            simd.wrapping_dyn_shl_u32s(second, simd.splat_u32s(30))
        };
        let negate = |v, bits| simd.transmute_f32s_u32s(simd.xor_u32s(simd.transmute_u32s_f32s(v), sign(bits)));
        (negate(sine, bits), negate(cosine, simd.add_u32s(bits, simd.splat_u32s(1))))
    }
}

impl Real for f64 {
    type V<S: Simd> = S::f64s;
    const ZERO: Self = 0.0;

    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }

    arithmetic!(
        F64_LANES,
        as_simd_f64s,
        as_mut_simd_f64s,
        splat_f64s,
        add_f64s,
        sub_f64s,
        mul_f64s,
        mul_add_e_f64s,
        reduce_sum_f64s
    );

    #[inline(always)]
    fn sigmoid<S: Simd>(_: S, a: Self::V<S>) -> Self::V<S> {
        lane_by_lane::<S>(a, |v| 1.0 / (1.0 + (-v).exp()))
    }

    #[inline(always)]
    fn sin_cos<S: Simd>(_: S, a: Self::V<S>) -> (Self::V<S>, Self::V<S>) {
        (lane_by_lane::<S>(a, f64::sin), lane_by_lane::<S>(a, f64::cos))
    }
}

fn lane_by_lane<S: Simd>(mut a: S::f64s, f: impl Fn(f64) -> f64) -> S::f64s {
    for lane in bytemuck::cast_slice_mut::<S::f64s, f64>(std::slice::from_mut(&mut a)) {
        *lane = f(*lane);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Each<'a>(&'a [f32], &'a mut [[f32; 3]]);

    impl WithSimd for Each<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for (x, out) in self.0.iter().zip(self.1) {
                let first = |v: S::f32s| bytemuck::cast_slice::<S::f32s, f32>(&[v])[0];
                let v = simd.splat_f32s(*x);
                let (s, c) = <f32 as Real>::sin_cos(simd, v);
                *out = [first(<f32 as Real>::sigmoid(simd, v)), first(s), first(c)];
            }
        }
    }

    #[test]
    fn vector_functions_hold_their_stated_errors() {
        let x: Vec<f32> = (-100_000..=100_000).map(|i| i as f32 * 1e-3).collect();
        let mut out = vec![[0.0; 3]; x.len()];
        Arch::new().dispatch(Each(&x, &mut out));
        let mut worst = [0.0f64; 3];
        for (x, got) in x.iter().zip(&out) {
            let x = f64::from(*x);
            let exact = [1.0 / (1.0 + (-x).exp()), x.sin(), x.cos()];
            for k in 0..3 {
                worst[k] = worst[k].max((f64::from(got[k]) - exact[k]).abs());
            }
        }
        assert!(worst[0] < 2e-7 && worst[1] < 3e-7 && worst[2] < 3e-7, "{worst:?}");
    }
}
