//! Costs of the device's work on a Cortex-M4F.
//!
//! Every number is fitted or read, none chosen: `firmware-sim/cycles/budget.sh DIR` traces the bare-metal image on models of
//! 18 sizes, `cargo run --release -p ballrace --example budget_costs -- fit DIR` prints these tables, and `-- check DIR`
//! holds their predictions against traces of 8 other sizes.

use super::Functions;
use super::work::Work;

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
    Memory { code_bytes: 38180, static_bytes: 0, stack_differences: 2316, stack_kalman: 3180, stack_windows: 5980 };
const APPROX_MEMORY: Memory =
    Memory { code_bytes: 37920, static_bytes: 0, stack_differences: 2316, stack_kalman: 3180, stack_windows: 5980 };

/// Costs of all work.
#[rustfmt::skip]
pub const COSTS: &[Row] = &[
    Row { work: Work::ScreenSample, exact: [23.00, 31.00, 31.00, 2.43], approx: [23.00, 31.00, 31.00, 2.43] },
    Row { work: Work::DifferencesSample, exact: [91.23, 115.29, 115.29, 7.99], approx: [91.48, 118.51, 118.51, 7.99] },
    Row { work: Work::DifferencesOrder, exact: [10.44, 11.62, 11.62, 0.00], approx: [10.41, 11.59, 11.59, 0.00] },
    Row { work: Work::DifferencesState, exact: [0.00, 0.00, 0.00, 0.11], approx: [0.00, 0.00, 0.00, 0.10] },
    Row { work: Work::DifferencesDelay, exact: [27.29, 42.64, 42.64, 0.00], approx: [27.26, 42.62, 42.62, 0.00] },
    Row { work: Work::KalmanSample, exact: [180.40, 291.40, 291.40, 10.95], approx: [180.40, 291.40, 291.40, 9.88] },
    Row { work: Work::KalmanState, exact: [21.51, 27.66, 27.66, 0.00], approx: [21.49, 27.64, 27.64, 0.00] },
    Row { work: Work::WindowSample, exact: [125.05, 169.64, 149.16, 19.39], approx: [125.03, 169.62, 149.14, 18.17] },
    Row { work: Work::WindowState, exact: [98.18, 131.72, 152.62, 0.00], approx: [98.16, 131.70, 152.60, 0.00] },
    Row { work: Work::WindowTap, exact: [19.98, 30.21, 30.27, 0.00], approx: [19.98, 30.21, 30.27, 0.00] },
    Row { work: Work::CausalState, exact: [22.69, 28.54, 28.54, 0.24], approx: [22.71, 28.56, 28.56, 0.27] },
    Row { work: Work::EncoderLayer, exact: [191.29, 333.03, 333.03, 16.62], approx: [185.28, 321.33, 321.33, 17.04] },
    Row { work: Work::EncoderOutput, exact: [7.58, 12.19, 12.19, 0.30], approx: [6.30, 11.03, 11.03, 0.22] },
    Row { work: Work::EncoderPanel, exact: [49.73, 53.78, 53.78, 0.00], approx: [52.92, 55.98, 55.98, 0.00] },
    Row { work: Work::EncoderPanelStep, exact: [26.41, 51.51, 51.51, 1.97], approx: [26.40, 51.51, 51.51, 2.02] },
    Row { work: Work::EncoderNarrowStep, exact: [5.12, 6.76, 6.76, 0.00], approx: [4.96, 6.65, 6.65, 0.09] },
    Row { work: Work::EncoderNarrowMultiplyAdd, exact: [6.63, 11.22, 11.22, 0.24], approx: [6.65, 11.23, 11.23, 0.23] },
    Row { work: Work::Sigmoid, exact: [41.18, 89.05, 92.41, 0.32], approx: [23.00, 30.50, 30.50, 0.40] },
    Row { work: Work::Monomial, exact: [8.53, 13.92, 13.97, 1.13], approx: [9.53, 13.88, 13.88, 1.02] },
    Row { work: Work::Factor, exact: [8.89, 11.81, 11.79, 0.00], approx: [8.88, 11.82, 11.82, 0.00] },
    Row { work: Work::Sine, exact: [74.61, 145.21, 145.21, 7.23], approx: [46.13, 73.22, 73.22, 1.28] },
    Row { work: Work::Power, exact: [54.91, 107.02, 107.00, 5.63], approx: [55.82, 106.92, 106.92, 5.56] },
    Row { work: Work::OddPower, exact: [97.36, 150.75, 150.65, 0.00], approx: [96.51, 151.01, 151.01, 0.00] },
    Row { work: Work::XiSample, exact: [64.80, 94.09, 94.09, 6.44], approx: [69.73, 92.94, 92.94, 10.17] },
    Row { work: Work::XiTerm, exact: [44.68, 55.69, 55.69, 1.70], approx: [47.68, 55.70, 55.70, 0.33] },
    Row { work: Work::XiCoefficient, exact: [11.54, 19.51, 19.51, 0.11], approx: [11.55, 19.52, 19.52, 0.45] },
    Row { work: Work::DecoderLayer, exact: [253.28, 455.83, 455.83, 18.19], approx: [259.10, 460.51, 460.51, 14.95] },
    Row { work: Work::DecoderOutput, exact: [0.00, 0.00, 0.00, 0.00], approx: [0.00, 0.00, 0.00, 0.39] },
    Row { work: Work::DecoderHidden, exact: [16.76, 23.35, 23.35, 0.00], approx: [15.51, 21.94, 21.94, 0.00] },
    Row { work: Work::DecoderPanel, exact: [52.57, 60.19, 60.19, 1.39], approx: [53.27, 61.51, 61.51, 0.00] },
    Row { work: Work::DecoderPanelStep, exact: [26.47, 51.60, 51.60, 1.99], approx: [26.48, 51.62, 51.62, 1.99] },
    Row { work: Work::DecoderNarrowStep, exact: [6.40, 7.19, 7.19, 0.00], approx: [6.26, 7.06, 7.06, 0.00] },
    Row { work: Work::DecoderNarrowMultiplyAdd, exact: [6.48, 11.03, 11.03, 0.24], approx: [6.52, 11.07, 11.07, 0.24] },
    Row { work: Work::MonitorSample, exact: [50.02, 86.03, 444.93, 4.16], approx: [50.03, 87.06, 443.78, 4.53] },
    Row { work: Work::MonitorResidual, exact: [41.89, 68.83, 67.78, 0.18], approx: [41.88, 68.67, 69.00, 0.18] },
    Row { work: Work::OtherSample, exact: [332.87, 594.39, 594.39, 29.04], approx: [331.03, 570.89, 570.89, 28.26] },
    Row { work: Work::OtherState, exact: [20.57, 54.12, 54.12, 1.10], approx: [20.46, 54.38, 54.38, 1.33] },
];
