//! Sample rate and gaps from a time column.

use std::path::Path;

use super::ReadError;
use super::settings::TimeAxisSettings;

const SETTINGS: TimeAxisSettings = TimeAxisSettings::DEFAULT;

/// Whether a column of this name is the time axis.
pub(super) fn is_time(name: &str) -> bool {
    matches!(name.to_ascii_lowercase().as_str(), "t" | "time" | "time_s" | "t_s" | "time [s]" | "time (s)" | "seconds")
}

/// Sample rate and gaps of a time column.
#[derive(Debug, PartialEq)]
pub(super) struct TimeAxis {
    pub sample_rate_hz: f64,
    /// Samples after which at least one step is missing.
    pub gaps: Vec<usize>,
}

/// Reads `time` (in s, one finite value per sample). `first_row` is the row of the first sample.
///
/// The rate is the mean over all steps that are not gaps: stored times are rounded, and the mean
/// over n steps is n times as exact as one step. A gap is a step above 1.5 times the median.
pub(super) fn read(time: &[f64], column: &str, path: &Path, first_row: usize) -> Result<TimeAxis, ReadError> {
    for (index, pair) in time.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            return Err(ReadError::TimeNotIncreasing {
                path: path.into(),
                row: first_row + index + 1,
                column: column.into(),
                found: pair[1],
                before: pair[0],
            });
        }
    }
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return Err(ReadError::MissingRate { path: path.into() });
    }
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;

    let is_gap = |pair: &[f64]| pair[1] - pair[0] > SETTINGS.gap_ratio * median;
    let gaps: Vec<usize> = time.windows(2).enumerate().filter(|(_, p)| is_gap(p)).map(|(i, _)| i).collect();
    let lost: f64 = gaps.iter().map(|&i| time[i + 1] - time[i]).sum();
    let regular = time.len() - 1 - gaps.len();
    let sample_rate_hz = regular as f64 / (time[time.len() - 1] - time[0] - lost);
    Ok(TimeAxis { sample_rate_hz, gaps })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_times_with_a_gap_give_the_rate() {
        // 12 kHz rounded to a microsecond, seven samples missing after sample 499.
        let stored = |i: usize| (i as f64 / 12_000.0 * 1e6).round() / 1e6;
        let time: Vec<f64> = (0..500).chain(507..12_000).map(stored).collect();
        let axis = read(&time, "t", Path::new("x.csv"), 2).unwrap();
        assert!((axis.sample_rate_hz / 12_000.0 - 1.0).abs() < 1e-5, "{axis:?}");
        assert_eq!(axis.gaps, [499]);
    }

    #[test]
    fn time_that_stands_still_is_an_error_with_its_row() {
        let error = read(&[0.0, 0.1, 0.1], "t", Path::new("x.csv"), 2).unwrap_err().to_string();
        assert_eq!(error, "x.csv, row 4, column `t`: found 0.1 s after 0.1 s, expected time to increase");
    }
}
