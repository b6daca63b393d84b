//! Signals: what a recording shows of a turning machine, before any model of it.
//!
//! | module | holds |
//! |---|---|
//! | [`spectrum`] | power density, amplitude spectrum |
//! | [`envelope`] | envelope of a band and its spectrum |
//! | [`kurtogram`] | the band that holds impacts, where nothing else is known |
//! | [`band`] | the band that shows given frequencies best |
//! | [`coherence`] | cyclic coherence over carrier and modulation, and the envelope spectrum enhanced by it |
//! | [`characteristic`] | the frequencies to look for, with their names |
//! | [`lines`] | a line and how far it stands out |
//! | [`order`] | the shaft's angle over time; spectra in orders of the shaft |
//! | [`synchronous`] | what repeats with the shaft, and the rest |
//! | [`speed`] | the shaft's speed, where nothing counts its turns |
//!
//! Everything takes samples as `f32` or `f64` and gives `f64`; frequencies are in Hz, times in s, angles in turns.

pub mod band;
pub mod characteristic;
pub mod coherence;
pub mod envelope;
pub(crate) mod interpolate;
pub mod kinematics;
pub mod kurtogram;
pub mod lines;
pub mod order;
pub mod spectra;
pub mod spectrum;
pub mod speed;
pub mod surrogate;
pub mod synchronous;
#[cfg(test)]
mod test_signals;
pub(crate) mod transform;

/// A sample of a recording: `f32` or `f64`.
pub trait Sample: Copy + Into<f64> + Sync {}

impl<T: Copy + Into<f64> + Sync> Sample for T {}
