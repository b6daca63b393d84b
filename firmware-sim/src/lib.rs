//! The ballrace device on the host, and the code shared with the bare-metal image.
//!
//! Data flows one way, and each module knows only the ones before it:
//!
//! | module | holds | takes → gives |
//! |---|---|---|
//! | [`source`] | samples and notices of missing ones, from memory, paced or not | recording → arrivals |
//! | [`faults`] | injection of broken and lost samples | arrivals → arrivals |
//! | [`batch`] | the device up to its monitor, many samples and recordings side by side | arrivals → residuals |
//! | [`runner`] | the device itself ([`ballrace_core::device`]) | arrivals → events |
//! | [`event`] | status changes, blocks, faults, totals | |
//! | [`intermediates`] | CRC-32 over all numbers of a run, to compare host and device | samples → report |
//!
//! ```
//! # fn doc(model: &ballrace_core::model::Model<'_>, samples: &[f32]) -> Result<(), Box<dyn std::error::Error>> {
//! use ballrace_firmware_sim::{faults::Injector, runner::{Recording, Runner}, source};
//!
//! let mut scratch = vec![0.0; Runner::scratch_len(model)];
//! let mut runner = Runner::new(model, &mut scratch)?;
//! let mut injector = Injector::new("nan:0.001,gap:1e-5x200".parse()?, 7);
//! let source = injector.over(source::in_memory(samples));
//! let recording = Recording { name: "r01.csv", sample_rate_hz: 25_600.0 };
//! runner.run(&recording, source, |event| println!("{event:?}"));
//! let summary = runner.finish(|event| println!("{event:?}"));
//! # Ok(()) }
//! ```
//!
//! Without the feature `std` only [`intermediates`] remains, `no_std` and without `alloc`, for the bare-metal image.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(feature = "std")]
pub mod batch;
#[cfg(feature = "std")]
pub mod event;
#[cfg(feature = "std")]
pub mod faults;
pub mod intermediates;
#[cfg(feature = "std")]
pub mod runner;
#[cfg(feature = "std")]
pub mod source;
