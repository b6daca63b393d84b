//! Costs of the device's work on a Cortex-M4F.
//!
//! Every number of a cost is fitted or read, none chosen: `firmware-sim/cycles/budget.sh DIR` traces the bare-metal image on models of
//! 31 sizes, `cargo run --release -p ballrace --example budget_costs -- fit DIR` prints these tables, and `-- check DIR`
//! holds their predictions against traces of 22 other sizes.

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
    Memory { code_bytes: 51624, static_bytes: 4, stack_differences: 3800, stack_kalman: 4580, stack_windows: 7388 };
const APPROX_MEMORY: Memory =
    Memory { code_bytes: 52496, static_bytes: 4, stack_differences: 3800, stack_kalman: 4580, stack_windows: 7388 };

/// Costs of all work.
#[rustfmt::skip]
pub const COSTS: &[Row] = &[
    Row { work: Work::ScreenSample, exact: [24.00, 31.00, 31.00, 0.80], approx: [24.00, 31.00, 31.00, 1.20] },
    Row { work: Work::DifferencesSample, exact: [54.39, 70.89, 70.89, 6.85], approx: [54.50, 69.03, 69.03, 7.10] },
    Row { work: Work::DifferencesOrder, exact: [3.51, 3.98, 3.98, 0.00], approx: [3.55, 3.92, 3.92, 0.00] },
    Row { work: Work::DifferencesState, exact: [31.98, 43.05, 43.05, 0.00], approx: [31.08, 46.33, 46.33, 0.00] },
    Row { work: Work::DifferencesDelay, exact: [8.13, 10.63, 10.63, 0.00], approx: [8.55, 9.05, 9.05, 0.00] },
    Row { work: Work::KalmanSample, exact: [179.40, 258.40, 258.40, 12.14], approx: [179.40, 257.40, 257.40, 13.44] },
    Row { work: Work::KalmanState, exact: [35.63, 43.47, 43.47, 0.00], approx: [35.18, 44.79, 44.79, 0.00] },
    Row { work: Work::WindowSample, exact: [90.29, 133.69, 240.21, 17.20], approx: [89.84, 132.01, 212.04, 16.88] },
    Row { work: Work::WindowState, exact: [98.93, 138.27, 52.50, 0.00], approx: [98.49, 142.58, 92.63, 0.00] },
    Row { work: Work::WindowTap, exact: [21.48, 28.66, 36.05, 0.00], approx: [21.48, 28.66, 32.41, 0.00] },
    Row { work: Work::CausalState, exact: [10.57, 15.73, 15.73, 0.38], approx: [11.02, 14.41, 14.41, 0.46] },
    Row { work: Work::EncoderLayer, exact: [196.25, 300.66, 300.66, 20.52], approx: [195.74, 300.87, 300.87, 22.43] },
    Row { work: Work::EncoderOutput, exact: [11.50, 16.69, 16.69, 0.04], approx: [9.31, 11.85, 11.85, 0.01] },
    Row { work: Work::EncoderPanel, exact: [16.38, 4.05, 4.05, 0.00], approx: [14.61, 15.23, 15.23, 0.00] },
    Row { work: Work::EncoderPanelStep, exact: [26.52, 37.41, 37.41, 2.05], approx: [26.41, 37.30, 37.30, 2.05] },
    Row { work: Work::EncoderNarrowStep, exact: [4.98, 6.00, 6.00, 0.63], approx: [4.41, 4.40, 4.40, 0.49] },
    Row { work: Work::EncoderNarrowMultiplyAdd, exact: [6.49, 8.35, 8.35, 0.17], approx: [6.53, 8.86, 8.86, 0.20] },
    Row { work: Work::FixedEncoder, exact: [125.32, 92.78, 92.78, 13.02], approx: [121.25, 118.26, 118.26, 14.39] },
    Row { work: Work::FixedEncoderInput, exact: [14.93, 25.64, 25.64, 0.10], approx: [14.82, 21.34, 21.34, 0.13] },
    Row { work: Work::FixedEncoderWord, exact: [3.84, 5.40, 5.40, 0.30], approx: [3.85, 5.48, 5.48, 0.29] },
    Row { work: Work::FixedEncoderProduct, exact: [11.77, 11.64, 11.64, 1.02], approx: [11.75, 11.56, 11.56, 1.04] },
    Row { work: Work::FixedEncoderOutput, exact: [16.26, 25.92, 25.92, 0.50], approx: [16.04, 28.42, 28.42, 0.58] },
    Row { work: Work::Sigmoid, exact: [54.54, 105.32, 108.63, 0.46], approx: [24.16, 31.19, 31.19, 0.46] },
    Row { work: Work::FixedSigmoid, exact: [7.65, 10.08, 10.08, 0.79], approx: [7.66, 11.23, 11.23, 0.77] },
    Row { work: Work::Monomial, exact: [15.80, 20.16, 20.26, 1.02], approx: [16.45, 19.81, 19.81, 1.08] },
    Row { work: Work::Factor, exact: [2.13, 2.89, 2.84, 0.17], approx: [2.74, 3.97, 3.97, 0.19] },
    Row { work: Work::Sine, exact: [82.27, 137.90, 138.06, 6.75], approx: [47.04, 69.85, 69.85, 1.43] },
    Row { work: Work::Power, exact: [80.82, 139.27, 138.61, 5.96], approx: [82.02, 138.68, 138.68, 5.66] },
    Row { work: Work::OddPower, exact: [59.61, 90.60, 91.07, 0.00], approx: [63.96, 95.90, 95.90, 0.00] },
    Row { work: Work::XiSample, exact: [32.93, 38.85, 38.85, 3.18], approx: [37.28, 41.34, 41.34, 8.30] },
    Row { work: Work::XiTerm, exact: [19.55, 27.56, 27.56, 1.57], approx: [24.15, 33.44, 33.44, 0.28] },
    Row { work: Work::XiCoefficient, exact: [16.89, 22.90, 22.90, 0.18], approx: [16.50, 22.35, 22.35, 0.49] },
    Row { work: Work::DecoderLayer, exact: [268.70, 411.36, 411.36, 22.70], approx: [267.34, 410.75, 410.75, 21.01] },
    Row { work: Work::DecoderOutput, exact: [0.00, 0.00, 0.00, 0.07], approx: [0.00, 0.00, 0.00, 0.32] },
    Row { work: Work::DecoderHidden, exact: [22.52, 32.98, 32.98, 0.00], approx: [21.26, 30.28, 30.28, 0.00] },
    Row { work: Work::DecoderPanel, exact: [23.32, 15.68, 15.68, 0.00], approx: [24.34, 16.11, 16.11, 0.00] },
    Row { work: Work::DecoderPanelStep, exact: [26.47, 37.43, 37.43, 2.02], approx: [26.47, 37.45, 37.45, 1.97] },
    Row { work: Work::DecoderNarrowStep, exact: [4.89, 5.46, 5.46, 0.59], approx: [4.67, 4.71, 4.71, 0.00] },
    Row { work: Work::DecoderNarrowMultiplyAdd, exact: [6.51, 8.29, 8.29, 0.19], approx: [6.59, 8.66, 8.66, 0.29] },
    Row { work: Work::FixedDecoder, exact: [173.87, 157.64, 157.64, 17.83], approx: [177.34, 153.90, 153.90, 20.17] },
    Row { work: Work::FixedDecoderInput, exact: [30.95, 51.41, 51.41, 0.97], approx: [30.60, 54.37, 54.37, 0.97] },
    Row { work: Work::FixedDecoderWord, exact: [7.94, 10.36, 10.36, 0.59], approx: [7.89, 10.54, 10.54, 0.58] },
    Row { work: Work::FixedDecoderProduct, exact: [12.27, 12.48, 12.48, 1.08], approx: [12.35, 12.41, 12.41, 1.09] },
    Row { work: Work::FixedDecoderOutput, exact: [10.34, 14.66, 14.66, 0.00], approx: [10.07, 11.91, 11.91, 0.00] },
    Row { work: Work::MonitorSample, exact: [58.31, 91.42, 491.43, 6.82], approx: [57.68, 90.37, 491.92, 6.44] },
    Row { work: Work::MonitorResidual, exact: [19.27, 22.03, 21.48, 0.00], approx: [19.30, 22.06, 22.03, 0.00] },
    Row { work: Work::OtherSample, exact: [229.02, 420.81, 420.78, 19.57], approx: [226.85, 420.40, 420.37, 17.88] },
    Row { work: Work::OtherState, exact: [18.23, 25.47, 25.48, 0.62], approx: [18.32, 25.50, 25.51, 0.57] },
    Row { work: Work::NextSample, exact: [21.61, 29.16, 29.22, 0.00], approx: [26.30, 34.56, 34.61, 0.00] },
];
