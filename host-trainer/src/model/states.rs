//! Virtual states of recordings by core's own code, and their standardisation, theory (6).

use ballrace_core::states::{StateSpec, VirtualStates};

use crate::model::samples::Samples;

/// States x and targets ẋ of one recording, in physical units; no rows if it is too short.
///
/// # Panics
/// If `spec` is not valid.
pub fn rows(recording: &[f32], spec: StateSpec) -> Samples<f32> {
    let n = spec.dimension;
    let mut delays = vec![0.0; spec.memory_len()];
    let mut states = VirtualStates::new(spec, &mut delays).expect("a valid spec and as many delays as it says");
    let (mut x, mut dx) = (vec![0.0; n], vec![0.0; n]);
    let mut out = Samples { inputs: n, x: Vec::with_capacity(n * recording.len()), dx: Vec::new() };
    out.dx.reserve(n * recording.len());
    for sample in recording {
        if states.push(*sample, &mut x, &mut dx) {
            out.x.extend_from_slice(&x);
            out.dx.extend_from_slice(&dx);
        }
    }
    out
}

/// Means and standard deviations of states and derivatives, physical units, theory (6).
///
/// x and ẋ have different scales: the standardised ẋ is not the derivative of the standardised x.
#[derive(Clone, Debug, PartialEq)]
pub struct Scales {
    /// Mean and standard deviation of each state.
    pub states: Vec<(f32, f32)>,
    /// Mean and standard deviation of each derivative.
    pub derivatives: Vec<(f32, f32)>,
}

impl Scales {
    /// Scales over all rows together; 1 for a column that does not vary.
    pub fn from_rows(rows: &[Samples<f32>]) -> Self {
        let inputs = rows.first().map_or(0, |r| r.inputs);
        let column = |pick: fn(&Samples<f32>) -> &[f32], i: usize| {
            let values = || rows.iter().flat_map(|r| pick(r).iter().skip(i).step_by(inputs)).map(|v| f64::from(*v));
            let count = values().count().max(1) as f64;
            let mean = values().sum::<f64>() / count;
            let spread = (values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt() as f32;
            (mean as f32, if spread > 0.0 { spread } else { 1.0 })
        };
        Self {
            states: (0..inputs).map(|i| column(|r| &r.x, i)).collect(),
            derivatives: (0..inputs).map(|i| column(|r| &r.dx, i)).collect(),
        }
    }

    /// Standardises rows in place, theory (6), by the device's own expression.
    pub fn apply(&self, rows: &mut Samples<f32>) {
        for (values, scales) in [(&mut rows.x, &self.states), (&mut rows.dx, &self.derivatives)] {
            for row in values.chunks_exact_mut(rows.inputs.max(1)) {
                for (v, (mean, scale)) in row.iter_mut().zip(scales) {
                    *v = (*v - mean) / scale;
                }
            }
        }
    }
}

/// Concatenates rows.
pub fn concatenate(rows: &[Samples<f32>]) -> Samples<f32> {
    Samples {
        inputs: rows.first().map_or(0, |r| r.inputs),
        x: rows.iter().flat_map(|r| &r.x).copied().collect(),
        dx: rows.iter().flat_map(|r| &r.dx).copied().collect(),
    }
}
