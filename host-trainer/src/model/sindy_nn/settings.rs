//! Settings of SINDy-NN in addition to [`TrainConfig`](super::train::TrainConfig).

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
    /// Checks of the held-out loss over the planned steps. Not tuned: chosen by hand.
    pub checks: usize,
    /// Greatest number of samples for a held-out loss or a term's power. Not tuned: chosen by hand.
    pub max_judged: usize,
}

impl RunSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { initial_coefficient: 0.01, checks: 40, max_judged: 4096 };
}
