//! Recordings of a machine as its diagnosis sees them.

use super::super::DiagnoseError;
use crate::identify::likelihood::observed::{NotObserved, accelerations};
use crate::recording::Recording;

/// One recording: speed, load and accelerations.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Name.
    pub name: String,
    /// Stated speed of the shaft, Hz.
    pub shaft_hz: f64,
    /// Load, N, where stated.
    pub load_n: Option<f64>,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Accelerations `ax` and `ay`, m/s², without their mean; `None` for one that was not recorded.
    pub channels: [Option<Vec<f64>>; 2],
}

impl Observation {
    /// A recording with its stated speed.
    ///
    /// # Errors
    /// A recording without acceleration or speed, or with under 64 samples.
    pub fn new(recording: &Recording) -> Result<Self, DiagnoseError> {
        let refuse = |found: String, expected| {
            DiagnoseError::from(NotObserved { recording: recording.source.to_string(), found, expected })
        };
        let found = accelerations(recording);
        if found.iter().all(Option::is_none) {
            let there: Vec<_> = recording.channels.iter().map(|c| c.name.as_str()).collect();
            return Err(refuse(format!("channels {}", there.join(", ")), "`ax` or `ay`"));
        }
        let shaft_hz = recording.shaft_hz.filter(|hz| *hz > 0.0);
        let shaft_hz = shaft_hz.ok_or_else(|| refuse("no shaft_hz".into(), "the shaft's speed in the manifest"))?;
        if recording.len() < 64 {
            return Err(refuse(format!("{} samples", recording.len()), "at least 64"));
        }
        let centred = |samples: &[f64]| {
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            samples.iter().map(|v| v - mean).collect::<Vec<_>>()
        };
        Ok(Self {
            name: recording.name(),
            shaft_hz,
            load_n: recording.load_n,
            sample_rate_hz: recording.sample_rate_hz,
            channels: found.map(|channel| channel.map(|c| centred(&c.samples))),
        })
    }

    /// Turns of the shaft in the recording.
    pub fn turns(&self) -> f64 {
        self.shaft_hz * self.len() as f64 / self.sample_rate_hz
    }

    /// Samples of a channel.
    pub fn len(&self) -> usize {
        self.channels.iter().flatten().map(Vec::len).next().unwrap_or_default()
    }

    /// A part of the recording.
    pub fn part(&self, span: std::ops::Range<usize>) -> Self {
        let channels = self.channels.each_ref().map(|c| c.as_ref().map(|samples| samples[span.clone()].to_vec()));
        Self { name: self.name.clone(), channels, ..*self }
    }

    /// Difference of the operating conditions: relative in speed, less in load.
    fn distance(&self, other: &Self) -> f64 {
        let speed = (self.shaft_hz / other.shaft_hz).ln().abs();
        let load = match (self.load_n, other.load_n) {
            (Some(a), Some(b)) => 0.1 * (a - b).abs() / a.abs().max(b.abs()).max(1.0),
            _ => 0.0,
        };
        speed + load
    }

    /// The recordings of the baseline under the nearest conditions, if these are near enough to be compared.
    pub fn matches<'b>(&self, baseline: &'b [Self]) -> Vec<&'b Self> {
        let comparable = || baseline.iter().filter(|b| (b.sample_rate_hz / self.sample_rate_hz - 1.0).abs() < 1e-6);
        let nearest = comparable().map(|b| self.distance(b)).fold(f64::INFINITY, f64::min);
        if nearest > NEAR {
            return Vec::new();
        }
        comparable().filter(|b| self.distance(b) <= nearest + 1e-6).collect()
    }
}

/// Greatest difference of conditions that are compared.
const NEAR: f64 = 0.2;

/// Index of the recording to hold out: that of the middle speed, so that the others surround it; the last of equals. `None`
/// for fewer than two recordings.
pub fn held_out(recordings: &[Observation]) -> Option<usize> {
    if recordings.len() < 2 {
        return None;
    }
    let middle = recordings.iter().map(|r| r.shaft_hz.ln()).sum::<f64>() / recordings.len() as f64;
    let away = |n: usize| (recordings[n].shaft_hz.ln() - middle).abs();
    (0..recordings.len()).rev().min_by(|a, b| away(*a).total_cmp(&away(*b)))
}

/// Recordings with weights that interpolate to a speed: the nearest below and above, or all of that speed.
pub fn neighbours<'r>(others: &[&'r Observation], shaft_hz: f64) -> Vec<(&'r Observation, f64)> {
    let off = |r: &Observation| (r.shaft_hz / shaft_hz).ln();
    let equal: Vec<_> = others.iter().filter(|r| off(r).abs() < 0.02).map(|r| (*r, 1.0)).collect();
    if !equal.is_empty() {
        let share = 1.0 / equal.len() as f64;
        return equal.into_iter().map(|(r, _)| (r, share)).collect();
    }
    let below = others.iter().filter(|r| off(r) < 0.0).max_by(|a, b| off(a).total_cmp(&off(b)));
    let above = others.iter().filter(|r| off(r) > 0.0).min_by(|a, b| off(a).total_cmp(&off(b)));
    match (below, above) {
        (Some(low), Some(high)) => {
            let part = off(low) / (off(low) - off(high));
            vec![(*low, 1.0 - part), (*high, part)]
        }
        (Some(one), None) | (None, Some(one)) => vec![(*one, 1.0)],
        (None, None) => Vec::new(),
    }
}
