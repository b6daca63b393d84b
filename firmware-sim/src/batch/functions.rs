//! Functions of [`ballrace_core::math`] on vectors, to the same bits: the same operations in the same order, branches as
//! choices between lanes. Lanes out of their range go through the scalar functions.

use ballrace_core::math;
use pulp::{Simd, bytemuck};

/// Adding it puts the nearest whole number into the low bits of the mantissa.
const ROUNDER: f32 = 12_582_912.0;

/// Applies a scalar function to each lane.
#[cold]
pub fn lane_by_lane<S: Simd>(mut x: S::f32s, f: impl Fn(f32) -> f32) -> S::f32s {
    for lane in bytemuck::cast_slice_mut::<S::f32s, f32>(std::slice::from_mut(&mut x)) {
        *lane = f(*lane);
    }
    x
}

/// Whether every lane's magnitude is at most a limit; false where one is NaN.
#[inline(always)]
fn all_within<S: Simd>(simd: S, x: &[S::f32s], limit: f32) -> bool {
    let limit = simd.splat_f32s(limit);
    let all = simd.equal_u32s(simd.splat_u32s(0), simd.splat_u32s(0));
    let mut within = all;
    for x in x {
        within = simd.and_m32s(within, simd.less_than_or_equal_f32s(simd.abs_f32s(*x), limit));
    }
    simd.first_true_m32s(simd.xor_m32s(within, all)) >= S::F32_LANES
}

/// Logistic function 1 / (1 + e⁻ˣ) of each, in place.
#[inline(always)]
pub fn sigmoids<S: Simd>(simd: S, x: &mut [S::f32s]) {
    // Within, e⁻ˣ is neither subnormal nor infinite.
    if all_within(simd, x, 87.0) {
        for x in x {
            *x = sigmoid(simd, *x);
        }
    } else {
        for x in x {
            *x = lane_by_lane::<S>(*x, math::sigmoid);
        }
    }
}

/// Logistic function for |x| ≤ 87, the exponential as `libm`'s.
#[inline(always)]
fn sigmoid<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let c = |value| simd.splat_f32s(value);
    let magnitude = simd.abs_f32s(x);
    let x = simd.neg_f32s(x);
    // k = x / ln 2 rounded: half is added to the magnitude, and what is behind the point dropped.
    let above = simd.add_f32s(simd.mul_f32s(c(f32::from_bits(0x3fb8_aa3b)), magnitude), c(0.5));
    let nearest = simd.sub_f32s(simd.add_f32s(above, c(ROUNDER)), c(ROUNDER));
    let too_far = simd.greater_than_f32s(nearest, above);
    let truncated = simd.select_f32s(too_far, simd.sub_f32s(nearest, c(1.0)), nearest);
    let far = simd.greater_than_f32s(magnitude, c(f32::from_bits(0x3f85_1592)));
    let reduced = simd.greater_than_f32s(magnitude, c(f32::from_bits(0x3eb1_7218)));
    let k = simd.select_f32s(far, truncated, c(1.0));
    let k = simd.select_f32s(reduced, k, c(0.0));
    let sign = simd.and_u32s(simd.transmute_u32s_f32s(x), simd.splat_u32s(1 << 31));
    let k = simd.transmute_f32s_u32s(simd.or_u32s(simd.transmute_u32s_f32s(k), sign));
    let high = simd.sub_f32s(x, simd.mul_f32s(k, c(f32::from_bits(0x3f31_7200))));
    let low = simd.mul_f32s(k, c(f32::from_bits(0x35bf_be8e)));
    let r = simd.sub_f32s(high, low);
    let square = simd.mul_f32s(r, r);
    let tail = simd.add_f32s(c(1.666_662_5e-1), simd.mul_f32s(square, c(-2.766_733_3e-3)));
    let rational = simd.sub_f32s(r, simd.mul_f32s(square, tail));
    let quotient = simd.div_f32s(simd.mul_f32s(r, rational), simd.sub_f32s(c(2.0), rational));
    let mantissa = simd.add_f32s(c(1.0), simd.add_f32s(simd.sub_f32s(quotient, low), high));
    // Times 2^k: no exponent overflows within the range.
    let exponent = simd.transmute_u32s_f32s(simd.add_f32s(k, c(ROUNDER)));
    let exponent = simd.wrapping_dyn_shl_u32s(exponent, simd.splat_u32s(23));
    let scaled = simd.transmute_f32s_u32s(simd.add_u32s(simd.transmute_u32s_f32s(mantissa), exponent));
    let tiny = simd.less_than_or_equal_f32s(magnitude, c(f32::from_bits(0x3900_0000)));
    let exponential = simd.select_f32s(tiny, simd.add_f32s(c(1.0), x), scaled);
    simd.div_f32s(c(1.0), simd.add_f32s(c(1.0), exponential))
}

/// Sine.
#[inline(always)]
pub fn sin<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    if all_within(simd, &[x], 8191.0) { turned(simd, x, 0) } else { lane_by_lane::<S>(x, math::sin) }
}

/// Cosine.
#[inline(always)]
pub fn cos<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    if all_within(simd, &[x], 8191.0) { turned(simd, x, 1) } else { lane_by_lane::<S>(x, math::cos) }
}

/// Sine of an angle below 8192 rad, `quarters` quarter turns ahead.
#[inline(always)]
fn turned<S: Simd>(simd: S, x: S::f32s, quarters: u32) -> S::f32s {
    let c = |value| simd.splat_f32s(value);
    let bits = |value| simd.splat_u32s(value);
    let mul = |a, b| simd.mul_f32s(a, b);
    let add = |a, b| simd.add_f32s(a, b);
    let sub = |a, b| simd.sub_f32s(a, b);
    let shifted = add(mul(x, c(std::f32::consts::FRAC_2_PI)), c(ROUNDER));
    let k = sub(shifted, c(ROUNDER));
    let above = sub(sub(x, mul(k, c(1.570_312_5))), mul(k, c(4.837_513e-4)));
    let third = mul(k, c(7.549_533_6e-8));
    let r = sub(above, third);
    let rounded_off = sub(sub(above, r), third);
    let r = add(r, sub(rounded_off, mul(k, c(2.563_344e-12))));
    let z = mul(r, r);
    let inner = sub(mul(add(mul(c(-1.951_529_6e-4), z), c(8.332_161e-3)), z), c(0.166_666_55));
    let sine = add(r, mul(r, mul(inner, z)));
    let half = mul(c(0.5), z);
    let near = sub(c(1.0), half);
    let inner = sub(mul(c(2.443_315_7e-5), z), c(1.388_731_6e-3));
    let rest = mul(mul(add(mul(inner, z), c(4.166_664_6e-2)), z), z);
    let cosine = add(near, add(sub(sub(c(1.0), near), half), rest));
    // The low bits of the shifted number are those of k.
    let quadrant = simd.add_u32s(simd.transmute_u32s_f32s(shifted), bits(quarters));
    let odd = simd.equal_u32s(simd.and_u32s(quadrant, bits(1)), bits(1));
    let value = simd.select_f32s(odd, cosine, sine);
    let sign = simd.wrapping_dyn_shl_u32s(simd.and_u32s(quadrant, bits(2)), bits(30));
    simd.transmute_f32s_u32s(simd.xor_u32s(simd.transmute_u32s_f32s(value), sign))
}
