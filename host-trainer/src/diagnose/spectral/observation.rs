//! A recording as power spectra.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use realfft::num_complex::Complex;

use super::settings::LikelihoodSettings;
use crate::identify::calibrate::distance::within_pass_band;
use crate::identify::calibrate::split::longer_part;
use crate::identify::likelihood::observed::{CHANNELS, Coefficients, Observed, padded};
use crate::identify::likelihood::tachometer::Reading;
use crate::recording::Recording;
use crate::rig::OperatingCondition;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Power at each frequency of both channels; white noise of variance σ² has the mean σ².
pub type Power = [Vec<f64>; 2];

/// Recording of the two channels of a bearing rig.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Name.
    pub name: String,
    /// Operating condition.
    pub condition: OperatingCondition,
    /// Standard deviation of the stated speed, as a share of it.
    pub speed_std: f64,
    /// Samples of `ax` and `ay`, m/s².
    pub samples: [Option<Vec<f64>>; 2],
    /// Power of `ax` and `ay`.
    pub power: [Option<Vec<f64>>; 2],
    /// Its logarithm.
    pub ln_power: [Option<Vec<f64>>; 2],
    /// Tachometer.
    pub tachometer: Option<Reading>,
}

impl Observation {
    /// Spectra of a recording.
    pub fn new(observed: &Observed) -> Self {
        let Observed { name, condition, shaft_hz_std, samples, tachometer, .. } = observed;
        let (power, ln_power) = powers(samples);
        let speed_std = shaft_hz_std / condition.shaft_hz;
        let (name, condition, samples, tachometer) = (name.clone(), *condition, samples.clone(), *tachometer);
        Self { name, condition, speed_std, samples, power, ln_power, tachometer }
    }

    /// Part of the recording, by its samples.
    fn part(&self, kept: Range<usize>) -> Self {
        let samples = self.samples.each_ref().map(|samples| samples.as_ref().map(|s| s[kept.clone()].to_vec()));
        let (power, ln_power) = powers(&samples);
        let condition = OperatingCondition { samples: kept.len(), ..self.condition };
        Self { name: self.name.clone(), condition, samples, power, ln_power, ..*self }
    }

    /// The same recording with other samples of each channel.
    pub fn with_samples(&self, of: impl Fn(usize, &[f64]) -> Vec<f64>) -> Self {
        let samples = [0, 1].map(|channel| self.samples[channel].as_deref().map(|s| of(channel, s)));
        let (power, ln_power) = powers(&samples);
        Self { samples, power, ln_power, ..self.clone() }
    }

    /// Beginning of at most `seconds`.
    pub fn beginning(&self, seconds: f64) -> Self {
        let count = (seconds * self.condition.sample_rate_hz) as usize;
        self.part(0..count.min(self.condition.samples))
    }

    /// Longer part before or after the times from `from_s` to `to_s`.
    pub fn longer_part(&self, from_s: f64, to_s: f64) -> Self {
        let at = |time: f64| ((time * self.condition.sample_rate_hz).max(0.0) as usize).min(self.condition.samples);
        self.part(longer_part(self.condition.samples, at(from_s)..at(to_s)))
    }

    /// Frequency of a bin, Hz.
    pub fn hz(&self, bin: f64) -> f64 {
        bin * self.condition.sample_rate_hz / self.condition.samples as f64
    }

    /// Bins of an order of the shaft.
    pub fn bins_of(&self, order: f64) -> f64 {
        order * self.condition.shaft_hz / self.hz(1.0)
    }

    /// Bins of the likelihood, within the band in which spectra are compared.
    pub fn bins(&self) -> Range<usize> {
        let last = within_pass_band(self.condition.samples / 2);
        SETTINGS.first_bin..last.max(SETTINGS.first_bin)
    }
}

/// Values of both channels; `None` for one that was not recorded.
type Channels = [Option<Vec<f64>>; 2];

/// Power of both channels, and its logarithm.
fn powers(samples: &Channels) -> (Channels, Channels) {
    let power = samples.each_ref().map(|samples| samples.as_deref().map(power));
    let ln = power.each_ref().map(|power| power.as_ref().map(|p| p.iter().map(|p| p.ln()).collect()));
    (power, ln)
}

/// Samples of `ax` or `ay` of a run; none of one that it does not have.
pub fn samples(run: &Recording, channel: usize) -> &[f64] {
    run.channel(CHANNELS[channel]).map_or(&[], |c| &c.samples)
}

/// Mean load of recordings, N.
pub fn mean_load_n(observations: &[Observation]) -> f64 {
    observations.iter().map(|o| o.condition.load_n.abs()).sum::<f64>() / observations.len().max(1) as f64
}

/// Duration of all recordings, s.
pub fn duration_s(observations: &[Observation]) -> f64 {
    observations.iter().map(|o| o.condition.samples as f64 / o.condition.sample_rate_hz).sum()
}

/// Power spectrum by sine tapers (K. S. Riedel, A. Sidorenko, "Minimum bias multiple taper spectral estimation", IEEE Trans.
/// Signal Process. 43 (1995) 188–195).
pub fn power(samples: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; samples.len() / 2 + 1];
    for bins in tapered(samples) {
        out.iter_mut().zip(bins).for_each(|(sum, x)| *sum += x.norm_sqr() / SETTINGS.tapers as f64);
    }
    out
}

/// Cross-spectrum X·Y* of two signals of a length by the same tapers.
pub fn cross_power(x: &[f64], y: &[f64]) -> Vec<Complex<f64>> {
    let mut out = vec![Complex::default(); x.len() / 2 + 1];
    for (x, y) in tapered(x).zip(tapered(y)) {
        let product = x.into_iter().zip(y).map(|(x, y)| x * y.conj() / SETTINGS.tapers as f64);
        out.iter_mut().zip(product).for_each(|(sum, product)| *sum += product);
    }
    out
}

/// Fourier coefficients of a signal in each taper.
fn tapered(samples: &[f64]) -> impl Iterator<Item = Coefficients> {
    let n = samples.len();
    let scale = (2.0 / (n as f64 + 1.0)).sqrt();
    let tapers = tapers(n);
    (0..tapers.len()).map(move |taper| {
        let tapered: Vec<f64> = samples.iter().zip(&tapers[taper]).map(|(v, w)| v * w).collect();
        padded(&tapered, n, scale)
    })
}

/// Tapers of a length.
type Tapers = Vec<Vec<f64>>;

/// Sine tapers of a length, without their scale.
fn tapers(n: usize) -> Arc<Tapers> {
    static KEPT: LazyLock<Mutex<HashMap<usize, Arc<Tapers>>>> = LazyLock::new(Mutex::default);
    let of = |taper: usize| -> Vec<f64> {
        let rate = PI * taper as f64 / (n as f64 + 1.0);
        (0..n).map(|t| (rate * (t + 1) as f64).sin()).collect()
    };
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    Arc::clone(kept.entry(n).or_insert_with(|| Arc::new((1..=SETTINGS.tapers).map(of).collect())))
}
