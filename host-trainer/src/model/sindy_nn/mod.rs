//! SINDy-NN: an autoencoder whose latent variables obey sparse dynamics (the paper; Champion et al.
//! 2019, its reference 30).
//!
//! Start at [`gradient`] for the method's equations; [`panel`] has the kernels they are made of,
//! [`real`] the vectors those are made of.

mod adam;
pub mod engine;
pub mod export;
pub mod gradient;
pub mod layout;
pub mod panel;
mod passes;
pub mod real;
pub mod terms;
pub mod train;

#[cfg(test)]
mod gradient_tests;
