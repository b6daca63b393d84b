//! One channel of every recording, for fit and monitor.

use super::Recording;
use super::settings::InputSettings;

const SETTINGS: InputSettings = InputSettings::DEFAULT;
const TACHOMETER: &str = "tacho";

/// One recording of the modelled channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name of the recording.
    pub name: String,
    /// Samples, m/s².
    pub samples: Vec<f32>,
}

/// One channel of every recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// One series for each recording.
    pub series: Vec<Series>,
    /// Samples of each recording after which at least one is missing, sorted.
    pub gaps: Vec<Vec<usize>>,
    /// Name of the channel.
    pub channel: String,
    /// Common sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Whether the recordings are one machine's life in order of time.
    pub run_to_failure: bool,
    /// Number of bad rows dropped.
    pub skipped_rows: usize,
    /// Start of each recording in seconds after midnight of the first one's day, where every recording states it.
    pub starts_s: Option<Vec<f64>>,
    /// Median time from the start of one recording to that of the next, s, where every recording states its start.
    pub interval_s: Option<f64>,
}

/// Failure to take recordings together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// No recordings.
    #[error("no recording could be read")]
    Empty,
    /// Recording without the channel.
    #[error("{recording}: found channels {found}, expected `{expected}`")]
    Channel {
        /// Name of the recording.
        recording: String,
        /// Names of its channels.
        found: String,
        /// Name of the channel.
        expected: String,
    },
    /// Pulses in the place of a vibration.
    #[error("{recording}, channel `tacho`: found a tachometer's pulses, expected a channel that vibrates")]
    Tachometer {
        /// Name of the first recording.
        recording: String,
    },
    /// Recording of another rate than the first.
    #[error("{recording}: found {found} Hz, expected {expected} Hz as {first} has; --resample makes them equal")]
    Rate {
        /// Name of the recording.
        recording: String,
        /// Sample rate of the recording, Hz.
        found: f64,
        /// Sample rate of the first recording, Hz.
        expected: f64,
        /// Name of the first recording.
        first: String,
    },
}

impl Input {
    /// One channel of each recording; by default the first channel of the first recording that is no tachometer.
    ///
    /// # Errors
    /// No recordings, the tachometer, a recording without the channel, or of another rate.
    pub fn from_recordings(recordings: &[Recording], channel: Option<&str>) -> Result<Self, InputError> {
        let first = recordings.first().ok_or(InputError::Empty)?;
        let name = match channel {
            Some(name) => name.to_owned(),
            None => {
                let of_machine = first.channels.iter().find(|c| c.name != TACHOMETER).or(first.channels.first());
                of_machine.map(|c| c.name.clone()).unwrap_or_default()
            }
        };
        if name == TACHOMETER {
            return Err(InputError::Tachometer { recording: first.source.to_string() });
        }
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
            if (recording.sample_rate_hz / first.sample_rate_hz - 1.0).abs() > SETTINGS.rate_tolerance {
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
        let starts_s: Option<Vec<f64>> = recordings.iter().map(|r| r.start_s).collect();
        Ok(Self {
            series,
            gaps: recordings.iter().map(|r| r.gaps.clone()).collect(),
            channel: name,
            sample_rate_hz: first.sample_rate_hz,
            run_to_failure: recordings.len() >= SETTINGS.min_run_to_failure && starts_s.is_some(),
            skipped_rows: recordings.iter().map(|r| r.skipped_rows).sum(),
            interval_s: starts_s.as_deref().and_then(interval_s),
            starts_s,
        })
    }

    /// Series of the first `count` recordings, cut at their gaps.
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

/// Median time between the starts of recordings, s.
fn interval_s(starts: &[f64]) -> Option<f64> {
    let mut intervals: Vec<f64> = starts.windows(2).map(|w| w[1] - w[0]).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().filter(|interval| interval.is_finite() && *interval > 0.0)
}
