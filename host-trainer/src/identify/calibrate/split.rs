//! Split into fitted and held-out recordings.

use super::settings::CalibrationSettings;
use crate::recording::{Channel, Recording};

const SETTINGS: CalibrationSettings = CalibrationSettings::DEFAULT;

/// Fitted and held-out recordings.
#[derive(Clone, Debug)]
pub struct Split {
    /// Fitted recordings.
    pub fitted: Vec<Recording>,
    /// Held-out recordings.
    pub held_out: Vec<Recording>,
}

impl Split {
    /// Split with the last quarter of the recordings held out; of a single one its last quarter.
    pub fn new(recordings: &[Recording]) -> Self {
        if let [only] = recordings {
            let cut = ((1.0 - SETTINGS.held_out_share) * only.len() as f64) as usize;
            return Self { fitted: vec![part(only, 0..cut)], held_out: vec![part(only, cut..only.len())] };
        }
        let kept = recordings.len() - (SETTINGS.held_out_share * recordings.len() as f64).ceil() as usize;
        Self { fitted: recordings[..kept].to_vec(), held_out: recordings[kept..].to_vec() }
    }

    /// Description of the held-out recordings.
    pub fn describe(&self) -> String {
        match (self.fitted.as_slice(), self.held_out.as_slice()) {
            ([one], [rest]) if one.source == rest.source => {
                format!("the last {:.2} s of {}", rest.duration_s(), rest.name())
            }
            (_, [only]) => only.name(),
            (_, [first, .., last]) => format!("{} to {}", first.name(), last.name()),
            (_, []) => "none".into(),
        }
    }
}

/// A part of a recording, by its samples.
pub fn part(recording: &Recording, span: std::ops::Range<usize>) -> Recording {
    let channel = |c: &Channel| Channel { samples: c.samples[span.clone()].to_vec(), ..c.clone() };
    Recording { channels: recording.channels.iter().map(channel).collect(), gaps: Vec::new(), ..recording.clone() }
}

/// Longer part of a recording before or after the samples `cut`.
pub fn longer_part(samples: usize, cut: std::ops::Range<usize>) -> std::ops::Range<usize> {
    if cut.start >= samples - cut.end { 0..cut.start } else { cut.end..samples }
}
