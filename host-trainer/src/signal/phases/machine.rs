//! Phases of every channel of a machine, raw and denoised.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use super::life::{Features, Timeline};
use super::{FEWEST_HEALTHY, Phases, Rules, phases};
use crate::recording::{Recording, Source};
use crate::signal::wavelet::denoise::Denoising;

/// Signal of which features are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// As recorded.
    Raw,
    /// Denoised by a stationary wavelet transform.
    Wavelet,
}

/// Life of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelLife {
    /// Name of the channel.
    pub channel: String,
    /// Signal of which the features are taken.
    pub filter: Filter,
    /// Features of each recording.
    pub features: Vec<Features>,
}

/// Lives of all channels of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Lives {
    /// Order of the recordings.
    pub timeline: Timeline,
    /// Lives, each channel first raw and then denoised.
    pub channels: Vec<ChannelLife>,
}

impl Lives {
    /// Lives of the channels that all recordings have, except `tacho`.
    pub fn new(recordings: &[Recording], denoising: &Denoising) -> Self {
        let names = recordings.first().map_or(&[][..], |first| &first.channels).iter().map(|c| c.name.as_str());
        let in_all = |name: &&str| *name != "tacho" && recordings.iter().all(|r| r.channel(name).is_some());
        let of = |name: &str, filter: Filter| {
            let features = recordings.par_iter().filter_map(|recording| {
                let samples = &recording.channel(name)?.samples;
                Some(match filter {
                    Filter::Raw => Features::new(samples),
                    Filter::Wavelet => Features::new(&denoising.apply(samples)),
                })
            });
            ChannelLife { channel: name.into(), filter, features: features.collect() }
        };
        let channels = names.filter(in_all).flat_map(|name| [of(name, Filter::Raw), of(name, Filter::Wavelet)]);
        Self { channels: channels.collect(), timeline: Timeline::new(recordings) }
    }

    /// Phases of each life; `None` for recordings that are too few.
    pub fn phases(&self, rules: &Rules) -> Vec<Option<Phases>> {
        self.channels.iter().map(|life| phases(&life.features, &self.timeline.follows, rules)).collect()
    }
}

/// A machine with its lives and their phases.
pub struct Machine {
    /// Name of its folder.
    pub name: String,
    /// Lives of its channels.
    pub lives: Lives,
    /// Phases of each.
    pub phases: Vec<Option<Phases>>,
}

/// Recordings in which phases cannot be sought.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// Too few recordings.
    #[error("{folder}: found {found} recordings, expected more than {fewest}: so many are healthy at the beginning")]
    TooFew {
        /// Folder of the machine.
        folder: PathBuf,
        /// Recordings found.
        found: usize,
        /// Healthy recordings at the beginning.
        fewest: usize,
    },
    /// Recording of another rate than the first.
    #[error("{recording}: found {found} Hz, expected {expected} Hz as {first} has; --resample makes them equal")]
    Rate {
        /// Source of the recording.
        recording: Source,
        /// Sample rate of the recording, Hz.
        found: f64,
        /// Sample rate of the first recording, Hz.
        expected: f64,
        /// Source of the first recording.
        first: Source,
    },
}

impl Machine {
    /// Phases of a folder's recordings; `denoising` at their sample rate, Hz.
    ///
    /// # Errors
    /// [`MachineError`]: too few recordings, or of several rates.
    pub fn new(
        folder: &Path,
        recordings: &[Recording],
        rules: &Rules,
        denoising: impl FnOnce(f64) -> Denoising,
    ) -> Result<Self, MachineError> {
        let fewest = rules.healthy.unwrap_or(FEWEST_HEALTHY);
        let Some(first) = recordings.first().filter(|_| recordings.len() > fewest) else {
            return Err(MachineError::TooFew { folder: folder.to_owned(), found: recordings.len(), fewest });
        };
        if let Some(other) = recordings.iter().find(|r| r.sample_rate_hz != first.sample_rate_hz) {
            return Err(MachineError::Rate {
                recording: other.source.clone(),
                found: other.sample_rate_hz,
                expected: first.sample_rate_hz,
                first: first.source.clone(),
            });
        }
        let lives = Lives::new(recordings, &denoising(first.sample_rate_hz));
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, phases: lives.phases(rules), lives })
    }
}
