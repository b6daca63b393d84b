//! Signal analysis of a rotating machine's recording, before any model.
//!
//! | module | holds |
//! |---|---|
//! | [`spectrum`] | power density, amplitude spectrum |
//! | [`envelope`] | envelope of a band and its spectrum |
//! | [`kurtogram`] | the band that holds impacts, by kurtosis alone |
//! | [`band`] | the band that shows given lines best |
//! | [`coherence`] | cyclic coherence, enhanced envelope spectrum |
//! | [`indicators`] | RMS, peak, crest factor, kurtosis, vibration velocity and its zones |
//! | [`kinematics`], [`characteristic`] | characteristic frequencies and their names |
//! | [`bearings`] | catalogue of bearings by designation |
//! | [`lines`] | lines and their significance |
//! | [`order`] | the shaft's angle over time, order spectra |
//! | [`synchronous`] | synchronous average and residual |
//! | [`phases`] | aging phases of a machine's life |
//! | [`speed`] | the shaft's speed without a tachometer |
//! | [`spectra`] | all of these for one recording |
//! | [`surrogate`] | surrogates without dynamics |
//! | [`wavelet`] | stationary wavelet transform, denoising |
//! | `settings` | settings of each stage |
//!
//! Samples are `f32` or `f64`, results `f64`; frequencies are in Hz, times in s, angles in turns.

pub mod band;
pub mod bearings;
pub mod characteristic;
pub mod coherence;
pub mod envelope;
pub mod indicators;
pub(crate) mod interpolate;
pub mod kinematics;
pub mod kurtogram;
pub mod lines;
pub mod order;
pub mod phases;
pub(crate) mod settings;
pub mod spectra;
pub mod spectrum;
pub mod speed;
pub mod surrogate;
pub mod synchronous;
#[cfg(test)]
pub(crate) mod test_signals;
pub(crate) mod transform;
pub mod wavelet;

/// A sample of a recording: `f32` or `f64`.
pub trait Sample: Copy + Into<f64> + Sync {}

impl<T: Copy + Into<f64> + Sync> Sample for T {}
