//! SINDy-NN, theory (9) to (16): an autoencoder whose latent variables obey sparse dynamics (the paper; Champion et
//! al. 2019, its reference 30).
//!
//! [`config`] holds the options, [`gradient`] the losses, [`schedule`] the learning rate, [`train`] the training, `panel` the
//! kernels, [`real`] their vectors.

mod adam;
pub mod config;
pub mod engine;
pub(crate) mod export;
pub mod gradient;
pub mod layout;
pub(crate) mod panel;
mod passes;
mod prune;
pub mod real;
pub mod schedule;
pub(crate) mod settings;
pub(crate) mod terms;
pub mod train;

#[cfg(test)]
mod gradient_tests;
