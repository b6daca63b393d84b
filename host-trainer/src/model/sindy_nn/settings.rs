//! Settings of SINDy-NN in addition to [`TrainConfig`](super::config::TrainConfig).

use super::config::PAPER_UNITS;
use super::layout::Layout;

/// Settings of Adam, theory (15): those of Kingma and Ba 2015.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdamSettings {
    /// Decay β₁ of the first moment. Kingma and Ba 2015.
    pub first_decay: f32,
    /// Decay β₂ of the second moment. Kingma and Ba 2015.
    pub second_decay: f32,
    /// Regularisation ε of the denominator. Kingma and Ba 2015.
    pub epsilon: f32,
}

impl AdamSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { first_decay: 0.9, second_decay: 0.999, epsilon: 1e-8 };
}

/// Settings of the batched gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineSettings {
    /// Samples in a block, a multiple of 16. Chosen by measurement: the hidden panels of two 256-wide layers stay in
    /// a 1 MB L2 cache, and the dot products are long enough that adding up their lanes does not dominate.
    pub block: usize,
}

impl EngineSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { block: 128 };
}

/// Settings of a training run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunSettings {
    /// Initial value of every coefficient of Ξ: the reference implementations'.
    pub initial_coefficient: f32,
    /// Epoch limit with 256 hidden units: the paper's.
    pub epochs: usize,
    /// Limit of the gradient steps with 256 hidden units. Chosen for a fit of some seconds.
    pub steps: usize,
    /// Greatest factor of both limits with fewer units, whose steps cost less and which learn slowly. Chosen on FEMTO
    /// Bearing3_3 and 3_1: 24 units at 20,000 steps take the time of 256 at 2,000 and predict the next sample within 0.005 of them.
    pub max_lengthening: usize,
    /// Start of a refinement's cosine, as a share of the training's. Chosen on the same bearings, of 1, 0.3, 0.1 and 0.03.
    pub refinement_start: f32,
    /// Checks of the validation loss over the planned steps. Not tuned: chosen by hand.
    pub checks: usize,
    /// Greatest number of samples for a validation loss or a term's power. Not tuned: chosen by hand.
    pub max_judged: usize,
}

impl RunSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        initial_coefficient: 0.01,
        epochs: 500,
        steps: 2000,
        max_lengthening: 12,
        refinement_start: 0.3,
        checks: 40,
        max_judged: 4096,
    };

    /// Factor of both limits for the hidden units of an encoder.
    pub(super) fn lengthening(&self, layout: &Layout) -> usize {
        let widths = layout.encoder.widths();
        let units: usize = widths.get(1..widths.len().saturating_sub(1)).unwrap_or(&[]).iter().sum();
        PAPER_UNITS.checked_div(units).map_or(1, |longer| longer.clamp(1, self.max_lengthening))
    }
}

/// Settings of the removal of terms, theory (16).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PruneSettings {
    /// Logarithm to base 10 of the least threshold above 0. Not tuned: chosen by hand.
    pub min_exponent: f64,
    /// Thresholds per decade. Not tuned: chosen by hand.
    pub per_decade: f64,
    /// Intervals between the least threshold above 0 and the greatest. Not tuned: chosen by hand.
    pub intervals: i32,
    /// Least samples of the quadratic form. Not tuned: chosen by hand.
    pub min_rows: usize,
    /// Samples of the quadratic form for each term. Not tuned: chosen by hand.
    pub rows_per_term: usize,
    /// Most samples of the quadratic form. Not tuned: chosen by hand.
    pub max_rows: usize,
    /// Addition to the form's diagonal, as a share of it: an equation with more terms than samples has a form too.
    pub ridge: f64,
    /// Most terms of an equation that are judged by the form; of more, those of least power are removed unjudged. Bounds the time,
    /// which goes with the cube.
    pub max_terms: usize,
}

impl PruneSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        min_exponent: -5.0,
        per_decade: 2.0,
        intervals: 8,
        min_rows: 512,
        rows_per_term: 2,
        max_rows: 4096,
        ridge: 1e-6,
        max_terms: 1024,
    };
}
