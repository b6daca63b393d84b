//! Costs of the device's work on a Cortex-M4F.
//!
//! Every number of a cost is fitted or read, none chosen: `firmware-sim/cycles/budget.sh DIR` traces the bare-metal image on models of
//! 26 sizes, `cargo run --release -p ballrace --example budget_costs -- fit DIR` prints these tables, and `-- check DIR`
//! holds their predictions against traces of 11 other sizes.

use super::Functions;
use super::work::Work;

/// Least hidden units that a fit within a budget tries. Not tuned: chosen by hand.
pub const LEAST_UNITS: usize = 4;

/// Cost of one unit of work: instructions, cycles, cycles in the most expensive sample, lines of flash waited for.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Kind of work.
    pub work: Work,
    /// With the functions of the host.
    pub exact: [f64; 4],
    /// With those of the feature `approx`.
    pub approx: [f64; 4],
}

/// Memory of the device without the model, bytes.
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// Flash of code and constants.
    pub code_bytes: usize,
    /// Static RAM beside the scratch.
    pub static_bytes: usize,
    /// Most stack in use with states by differences.
    pub stack_differences: usize,
    /// With states by the Kalman filter, whose gain is found once.
    pub stack_kalman: usize,
    /// With states by Savitzky–Golay windows, whose weights are found once.
    pub stack_windows: usize,
}

impl Memory {
    /// Memory of a build.
    pub const fn of(functions: Functions) -> Self {
        match functions {
            Functions::Exact => EXACT_MEMORY,
            Functions::Approx => APPROX_MEMORY,
        }
    }
}

const EXACT_MEMORY: Memory =
    Memory { code_bytes: 51312, static_bytes: 4, stack_differences: 3880, stack_kalman: 4660, stack_windows: 7468 };
const APPROX_MEMORY: Memory =
    Memory { code_bytes: 52184, static_bytes: 4, stack_differences: 3880, stack_kalman: 4660, stack_windows: 7468 };

/// Costs of all work.
#[rustfmt::skip]
pub const COSTS: &[Row] = &[
    Row { work: Work::ScreenSample, exact: [24.00, 31.19, 31.19, 1.59], approx: [24.00, 31.00, 31.00, 2.20] },
    Row { work: Work::DifferencesSample, exact: [66.57, 86.65, 86.65, 6.88], approx: [66.61, 89.39, 89.39, 7.79] },
    Row { work: Work::DifferencesOrder, exact: [4.15, 4.77, 4.77, 0.00], approx: [4.16, 4.45, 4.45, 0.00] },
    Row { work: Work::DifferencesState, exact: [6.02, 11.65, 11.65, 0.00], approx: [5.45, 10.37, 10.37, 0.01] },
    Row { work: Work::DifferencesDelay, exact: [20.45, 25.52, 25.52, 0.00], approx: [20.74, 26.40, 26.40, 0.00] },
    Row { work: Work::KalmanSample, exact: [179.40, 255.40, 255.40, 12.31], approx: [179.40, 258.40, 258.40, 13.38] },
    Row { work: Work::KalmanState, exact: [22.52, 26.04, 26.04, 0.00], approx: [22.26, 25.27, 25.27, 0.00] },
    Row { work: Work::WindowSample, exact: [79.07, 123.57, 203.28, 15.40], approx: [78.81, 121.75, 167.15, 15.35] },
    Row { work: Work::WindowState, exact: [79.30, 121.67, 57.79, 0.00], approx: [79.04, 117.93, 87.93, 0.00] },
    Row { work: Work::WindowTap, exact: [21.54, 28.70, 34.24, 0.00], approx: [21.54, 28.71, 31.11, 0.00] },
    Row { work: Work::CausalState, exact: [21.68, 29.16, 29.16, 0.34], approx: [21.94, 29.93, 29.93, 0.34] },
    Row { work: Work::EncoderLayer, exact: [196.15, 300.90, 300.90, 18.93], approx: [195.66, 299.39, 299.39, 22.55] },
    Row { work: Work::EncoderOutput, exact: [11.50, 16.85, 16.85, 0.07], approx: [9.28, 14.03, 14.03, 0.02] },
    Row { work: Work::EncoderPanel, exact: [16.47, 1.10, 1.10, 0.00], approx: [14.87, 0.15, 0.15, 0.00] },
    Row { work: Work::EncoderPanelStep, exact: [26.52, 37.89, 37.89, 2.05], approx: [26.41, 37.23, 37.23, 2.04] },
    Row { work: Work::EncoderNarrowStep, exact: [4.97, 5.85, 5.85, 0.50], approx: [4.41, 5.12, 5.12, 0.52] },
    Row { work: Work::EncoderNarrowMultiplyAdd, exact: [6.49, 8.37, 8.37, 0.18], approx: [6.54, 8.44, 8.44, 0.20] },
    Row { work: Work::FixedEncoder, exact: [332.76, 419.61, 419.61, 19.28], approx: [326.43, 423.41, 423.41, 21.32] },
    Row { work: Work::FixedEncoderWord, exact: [3.57, 4.97, 4.97, 0.28], approx: [3.58, 4.94, 4.94, 0.28] },
    Row { work: Work::FixedEncoderProduct, exact: [13.68, 14.81, 14.81, 1.08], approx: [13.64, 14.90, 14.90, 1.10] },
    Row { work: Work::Sigmoid, exact: [54.56, 105.35, 108.67, 0.42], approx: [24.15, 31.19, 31.19, 0.48] },
    Row { work: Work::FixedSigmoid, exact: [7.68, 10.09, 10.09, 0.80], approx: [7.67, 10.09, 10.09, 0.79] },
    Row { work: Work::Monomial, exact: [17.61, 23.55, 23.55, 1.22], approx: [17.25, 21.05, 21.05, 1.22] },
    Row { work: Work::Factor, exact: [0.60, 0.24, 0.25, 0.00], approx: [1.87, 2.68, 2.68, 0.00] },
    Row { work: Work::Sine, exact: [81.83, 137.03, 137.04, 6.66], approx: [46.51, 69.13, 69.13, 1.20] },
    Row { work: Work::Power, exact: [76.39, 132.36, 132.38, 5.94], approx: [79.98, 135.52, 135.52, 6.29] },
    Row { work: Work::OddPower, exact: [67.85, 103.00, 102.96, 0.00], approx: [69.51, 103.91, 103.91, 0.00] },
    Row { work: Work::XiSample, exact: [32.60, 38.98, 38.98, 1.25], approx: [38.81, 43.77, 43.77, 7.09] },
    Row { work: Work::XiTerm, exact: [19.59, 27.45, 27.45, 1.63], approx: [24.14, 33.42, 33.42, 0.30] },
    Row { work: Work::XiCoefficient, exact: [16.86, 25.97, 25.97, 0.15], approx: [16.42, 22.23, 22.23, 0.49] },
    Row { work: Work::DecoderLayer, exact: [268.62, 413.26, 413.26, 18.95], approx: [267.15, 412.24, 412.24, 21.86] },
    Row { work: Work::DecoderOutput, exact: [0.00, 0.00, 0.00, 0.17], approx: [0.00, 0.00, 0.00, 0.27] },
    Row { work: Work::DecoderHidden, exact: [22.49, 33.64, 33.64, 0.00], approx: [21.18, 30.87, 30.87, 0.00] },
    Row { work: Work::DecoderPanel, exact: [23.43, 11.24, 11.24, 0.00], approx: [24.63, 14.88, 14.88, 0.00] },
    Row { work: Work::DecoderPanelStep, exact: [26.47, 37.90, 37.90, 2.01], approx: [26.47, 37.37, 37.37, 1.98] },
    Row { work: Work::DecoderNarrowStep, exact: [4.90, 4.75, 4.75, 0.52], approx: [4.73, 4.64, 4.64, 0.00] },
    Row { work: Work::DecoderNarrowMultiplyAdd, exact: [6.51, 8.41, 8.41, 0.18], approx: [6.58, 8.51, 8.51, 0.30] },
    Row { work: Work::FixedDecoder, exact: [465.73, 628.80, 628.80, 24.50], approx: [462.53, 594.91, 594.91, 25.97] },
    Row { work: Work::FixedDecoderWord, exact: [7.99, 10.48, 10.48, 0.58], approx: [7.95, 10.72, 10.72, 0.59] },
    Row { work: Work::FixedDecoderProduct, exact: [12.22, 12.67, 12.67, 1.08], approx: [12.30, 11.72, 11.72, 1.07] },
    Row { work: Work::MonitorSample, exact: [59.06, 87.81, 475.60, 7.08], approx: [57.96, 88.31, 477.94, 6.65] },
    Row { work: Work::MonitorResidual, exact: [18.90, 22.63, 21.62, 0.00], approx: [19.00, 21.80, 21.84, 0.00] },
    Row { work: Work::OtherSample, exact: [356.37, 606.77, 606.77, 23.83], approx: [356.94, 611.80, 611.82, 25.65] },
    Row { work: Work::OtherState, exact: [17.68, 25.44, 25.45, 0.55], approx: [17.73, 24.49, 24.49, 0.29] },
];
