//! Faults of the acquisition, found in the samples themselves: clipping, offset, missing samples. They are detected first, and
//! removed or cut out.

mod clipping;
mod converter;
mod dropped;
mod held;
mod offset;
mod pace;
mod phase_jump;
mod step;

use std::ops::Range;

use clipping::Limits;
pub use converter::Converter;
use dropped::{Gap, Kind};
use offset::{Offset, offsets};
use pace::Pace;
pub use pace::WANDER;
use step::steady_part;

use super::DiagnoseError;
use super::result::Cause;
use crate::identify::calibrate::split::part;
use crate::identify::likelihood::observed::{CHANNELS, Observed, accelerations};
use crate::recording::{Channel, Recording};
use crate::rig::config::RigKind;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};
use crate::stats::significance::two_sided;

/// Greatest probability of a fault: others than those of the vocabulary are possible.
pub const SURE: f64 = 0.97;
/// Samples to either side of missing ones that are left out, too: where they are missing is known no better.
const MARGIN: usize = 600;

/// Acquisition fault with its evidence.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Effect with its parameters.
    pub effect: EffectEntry,
    /// Evidence in a sentence.
    pub evidence: String,
    /// p-value of the fault.
    pub p_value: f64,
    /// Probability.
    pub probability: f64,
}

impl Fault {
    /// The fault as a cause.
    pub fn cause(&self) -> Cause {
        let effect = &self.effect;
        Cause {
            name: effect.kind.to_string(),
            probability: self.probability,
            parameters: effect.parameters.iter().map(|(key, value)| (key.to_string(), value.into())).collect(),
            evidence: self.evidence.clone(),
            equation: effect.equation(RigKind::Bearing5Dof),
            ..Cause::default()
        }
    }
}

/// Recordings with their acquisition faults.
#[derive(Clone, Debug)]
pub struct Acquired {
    /// Recordings without the removed faults.
    pub recordings: Vec<Recording>,
    /// Offsets of all recordings, which are subtracted.
    offsets: Vec<Offset>,
    /// Change of the speed that the recordings no longer have.
    pace: Option<Pace>,
    /// What is taken out of the samples: stretches around missing ones, one side of a jump of the mean, and the electrical line.
    pub taken_out: Vec<Fault>,
    /// Clipping. Its samples are restored.
    pub clipped: Vec<Fault>,
    /// Limits of each recording, by its name.
    limits: Vec<(String, Limits)>,
}

impl Acquired {
    /// Detects and removes the faults in recordings of a bearing rig.
    ///
    /// # Errors
    /// Recordings without acceleration, speed or load; a rig that cannot run.
    pub fn detect(rig: &Rig, recordings: &[Recording]) -> Result<Self, DiagnoseError> {
        let limits = Limits::of(recordings);
        let clipped = clipping::clipped(recordings, &limits);
        let restored: Vec<Recording> = recordings.iter().zip(&limits).map(|(r, limits)| limits.restored(r)).collect();
        let limits = recordings.iter().map(Recording::name).zip(limits).collect();
        let noise_std = rig.bearing().map_or(0.0, |machine| machine.sensor.noise_std_m_per_s2);
        let offsets = offsets(&Observed::from_recordings(&restored)?, noise_std, !clipped.is_empty());
        let mut recordings: Vec<Recording> = restored.iter().map(|r| without(r, &offsets)).collect();
        let taken_out = whole_part(&mut recordings).into_iter().chain(steady_part(&mut recordings)).collect();
        let pace = Pace::even_out(&mut recordings);
        Ok(Self { recordings, offsets, pace, taken_out, clipped, limits })
    }

    /// Samples of a channel as this sensor records those of a healthy one at a constant speed: at the speed of the recording of that
    /// name, with its offset and within its limits.
    pub fn as_recorded(&self, recording: &str, channel: usize, samples: &[f64]) -> Vec<f64> {
        let offset: f64 = self.offsets.iter().filter_map(|o| o.of(recording, CHANNELS[channel])).sum();
        let limits = self.limits.iter().find(|(name, _)| name == recording).map(|(_, limits)| limits);
        let within = |value: f64| limits.map_or(value, |limits| limits.clamped(channel, value));
        let own = self.pace.as_ref().and_then(|pace| pace.as_recorded(recording, samples));
        own.as_deref().unwrap_or(samples).iter().map(|v| within(v + offset)).collect()
    }

    /// All faults, the removed ones first.
    pub fn faults(&self) -> impl DoubleEndedIterator<Item = &Fault> {
        self.offsets
            .iter()
            .map(|offset| &offset.fault)
            .chain(self.pace.iter().map(|pace| &pace.fault))
            .chain(&self.taken_out)
            .chain(&self.clipped)
    }
}

/// Faults of the clipped channels of recordings.
pub fn clipped(recordings: &[Recording]) -> Vec<Fault> {
    clipping::clipped(recordings, &Limits::of(recordings))
}

/// A recording without its offsets.
fn without(recording: &Recording, offsets: &[Offset]) -> Recording {
    let (mut out, name) = (recording.clone(), recording.name());
    for (channel, measured) in CHANNELS.into_iter().zip(accelerations(recording)) {
        let offset: f64 = offsets.iter().filter_map(|o| o.of(&name, channel)).sum();
        let is_it = |c: &&mut Channel| measured.is_some_and(|measured| measured.name == c.name);
        out.channels.iter_mut().filter(is_it).flat_map(|c| &mut c.samples).for_each(|v| *v -= offset);
    }
    out
}

/// Gaps of a recording.
fn gaps(recording: &Recording) -> Vec<Gap> {
    if let Some(gap) = dropped::gap(recording) {
        return vec![gap];
    }
    let held = held::gaps(recording);
    if !held.is_empty() || recording.channel("tacho").is_some() {
        return held;
    }
    phase_jump::gap(recording).into_iter().collect()
}

/// Cuts recordings where samples are missing to the longest part between; the fault of the longest gaps, with the median count, if
/// there are any.
pub fn whole_part(recordings: &mut [Recording]) -> Option<Fault> {
    let gaps: Vec<Vec<Gap>> = recordings.iter().map(gaps).collect();
    let longest = |(gaps, r): (&Vec<Gap>, &Recording)| {
        gaps.iter().max_by_key(|gap| gap.count).map(|gap| (*gap, r.sample_rate_hz))
    };
    let mut found: Vec<(Gap, f64)> = gaps.iter().zip(&*recordings).filter_map(longest).collect();
    if found.is_empty() {
        return None;
    }
    found.sort_by_key(|(gap, _)| gap.count);
    let (gap, rate) = found[found.len() / 2];
    let what = match gap.kind {
        Kind::ShortTurn => format!("One turn of the shaft is {} samples short, all others are alike,", gap.count),
        Kind::PhaseJump => format!("The phases of all lines jump by {} samples, or by whole periods more,", gap.count),
        Kind::Held => format!("{} samples in a row repeat the one before them", gap.count),
    };
    let evidence =
        format!("{what} at {:.3} s, in {} of {} recordings.", gap.sample as f64 / rate, found.len(), recordings.len());
    for (gaps, recording) in gaps.iter().zip(recordings.iter_mut()).filter(|(gaps, _)| !gaps.is_empty()) {
        let spans: Vec<Range<usize>> = gaps.iter().map(Gap::span).collect();
        *recording = part(recording, between(&spans, recording.len()));
    }
    let effect = EffectEntry::new(
        EffectKind::DroppedSamples,
        &[(ParameterKey::TimeS, gap.sample as f64 / rate), (ParameterKey::Count, gap.count as f64)],
    );
    Some(Fault { effect, evidence, p_value: two_sided(gap.z), probability: SURE })
}

/// Longest part between spans of samples that are left out, which are in the order of time; all of it if only shreds are left.
fn between(left_out: &[Range<usize>], samples: usize) -> Range<usize> {
    let ends = left_out.iter().map(|span| span.end + MARGIN);
    let starts = left_out.iter().map(|span| span.start.saturating_sub(MARGIN));
    let parts = std::iter::once(0).chain(ends).zip(starts.chain([samples])).map(|(from, to)| from..to);
    parts.max_by_key(ExactSizeIterator::len).filter(|part| part.len() > samples / 8).unwrap_or(0..samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_part_between_gaps_is_kept() {
        let span = |sample, count, kind| Gap { sample, count, z: 9.0, kind }.span();
        assert_eq!(between(&[span(9000, 300, Kind::ShortTurn)], 25_600), 9000 + MARGIN..25_600);
        let held = [span(2000, 900, Kind::Held), span(20_000, 900, Kind::Held)];
        assert_eq!(between(&held, 25_600), 2900 + MARGIN..20_000 - MARGIN);
    }
}
