//! A recording of the two channels that a bearing rig has, in the frequency domain.

use std::borrow::Cow;

use realfft::num_complex::Complex;

use super::tachometer::Reading;
use crate::recording::{Channel, Recording};
use crate::rig::OperatingCondition;
use crate::signal::interpolate::{Interpolator, held};
use crate::signal::transform::forward_plan;

/// Names of the accelerations in a simulated recording.
pub const CHANNELS: [&str; 2] = ["ax", "ay"];

/// Fourier coefficients of a channel, from frequency 0 to half the sample rate, theory (1): white noise of variance σ² has
/// E|X|² = σ² in each.
pub type Coefficients = Vec<Complex<f64>>;

/// A recording with its spectra and operating condition.
#[derive(Clone, Debug)]
pub struct Observed {
    /// Name.
    pub name: String,
    /// Operating condition.
    pub condition: OperatingCondition,
    /// Standard deviation of the stated speed, Hz.
    pub shaft_hz_std: f64,
    /// Samples of `ax` and `ay`, m/s²; `None` for a channel that was not recorded.
    pub samples: [Option<Vec<f64>>; 2],
    /// Fourier coefficients of `ax` and `ay`.
    pub spectra: [Option<Coefficients>; 2],
    /// Tachometer's reading of the shaft's angle at the first sample.
    pub tachometer: Option<Reading>,
}

/// Error of a recording that lacks what a bearing rig needs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{recording}: found {found}, expected {expected}")]
pub struct NotObserved {
    /// The recording.
    pub recording: String,
    /// Contents of the recording.
    pub found: String,
    /// Expected contents.
    pub expected: &'static str,
}

/// Channels `ax` and `ay` of a recording: by these names, by the default places of the rig's sensors, by FEMTO's names, or,
/// of a recording with one acceleration, that one as `ay`, in the direction of the load.
pub fn accelerations(recording: &Recording) -> [Option<&Channel>; 2] {
    let by_name = |names: [&str; 3]| names.iter().find_map(|name| recording.channel(name));
    let found = [by_name(["ax", "outer-x", "horizontal"]), by_name(["ay", "resonator-y", "vertical"])];
    let measured: Vec<_> = recording.channels.iter().filter(|c| c.name != "tacho").collect();
    match (found, measured.as_slice()) {
        ([None, None], [only]) => [None, Some(only)],
        _ => found,
    }
}

impl Observed {
    /// Recordings with their speeds and loads. A load that is not stated is taken to be 0 N.
    ///
    /// # Errors
    /// As [`Observed::from_recording`], for the first recording that lacks something.
    pub fn from_recordings(recordings: &[Recording]) -> Result<Vec<Self>, NotObserved> {
        recordings.iter().map(Self::from_recording).collect()
    }

    /// A recording with its speed and load; 0 N where none is stated.
    ///
    /// # Errors
    /// A recording without acceleration or speed, or with under 64 samples.
    pub fn from_recording(recording: &Recording) -> Result<Self, NotObserved> {
        let name = recording.source.to_string();
        let refuse = |found: &str, expected| NotObserved { recording: name.clone(), found: found.into(), expected };
        let channels = accelerations(recording);
        if channels.iter().all(Option::is_none) {
            let there: Vec<_> = recording.channels.iter().map(|c| c.name.as_str()).collect();
            return Err(refuse(
                &format!("channels {}", there.join(", ")),
                "`ax` or `ay`; `channels = { name = \"resonator-y\" }` in the manifest says which is which",
            ));
        }
        let shaft_hz = recording.shaft_hz.ok_or_else(|| refuse("no shaft_hz", "the shaft's speed in the manifest"))?;
        // Unknown on many machines; who reports on this recording says that none was stated.
        let load_n = recording.load_n.unwrap_or_default();
        if recording.len() < 64 {
            return Err(refuse(&format!("{} samples", recording.len()), "at least 64"));
        }
        let condition =
            OperatingCondition { shaft_hz, load_n, sample_rate_hz: recording.sample_rate_hz, samples: recording.len() };
        let spectra = channels.map(|channel| channel.map(|c| coefficients(&c.samples)));
        let samples = channels.map(|channel| channel.map(|c| c.samples.clone()));
        let tachometer = Reading::from_recording(recording, shaft_hz);
        let shaft_hz_std = recording.speed_std_hz().unwrap_or_default();
        Ok(Self { name: recording.name(), condition, shaft_hz_std, samples, spectra, tachometer })
    }
}

impl Observed {
    /// Recording resampled to the constant speed that the shaft had at t = 0, for a shaft that gains `rate_per_s` of it a
    /// second.
    pub fn at_even_speed(&self, rate_per_s: f64) -> Cow<'_, Self> {
        if rate_per_s == 0.0 {
            return Cow::Borrowed(self);
        }
        let (interpolator, rate) = (Interpolator::new(), self.condition.sample_rate_hz);
        // An even speed takes t + r t²/2 for the same turn.
        let place = |even: usize| {
            let even_s = even as f64 / rate;
            let root = (1.0 + 2.0 * rate_per_s * even_s).max(0.0).sqrt();
            2.0 * even_s / (1.0 + root) * rate
        };
        let samples = self.samples.each_ref().map(|channel| {
            channel.as_ref().map(|s| (0..s.len()).map(|i| interpolator.at(place(i), held(s))).collect::<Vec<_>>())
        });
        let spectra = samples.each_ref().map(|channel| channel.as_ref().map(|s| coefficients(s)));
        Cow::Owned(Self {
            name: self.name.clone(),
            condition: self.condition,
            shaft_hz_std: self.shaft_hz_std,
            tachometer: self.tachometer,
            samples,
            spectra,
        })
    }
}

/// Fourier coefficients of a signal, theory (1).
pub fn coefficients(samples: &[f64]) -> Coefficients {
    padded(samples, samples.len(), 1.0 / (samples.len() as f64).sqrt())
}

/// Fourier transform of a signal padded with zeros to `length` samples, times `scale`.
pub fn padded(samples: &[f64], length: usize, scale: f64) -> Coefficients {
    let transform = forward_plan(length);
    let mut buffer: Vec<f64> = samples.iter().map(|v| v * scale).collect();
    buffer.resize(length, 0.0);
    let mut out = transform.make_output_vec();
    // Both buffers have the transform's length.
    transform.process(&mut buffer, &mut out).unwrap_or_default();
    out
}
