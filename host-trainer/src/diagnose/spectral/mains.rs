//! Electrical line: sinusoids at multiples of one frequency that stay where they are while the speed changes.
//!
//! Their sizes and phases in each channel are those of a cable, not of a rig, so that they are fitted to the samples and taken out
//! before any hypothesis about the machine.

use std::f64::consts::TAU;

use super::data::{Data, Point};
use super::observation::Observation;
use super::settings::MainsSettings;
use crate::diagnose::acquisition::{Fault, SURE};
use crate::identify::force_balance::gram::cholesky_solve;
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::signal::transform::median;

const SETTINGS: MainsSettings = MainsSettings::DEFAULT;

/// Electrical line in some recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Mains {
    /// Fundamental frequency, Hz.
    pub hz: f64,
    /// Multiples of it that stand out, the fundamental first.
    pub multiples: Vec<f64>,
    /// Whether each recording has it.
    pub is_in: Vec<bool>,
    /// Decrease of −ln L by the fundamental.
    pub gain: f64,
}

impl Mains {
    /// Electrical line that stands out of the prediction at a point, between 45 and 65 Hz.
    pub fn find(data: &Data, at: &Point) -> Option<Self> {
        let gains = |hz: f64| -> Vec<f64> { (0..data.observations.len()).map(|n| gain(data, at, n, hz)).collect() };
        let [from, to, step] = SETTINGS.range_hz;
        let grid = (0..=((to - from) / step).round() as u32).map(|n| from + step * f64::from(n));
        let strength = |gains: &[f64]| gains.iter().filter(|g| **g > SETTINGS.gain).sum::<f64>();
        let (hz, found) = grid.map(|hz| (hz, gains(hz))).max_by(|a, b| strength(&a.1).total_cmp(&strength(&b.1)))?;
        let bounded = |gain: f64| gain.min(SETTINGS.most_gain);
        let total: f64 = found.iter().filter(|g| **g > SETTINGS.gain).map(|g| bounded(*g)).sum();
        let is_in: Vec<bool> = found.iter().map(|g| *g > SETTINGS.gain).collect();
        let having = || data.observations.iter().zip(&is_in).filter(|(_, is_in)| **is_in).map(|(o, _)| o);
        having().next()?;
        let hz = refined(having, hz);
        // A line of the shaft is at the same order, one of the supply at the same frequency.
        let locked = |o: &Observation| -> f64 {
            let order = hz / o.condition.shaft_hz;
            let each = data.observations.iter().enumerate().map(|(n, o)| (n, order * o.condition.shaft_hz, o.hz(1.0)));
            let moved = each.filter(|(_, there, bin)| (there - hz).abs() > SETTINGS.moved_bins * bin);
            moved.map(|(n, there, _)| bounded(gain(data, at, n, there))).sum()
        };
        let most_locked = having().map(locked).fold(0.0, f64::max);
        if most_locked > SETTINGS.locked_share * total
            || !is_of_supply(&having().collect::<Vec<_>>(), hz, is_in.iter().all(|is| *is))
        {
            return None;
        }
        let stands_out = |multiple: &f64| {
            let all = gains(multiple * hz);
            let count = all.iter().zip(&is_in).filter(|(g, is_in)| **is_in && **g > SETTINGS.harmonic_gain).count();
            2 * count > having().count()
        };
        let multiples =
            std::iter::once(1.0).chain((2..=SETTINGS.most_multiples).map(f64::from).filter(stands_out)).collect();
        Some(Self { hz, multiples, gain: total, is_in })
    }

    /// Recordings without it; `first` is the number of the first of them among those it was found in.
    pub fn removed(&self, observations: &[Observation], first: usize) -> Vec<Observation> {
        let each = observations.iter().enumerate();
        each.map(|(n, o)| if self.is_in[first + n] { o.with_samples(|_, s| self.without(s, o)) } else { o.clone() })
            .collect()
    }

    fn without(&self, samples: &[f64], o: &Observation) -> Vec<f64> {
        let sum = self.series(samples, o);
        samples.iter().zip(sum).map(|(v, line)| v - line).collect()
    }

    /// The line in the samples of a channel, by least squares.
    pub fn series(&self, samples: &[f64], o: &Observation) -> Vec<f64> {
        let columns = self.columns(o);
        let fitted = fitted(&columns, samples);
        let mut out = vec![0.0; samples.len()];
        for (column, value) in columns.iter().zip(fitted) {
            out.iter_mut().zip(column).for_each(|(sum, c)| *sum += value * c);
        }
        out
    }

    fn columns(&self, o: &Observation) -> Vec<Vec<f64>> {
        let rate = o.condition.sample_rate_hz;
        let angle = |multiple: f64, n: usize| TAU * multiple * self.hz * n as f64 / rate;
        let of = |multiple: &f64| {
            let angles: Vec<f64> = (0..o.condition.samples).map(|n| angle(*multiple, n)).collect();
            [angles.iter().map(|a| a.cos()).collect(), angles.iter().map(|a| a.sin()).collect()]
        };
        self.multiples.iter().flat_map(of).collect()
    }

    /// The line as a fault of the acquisition; `observations` are all those that it was found in.
    pub fn fault(&self, observations: &[Observation]) -> Fault {
        let having: Vec<&Observation> =
            observations.iter().zip(&self.is_in).filter(|(_, is_in)| **is_in).map(|(o, _)| o).collect();
        let sizes: [f64; 2] = [0, 1].map(|channel| {
            let sizes = having.iter().filter_map(|o| {
                let values = fitted(&self.columns(o)[..2], o.samples[channel].as_ref()?);
                Some(values[0].hypot(values[1]))
            });
            sizes.sum::<f64>() / having.len().max(1) as f64
        });
        let most = sizes[0].max(sizes[1]);
        let channel = match sizes.map(|size| size > SETTINGS.weak_share * most) {
            [true, true] => "all",
            [true, false] => CHANNELS[0],
            _ => CHANNELS[1],
        };
        let hz = self.hz;
        let effect = EffectEntry::new(
            EffectKind::MainsInterference,
            &[(ParameterKey::FrequencyHz, hz), (ParameterKey::Amplitude, most)],
        )
        .with_text(ParameterKey::Channel, channel);
        let speeds =
            |pick: fn(f64, f64) -> f64| having.iter().map(|o| o.condition.shaft_hz).reduce(pick).unwrap_or(0.0);
        let evidence = format!(
            "A line of {most:.4} m/s² stays at {hz:.2} Hz, with {} harmonics, in {} of {} recordings at {:.2} to {:.2} Hz of the shaft.",
            self.multiples.len() - 1,
            having.len(),
            observations.len(),
            speeds(f64::min),
            speeds(f64::max)
        );
        let tried = (SETTINGS.range_hz[1] - SETTINGS.range_hz[0]) / SETTINGS.range_hz[2];
        let p_value = (tried * (-self.gain).exp()).clamp(1e-300, 1.0);
        Fault { effect, evidence, p_value, probability: SURE }
    }
}

/// Decrease of −ln L by a line at a frequency that nothing near it shows, in both channels of a recording.
fn gain(data: &Data, at: &Point, recording: usize, hz: f64) -> f64 {
    let o = &data.observations[recording];
    let place = hz / o.hz(1.0);
    let near = [place.floor() as usize, place.ceil() as usize];
    let of = |channel: usize| -> f64 {
        let Some(power) = o.power[channel].as_ref() else { return 0.0 };
        let spectrum = data.channel(at, recording, channel);
        let ratio = |k: usize| power.get(k).map(|p| p / (spectrum.noise(k) + spectrum.line(k)));
        let middle = near[0];
        let around = (middle.saturating_sub(SETTINGS.around_bins)..=middle + SETTINGS.around_bins)
            .filter(|k| *k >= o.bins().start && k.abs_diff(middle) > SETTINGS.apart_bins);
        let mut around: Vec<f64> = around.filter_map(ratio).collect();
        let level = median(&mut around).unwrap_or(1.0).max(1.0);
        let greatest = |bins: [usize; 2]| bins.into_iter().filter_map(|k| power.get(k)).copied().fold(0.0, f64::max);
        // The skirt of a line near it is none.
        let beyond = SETTINGS.apart_bins;
        if greatest(near) <= greatest([near[0].saturating_sub(beyond), near[1] + beyond]) {
            return 0.0;
        }
        let most = near.into_iter().filter_map(ratio).fold(0.0, f64::max) / level;
        if most > 1.0 { most - 1.0 - most.ln() } else { 0.0 }
    };
    of(0) + of(1)
}

/// Whether a line is near the frequency of a supply, and stays there at different speeds or is no harmonic of the shaft; or stays at
/// another frequency in all recordings.
fn is_of_supply(having: &[&Observation], hz: f64, is_in_all: bool) -> bool {
    let speeds = || having.iter().map(|o| o.condition.shaft_hz);
    let Some(bin) = having.iter().map(|o| o.hz(1.0)).reduce(f64::max) else { return false };
    let (least, most) = (speeds().fold(f64::MAX, f64::min), speeds().fold(0.0, f64::max));
    let moves = hz * (most - least) / most > SETTINGS.moved_bins * bin;
    let is_harmonic = |shaft: f64| ((hz / shaft).round() * shaft - hz).abs() < SETTINGS.harmonic_bins * bin;
    let is_near = SETTINGS.supplies_hz.iter().any(|supply| (hz - supply).abs() < SETTINGS.supply_reach_hz);
    match is_near {
        true => moves || !speeds().all(is_harmonic),
        false => moves && is_in_all,
    }
}

/// Frequency of the greatest power of recordings near one, Hz.
fn refined<'o, I: Iterator<Item = &'o Observation>>(having: impl Fn() -> I, hz: f64) -> f64 {
    let power = |hz: f64| -> f64 {
        let of = |o: &Observation, samples: &Vec<f64>| {
            let line = Mains { hz, multiples: vec![1.0], is_in: Vec::new(), gain: 0.0 };
            let columns = line.columns(o);
            columns.iter().map(|c| c.iter().zip(samples).map(|(c, v)| c * v).sum::<f64>().powi(2)).sum::<f64>()
        };
        having().flat_map(|o| o.samples.iter().flatten().map(move |s| of(o, s))).sum()
    };
    let mut best = hz;
    let mut step = SETTINGS.range_hz[2];
    while step > SETTINGS.resolution_hz {
        let tried = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|by| best + by * step);
        best = tried.into_iter().map(|hz| (power(hz), hz)).max_by(|a, b| a.0.total_cmp(&b.0)).map_or(best, |b| b.1);
        step *= 0.4;
    }
    best
}

/// Least squares of samples on columns; zeros where these are no more than one.
fn fitted(columns: &[Vec<f64>], samples: &[f64]) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut normal: Vec<Vec<f64>> =
        (0..columns.len()).map(|i| (0..=i).map(|j| dot(&columns[i], &columns[j])).collect()).collect();
    let right: Vec<f64> = columns.iter().map(|c| dot(c, samples)).collect();
    cholesky_solve(&mut normal, &right, 0.0).unwrap_or_else(|| vec![0.0; columns.len()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::rig::test_support::nominal;

    /// At two speeds, of which neither has a line at a supply's frequency as its harmonic.
    #[test]
    fn null_a_line_away_from_the_supplies_is_in_all_recordings_or_none_of_one() {
        let mut slow = observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0));
        slow.condition.shaft_hz = 30.0;
        let mut fast = slow.clone();
        fast.condition.shaft_hz = 41.0;
        let both = [&slow, &fast];
        assert!(is_of_supply(&both, 52.5, true) && !is_of_supply(&both, 52.5, false));
        assert!(is_of_supply(&both, 50.1, false) && is_of_supply(&both[..1], 50.1, false));
        assert!(!is_of_supply(&both[..1], 52.5, true) && !is_of_supply(&both[..1], 60.0, true));
    }
}
