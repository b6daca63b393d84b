//! From a vibration recording to a sparse dynamics model on a microcontroller.
//!
//! Data flows one way, and each layer knows only those of earlier rows (a test holds the order):
//!
//! | layer | holds | takes → gives |
//! |---|---|---|
//! | [`stats`] | significance, optimisation, cancellation, numbers as text | |
//! | [`paper`] | numbers of the paper whose method this is | |
//! | [`recording`] | readers, units, resampling, writers | files → [`Recording`] |
//! | [`signal`] | spectra, envelopes, orders, speed, kinematics, surrogates, wavelets, aging phases | samples → spectra, lines |
//! | [`rig`] | the 5-DoF and the one-degree-of-freedom rig, effects, simulation | [`Rig`] → [`Recording`] |
//! | [`model`] | virtual states, SINDy-NN, STLSQ, scores, export, replay on the device's code | series → [`OwnedModel`] |
//! | [`rivals`] | networks of the paper's Table 4, and least squares on the same windows | series → scores |
//! | [`sweep`] | studies of libraries and dimensions, resumable | `sweep.toml` → rows |
//! | [`features`] | fitted coefficients as features, by leave-one-bearing-out | recordings → scores |
//! | [`identify`] | parameters of a rig: likelihood, force balance, calibration | rig, recordings → rig |
//! | [`mod@diagnose`] | what the rig leaves out: location, cause, corrected rig | rig, recordings → diagnosis |
//! | [`fleet`] | telemetry of machines by MQTT into SQLite (feature `fleet`) | events → messages → machines |
//! | [`report`] | HTML documents and plots | results → HTML, SVG |
//! | [`evaluate`] | how often a diagnosis is right, on concealed cases | seed → score |
//! | [`cli`] | the commands and the demo | arguments → files, text |
//!
//! From a recording to the device, and back:
//!
//! ```
//! use ballrace::model::export::{Format, export};
//! use ballrace::model::fit::{FitConfig, Solver, fit};
//! use ballrace::model::replay::{Options, replay};
//! use ballrace::model::stlsq::StlsqConfig;
//! use ballrace::recording::{LoadOptions, Unit, load, input::Input};
//!
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("r01.csv");
//! let rows: String = (0..4000).map(|k| format!("{}\n", (0.3 * k as f64).sin() + 0.2 * (1.1 * k as f64).sin())).collect();
//! std::fs::write(&file, format!("ay\n{rows}"))?;
//!
//! let options = LoadOptions { sample_rate_hz: Some(25_600.0), unit: Unit::parse("m/s^2"), ..LoadOptions::default() };
//! let input = Input::from_recordings(&load(&[file], &options)?.recordings, None)?;
//! let solver = Solver::Stlsq(StlsqConfig::default());
//! let config = FitConfig { degree: 1, harmonics: 0, solver, null_fits: 0, ..FitConfig::default() };
//! let model = fit(&input.series, input.sample_rate_hz, &config, &|_| ())?.model;
//! assert_eq!(export(&model, Format::Bin)?, model.bytes());
//! let run = replay(&model, &input, &Options::default(), &mut |_, _| ())?;
//! assert!(run.summary.evaluated > 3900 && run.summary.alarms == 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod cli;
pub mod diagnose;
pub mod evaluate;
pub mod features;
#[cfg(feature = "fleet")]
pub mod fleet;
pub mod identify;
pub mod model;
pub mod paper;
pub mod recording;
pub mod report;
pub mod rig;
pub mod rivals;
pub mod signal;
pub mod stats;
pub mod sweep;

pub use diagnose::{Task, diagnose};
pub use identify::calibrate::calibrate;
pub use model::OwnedModel;
pub use model::fit::{FitConfig, Fitted, fit};
pub use model::replay::replay;
pub use recording::{Recording, load};
pub use rig::{EffectEntry, Rig, simulate};
