//! What to read, and how strictly.

use std::{fmt, ops::Range, sync::Arc};

use super::{ReadError, Unit};

/// How far a [`load`](super::load) has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Recordings read.
    pub done: usize,
    /// Recordings there are to read.
    pub total: usize,
}

/// Called after each recording, from any thread, `done` in no certain order.
pub type ProgressFn = Arc<dyn Fn(Progress) + Send + Sync>;

/// What [`load`](super::load) reads. The default reads everything and refuses anything wrong.
#[derive(Clone, Default)]
pub struct LoadOptions {
    /// Drop bad rows and unreadable recordings instead of failing. Both are counted: rows in
    /// [`Recording::skipped_rows`](super::Recording::skipped_rows), recordings in
    /// [`Loaded::skipped`](super::Loaded::skipped). A dropped row shortens the time axis.
    pub skip_bad: bool,
    /// Sample rate in Hz, over whatever the file, its manifest or its format state.
    pub sample_rate_hz: Option<f64>,
    /// Unit of the accelerations, over whatever the file, its manifest or its format state.
    pub unit: Option<Unit>,
    /// Variable of `.mat` files, such as `X130_DE_time` or `bearing.gs`.
    pub variable: Option<String>,
    /// Only these channels, by name or location; every one must be there. The others are not
    /// parsed where the format allows.
    pub channels: Option<Vec<String>>,
    /// Only these recordings, counted from 0 over all paths. A range that reaches beyond the
    /// last one is cut; one with no recording in it is an error.
    pub recordings: Option<Range<usize>>,
    /// Resample every recording to this rate in Hz ([`resample`](super::resample)).
    pub resample_hz: Option<f64>,
    /// Called after each recording.
    pub progress: Option<ProgressFn>,
}

impl LoadOptions {
    pub(super) fn check(&self) -> Result<(), ReadError> {
        let rates = [("sample_rate_hz", self.sample_rate_hz), ("resample_hz", self.resample_hz)];
        for (option, rate) in rates {
            if let Some(rate) = rate
                && !(rate.is_finite() && rate > 0.0)
            {
                let expected = "a positive number of Hz".into();
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
