//! Mains interference in recordings: found in the residual of the rig, and removed from the samples.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use super::Fault;
use crate::diagnose::DiagnoseError;
use crate::diagnose::residual::{Whitened, whitened};
use crate::identify::likelihood::observed::{Observed, accelerations};
use crate::identify::likelihood::problem::Problem;
use crate::identify::likelihood::whittle::{Prediction, judged_bins};
use crate::recording::Recording;
use crate::rig::{EffectEntry, Rig};
use crate::signal::transform::{hann, inverse_plan};
use crate::stats::optimise::golden_section;

/// Minimum power of the mains line in a residual over its neighbourhood, in every recording.
const STANDS_OUT: f64 = 14.0;
/// Harmonics that are removed, those of the effect `mains-interference`.
const HARMONICS: [f64; 3] = [1.0, 3.0, 5.0];
/// Count of frequencies that are tried.
const TRIED: u32 = 401;
/// Lowest frequency that is tried, Hz.
const FROM_HZ: f64 = 45.0;
/// Step of the frequencies that are tried, Hz.
const APART_HZ: f64 = 0.05;

/// Mains interference in the residual of the rig, and the recordings without it; `None` if there is none.
///
/// # Errors
/// Recordings without acceleration, speed or load; a rig that cannot run.
pub fn taken_out(rig: &Rig, recordings: &[Recording]) -> Result<Option<(Fault, Vec<Recording>)>, DiagnoseError> {
    let observed = Observed::from_recordings(recordings)?;
    let problem = Problem::of_angles(&observed, rig.clone());
    let expected = problem.predict(&problem.start()?)?;
    let Some((near_hz, stands_out)) = found(&observed, &whitened(&observed, &expected)) else { return Ok(None) };
    let left: Vec<Left> =
        observed.iter().zip(&expected).enumerate().flat_map(|(n, (o, e))| Left::from_recording(n, o, e)).collect();
    let hz = refined(&left, near_hz);
    let mut without = recordings.to_vec();
    for of in &left {
        of.take_out(hz, &mut without[of.recording]);
    }
    let amplitude = left.iter().map(|l| l.line(hz).norm()).sum::<f64>() / left.len().max(1) as f64;
    let fault = Fault {
        effect: EffectEntry::new(
            EffectKind::MainsInterference,
            &[(ParameterKey::FrequencyHz, hz), (ParameterKey::Amplitude, amplitude)],
        ),
        evidence: format!(
            "A line at {hz:.2} Hz, independent of the shaft speed, has at least {stands_out:.0} times the power of its neighbourhood in every recording."
        ),
        // Powers of noise over their median are exponential times 1/ln 2; in every recording, at one of the frequencies tried.
        p_value: (f64::from(TRIED) * (-std::f64::consts::LN_2 * stands_out * observed.len() as f64).exp()).min(1.0),
    };
    Ok(Some((fault, without)))
}

/// Frequency of a line in every recording, independent of the shaft's speed, and its least power over the neighbourhood.
fn found(observed: &[Observed], residuals: &[Whitened]) -> Option<(f64, f64)> {
    let speeds: Vec<f64> = observed.iter().map(|o| o.condition.shaft_hz).collect();
    let (least, most) = speeds.iter().fold((f64::MAX, 0.0f64), |(l, m), s| (l.min(*s), m.max(*s)));
    // At a single speed a line near a harmonic of the shaft is not distinguishable from it.
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
    let tried = (0..TRIED).map(|k| FROM_HZ + APART_HZ * f64::from(k)).map(|hz| (hz, score(hz)));
    tried.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, score)| *score > STANDS_OUT)
}

/// Power of the residual at a frequency over the median of the bins 3 to 12 to either side.
fn ratio(w: &Whitened, hz: f64) -> f64 {
    let n = w.signal.len() as f64;
    let step = w.sample_rate_hz / n;
    let here = turned(&w.signal, hz / w.sample_rate_hz).norm_sqr() / n;
    let middle = (hz / step).round() as usize;
    let around = (3..=12).flat_map(|d| [middle.checked_sub(d), Some(middle + d)]).flatten();
    let mut levels: Vec<f64> = around.filter_map(|k| w.spectrum.get(k)).map(|b| b.norm_sqr()).collect();
    levels.sort_by(f64::total_cmp);
    here / levels.get(levels.len() / 2).copied().unwrap_or(1.0).max(0.7)
}

/// Samples of a block.
const BLOCK: usize = 64;

/// Σ x e^{−2πi·turns·t} over the samples, block by block: all have the same angles from their beginnings on.
fn turned(samples: &[f64], turns: f64) -> Complex<f64> {
    let within: [Complex<f64>; BLOCK] = std::array::from_fn(|i| Complex::from_polar(1.0, -TAU * turns * i as f64));
    let of_block = |(n, block): (usize, &[f64])| {
        let sum: Complex<f64> = block.iter().zip(&within).map(|(v, turn)| turn * *v).sum();
        sum * Complex::from_polar(1.0, -TAU * turns * (n * BLOCK) as f64)
    };
    samples.chunks(BLOCK).enumerate().map(of_block).sum()
}

/// Residual of one channel, which lacks the machine's own lines near the mains line.
struct Left {
    recording: usize,
    channel: usize,
    sample_rate_hz: f64,
    /// Residual times a Hann window whose sum is 2, against leakage from distant lines.
    windowed: Vec<f64>,
}

impl Left {
    fn from_recording(recording: usize, o: &Observed, e: &Prediction) -> Vec<Self> {
        let n = o.condition.samples;
        let inverse = inverse_plan(n);
        let window = hann(n);
        let scale = 2.0 / ((n as f64).sqrt() * window.iter().sum::<f64>());
        let of = |channel: usize| {
            let x = o.spectra[channel].as_ref()?;
            let mut bins = vec![Complex::default(); x.len()];
            for k in judged_bins(x, 1.0) {
                bins[k] = x[k] - e.mean[channel][k];
            }
            let mut signal = inverse.make_output_vec();
            inverse.process(&mut bins, &mut signal).unwrap_or_default();
            let windowed = signal.iter().zip(&window).map(|(v, w)| v * w * scale).collect();
            Some(Self { recording, channel, sample_rate_hz: o.condition.sample_rate_hz, windowed })
        };
        (0..2).filter_map(of).collect()
    }

    /// Complex amplitude of the line at a frequency.
    fn line(&self, hz: f64) -> Complex<f64> {
        turned(&self.windowed, hz / self.sample_rate_hz)
    }

    fn take_out(&self, hz: f64, recording: &mut Recording) {
        let lines = HARMONICS.map(|n| (TAU * n * hz / self.sample_rate_hz, self.line(n * hz)));
        let Some(name) = accelerations(recording)[self.channel].map(|c| c.name.clone()) else { return };
        for channel in recording.channels.iter_mut().filter(|c| c.name == name) {
            for (i, v) in channel.samples.iter_mut().enumerate() {
                let at = |(step, line): &(f64, Complex<f64>)| (line * Complex::from_polar(1.0, step * i as f64)).re;
                *v -= lines.iter().map(at).sum::<f64>();
            }
        }
    }
}

/// Frequency of greatest power, first of the line itself, then with more and more of its harmonics, which determine it better.
fn refined(left: &[Left], near_hz: f64) -> f64 {
    (1..=HARMONICS.len()).fold(near_hz, |hz, count| {
        let power = |hz: f64| -> f64 {
            left.iter().flat_map(|l| HARMONICS[..count].iter().map(|n| l.line(n * hz).norm_sqr())).sum()
        };
        let reach = APART_HZ / HARMONICS[count - 1];
        golden_section(&power, hz - reach, hz + reach)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::likelihood::observed::CHANNELS;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    /// Removal of a line restores the recording without it.
    #[test]
    fn invariant_a_line_between_bins_is_taken_out_to_its_last_part() {
        let rig = nominal();
        let made = |rig: &Rig| -> Vec<Recording> {
            let of = |seed: u64| simulate(rig, &condition(31.0 + seed as f64, 500.0, 12_800), &Start::seeded(seed));
            (0..3).map(|seed| of(seed).unwrap()).collect()
        };
        let line = EffectEntry::new(
            EffectKind::MainsInterference,
            &[(ParameterKey::FrequencyHz, 50.0371), (ParameterKey::Amplitude, 0.5)],
        );
        let (plain, with) = (made(&rig), made(&rig.clone().with_effect(line)));
        assert!(taken_out(&rig, &plain).unwrap().is_none());
        let (fault, without) = taken_out(&rig, &with).unwrap().unwrap();
        assert!((fault.effect.number(ParameterKey::FrequencyHz).unwrap() - 50.0371).abs() < 2e-3, "{:?}", fault.effect);
        assert!((fault.effect.number(ParameterKey::Amplitude).unwrap() / 0.5 - 1.0).abs() < 0.01, "{:?}", fault.effect);
        for (plain, without) in plain.iter().zip(&without) {
            for name in CHANNELS {
                let [a, b] = [plain, without].map(|r| &r.channel(name).unwrap().samples);
                let rms = (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt();
                // A hundredth of the line's own.
                assert!(rms < 0.01 * 0.38, "{name}: {rms}");
            }
        }
    }
}
