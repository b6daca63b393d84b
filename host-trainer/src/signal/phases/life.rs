//! Features of a machine's recordings in order of time.

use crate::recording::Recording;
use crate::signal::settings::PhaseSettings;
use crate::signal::transform::median;

/// Features of the samples of a recording about their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Features {
    /// Kurtosis, 3 for normal noise; NaN for a constant signal.
    pub kurtosis: f64,
    /// Root mean square, in the unit of the samples.
    pub rms: f64,
}

impl Features {
    /// Features of samples.
    pub fn new(samples: &[f64]) -> Self {
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let [square, fourth] = samples.iter().fold([0.0; 2], |[square, fourth], sample| {
            let power = (sample - mean).powi(2);
            [square + power, fourth + power * power]
        });
        Self { kurtosis: count * fourth / (square * square), rms: (square / count).sqrt() }
    }
}

/// Order of recordings in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    /// Names.
    pub names: Vec<String>,
    /// Times since the first recording, s; `None` if the files state none.
    pub times_s: Option<Vec<f64>>,
    /// Whether each recording follows the one before it without a gap; true for the first.
    pub follows: Vec<bool>,
}

const SETTINGS: PhaseSettings = PhaseSettings::DEFAULT;

impl Timeline {
    /// Order of recordings. A gap shows in the times, or in the numbers of the names where there are no times.
    pub fn new(recordings: &[Recording]) -> Self {
        let names: Vec<String> = recordings.iter().map(Recording::name).collect();
        let starts: Option<Vec<f64>> = recordings.iter().map(|recording| recording.start_s).collect();
        let first = starts.as_ref().and_then(|starts| starts.first().copied()).unwrap_or(0.0);
        let times_s: Option<Vec<f64>> = starts.map(|starts| starts.iter().map(|start| start - first).collect());
        let steps: Vec<Option<f64>> = match &times_s {
            Some(times) => times.windows(2).map(|pair| Some(pair[1] - pair[0])).collect(),
            None => names.windows(2).map(|pair| Some(number(&pair[1])? - number(&pair[0])?)).collect(),
        };
        let usual = median(&mut steps.iter().flatten().copied().collect::<Vec<_>>());
        let is_usual = |step: &Option<f64>| match (step, usual) {
            (Some(step), Some(usual)) => *step > 0.0 && *step < SETTINGS.gap * usual,
            _ => true,
        };
        let follows = std::iter::once(true).chain(steps.iter().map(is_usual)).take(names.len()).collect();
        Self { names, times_s, follows }
    }

    /// Number of gaps.
    pub fn gaps(&self) -> usize {
        self.follows.iter().filter(|follows| !**follows).count()
    }
}

/// Number at the end of a name.
fn number(name: &str) -> Option<f64> {
    let digits = name.len() - name.bytes().rev().take_while(u8::is_ascii_digit).count();
    name[digits..].parse().ok()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::recording::{Channel, Source};
    use crate::signal::test_signals::gaussian;

    fn named(number: usize, start_s: Option<f64>) -> Recording {
        let source = Source { path: format!("acc_{number:05}.csv").into(), variable: None };
        let channels = vec![Channel { name: "ay".into(), samples: vec![0.0], location: None }];
        Recording { source, channels, sample_rate_hz: 1.0, start_s, ..Recording::default() }
    }

    #[test]
    fn literature_kurtosis_and_rms_of_known_signals() {
        let sine: Vec<f64> = (0..1000).map(|n| 5.0 + 2.0 * (TAU * f64::from(n) / 50.0).sin()).collect();
        let found = Features::new(&sine);
        assert!((found.kurtosis - 1.5).abs() < 1e-9 && (found.rms - 2f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert!((Features::new(&gaussian(100_000, 1)).kurtosis - 3.0).abs() < 0.05);
        assert!(Features::new(&[4.0; 9]).kurtosis.is_nan());
    }

    #[test]
    fn a_gap_shows_in_the_times_or_in_the_numbers() {
        let by_number: Vec<Recording> = [1, 2, 3, 7, 8].map(|n| named(n, None)).to_vec();
        let by_time: Vec<Recording> = [1, 2, 3, 7, 8].map(|n| named(n, Some(10.0 * n as f64 + 3.0))).to_vec();
        for recordings in [by_number, by_time] {
            let timeline = Timeline::new(&recordings);
            assert_eq!(timeline.follows, [true, true, true, false, true]);
            assert_eq!(timeline.gaps(), 1);
        }
        assert_eq!(Timeline::new(&[]).follows, [true; 0]);
    }
}
