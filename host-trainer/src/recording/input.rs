//! One channel of every recording, as fit and monitor take it.

use super::Recording;

/// One recording of the channel that is modelled.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What to call it.
    pub name: String,
    /// Samples, m/s².
    pub samples: Vec<f32>,
}

/// One channel of every recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The recordings.
    pub series: Vec<Series>,
    /// Of each recording the samples after which at least one is missing, sorted.
    pub gaps: Vec<Vec<usize>>,
    /// Name of the channel.
    pub channel: String,
    /// Their common sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Whether they are one machine's life in order of time.
    pub run_to_failure: bool,
    /// Bad rows that were dropped.
    pub skipped_rows: usize,
}

/// Why recordings cannot be taken together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// No recordings.
    #[error("no recording could be read")]
    Empty,
    /// One has not the channel.
    #[error("{recording}: found channels {found}, expected `{expected}`")]
    Channel {
        /// The recording.
        recording: String,
        /// Its channels.
        found: String,
        /// The channel.
        expected: String,
    },
    /// One has another rate than the first.
    #[error("{recording}: found {found} Hz, expected {expected} Hz as {first} has; --resample makes them equal")]
    Rate {
        /// The recording.
        recording: String,
        /// Its rate.
        found: f64,
        /// The first one's.
        expected: f64,
        /// The first one.
        first: String,
    },
}

impl Input {
    /// One channel of each recording; the first of the first where none is named.
    ///
    /// # Errors
    /// A recording without the channel, or of another rate.
    pub fn from_recordings(recordings: &[Recording], channel: Option<&str>) -> Result<Self, InputError> {
        let first = recordings.first().ok_or(InputError::Empty)?;
        let name = match channel {
            Some(name) => name.to_owned(),
            None => first.channels.first().map(|c| c.name.clone()).unwrap_or_default(),
        };
        let mut series = Vec::with_capacity(recordings.len());
        for recording in recordings {
            let channel = recording.channel(&name).ok_or_else(|| {
                let there: Vec<_> = recording.channels.iter().map(|c| c.name.as_str()).collect();
                InputError::Channel {
                    recording: recording.source.to_string(),
                    found: there.join(", "),
                    expected: name.clone(),
                }
            })?;
            if (recording.sample_rate_hz / first.sample_rate_hz - 1.0).abs() > 1e-6 {
                return Err(InputError::Rate {
                    recording: recording.source.to_string(),
                    found: recording.sample_rate_hz,
                    expected: first.sample_rate_hz,
                    first: first.source.to_string(),
                });
            }
            let samples = channel.samples.iter().map(|v| *v as f32).collect();
            series.push(Series { name: recording.name(), samples });
        }
        Ok(Self {
            series,
            gaps: recordings.iter().map(|r| r.gaps.clone()).collect(),
            channel: name,
            sample_rate_hz: first.sample_rate_hz,
            run_to_failure: recordings.len() >= 20 && recordings.iter().all(|r| r.start_s.is_some()),
            skipped_rows: recordings.iter().map(|r| r.skipped_rows).sum(),
        })
    }

    /// The first `count` recordings without their gaps: what follows a gap is a recording of its own.
    pub fn continuous(&self, count: usize) -> Vec<Series> {
        let pieces = |(series, gaps): (&Series, &Vec<usize>)| -> Vec<Series> {
            let ends = gaps.iter().map(|gap| gap + 1).chain([series.samples.len()]);
            let starts = std::iter::once(0).chain(gaps.iter().map(|gap| gap + 1));
            let name = |piece: usize| match gaps.len() {
                0 => series.name.clone(),
                _ => format!("{}, part {}", series.name, piece + 1),
            };
            let spans = starts.zip(ends).enumerate().filter(|(_, (start, end))| start < end);
            spans
                .map(|(n, (start, end))| Series { name: name(n), samples: series.samples[start..end].to_vec() })
                .collect()
        };
        self.series.iter().zip(&self.gaps).take(count).flat_map(pieces).collect()
    }
}
