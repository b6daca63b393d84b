//! Trace of a model over a short stretch of a recording, by core's evaluator.

use std::ops::Range;

use ballrace_core::evaluator::{Evaluator, scratch_len};
use ballrace_core::model::{Input, Model};

/// Evaluated rows of a stretch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Time in the recording of the sample that completed each row, s.
    pub times_s: Vec<f64>,
    /// Names of the derivatives.
    pub names: Vec<String>,
    /// Measured derivatives, a column each, in the model's scaled units.
    pub measured: Vec<Vec<f32>>,
    /// Predicted derivatives, a column each, in the model's scaled units.
    pub predicted: Vec<Vec<f32>>,
    /// Root mean square over the derivatives of the residual in healthy spreads; its square averaged
    /// over a block is the monitor's level, theory (85).
    pub residual: Vec<f32>,
}

impl Trace {
    /// Trace over a range of samples, after running over all samples before it.
    pub fn record(model: &Model<'_>, samples: &[f32], sample_rate_hz: f64, range: Range<usize>) -> Self {
        let count = model.input.len();
        let names = match model.input {
            Input::VirtualStates(spec) => (0..count).map(|i| format!("a^({})", spec.orders.state(i) + 1)).collect(),
            Input::Direct(_) => (0..count).map(|i| format!("dx{i}/dt")).collect(),
        };
        let mut out = Self { names, measured: vec![vec![]; count], predicted: vec![vec![]; count], ..Self::default() };
        let mut scratch = vec![0.0; scratch_len(model)];
        let Some(mut evaluator) = Evaluator::new(model, &mut scratch) else { return out };
        for (i, sample) in samples.iter().enumerate().take(range.end) {
            let Some(step) = evaluator.step(*sample).filter(|step| step.comparable && i >= range.start) else {
                continue;
            };
            out.times_s.push(i as f64 / sample_rate_hz);
            for (d, (measured, expected)) in step.measured.iter().zip(step.expected).enumerate() {
                out.measured[d].push(*measured);
                out.predicted[d].push(*expected);
            }
            let squares = step.residuals().zip(model.residual_spread.iter()).map(|(r, s)| (r / s) * (r / s));
            out.residual.push((squares.sum::<f32>() / count.max(1) as f32).sqrt());
        }
        out
    }

    /// First and last time, ms.
    pub fn times_ms(&self) -> Range<f64> {
        let ends = (self.times_s.first(), self.times_s.last());
        let (first, last) = (ends.0.copied().unwrap_or(0.0), ends.1.copied().unwrap_or(0.0));
        1e3 * first..1e3 * last.max(first + 1e-3)
    }

    /// Time in ms and value of a column.
    pub fn points<'s>(&'s self, values: &'s [f32]) -> impl Iterator<Item = (f64, f64)> + 's {
        self.times_s.iter().zip(values).map(|(t, v)| (1e3 * t, f64::from(*v)))
    }
}
