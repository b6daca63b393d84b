//! Transcendental functions of host and device.
//!
//! By default `libm` on host and device, so that both agree to the bit (`std`'s `exp` differs in one
//! value of ten). The feature `approx` selects faster forms; the largest absolute errors, measured by
//! the tests of this module over the stated ranges:
//!
//! | function | exact | `approx` | range |
//! |---|---|---|---|
//! | [`sigmoid`] | 1.2e-7 | 3e-5 (256-entry table, linear) | all |
//! | [`exp`] | 1 ulp | 4e-3 relative (micromath, guarded) | \|x\| ≤ 80 |
//! | [`ln`] | 1 ulp | the same | all |
//! | [`sin`], [`cos`] | 1.2e-7, 1.6 ulp | 2e-3 (micromath) | \|x\| ≤ 100; 1.6 ulp to 8192 |
//!
//! Both builds give NaN for NaN and never panic.

/// Natural exponential.
#[cfg(not(feature = "approx"))]
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Natural exponential, micromath's with guards: its `exp(NaN)` is +∞, its `exp(89)` NaN.
#[cfg(feature = "approx")]
pub fn exp(x: f32) -> f32 {
    if x.is_nan() {
        x
    } else if x > 88.0 {
        f32::INFINITY
    } else if x < -87.0 {
        0.0
    } else {
        micromath::F32(x).exp().0
    }
}

/// Logistic function 1 / (1 + e⁻ˣ).
#[cfg(not(feature = "approx"))]
pub fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// Logistic function from a 256-interval table over 0 ≤ |x| < 12, linearly interpolated.
#[cfg(feature = "approx")]
pub fn sigmoid(x: f32) -> f32 {
    let magnitude = x.abs();
    let upper = if magnitude < table::END {
        let position = magnitude * table::PER_UNIT;
        let i = position as usize;
        let fraction = position - i as f32;
        match table::SIGMOID.get(i..i + 2) {
            Some(&[a, b]) => a + (b - a) * fraction,
            _ => 1.0,
        }
    } else if x.is_nan() {
        return x;
    } else {
        1.0
    };
    if x < 0.0 { 1.0 - upper } else { upper }
}

#[cfg(feature = "approx")]
mod table {
    pub const INTERVALS: usize = 256;
    pub const END: f32 = 12.0;
    pub const PER_UNIT: f32 = INTERVALS as f32 / END;
    pub static SIGMOID: [f32; INTERVALS + 1] = build();

    const fn build() -> [f32; INTERVALS + 1] {
        let mut t = [0.0; INTERVALS + 1];
        let mut i = 0;
        while i <= INTERVALS {
            let x = i as f64 * END as f64 / INTERVALS as f64;
            t[i] = (1.0 / (1.0 + super::exp_minus(x))) as f32;
            i += 1;
        }
        t
    }
}

/// Exponential e⁻ˣ for |x| ≤ 16 at compile time: the series of e^(−x/64), squared six times.
pub(crate) const fn exp_minus(x: f64) -> f64 {
    let y = -x / 64.0;
    let mut term = 1.0;
    let mut sum = 1.0;
    let mut n = 1;
    while n < 16 {
        term *= y / n as f64;
        sum += term;
        n += 1;
    }
    let mut k = 0;
    while k < 6 {
        sum *= sum;
        k += 1;
    }
    sum
}

/// Natural logarithm, to 1 ulp; −∞ for ±0, NaN below 0. Both builds have the same: only additions, multiplications and bit
/// operations, in a stated order (Moshier, Cephes, `logf`; the polynomial's largest relative error is 1e-8).
pub fn ln(x: f32) -> f32 {
    if x.is_nan() || x == f32::INFINITY {
        return x;
    }
    if x <= 0.0 {
        return if x < 0.0 { f32::NAN } else { f32::NEG_INFINITY };
    }
    let (normal, shift) = if x < f32::MIN_POSITIVE { (x * 8_388_608.0, 23) } else { (x, 0) };
    // x = 2^exponent · (1 + t) with 1 + t from √½ to √2.
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let above = normal.to_bits().wrapping_sub(SQRT_HALF);
    let exponent = ((above as i32 >> 23) - shift) as f32;
    let t = f32::from_bits((above & 0x007f_ffff) + SQRT_HALF) - 1.0;
    const POLYNOMIAL: [f32; 9] = [
        7.037_683_6e-2,
        -1.151_461e-1,
        1.167_699_9e-1,
        -1.242_014_1e-1,
        1.424_932_3e-1,
        -1.666_805_7e-1,
        2.000_071_5e-1,
        -2.499_999_4e-1,
        3.333_333e-1,
    ];
    let square = t * t;
    let tail = POLYNOMIAL.iter().fold(0.0, |sum, c| sum * t + c) * t * square;
    // ln 2 in two parts, of which the first has trailing zeros: its product with the exponent is exact.
    let low = tail + exponent * -2.121_944_4e-4 - 0.5 * square;
    (t + low) + exponent * (355.0 / 512.0)
}

/// Sine of an angle in radians, to 1.6 ulp for |x| < 8192.
#[cfg(not(feature = "approx"))]
pub fn sin(x: f32) -> f32 {
    turned(x, 0)
}

/// Sine of an angle in radians, micromath's.
#[cfg(feature = "approx")]
pub fn sin(x: f32) -> f32 {
    if x.is_finite() { micromath::F32(x).sin().0 } else { f32::NAN }
}

/// Cosine of an angle in radians, to 1.6 ulp for |x| < 8192.
#[cfg(not(feature = "approx"))]
pub fn cos(x: f32) -> f32 {
    turned(x, 1)
}

/// Sine of an angle `quarters` quarter turns ahead of `x`. In single precision throughout up to 8192 rad, where `libm` would
/// reduce in doubles, a thousand instructions of a Cortex-M4F; beyond, where a scaled state hardly comes, in doubles; NaN from
/// 2²⁶ on, where neighbouring numbers are a turn apart.
#[cfg(not(feature = "approx"))]
fn turned(x: f32, quarters: i32) -> f32 {
    const ROUNDER: f32 = 12_582_912.0;
    // π/2 in parts of 8, 11, 11 and 24 bits: k times the first three is exact (W. J. Cody, W. Waite, 1980).
    const PARTS: [f32; 4] = [1.570_312_5, 4.837_513e-4, 7.549_533_6e-8, 2.563_344e-12];
    let (quadrant, r) = if x.abs() < 8192.0 {
        let k = (x * core::f32::consts::FRAC_2_PI + ROUNDER) - ROUNDER;
        let above = (x - k * PARTS[0]) - k * PARTS[1];
        let third = k * PARTS[2];
        let r = above - third;
        let rounded_off = (above - r) - third;
        (k as i32, r + (rounded_off - k * PARTS[3]))
    } else if x.abs() < 67_108_864.0 {
        let x = f64::from(x);
        let half = if x < 0.0 { -0.5 } else { 0.5 };
        let k = (x * core::f64::consts::FRAC_2_PI + half) as i32;
        (k, (x - f64::from(k) * core::f64::consts::FRAC_PI_2) as f32)
    } else {
        return f32::NAN;
    };
    // Minimax polynomials on |r| ≤ π/4 (S. L. Moshier, Cephes, sinf and cosf).
    let z = r * r;
    let quadrant = quadrant + quarters;
    let value = if quadrant & 1 == 0 {
        r + r * (((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z)
    } else {
        let half = 0.5 * z;
        let near = 1.0 - half;
        let rest = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z;
        near + (((1.0 - near) - half) + rest)
    };
    if quadrant & 2 == 0 { value } else { -value }
}

/// Cosine of an angle in radians, micromath's.
#[cfg(feature = "approx")]
pub fn cos(x: f32) -> f32 {
    if x.is_finite() { micromath::F32(x).cos().0 } else { f32::NAN }
}

/// Square root, correctly rounded in both builds.
pub fn sqrt(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Cube root of a positive number up to 1e38, to 2.4e-7, the same in both builds, NaN beyond; 0, NaN and ∞ as they are. `libm`'s works in doubles, which a
/// Cortex-M4F does in software.
pub fn cbrt(x: f32) -> f32 {
    if !(x.is_normal() && x > 0.0) {
        return x;
    }
    // A third of the exponent (W. Kahan, 1991), right to 5 %; each of Halley's steps makes three times as many digits right.
    let mut root = f32::from_bits(x.to_bits() / 3 + 709_958_130);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + x + x) / (cube + cube + x);
    }
    root
}

/// Functions in `f64`, for numbers that are found once, when a device is made; the same in both builds.
pub mod double {
    /// Square root, correctly rounded.
    pub fn sqrt(x: f64) -> f64 {
        libm::sqrt(x)
    }

    /// Cosine and sine of an angle of −2π to 2π in radians, to 1e-14: the series of e^(ix/16), squared four times.
    /// `libm`'s would be 9 kB of the device's flash.
    pub fn cos_sin(x: f64) -> (f64, f64) {
        let y = x / 16.0;
        // Horner's scheme of Σ (iy)^n / n!.
        let (mut cos, mut sin) = (1.0, 0.0);
        for n in (1..=14).rev() {
            let factor = y / f64::from(n);
            (cos, sin) = (1.0 - factor * sin, factor * cos);
        }
        for _ in 0..4 {
            (cos, sin) = (cos * cos - sin * sin, 2.0 * cos * sin);
        }
        (cos, sin)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    /// Every `f32` from 2⁻¹² to 8192; below, a sine is its angle.
    #[cfg(not(feature = "approx"))]
    #[cfg_attr(miri, ignore)]
    #[test]
    fn literature_sines_and_cosines_are_right_to_the_stated_ulp() {
        let ulp = |v: f64| f64::from((v.abs() as f32).next_up()) - f64::from(v.abs() as f32);
        let errors = |x: f32| {
            let (sine, cosine) = f64::from(x).sin_cos();
            let error = |found: f32, exact: f64| (f64::from(found) - exact).abs() / ulp(exact);
            error(sin(x), sine).max(error(cos(x), cosine))
        };
        let (first, last) = ((1.0f32 / 4096.0).to_bits(), 8192.0f32.to_bits());
        let worst =
            |part: u32| (first + part..last).step_by(4).map(|bits| errors(f32::from_bits(bits))).fold(0.0, f64::max);
        let worst = std::thread::scope(|scope| {
            let parts = [0, 1, 2, 3].map(|part| scope.spawn(move || worst(part)));
            parts.into_iter().map(|part| part.join().unwrap()).fold(0.0, f64::max)
        });
        std::println!("sine and cosine: {worst:.3} ulp");
        assert!(worst < 1.6, "{worst}");
        for x in [1e-5f32, 3e-30, -0.0, 0.3, 77.0, 8000.0] {
            assert_eq!((sin(-x), cos(-x)), (-sin(x), cos(x)), "{x}");
        }
        assert_eq!(sin(1e-5), 1e-5);
        // Beyond, in doubles.
        for x in [8192.0f32, 1e5, 5e7] {
            assert!((f64::from(sin(x)) - f64::from(x).sin()).abs() < 1.2e-7, "{x}");
            assert!((f64::from(cos(-x)) - f64::from(x).cos()).abs() < 1.2e-7, "{x}");
        }
        assert!(sin(1e8).is_nan() && cos(f32::INFINITY).is_nan());
    }

    /// Every seventh positive `f32`, subnormal ones included.
    #[cfg_attr(miri, ignore)]
    #[test]
    fn literature_logarithms_are_right_to_the_stated_ulp() {
        let errors = |bits: u32| {
            let x = f32::from_bits(bits);
            let exact = f64::from(x).ln();
            let ulp = f64::from((exact.abs() as f32).next_up()) - f64::from(exact.abs() as f32);
            if exact == 0.0 { f64::from(ln(x).abs()) } else { (f64::from(ln(x)) - exact).abs() / ulp }
        };
        let worst = |part: u32| (1 + 7 * part..f32::INFINITY.to_bits()).step_by(28).map(errors).fold(0.0, f64::max);
        let worst = std::thread::scope(|scope| {
            let parts = [0, 1, 2, 3].map(|part| scope.spawn(move || worst(part)));
            parts.into_iter().map(|part| part.join().unwrap()).fold(0.0, f64::max)
        });
        // Around 1, where the logarithm crosses zero, every one.
        let near = (0.9f32.to_bits()..1.1f32.to_bits()).map(errors).fold(0.0, f64::max);
        std::println!("logarithm: {worst:.3} ulp, {near:.3} from 0.9 to 1.1");
        assert!(worst < 1.0 && near < 1.0, "{worst} {near}");
        assert_eq!((ln(0.0), ln(-0.0), ln(1.0)), (f32::NEG_INFINITY, f32::NEG_INFINITY, 0.0));
        assert_eq!(ln(f32::INFINITY), f32::INFINITY);
        assert!(ln(-1.0).is_nan() && ln(f32::NAN).is_nan() && ln(f32::NEG_INFINITY).is_nan());
    }

    #[test]
    fn cube_roots_are_right_to_the_last_digits() {
        let worst = (0..400_000).fold(0.0f64, |worst, i| {
            let x = 10f64.powf(-6.0 + 12.0 * f64::from(i) / 4e5) as f32;
            worst.max((f64::from(cbrt(x)) / f64::from(x).cbrt() - 1.0).abs())
        });
        assert!(worst < 2.4e-7, "{worst}");
        assert!(cbrt(f32::NAN).is_nan());
        assert_eq!((cbrt(0.0), cbrt(f32::INFINITY)), (0.0, f32::INFINITY));
        assert!(cbrt(f32::MAX).is_nan() && (cbrt(1e38) / 4.641_589e12 - 1.0).abs() < 1e-6);
    }

    fn worst(range: f32, f: fn(f32) -> f32, reference: fn(f64) -> f64, relative: bool) -> f64 {
        (-200_000..=200_000)
            .map(|i| {
                let x = range * i as f32 / 200_000.0;
                let exact = reference(x as f64);
                let error = (f(x) as f64 - exact).abs();
                if relative { error / exact.abs() } else { error }
            })
            .fold(0.0, f64::max)
    }

    /// The errors this module's documentation publishes.
    #[test]
    fn published_errors_hold() {
        let (sigmoid_limit, exp_limit, sine_limit) =
            if cfg!(feature = "approx") { (3e-5, 4e-3, 2e-3) } else { (1.2e-7, 1.2e-7, 1.2e-7) };
        let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
        for (name, error, limit) in [
            ("sigmoid", worst(20.0, sigmoid, logistic, false), sigmoid_limit),
            ("exp", worst(80.0, exp, f64::exp, true), exp_limit),
            ("sin", worst(100.0, sin, f64::sin, false), sine_limit),
            ("cos", worst(100.0, cos, f64::cos, false), sine_limit),
        ] {
            std::println!("{name}: {error:.3e}");
            assert!(error <= limit, "{name}: measured {error:e}, published {limit:e}");
        }
    }

    #[test]
    fn golden_cosine_and_sine_in_double() {
        for i in -1000..=1000 {
            let x = 2.0 * std::f64::consts::PI * f64::from(i) / 1000.0;
            let (cos, sin) = double::cos_sin(x);
            assert!((cos - x.cos()).abs() < 1e-14 && (sin - x.sin()).abs() < 1e-14, "{x}: {cos} {sin}");
        }
    }

    #[test]
    fn nan_stays_nan_and_ends_are_right() {
        for f in [exp, sigmoid, sin, cos, sqrt] {
            assert!(f(f32::NAN).is_nan());
        }
        assert_eq!(sigmoid(f32::INFINITY), 1.0);
        assert_eq!(sigmoid(f32::NEG_INFINITY), 0.0);
        assert_eq!(exp(1e9), f32::INFINITY);
        assert_eq!(exp(-1e9), 0.0);
        assert!(sin(f32::INFINITY).is_nan());
        assert!(sqrt(-1.0).is_nan());
    }
}
