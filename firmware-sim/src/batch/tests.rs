use super::*;
use ballrace_core::math;
use pulp::{Simd, WithSimd, bytemuck};

#[derive(Clone, Copy)]
enum Function {
    Sigmoid,
    Sin,
    Cos,
}

/// Bits at which a function on vectors differs from the scalar one, at most one of each thread.
struct Differing {
    function: Function,
    bits: std::ops::Range<u64>,
    stride: u64,
}

impl WithSimd for Differing {
    type Output = Option<f32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<f32> {
        let Self { function, bits, stride } = self;
        let mut x = simd.splat_f32s(0.0);
        for first in bits.step_by(S::F32_LANES * stride as usize) {
            let lanes = bytemuck::cast_slice_mut::<S::f32s, f32>(std::slice::from_mut(&mut x));
            for (i, lane) in lanes.iter_mut().enumerate() {
                *lane = f32::from_bits((first + i as u64 * stride) as u32);
            }
            let (found, scalar): (_, fn(f32) -> f32) = match function {
                Function::Sigmoid => {
                    let mut found = x;
                    functions::sigmoids(simd, std::slice::from_mut(&mut found));
                    (found, math::sigmoid)
                }
                Function::Sin => (functions::sin(simd, x), math::sin),
                Function::Cos => (functions::cos(simd, x), math::cos),
            };
            let lanes = bytemuck::cast_slice::<S::f32s, f32>(std::slice::from_ref(&x));
            let found = bytemuck::cast_slice::<S::f32s, f32>(std::slice::from_ref(&found));
            for (x, found) in lanes.iter().zip(found) {
                let expected = scalar(*x);
                if found.to_bits() != expected.to_bits() && !(found.is_nan() && expected.is_nan()) {
                    return Some(*x);
                }
            }
        }
        None
    }
}

/// Every `BALLRACE_STRIDE`-th `f32`, 1 for all of them (a minute); odd, so that no bit stays as it is.
#[cfg_attr(feature = "approx", ignore = "the vectors have the exact functions only")]
#[test]
fn invariant_functions_on_vectors_are_the_device_s_to_the_bit() {
    let stride = std::env::var("BALLRACE_STRIDE").map_or(1009, |stride| stride.parse().unwrap());
    for function in [Function::Sigmoid, Function::Sin, Function::Cos] {
        let halves = [0..1u64 << 31, 1 << 31..1 << 32];
        let differing =
            halves.into_par_iter().find_map_any(|bits| Arch::new().dispatch(Differing { function, bits, stride }));
        assert_eq!(differing.map(|x| (x, x.to_bits())), None);
    }
}
