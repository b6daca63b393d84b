//! Windows of states or samples, and what follows them.

use ballrace_core::states::StateSpec;
use faer::Mat;
use faer::linalg::solvers::SolveLstsqCore;

use super::settings::SETTINGS;
use crate::model::fit::score::Sums;
use crate::model::samples::Samples;
use crate::model::states::{self, Scales};
use crate::recording::input::Series;

/// Windows with their targets, standardised.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Windows {
    /// Values of each time step.
    pub channels: usize,
    /// Values to predict.
    pub outputs: usize,
    /// Windows: count × [`window`](super::settings::RivalSettings::window) × channels, the oldest step first.
    pub inputs: Vec<f32>,
    /// Targets: count × outputs.
    pub targets: Vec<f32>,
}

impl Windows {
    /// Number of windows.
    pub fn len(&self) -> usize {
        self.targets.len().checked_div(self.outputs).unwrap_or(0)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Values of a window.
    pub const fn width(&self) -> usize {
        SETTINGS.window * self.channels
    }

    /// Mean R² over the outputs of predictions in the order of the targets, theory (22).
    pub fn r_squared(&self, predicted: &[f32]) -> f64 {
        let of = |output: usize| {
            let mut sums = Sums::default();
            let values = self.targets.iter().zip(predicted).skip(output).step_by(self.outputs);
            values.for_each(|(target, predicted)| sums.push((*target).into(), f64::from(target - predicted)));
            sums.r_squared()
        };
        (0..self.outputs).map(of).sum::<f64>() / self.outputs as f64
    }
}

/// Windows of the states of each part, whose targets are the derivatives at the last step; scales are those of the first part.
pub fn of_states(parts: [&Vec<Series>; 3], spec: StateSpec) -> [Windows; 3] {
    let rows = parts.map(|part| part.iter().map(|s| states::rows(&s.samples, spec)).collect::<Vec<_>>());
    let scales = Scales::from_rows(&rows[0]);
    rows.map(|mut rows| {
        let mut windows = Windows { channels: spec.dimension, outputs: spec.dimension, ..Windows::default() };
        for rows in &mut rows {
            scales.apply(rows);
            let Samples { inputs, x, dx } = rows;
            for (window, target) in x
                .windows(SETTINGS.window * *inputs)
                .step_by(*inputs)
                .zip(dx.chunks_exact(*inputs).skip(SETTINGS.window - 1))
            {
                windows.inputs.extend_from_slice(window);
                windows.targets.extend_from_slice(target);
            }
        }
        windows
    })
}

/// Windows of the samples of each part, whose target is the next sample; scales are those of the first part.
pub fn of_signals(parts: [&Vec<Series>; 3]) -> [Windows; 3] {
    let values = || parts[0].iter().flat_map(|s| &s.samples).map(|v| f64::from(*v));
    let count = values().count().max(1) as f64;
    let mean = values().sum::<f64>() / count;
    let spread = (values().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
    let spread = if spread > 0.0 { spread } else { 1.0 };
    let scaled = |v: &f32| ((f64::from(*v) - mean) / spread) as f32;
    parts.map(|part| {
        let mut windows = Windows { channels: 1, outputs: 1, ..Windows::default() };
        for window in part.iter().flat_map(|s| s.samples.windows(SETTINGS.window + 1)) {
            windows.inputs.extend(window[..SETTINGS.window].iter().map(scaled));
            windows.targets.push(scaled(&window[SETTINGS.window]));
        }
        windows
    })
}

/// Mean R² of least squares on the same windows, fitted to the first and scored on both; `None` for fewer windows than
/// coefficients.
pub fn linear_r_squared(train: &Windows, held_out: &Windows) -> Option<[f64; 2]> {
    let (width, outputs) = (train.width(), train.outputs);
    if train.len() <= width {
        return None;
    }
    let matrix = |windows: &Windows| {
        Mat::from_fn(windows.len(), width + 1, |row, column| match column {
            0 => 1.0,
            _ => f64::from(windows.inputs[row * width + column - 1]),
        })
    };
    let mut solution =
        Mat::from_fn(train.len(), outputs, |row, output| f64::from(train.targets[row * outputs + output]));
    let past = matrix(train);
    past.col_piv_qr().solve_lstsq_in_place_with_conj(faer::Conj::No, solution.as_mut());
    let coefficients = solution.subrows(0, width + 1);
    Some([train, held_out].map(|windows| {
        let predicted = matrix(windows) * coefficients;
        let rows = (0..windows.len()).flat_map(|row| (0..outputs).map(move |output| (row, output)));
        windows.r_squared(&rows.map(|(row, output)| predicted[(row, output)] as f32).collect::<Vec<_>>())
    }))
}
