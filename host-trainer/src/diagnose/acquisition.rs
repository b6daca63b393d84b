//! Faults between the sensor and the file, which are seen in the samples themselves: a range that is too small, an offset,
//! the electrical line. They are found before anything else is sought, and what can be taken out is taken out.

use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use super::DiagnoseError;
use super::residual::{Whitened, two_sided, whitened};
use crate::recording::Recording;
use crate::rig::{EffectEntry, Rig};
use crate::whittle::observed::{CHANNELS, Observed, accelerations};
use crate::whittle::problem::Problem;

/// Samples of a channel at its greatest value from which its range has been too small; of noise there is one, rounded to
/// what files hold a few.
const TIES: usize = 12;
/// Standard deviations of its own scatter that a mean must be from 0.
const OFFSET: f64 = 6.0;
/// Standard deviations that two channels' offsets may differ by and be the same.
const ALIKE: f64 = 3.0;
/// Power of the electrical line in a residual over its surroundings, in every recording.
const LINE: f64 = 14.0;
/// Harmonics of the line that are taken out, as [`EffectEntry`] `mains-interference` has them.
const HARMONICS: [f64; 3] = [1.0, 3.0, 5.0];

/// Frequencies that are tried, 0.05 Hz apart from 45 Hz on.
const TRIED: u32 = 401;

/// A fault and what shows it.
#[derive(Clone, Debug)]
pub struct Fault {
    /// The effect.
    pub effect: EffectEntry,
    /// One sentence.
    pub evidence: String,
    /// Probability of it by chance.
    pub p_value: f64,
}

/// Recordings with what was the matter between sensor and file.
#[derive(Clone, Debug)]
pub struct Acquired {
    /// The recordings without what could be taken out.
    pub recordings: Vec<Recording>,
    /// What was taken out: offsets, the electrical line.
    pub taken_out: Vec<Fault>,
    /// Ranges that were too small; what was cut off is lost.
    pub clipped: Vec<Fault>,
}

impl Acquired {
    /// Recordings of a bearing rig.
    ///
    /// # Errors
    /// Recordings without acceleration, speed or load; a rig that cannot run.
    pub fn of(rig: &Rig, recordings: &[Recording]) -> Result<Self, DiagnoseError> {
        let clipped = clipped(recordings);
        let noise_std = rig.bearing().map_or(0.0, |machine| machine.sensor.noise_std_m_per_s2);
        let mut taken_out = offset(&Observed::of_all(recordings)?, noise_std);
        let mut recordings = without(recordings, &taken_out);
        if let Some(line) = mains(rig, &Observed::of_all(&recordings)?)? {
            recordings = without(&recordings, std::slice::from_ref(&line));
            taken_out.push(line);
        }
        Ok(Self { recordings, taken_out, clipped })
    }

    /// All faults.
    pub fn faults(&self) -> impl DoubleEndedIterator<Item = &Fault> {
        self.taken_out.iter().chain(&self.clipped)
    }
}

/// Channels whose range has been too small, in most of the recordings.
fn clipped(recordings: &[Recording]) -> Vec<Fault> {
    let mut levels: [Vec<(f64, usize)>; 2] = [Vec::new(), Vec::new()];
    for recording in recordings {
        for (channel, found) in accelerations(recording).into_iter().enumerate() {
            let Some(samples) = found.map(|c| &c.samples) else { continue };
            let top = samples.iter().fold(0.0f64, |t, v| t.max(v.abs()));
            let ties = samples.iter().filter(|v| v.abs() > top * (1.0 - 1e-6)).count();
            if ties >= TIES {
                levels[channel].push((top, ties));
            }
        }
    }
    let mut out = Vec::new();
    for (channel, mut found) in levels.into_iter().enumerate() {
        if 2 * found.len() <= recordings.len() {
            continue;
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (value, ties) = found[found.len() / 2];
        let effect = EffectEntry::new("sensor-clipping", &[("value", value)]).with_text("channel", CHANNELS[channel]);
        let evidence = format!(
            "{ties} samples of {} stand at exactly ±{value:.4} m/s², its greatest value, in {} of {} recordings likewise at theirs.",
            CHANNELS[channel],
            found.len(),
            recordings.len()
        );
        // Each would have had to fall on the very value, of at least two that it could fall on.
        let p_value = 0.5f64.powi(ties.min(200) as i32);
        out.push(Fault { effect, evidence, p_value });
    }
    out
}

/// Channels with an offset: the mean of an acceleration is 0, whatever the machine does, within the sensor's noise.
fn offset(observed: &[Observed], noise_std: f64) -> Vec<Fault> {
    let (mut out, mut levels) = (Vec::new(), Vec::new());
    for (channel, name) in CHANNELS.into_iter().enumerate() {
        let means: Vec<(f64, f64)> = observed
            .iter()
            .filter_map(|o| o.samples[channel].as_ref())
            .map(|s| {
                let n = s.len() as f64;
                let mean = s.iter().sum::<f64>() / n;
                // A motion that starts and ends somewhere has a mean, too: the change of its velocity over the time.
                let largest = s.iter().fold(0.0f64, |l, v| l.max((v - mean).abs()));
                (mean, noise_std / n.sqrt() + largest / n)
            })
            .collect();
        let weight: f64 = means.iter().map(|(_, d)| d.powi(-2)).sum();
        let mean = means.iter().map(|(m, d)| m / (d * d)).sum::<f64>() / weight;
        let alike = means.iter().all(|(m, d)| m.signum() == mean.signum() && m.abs() > 0.5 * OFFSET * d);
        if means.is_empty() || !alike || mean.abs() * weight.sqrt() < OFFSET {
            continue;
        }
        let effect = EffectEntry::new("sensor-bias", &[("value", mean)]).with_text("channel", name);
        let evidence = format!(
            "{} has a mean of {mean:.4} m/s² in every recording, {:.0} standard deviations of its noise from 0.",
            name,
            mean.abs() * weight.sqrt()
        );
        out.push(Fault { effect, evidence, p_value: two_sided(mean.abs() * weight.sqrt()) });
        levels.push((mean, weight.recip()));
    }
    // The same offset in all channels is one fault, of what they share.
    if let ([first, second], [(a, va), (b, vb)]) = (out.as_slice(), levels.as_slice())
        && (a - b).abs() < ALIKE * (va + vb).sqrt()
    {
        let value = (a / va + b / vb) / (1.0 / va + 1.0 / vb);
        let effect = EffectEntry::new("sensor-bias", &[("value", value)]).with_text("channel", "all");
        let evidence = format!("{} {}", first.evidence, second.evidence);
        return vec![Fault { effect, evidence, p_value: first.p_value.max(second.p_value) }];
    }
    out
}

/// The electrical line, where the residual of the rig has it.
fn mains(rig: &Rig, observed: &[Observed]) -> Result<Option<Fault>, DiagnoseError> {
    let problem = Problem::of_angles(observed, rig.clone());
    let expected = problem.expected(&problem.start()?)?;
    Ok(mains_in(observed, &whitened(observed, &expected)))
}

/// The electrical line: power at one frequency of 45 to 65 Hz in every recording, whatever the shaft's speed.
fn mains_in(observed: &[Observed], residuals: &[Whitened]) -> Option<Fault> {
    let speeds: Vec<f64> = observed.iter().map(|o| o.condition.shaft_hz).collect();
    let (least, most) = speeds.iter().fold((f64::MAX, 0.0f64), |(l, m), s| (l.min(*s), m.max(*s)));
    // At one speed the line cannot be told from a harmonic of the shaft that lies as near.
    let told = most - least > 0.5;
    let score = |hz: f64| -> f64 {
        let near_shaft = speeds.iter().any(|s| (hz / s - (hz / s).round()).abs() * s < 0.6);
        if !told && near_shaft {
            return 0.0;
        }
        let of = |recording: usize| {
            let channels = residuals.iter().filter(|w| w.recording == recording);
            channels.map(|w| ratio(w, hz)).fold(0.0, f64::max)
        };
        (0..observed.len()).map(of).fold(f64::MAX, f64::min)
    };
    let grid = (0..TRIED).map(|k| 45.0 + 0.05 * f64::from(k));
    let (value, hz) = grid.map(|hz| (score(hz), hz)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    if value < LINE {
        return None;
    }
    let amplitudes: Vec<f64> = observed
        .iter()
        .flat_map(|o| {
            o.samples.iter().flatten().map(|s| 2.0 * line(s, o.condition.sample_rate_hz, hz).norm() / s.len() as f64)
        })
        .collect();
    let amplitude = amplitudes.iter().sum::<f64>() / amplitudes.len() as f64;
    let effect = EffectEntry::new("mains-interference", &[("frequency_hz", hz), ("amplitude", amplitude)]);
    let evidence = format!(
        "A line at {hz:.2} Hz stands in every recording, whatever the speed of the shaft, at least {value:.0} times above its surroundings."
    );
    // Noise is above its median by ln 2 times an exponential number; in every recording, at one of the frequencies tried.
    let p_value = (f64::from(TRIED) * (-std::f64::consts::LN_2 * value * observed.len() as f64).exp()).min(1.0);
    Some(Fault { effect, evidence, p_value })
}

/// Σ x e^{−iωt}.
fn line(samples: &[f64], rate: f64, hz: f64) -> Complex<f64> {
    samples.iter().enumerate().map(|(i, v)| Complex::from_polar(*v, -TAU * hz * i as f64 / rate)).sum()
}

/// Power of the residual at a frequency over the median of what is 3 to 12 bins to either side.
fn ratio(w: &Whitened, hz: f64) -> f64 {
    let n = w.signal.len() as f64;
    let step = w.sample_rate_hz / n;
    let here = line(&w.signal, w.sample_rate_hz, hz).norm_sqr() / n;
    let middle = (hz / step).round() as usize;
    let around = (3..=12).flat_map(|d| [middle.checked_sub(d), Some(middle + d)]).flatten();
    let mut levels: Vec<f64> = around.filter_map(|k| w.spectrum.get(k)).map(|b| b.norm_sqr()).collect();
    levels.sort_by(f64::total_cmp);
    here / levels.get(levels.len() / 2).copied().unwrap_or(1.0).max(0.7)
}

/// The recordings without an offset or the electrical line.
fn without(recordings: &[Recording], faults: &[Fault]) -> Vec<Recording> {
    let mut out = recordings.to_vec();
    for fault in faults {
        let number = |key: &str| fault.effect.number(key).unwrap_or_default();
        let concerns = |name: &str| match fault.effect.text("channel") {
            None | Some("all") => name != "tacho",
            Some(channel) => channel == name,
        };
        for recording in &mut out {
            let rate = recording.sample_rate_hz;
            for channel in recording.channels.iter_mut().filter(|c| concerns(&c.name)) {
                match fault.effect.name.as_str() {
                    "sensor-bias" => channel.samples.iter_mut().for_each(|v| *v -= number("value")),
                    "mains-interference" => {
                        for n in HARMONICS {
                            let hz = n * number("frequency_hz");
                            let amplitude = line(&channel.samples, rate, hz) * 2.0 / channel.samples.len() as f64;
                            for (i, v) in channel.samples.iter_mut().enumerate() {
                                *v -= (amplitude * Complex::from_polar(1.0, TAU * hz * i as f64 / rate)).re;
                            }
                        }
                    }
                    _ => {}
                }
            }
        }
    }
    out
}
