//! The ballrace device on the host, and what it shares with the bare-metal image.
//!
//! Data flows one way, and each module knows only the ones before it:
//!
//! | module | holds | takes → gives |
//! |---|---|---|
//! | [`source`] | what arrives at a device; recordings in memory, as fast as it goes or paced | recording → arrivals |
//! | [`faults`] | broken sensors and lost samples, put between a source and the device | arrivals → arrivals |
//! | [`runner`] | the device itself ([`ballrace_core::device`]), fed with arrivals | arrivals → events |
//! | [`event`] | what a device tells of: its status, its faults, its totals | |
//! | [`intermediates`] | every number of a run in one CRC-32, to hold host and device to the same bits | samples → report |
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
//! Without the feature `std` only [`intermediates`] remains, `no_std` and without `alloc`; that the
//! image links for a bare-metal target is the proof.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(feature = "std")]
pub mod event;
#[cfg(feature = "std")]
pub mod faults;
pub mod intermediates;
#[cfg(feature = "std")]
pub mod runner;
#[cfg(feature = "std")]
pub mod source;
