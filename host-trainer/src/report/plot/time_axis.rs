//! Horizontal axis of trends over recordings.

use std::ops::Range;

use crate::recording::input::{Input, Series};

/// Horizontal axis of a trend: clock time in hours where the recordings state their starts, else their numbers from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeAxis {
    /// Number of the recording; recording n fills the unit interval around n + 1.
    Number {
        /// Number of recordings.
        count: usize,
    },
    /// Clock time, h after midnight of the first day: start and end of each recording.
    Clock(Vec<Range<f64>>),
}

impl TimeAxis {
    /// Axis over the recordings of an input: clock time if they follow one another.
    pub fn of(input: &Input) -> Self {
        let count = input.series.len();
        let starts =
            input.starts_s.as_deref().filter(|s| s.len() == count && s.len() > 1 && s.is_sorted_by(|a, b| a < b));
        let hours = |(start, series): (&f64, &Series)| {
            let end = start + series.samples.len() as f64 / input.sample_rate_hz;
            start / 3600.0..end / 3600.0
        };
        match starts {
            Some(starts) => Self::Clock(starts.iter().zip(&input.series).map(hours).collect()),
            None => Self::Number { count },
        }
    }

    /// Place of a share (0 to 1) of a recording.
    pub fn at(&self, recording: usize, share: f64) -> f64 {
        match self {
            Self::Number { .. } => recording as f64 + 0.5 + share,
            Self::Clock(spans) => spans.get(recording).map_or(f64::NAN, |s| s.start + share * (s.end - s.start)),
        }
    }

    /// Range from the first to the last recording.
    pub fn range(&self) -> Range<f64> {
        match self {
            Self::Number { count } => 0.5..(*count).max(1) as f64 + 0.5,
            Self::Clock(spans) => self.at(0, 0.0)..self.at(spans.len().saturating_sub(1), 1.0),
        }
    }

    /// Name of the axis.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Number { .. } => "recording",
            Self::Clock(_) => "clock time",
        }
    }

    /// Text of a place: `08:15`, with seconds on an axis of less than half an hour, and the days since the first.
    pub fn tick(&self, place: f64) -> String {
        let Self::Clock(_) = self else { return super::style::tick(place) };
        let range = self.range();
        let second = (place * 3600.0).round() as i64;
        let (day, hour, minute) = (second.div_euclid(86_400), second.div_euclid(3600) % 24, second.div_euclid(60) % 60);
        let brief = range.end - range.start < 0.5;
        let seconds = if brief { format!(":{:02}", second % 60) } else { String::new() };
        let days = if day > 0 { format!("+{day} d ") } else { String::new() };
        format!("{days}{hour:02}:{minute:02}{seconds}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_times_are_hours_and_minutes_of_a_day() {
        let day = TimeAxis::Clock(vec![8.0..8.1, 33.0..33.1]);
        assert_eq!([8.25, 33.5].map(|h| day.tick(h)), ["08:15", "+1 d 09:30"]);
        let minutes = TimeAxis::Clock(vec![8.0..8.1, 8.2..8.3]);
        assert_eq!(minutes.tick(8.02), "08:01:12");
        assert_eq!(minutes.range(), 8.0..8.3);
        assert_eq!((day.at(1, 0.0), day.name()), (33.0, "clock time"));
        let numbers = TimeAxis::Number { count: 3 };
        assert_eq!((numbers.at(0, 0.0), numbers.at(2, 1.0), numbers.tick(2.0)), (0.5, 3.5, "2".into()));
    }
}
