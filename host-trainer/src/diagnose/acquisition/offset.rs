//! Offsets of sensors: means of an acceleration, which is 0 on the mean whatever a machine does.
//!
//! Healthy sensors have offsets too, which are the same in all their recordings. One is a fault if it is greater than those, or if
//! other channels or recordings have none: what is healthy spares neither.

use crate::diagnose::acquisition::{Fault, SURE};
use crate::identify::likelihood::observed::{CHANNELS, Observed};
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::signal::transform::{forward, hann};
use crate::stats::significance::two_sided;

/// Standard deviations from 0 of a mean that is an offset.
const FAR: f64 = 4.0;
/// Standard errors of an offset that others do not have. By hand: far beyond the slow motion of a machine; the least of choosing seeds 83
/// and 84 has 128, a machine with a great defect 4.
const ALONE: f64 = 12.0;
/// Standard deviation of an offset that a sensor has when nothing is wrong with it, over that of its noise: by hand.
const OF_NOISE: f64 = 0.5;
/// Standard errors by which two channels' offsets may differ and count as one.
const ALIKE: f64 = 3.0;
/// Frequencies, over that of one period in a recording, whose power is that of the mean's error.
const BESIDE: std::ops::Range<usize> = 3..9;
/// Odds of a faulty sensor to a healthy one with an offset, before its recordings are seen. By hand: one of the some thirty effects
/// of the vocabulary.
const PRIOR_ODDS: f64 = 1.0 / 30.0;
/// Least probability of an offset no greater than those of healthy sensors. By hand.
const LEAST_PROBABLE: f64 = 0.5;

/// Offset of a sensor.
#[derive(Clone, Debug)]
pub struct Offset {
    /// The fault.
    pub fault: Fault,
    /// Channels that have it.
    channels: Vec<&'static str>,
    /// Names of the recordings that have it.
    recordings: Vec<String>,
    /// Its value, m/s².
    value: f64,
}

impl Offset {
    /// Value in a channel of a recording, m/s²; `None` where it is not.
    pub fn of(&self, recording: &str, channel: &str) -> Option<f64> {
        let is_there = self.channels.contains(&channel) && self.recordings.iter().any(|name| name == recording);
        is_there.then_some(self.value)
    }

    /// Offset with its evidence.
    fn new(
        value: f64,
        z: f64,
        probability: f64,
        channels: Vec<&'static str>,
        recordings: Vec<String>,
        evidence: String,
    ) -> Self {
        let channel = match channels.as_slice() {
            [one] => one,
            _ => "all",
        };
        let effect = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, value)])
            .with_text(ParameterKey::Channel, channel);
        let fault = Fault { effect, evidence, p_value: two_sided(z), probability };
        Self { fault, channels, recordings, value }
    }
}

/// Mean of a channel of a recording, m/s².
#[derive(Clone, Copy, Debug)]
struct Level {
    recording: usize,
    channel: usize,
    mean: f64,
    /// Standard deviation by the sensor's noise.
    of_noise: f64,
    /// The same, by what the recording has beside 0 Hz too.
    std: f64,
}

impl Level {
    fn is_far(&self) -> bool {
        self.mean.abs() > FAR * self.std
    }
}

/// Offsets of recordings, their sensors' noise of a standard deviation, m/s². Samples that were clipped and are restored have a small
/// mean of their own.
pub fn offsets(observed: &[Observed], noise_std: f64, are_clipped: bool) -> Vec<Offset> {
    let levels = levels(observed, noise_std);
    let names: Vec<String> = observed.iter().map(|o| o.name.clone()).collect();
    let great = great(&levels, &names, noise_std);
    if !great.is_empty() || are_clipped {
        return great;
    }
    alone(&levels, &names, noise_std).into_iter().collect()
}

/// Mean of every channel of every recording.
fn levels(observed: &[Observed], noise_std: f64) -> Vec<Level> {
    let of = |recording: usize, channel: usize, samples: &[f64]| {
        // A window, so that turns of the shaft that are not whole leave no mean.
        let window = hann(samples.len());
        let sum: f64 = window.iter().sum();
        let squares: f64 = window.iter().map(|w| w * w).sum();
        let mut windowed: Vec<f64> = samples.iter().zip(&window).map(|(v, w)| v * w / sum).collect();
        let mean = windowed.iter().sum();
        let spectrum = forward(&mut windowed);
        let beside = spectrum.get(BESIDE).unwrap_or_default();
        let power = beside.iter().map(|c| c.norm_sqr()).sum::<f64>() / beside.len().max(1) as f64;
        let of_noise = noise_std * squares.sqrt() / sum;
        Level { recording, channel, mean, of_noise, std: of_noise.max(power.sqrt()) }
    };
    let each = observed.iter().enumerate().flat_map(|(recording, o)| {
        let channels = o.samples.iter().enumerate();
        channels.filter_map(move |(channel, samples)| Some((recording, channel, samples.as_deref()?)))
    });
    each.map(|(recording, channel, samples)| of(recording, channel, samples)).collect()
}

/// Offsets greater than those of healthy sensors, in every recording.
fn great(levels: &[Level], names: &[String], noise_std: f64) -> Vec<Offset> {
    let healthy = OF_NOISE * noise_std;
    let (mut out, mut variances) = (Vec::new(), Vec::new());
    for (channel, name) in CHANNELS.into_iter().enumerate() {
        let means: Vec<&Level> = levels.iter().filter(|level| level.channel == channel).collect();
        let (mean, std) = weighted(means.iter().map(|level| (level.mean, level.of_noise)));
        // Means that differ by more than their noise are no offset of the sensor to that extent.
        let count = means.len() as f64;
        let squares: f64 = means.iter().map(|level| (level.mean - mean).powi(2)).sum();
        let scatter = (squares / (count - 1.0).max(1.0) / count).sqrt();
        let z = mean.abs() / healthy.hypot(std.max(scatter));
        let is_alike = means.iter().all(|level| {
            level.mean.signum() == mean.signum() && level.mean.abs() > 0.5 * FAR * healthy.hypot(level.of_noise)
        });
        if means.is_empty() || !is_alike || z < FAR {
            continue;
        }
        let evidence = format!(
            "{name} has a mean of {mean:.4} m/s² in every recording, {z:.0} standard deviations of a healthy sensor's from 0.",
        );
        // Sensors differ by more than the prior says, the more so the nearer.
        let probability = SURE * -(-(z - FAR / 2.0) / FAR).exp_m1();
        out.push(Offset::new(mean, z, probability, vec![name], names.to_vec(), evidence));
        variances.push((z, healthy * healthy + std * std));
    }
    // The same offset in all channels is one fault.
    if let ([first, second], [(za, va), (zb, vb)]) = (out.as_slice(), variances.as_slice())
        && (first.value - second.value).abs() < ALIKE * (va + vb).sqrt()
    {
        let value = (first.value / va + second.value / vb) / (1.0 / va + 1.0 / vb);
        let evidence = format!("{} {}", first.fault.evidence, second.fault.evidence);
        let probability = first.fault.probability.min(second.fault.probability);
        return vec![Offset::new(value, za.min(*zb), probability, CHANNELS.to_vec(), names.to_vec(), evidence)];
    }
    out
}

/// Mean of values with their standard deviations, and its own.
fn weighted(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (weight, sum) = values.fold((0.0, 0.0), |(weight, sum), (value, std)| {
        let of_this = f64::powi(std, -2);
        (weight + of_this, sum + of_this * value)
    });
    (sum / weight, f64::sqrt(weight).recip())
}

/// Levels less that of most recordings of their channel, if the recordings of a channel differ.
fn beside_healthy(levels: &[Level]) -> Vec<Level> {
    let alike = |a: &Level, b: &Level| a.channel == b.channel && (a.mean - b.mean).abs() < FAR * a.std.hypot(b.std);
    let is_changing = levels.iter().any(|a| levels.iter().any(|b| a.channel == b.channel && !alike(a, b)));
    let usual = |level: &Level| {
        let of_channel = levels.iter().filter(|other| other.channel == level.channel);
        // Of two halves the one nearer to 0.
        let most = of_channel.max_by(|a, b| {
            let count = |of: &Level| levels.iter().filter(|other| alike(of, other)).count();
            count(a).cmp(&count(b)).then(b.mean.abs().total_cmp(&a.mean.abs()))
        });
        most.filter(|_| is_changing)
    };
    let beside = |level: &Level| match usual(level) {
        Some(usual) => Level { mean: level.mean - usual.mean, std: level.std.hypot(usual.std), ..*level },
        None => *level,
    };
    levels.iter().map(beside).collect()
}

/// One offset, however small, that some channels and recordings have while the others have none, or that both channels have alike.
fn alone(levels: &[Level], names: &[String], noise_std: f64) -> Option<Offset> {
    let levels = beside_healthy(levels);
    let (far, others): (Vec<&Level>, Vec<&Level>) = levels.iter().partition(|level| level.is_far());
    let (value, std) = weighted(far.iter().map(|level| (level.mean, level.std)));
    let channels: Vec<usize> =
        (0..CHANNELS.len()).filter(|channel| far.iter().any(|level| level.channel == *channel)).collect();
    let (with, without): (Vec<usize>, Vec<usize>) =
        (0..names.len()).partition(|recording| far.iter().any(|level| level.recording == *recording));
    let is_one = others.iter().all(|level| !channels.contains(&level.channel) || !with.contains(&level.recording));
    if far.is_empty() || !is_one || far.iter().any(|level| (level.mean - value).abs() > FAR * level.std) {
        return None;
    }
    let z = value.abs() / std;
    if z < ALONE {
        return None;
    }
    let said = format!("a mean of {value:.4} m/s², {z:.0} standard errors from 0");
    let of_channel = |channel: usize| {
        let of = levels.iter().filter(|level| level.channel == channel);
        weighted(of.map(|level| (level.mean, level.std)))
    };
    // Density of a difference of 0 of healthy sensors with offsets over that of ones without.
    let odds = |(mean, std): (f64, f64)| std / (OF_NOISE * noise_std) * (0.5 * (mean / std).powi(2)).exp();
    let of = |recordings: &[usize]| recordings.iter().map(|n| names[*n].as_str()).collect::<Vec<_>>();
    let (odds_of_healthy, evidence) = match channels.as_slice() {
        // The offset of a healthy sensor does not change.
        _ if !without.is_empty() => {
            let having = channels.iter().map(|channel| CHANNELS[*channel]).collect::<Vec<_>>().join(" and ");
            let [with, without] = [&with, &without].map(|recordings| of(recordings).join(", "));
            (0.0, format!("In {having} of {with} there is {said}, beside what {without} have."))
        }
        [channel] if others.iter().any(|level| level.channel != *channel) => {
            let [this, other] = [*channel, 1 - channel];
            let evidence = format!(
                "{} has {said}, in every recording, and {} has none, as few healthy sensors do.",
                CHANNELS[this], CHANNELS[other]
            );
            (odds(of_channel(other)), evidence)
        }
        [first, second] => {
            let [(one, one_std), (other, other_std)] = [*first, *second].map(of_channel);
            let evidence = format!("ax and ay both have {said}, in every recording, where healthy sensors differ.");
            (odds((one - other, one_std.hypot(other_std))), evidence)
        }
        _ => return None,
    };
    let probability = SURE * PRIOR_ODDS / (PRIOR_ODDS + odds_of_healthy);
    let recordings = of(&with).into_iter().map(str::to_owned).collect();
    let channels = channels.into_iter().map(|channel| CHANNELS[channel]).collect();
    Some(Offset::new(value, z, probability, channels, recordings, evidence)).filter(|_| probability > LEAST_PROBABLE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    const NOISE_STD: f64 = 0.05;

    /// Offsets of recordings whose channels `ax` and `ay` have these means.
    fn found(means: [[f64; 2]; 4], are_clipped: bool) -> Vec<Offset> {
        let with = |(seed, means): (usize, &[f64; 2])| {
            let start = Start::seeded(seed as u64);
            let mut recording = simulate(&nominal(), &condition(30.0, 800.0, 12_800), &start).unwrap();
            for (name, mean) in CHANNELS.iter().zip(means) {
                let channel = recording.channels.iter_mut().find(|c| c.name == *name).unwrap();
                channel.samples.iter_mut().for_each(|v| *v += mean);
            }
            recording
        };
        let recordings: Vec<Recording> = means.iter().enumerate().map(with).collect();
        offsets(&Observed::from_recordings(&recordings).unwrap(), NOISE_STD, are_clipped)
    }

    /// An offset is the same in all recordings of a sensor.
    #[test]
    fn means_that_wander_are_no_offset() {
        let [offset] = &found([0.40, 0.41, 0.39, 0.40].map(|ay| [0.0, ay]), false)[..] else { panic!("one offset") };
        assert!((offset.value / 0.4 - 1.0).abs() < 0.05);
        assert!(found([0.08, 0.47, 0.37, 0.48].map(|ay| [0.02, ay]), false).is_empty());
    }

    /// Less than half the noise, which a healthy sensor may have: in one channel, in both alike, in one recording.
    #[test]
    fn a_small_offset_that_others_do_not_have_is_one() {
        let [one] = &found([[0.02, 0.0]; 4], false)[..] else { panic!("one offset") };
        assert_eq!((one.channels.as_slice(), one.recordings.len()), ([CHANNELS[0]].as_slice(), 4));
        assert!(found([[0.02, 0.0]; 4], true).is_empty(), "a mean of restored samples");
        let [both] = &found([[0.02, 0.02]; 4], false)[..] else { panic!("one offset") };
        assert_eq!(both.fault.effect.text(ParameterKey::Channel), Some("all"));
        let mut means = [[0.015, -0.01]; 4];
        assert!(found(means, false).is_empty(), "offsets of healthy sensors");
        means = [[0.0; 2]; 4];
        assert!(found(means, false).is_empty());
        means[2] = [0.02; 2];
        let [third] = &found(means, false)[..] else { panic!("one offset") };
        // Beside offsets of healthy sensors.
        let both = means.map(|[ax, ay]| [ax + 0.01, ay - 0.015]);
        let [beside] = &found(both, false)[..] else { panic!("one offset") };
        assert!((beside.value - 0.02).abs() < 1e-3 && beside.recordings == third.recordings);
        assert_eq!(third.recordings.len(), 1);
        assert!(third.fault.probability > one.fault.probability && one.fault.probability > 0.5);
        let name = &third.recordings[0];
        assert!((third.of(name, "ay").unwrap() / 0.02 - 1.0).abs() < 0.1 && third.of("another", "ay").is_none());
    }
}
