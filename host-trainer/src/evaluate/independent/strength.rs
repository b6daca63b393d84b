//! Strength of an effect, by what it changes in the recordings.

use super::Bench;
use super::effects::{Apply, Strength};
use super::integrate::run;
use super::settings::StrengthSettings;
use crate::recording::Recording;
use crate::rig::{OperatingCondition, RigError};

const SETTINGS: StrengthSettings = StrengthSettings::DEFAULT;

/// Root mean square of a channel over all recordings, without its mean.
pub fn rms(recordings: &[Recording], name: &str) -> f64 {
    let channels = recordings.iter().filter_map(|r| r.channel(name));
    let (mut sum, mut count) = (0.0, 0usize);
    for samples in channels.map(|c| &c.samples) {
        let mean = samples.iter().sum::<f64>() / samples.len().max(1) as f64;
        sum += samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        count += samples.len();
    }
    (sum / count.max(1) as f64).sqrt()
}

/// Finds the strength at which an effect changes one of its recordings by `target`, as far as its limits let it; 1 for a
/// strength that is fixed, and `None` where even at its limit it changes next to nothing. `patience`, from 1 to 0, scales the
/// greatest strength and the least change.
///
/// # Errors
/// A healthy machine that diverges, or an effect that does at all strengths that were tried.
pub fn reach(
    strength: &Strength,
    target: Option<f64>,
    patience: f64,
    present: &[bool],
    apply: &Apply,
    bench: &Bench,
) -> Result<Option<f64>, RigError> {
    let recording = present.iter().position(|p| *p).unwrap_or(0);
    let stated = bench.drawn.conditions[recording];
    let samples = |seconds: f64| ((seconds * stated.sample_rate_hz).ceil() as usize).clamp(1, stated.samples);
    let ([least, most], weakest, from, to) = match strength {
        Strength::Fixed => return Ok(Some(1.0)),
        Strength::Lasting(limits) => (*limits, SETTINGS.least[0], 0, samples(SETTINGS.seconds)),
        Strength::Event(limits, times) => {
            let (from, to) = (samples(times[recording]) - 1, samples(times[recording] + SETTINGS.event_s));
            (*limits, SETTINGS.least[1], from, to)
        }
    };
    let (weakest, most) = (patience * weakest, (patience * most).max(2.0 * least));
    let Some(target) = target else { return Ok(Some(1.0)) };
    let condition = OperatingCondition { samples: to, ..stated };
    let seed = Some(bench.seeds[recording]);
    let without = run(&bench.plant(recording), &condition, seed)?;
    let ratio = |size: f64| {
        let mut plant = bench.plant(recording);
        apply(size, recording, &mut plant);
        run(&plant, &condition, seed).map(|with| changed(&without, &with, from))
    };
    let (mut low, mut high) = (least, most);
    let mut size = (least * most).sqrt();
    let mut last = Err(RigError::Diverged { time_s: 0.0 });
    for _ in 0..SETTINGS.attempts {
        let next = match ratio(size) {
            Ok(found) if found.is_finite() => {
                last = Ok((found >= weakest).then_some(size));
                if found > target / SETTINGS.tolerance && found < target * SETTINGS.tolerance {
                    break;
                }
                if found > target {
                    high = size
                } else {
                    low = size
                }
                size * (target / found.max(f64::MIN_POSITIVE)).clamp(1.0 / SETTINGS.factor, SETTINGS.factor)
            }
            _ => {
                high = size;
                size / SETTINGS.factor
            }
        };
        // A step beyond what is known of the strength goes halfway instead.
        let inside = if next > low && next < high { next } else { (low * high).sqrt() };
        let next = if next >= most && high == most { most } else { inside };
        if (next / size).ln().abs() < 1e-3 {
            break;
        }
        size = next;
    }
    last
}

/// RMS of a change in both channels, from a sample on, over the RMS without it and without the mean.
fn changed(without: &Recording, with: &Recording, from: usize) -> f64 {
    let (mut change, mut power) = (0.0, 0.0);
    for name in ["ax", "ay"] {
        let (Some(a), Some(b)) = (without.channel(name), with.channel(name)) else { continue };
        let count = a.samples.len().min(b.samples.len()).saturating_sub(from).max(1);
        let sum: f64 = a.samples.iter().zip(&b.samples).skip(from).map(|(a, b)| (b - a).powi(2)).sum();
        change += sum / count as f64;
        power += rms(std::slice::from_ref(without), name).powi(2);
    }
    (change / power.max(f64::MIN_POSITIVE)).sqrt()
}
