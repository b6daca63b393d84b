//! Rivals of the paper's Table 4: networks that predict the derivatives, or the next sample, from a window of the past.
//!
//! | module | holds |
//! |---|---|
//! | [`windows`] | windows of the states or of the signal, and what follows them |
//! | `network` | LSTM, TCN, PatchTransformer on candle |
//! | `training` | Adam with early stop, and the choice of its learning rate, by validation recordings |
//! | [`settings`] | widths, window, training |
//!
//! candle rather than burn: 158 packages in a lock file instead of 613, and the three networks need no more than its layers. The
//! feature `rivals` of the crate brings them in; without it [`windows`] alone is built, for the linear baseline on the same
//! window.

#[cfg(feature = "rivals")]
pub mod network;
pub mod settings;
#[cfg(all(test, feature = "rivals"))]
mod tests;
#[cfg(feature = "rivals")]
pub mod training;
pub mod windows;

use ballrace_core::states::StateSpec;

use crate::model::fit::Split;
use windows::Windows;

/// Network of Table 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rival {
    /// Long short-term memory: S. Hochreiter, J. Schmidhuber, Neural Computation 9 (1997) 1735–1780.
    Lstm,
    /// Temporal convolutional network: S. Bai, J. Z. Kolter, V. Koltun, arXiv:1803.01271 (2018). Without their dropout and
    /// weight normalisation, and linear after the sum of a block: early stop regularises here.
    Tcn,
    /// Transformer over patches: Y. Nie, N. H. Nguyen, P. Sinthong, J. Kalagnanam, ICLR 2023. A patch holds all channels,
    /// where theirs are a series each, and scales are those of the part fitted to, where theirs are each window's.
    PatchTransformer,
}

/// What is predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// Derivatives of these virtual states, from the states up to and including the present: the paper's.
    Derivatives(StateSpec),
    /// Next sample from past ones.
    NextSample,
}

/// Windows of the three parts of a split, in the scales of the first.
pub struct Parts {
    /// Part fitted to.
    pub train: Windows,
    /// Validation part.
    pub validation: Windows,
    /// Held-out part.
    pub held_out: Windows,
}

impl Parts {
    /// Windows of a task over a split.
    pub fn new(split: &Split, task: Task) -> Self {
        let [train, validation, held_out] = match task {
            Task::Derivatives(spec) => windows::of_states([&split.train, &split.validation, &split.held_out], spec),
            Task::NextSample => windows::of_signals([&split.train, &split.validation, &split.held_out]),
        };
        Self { train, validation, held_out }
    }
}

/// Scores of a rival: mean R² over its outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RivalScores {
    /// On the part fitted to.
    pub in_sample: f64,
    /// On the validation part, which chose learning rate and stop.
    pub validation: f64,
    /// On the held-out part.
    pub held_out: f64,
    /// Parameters of the network.
    pub parameters: usize,
}

/// Scores of a rival on both tasks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BothScores {
    /// On the derivatives.
    pub derivatives: RivalScores,
    /// On the next sample, by another training; `None` if it was not asked for.
    pub next_sample: Option<RivalScores>,
}

/// Trains a rival for the derivatives of some states and, with `causal`, for the next sample.
///
/// # Errors
/// As [`score`].
pub fn score_both(rival: Rival, split: &Split, spec: StateSpec, causal: bool, seed: u64) -> Result<BothScores, String> {
    let derivatives = score(rival, split, Task::Derivatives(spec), seed)?;
    let next_sample = causal.then(|| score(rival, split, Task::NextSample, seed)).transpose()?;
    Ok(BothScores { derivatives, next_sample })
}

/// Trains a rival on a split and scores it.
///
/// # Errors
/// A message: too few samples for a window, a training that diverged, an error of the framework, or a build without the
/// feature `rivals`.
pub fn score(rival: Rival, split: &Split, task: Task, seed: u64) -> Result<RivalScores, String> {
    let parts = Parts::new(split, task);
    if [&parts.train, &parts.validation, &parts.held_out].into_iter().any(Windows::is_empty) {
        return Err(format!("found recordings shorter than a window of {} samples", settings::SETTINGS.window));
    }
    trained(rival, &parts, seed)
}

#[cfg(feature = "rivals")]
fn trained(rival: Rival, parts: &Parts, seed: u64) -> Result<RivalScores, String> {
    let trained = training::train(rival, parts, seed).map_err(|error| error.to_string())?;
    if trained.in_sample.is_finite() && trained.held_out.is_finite() {
        Ok(trained)
    } else {
        Err("the training diverged".into())
    }
}

#[cfg(not(feature = "rivals"))]
fn trained(rival: Rival, _: &Parts, _: u64) -> Result<RivalScores, String> {
    Err(format!("{rival:?} is in builds with the feature `rivals` only"))
}
