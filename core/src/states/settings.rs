//! Limits of virtual states, which bound memory and time on the device.

/// Greatest model dimension n_MD.
pub const MAX_DIMENSION: usize = 16;

/// Highest order of a state that is estimated otherwise than by differences: 16 consecutive orders, or 8 even ones.
pub const MAX_ESTIMATED_ORDER: usize = 15;

/// Longest Savitzky–Golay window, samples.
pub const MAX_WINDOW: usize = 64;

/// Greatest degree of a Savitzky–Golay polynomial above the order of its derivative.
pub const MAX_EXCESS: u8 = 4;

/// Greatest number of samples of a Savitzky–Golay window for each coefficient of its polynomial.
pub const MAX_STRETCH: f32 = 8.0;

/// Lowest cut-off of the Kalman filter, cycles a sample. The slowest filter, of order 15, then settles within some
/// 1,500 samples.
pub const MIN_CUTOFF: f32 = 0.01;

/// Share to which the slowest mode of the Kalman filter must have decayed before its states count.
pub(super) const SETTLED: f64 = 1e-4;
