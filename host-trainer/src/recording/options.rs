//! Options of loading recordings.

use std::{fmt, ops::Range, sync::Arc};

use super::settings::StatedSettings;
use super::{ReadError, Unit};

/// Progress of a [`load`](super::load).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Recordings read.
    pub done: usize,
    /// Recordings to read.
    pub total: usize,
}

/// Callback after each recording, from any thread, with `done` in no particular order.
pub type ProgressFn = Arc<dyn Fn(Progress) + Send + Sync>;

/// Options of [`load`](super::load). The default reads everything and accepts no error.
#[derive(Clone, Default)]
pub struct LoadOptions {
    /// Drops bad rows and unreadable recordings instead of failing. Both are counted: rows in
    /// [`Recording::skipped_rows`](super::Recording::skipped_rows), recordings in
    /// [`Loaded::skipped`](super::Loaded::skipped). A dropped row shortens the time axis.
    pub skip_bad: bool,
    /// Sample rate, Hz; overrides the file, its manifest and its format.
    pub sample_rate_hz: Option<f64>,
    /// Unit of the accelerations; overrides the file, its manifest and its format.
    pub unit: Option<Unit>,
    /// Variable of `.mat` files, such as `X130_DE_time` or `bearing.gs`.
    pub variable: Option<String>,
    /// Channels to read, by name or location, all of which must exist; `None`: all.
    pub channels: Option<Vec<String>>,
    /// Recordings to read, counted from 0 over all paths; `None`: all. A range beyond the last one is cut; an empty one
    /// is an error.
    pub recordings: Option<Range<usize>>,
    /// Sample rate to resample every recording to, Hz ([`resample`](super::resample)).
    pub resample_hz: Option<f64>,
    /// Callback after each recording.
    pub progress: Option<ProgressFn>,
}

impl LoadOptions {
    pub(super) fn check(&self) -> Result<(), ReadError> {
        let rates = [("sample_rate_hz", self.sample_rate_hz), ("resample_hz", self.resample_hz)];
        for (option, rate) in rates {
            if let Some(rate) = rate
                && !StatedSettings::DEFAULT.sample_rate_hz.contains(&rate)
            {
                let expected = StatedSettings::RATES.into();
                return Err(ReadError::BadOption { option, found: rate.to_string(), expected });
            }
        }
        Ok(())
    }
}

impl fmt::Debug for LoadOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LoadOptions")
            .field("skip_bad", &self.skip_bad)
            .field("sample_rate_hz", &self.sample_rate_hz)
            .field("unit", &self.unit)
            .field("variable", &self.variable)
            .field("channels", &self.channels)
            .field("recordings", &self.recordings)
            .field("resample_hz", &self.resample_hz)
            .finish_non_exhaustive()
    }
}
