//! Recordings of accelerometers, in SI units, with the operating condition.
//!
//! [`load`] reads files and folders into [`Recording`]s, [`mod@write`] stores them.
//!
//! | module | format |
//! |---|---|
//! | `femto` | PRONOSTIA/FEMTO `acc_*.csv` without header |
//! | `csv` | CSV with a header |
//! | `mat` | MATLAB v5 (CWRU, MFPT, and others) |
//! | `npy` | NumPy arrays |
//! | `parquet` | Parquet columns |
//! | [`manifest`] | `recordings.toml`: metadata that the files lack |
//!
//! `find` turns paths into jobs, a format turns a job into raw columns, `assemble` turns raw columns into a
//! [`Recording`].

use std::{fmt, path::PathBuf};

mod assemble;
pub(crate) mod atomic_write;
pub(crate) mod bounded;
mod error;
mod find;
mod formats;
pub mod input;
mod job;
mod load;
pub mod manifest;
mod options;
pub(crate) mod owned;
pub(crate) mod parquet_table;
mod parse_number;
pub mod reference_data;
pub mod resample;
pub(crate) mod settings;
mod table;
mod time_axis;
mod unit;
pub mod write;

pub use error::ReadError;
pub use find::sources;
pub use load::{Loaded, load, load_all};
pub use options::{LoadOptions, Progress, ProgressFn};
pub use unit::{STANDARD_GRAVITY, Unit, is_acceleration};

/// Source of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// Path of the file.
    pub path: PathBuf,
    /// Variable chosen from a `.mat` file.
    pub variable: Option<String>,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        self.variable.as_ref().map_or(Ok(()), |variable| write!(f, ":{variable}"))
    }
}

/// One signal of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Column or variable name; `horizontal` and `vertical` for FEMTO; `ch1`, `ch2`, … for NumPy.
    pub name: String,
    /// Location of the sensor, such as `outer-x` or `resonator-y`: from the manifest, or the
    /// default for `ax` and `ay`.
    pub location: Option<String>,
    /// Samples at the recording's rate. Accelerations are in m/s², everything else
    /// (`tacho`, `u`, `q`, `qd`, `qdd`, names that end in another unit) is as stored.
    pub samples: Vec<f64>,
}

impl Channel {
    /// Whether the samples are accelerations, by the channel's name.
    pub fn is_acceleration(&self) -> bool {
        unit::Quantity::from_name(&self.name) != unit::Quantity::Other
    }

    /// Whether the sensor is where it is without a statement.
    pub fn is_at_default(&self) -> bool {
        self.location.as_deref() == unit::default_location(&self.name)
    }

    /// Value that all samples have, if they have one.
    pub fn constant(&self) -> Option<f64> {
        let first = *self.samples.first()?;
        self.samples.iter().all(|sample| *sample == first).then_some(first)
    }
}

/// A recording: channels of equal length on one time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Source of the recording.
    pub source: Source,
    /// Channels, at least one, in the order of the file.
    pub channels: Vec<Channel>,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Shaft speed, revolutions per second.
    pub shaft_hz: Option<f64>,
    /// Standard deviation of that speed, Hz, where the manifest states one.
    pub shaft_hz_std: Option<f64>,
    /// Radial load, N.
    pub load_n: Option<f64>,
    /// Time of the first sample in seconds after midnight of the day on which the first
    /// recording of its folder began; beyond 86 400 once midnight has passed. FEMTO only.
    pub start_s: Option<f64>,
    /// Sample rate before it was resampled up, Hz: above half of it there is no content.
    pub resampled_from_hz: Option<f64>,
    /// Number of bad rows dropped (only with [`LoadOptions::skip_bad`]).
    pub skipped_rows: usize,
    /// Samples after which at least one is missing, sorted: the time column skips a step, or a bad row was dropped.
    pub gaps: Vec<usize>,
}

impl Recording {
    /// Samples per channel.
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, |c| c.samples.len())
    }

    /// Whether there are no samples. [`load`] never returns such a recording.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Duration, s: one sample period for each sample.
    pub fn duration_s(&self) -> f64 {
        self.len() as f64 / self.sample_rate_hz
    }

    /// Standard deviation of the stated shaft speed, Hz: the manifest's, else a fixed share of the speed. `None` without a speed.
    /// A channel `tacho` measures the speed better.
    pub fn speed_std_hz(&self) -> Option<f64> {
        let usual = |speed: f64| settings::ConditionSettings::DEFAULT.stated_speed_std * speed;
        self.shaft_hz_std.or_else(|| self.shaft_hz.map(usual))
    }

    /// Channel of this name, or else at this location.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        let by_name = self.channels.iter().find(|c| c.name == name);
        by_name.or_else(|| self.channels.iter().find(|c| c.location.as_deref() == Some(name)))
    }

    /// Samples of the channel of this name, or else at this location.
    pub fn samples(&self, name: &str) -> Option<&[f64]> {
        self.channel(name).map(|channel| channel.samples.as_slice())
    }

    /// File name without its ending, such as `r01`.
    pub fn name(&self) -> String {
        self.source.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}
