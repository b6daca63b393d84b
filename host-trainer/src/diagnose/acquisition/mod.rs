//! Faults of the acquisition, found in the samples themselves: clipping, offset, missing samples. They are detected first, and
//! removed or cut out.

mod clipping;
mod converter;
mod dropped;
mod held;
mod step;

use std::ops::Range;

use clipping::Limits;
pub use converter::Converter;
use dropped::{Gap, Kind};
use step::steady_part;

use super::DiagnoseError;
use super::result::Cause;
use crate::identify::calibrate::split::part;
use crate::identify::likelihood::observed::{CHANNELS, Observed};
use crate::recording::Recording;
use crate::rig::config::RigKind;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};
use crate::signal::transform::hann;
use crate::stats::significance::two_sided;

/// Standard deviations from 0 of a mean that is an offset.
const OFFSET: f64 = 4.0;
/// Standard deviation of an offset that a sensor has when nothing is wrong with it, over that of its noise: by hand. It is the same
/// in all recordings of a sensor.
const OFFSET_OF_NOISE: f64 = 0.5;
/// Greatest probability of a fault: others than those of the vocabulary are possible.
pub const SURE: f64 = 0.97;
/// Standard errors by which two channels' offsets may differ and count as one.
const ALIKE: f64 = 3.0;
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
    offsets: Vec<Fault>,
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
        let limits: Vec<Limits> = recordings.iter().map(Limits::of).collect();
        let clipped = clipping::clipped(recordings, &limits);
        let restored: Vec<Recording> = recordings.iter().zip(&limits).map(|(r, limits)| limits.restored(r)).collect();
        let limits = recordings.iter().map(Recording::name).zip(limits).collect();
        let noise_std = rig.bearing().map_or(0.0, |machine| machine.sensor.noise_std_m_per_s2);
        let offsets = offset(&Observed::from_recordings(&restored)?, noise_std);
        let mut recordings = without(&restored, &offsets);
        let taken_out = whole_part(&mut recordings).into_iter().chain(steady_part(&mut recordings)).collect();
        Ok(Self { recordings, offsets, taken_out, clipped, limits })
    }

    /// Samples of a channel as this sensor records those of a healthy one: with its offset and, in the recording of that name,
    /// within its limits.
    pub fn as_recorded(&self, recording: &str, channel: usize, samples: &[f64]) -> Vec<f64> {
        let offsets = self.offsets.iter().filter(|f| concerns(f, CHANNELS[channel]));
        let offset: f64 = offsets.filter_map(|f| f.effect.number(ParameterKey::Value)).sum();
        let limits = self.limits.iter().find(|(name, _)| name == recording).map(|(_, limits)| limits);
        let within = |value: f64| limits.map_or(value, |limits| limits.clamped(channel, value));
        samples.iter().map(|v| within(v + offset)).collect()
    }

    /// All faults, the removed ones first.
    pub fn faults(&self) -> impl DoubleEndedIterator<Item = &Fault> {
        self.offsets.iter().chain(&self.taken_out).chain(&self.clipped)
    }
}

/// Faults of the clipped channels of recordings.
pub fn clipped(recordings: &[Recording]) -> Vec<Fault> {
    let limits: Vec<Limits> = recordings.iter().map(Limits::of).collect();
    clipping::clipped(recordings, &limits)
}

/// Channels with an offset: the mean of an acceleration is 0 within the sensor's noise.
fn offset(observed: &[Observed], noise_std: f64) -> Vec<Fault> {
    let (mut out, mut levels) = (Vec::new(), Vec::new());
    for (channel, name) in CHANNELS.into_iter().enumerate() {
        let mean = |samples: &Vec<f64>| {
            // A window, so that turns of the shaft that are not whole leave no mean.
            let window = hann(samples.len());
            let sum: f64 = window.iter().sum();
            let mean = samples.iter().zip(&window).map(|(v, w)| v * w).sum::<f64>() / sum;
            let squares: f64 = window.iter().map(|w| w * w).sum();
            (mean, noise_std * squares.sqrt() / sum)
        };
        let means: Vec<(f64, f64)> = observed.iter().filter_map(|o| o.samples[channel].as_ref()).map(mean).collect();
        let weight: f64 = means.iter().map(|(_, std)| std.powi(-2)).sum();
        let mean = means.iter().map(|(m, std)| m / (std * std)).sum::<f64>() / weight;
        let healthy = OFFSET_OF_NOISE * noise_std;
        // Means that differ by more than their noise are no offset of the sensor to that extent.
        let count = means.len() as f64;
        let squares: f64 = means.iter().map(|(m, _)| (m - mean).powi(2)).sum();
        let scatter = (squares / (count - 1.0).max(1.0) / count).sqrt();
        let z = mean.abs() / healthy.hypot(weight.sqrt().recip().max(scatter));
        let alike =
            means.iter().all(|(m, std)| m.signum() == mean.signum() && m.abs() > 0.5 * OFFSET * healthy.hypot(*std));
        if means.is_empty() || !alike || z < OFFSET {
            continue;
        }
        let effect = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, mean)])
            .with_text(ParameterKey::Channel, name);
        let evidence = format!(
            "{name} has a mean of {mean:.4} m/s² in every recording, {z:.0} standard deviations of a healthy sensor's from 0.",
        );
        // Sensors differ by more than the prior says, the more so the nearer.
        let probability = SURE * -(-(z - OFFSET / 2.0) / OFFSET).exp_m1();
        out.push(Fault { effect, evidence, p_value: two_sided(z), probability });
        levels.push((mean, healthy * healthy + weight.recip()));
    }
    // The same offset in all channels is one fault.
    if let ([first, second], [(a, va), (b, vb)]) = (out.as_slice(), levels.as_slice())
        && (a - b).abs() < ALIKE * (va + vb).sqrt()
    {
        let value = (a / va + b / vb) / (1.0 / va + 1.0 / vb);
        let effect = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, value)])
            .with_text(ParameterKey::Channel, "all");
        let evidence = format!("{} {}", first.evidence, second.evidence);
        let (p_value, probability) = (first.p_value.max(second.p_value), first.probability.min(second.probability));
        return vec![Fault { effect, evidence, p_value, probability }];
    }
    out
}

/// Whether a channel has a fault.
fn concerns(fault: &Fault, channel: &str) -> bool {
    match fault.effect.text(ParameterKey::Channel) {
        None | Some("all") => channel != "tacho",
        Some(name) => name == channel,
    }
}

/// The recordings without their offsets.
fn without(recordings: &[Recording], offsets: &[Fault]) -> Vec<Recording> {
    let mut out = recordings.to_vec();
    for fault in offsets {
        let value = fault.effect.number(ParameterKey::Value).unwrap_or_default();
        for channel in out.iter_mut().flat_map(|r| &mut r.channels).filter(|c| concerns(fault, &c.name)) {
            channel.samples.iter_mut().for_each(|v| *v -= value);
        }
    }
    out
}

/// Cuts recordings where samples are missing to the longest part between; the fault of the longest gaps, with the median count, if
/// there are any.
pub fn whole_part(recordings: &mut [Recording]) -> Option<Fault> {
    let gaps: Vec<Vec<Gap>> = recordings
        .iter()
        .map(|recording| dropped::gap(recording).map_or_else(|| held::gaps(recording), |gap| vec![gap]))
        .collect();
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
        Kind::Cut => format!("One turn of the shaft is {} samples short, all others are alike,", gap.count),
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
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    #[test]
    fn the_longest_part_between_gaps_is_kept() {
        let span = |sample, count, kind| Gap { sample, count, z: 9.0, kind }.span();
        assert_eq!(between(&[span(9000, 300, Kind::Cut)], 25_600), 9000 + MARGIN..25_600);
        let held = [span(2000, 900, Kind::Held), span(20_000, 900, Kind::Held)];
        assert_eq!(between(&held, 25_600), 2900 + MARGIN..20_000 - MARGIN);
    }

    /// Offsets of recordings whose channel `ay` has these means, each of them far beyond the sensor's noise.
    fn offsets(means: [f64; 4]) -> Vec<Fault> {
        let with = |(seed, mean): (usize, &f64)| {
            let mut recording =
                simulate(&nominal(), &condition(30.0, 800.0, 12_800), &Start::seeded(seed as u64)).unwrap();
            let channel = recording.channels.iter_mut().find(|c| c.name == "ay").unwrap();
            channel.samples.iter_mut().for_each(|v| *v += mean);
            recording
        };
        let recordings: Vec<Recording> = means.iter().enumerate().map(with).collect();
        offset(&Observed::from_recordings(&recordings).unwrap(), 0.05)
    }

    /// An offset is the same in all recordings of a sensor.
    #[test]
    fn means_that_wander_are_no_offset() {
        let [fault] = &offsets([0.40, 0.41, 0.39, 0.40])[..] else { panic!("one offset") };
        assert!((fault.effect.number(ParameterKey::Value).unwrap() / 0.4 - 1.0).abs() < 0.05);
        assert!(offsets([0.08, 0.47, 0.37, 0.48]).is_empty());
    }
}
