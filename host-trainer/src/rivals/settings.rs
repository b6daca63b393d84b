//! Settings of the rivals.

/// Window, widths and training of the rivals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RivalSettings {
    /// Samples, or rows of states, in a window. Not tuned: as many as the paper's states reach over.
    pub window: usize,
    /// Hidden units of the LSTM, channels of the TCN, width of the PatchTransformer. Not tuned: some thousand parameters, as
    /// SINDy-NN has.
    pub width: usize,
    /// Taps of the TCN's kernels. Not tuned: usual.
    pub kernel: usize,
    /// Blocks of the TCN; each dilates twice as far as the one before. Chosen so that they reach over the window.
    pub blocks: usize,
    /// Samples of a patch. Not tuned: usual share of a window.
    pub patch: usize,
    /// Samples from a patch to the next.
    pub stride: usize,
    /// Layers of the PatchTransformer. Not tuned.
    pub layers: usize,
    /// Heads of its attention. Not tuned.
    pub heads: usize,
    /// Learning rates of Adam that are tried; the validation part chooses.
    pub learning_rates: [f64; 2],
    /// Windows of a step. Not tuned: usual.
    pub batch: usize,
    /// Most epochs.
    pub epochs: usize,
    /// Epochs without a better validation error that end a training.
    pub patience: usize,
}

/// Settings of all rivals.
pub const SETTINGS: RivalSettings = RivalSettings {
    window: 16,
    width: 32,
    kernel: 3,
    blocks: 3,
    patch: 4,
    stride: 2,
    layers: 2,
    heads: 4,
    learning_rates: [1e-2, 2e-3],
    batch: 64,
    epochs: 40,
    patience: 6,
};
