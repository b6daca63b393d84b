//! States and forces of recordings on one grid, all behind the same filter: theory (63) to (65).
//!
//! The equation of motion, convolved with a kernel, still holds term by term. Linear terms are taken from the raw position,
//! nonlinear ones from states smoothed only as much as the sensor's noise requires, then passed through the same kernel.
//! If the acceleration is measured, position and speed are its integrals behind a high-pass, which every term passes.

use super::{
    error::BalanceError,
    filter::{HighPass, Kernel},
    noise::{self, Band},
    settings::BalanceSettings,
    shooting::{Measured, Observed},
};
use crate::recording::Recording;
use crate::rig::sdof::Interpolation;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Quantity that the sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensed {
    /// Position q.
    Position,
    /// Acceleration q̈.
    Acceleration,
}

impl Sensed {
    /// Name of the channel in recordings.
    pub fn channel(self) -> &'static str {
        match self {
            Self::Position => "q",
            Self::Acceleration => "qdd",
        }
    }

    /// Quantity that all recordings have, the position first.
    ///
    /// # Errors
    ///
    /// A recording without either.
    pub fn in_all(recordings: &[&Recording]) -> Result<Self, BalanceError> {
        let both = [Self::Position, Self::Acceleration];
        let found = both.into_iter().find(|sensed| recordings.iter().all(|r| r.channel(sensed.channel()).is_some()));
        found.ok_or_else(|| match recordings.iter().find(|r| r.channel("q").is_none()) {
            Some(recording) => BalanceError::no_channel(recording, "q or qdd", "q"),
            None => BalanceError::NoRecordings,
        })
    }
}

/// An input between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// The last sample's value until the next, as of a converter: half a sample late.
    Held,
    /// A straight line from one sample to the next.
    Straight,
    /// Band-limited interpolation: the input was sampled itself.
    Smooth,
}

impl Between {
    /// The simulation's interpolation.
    pub fn interpolation(self) -> Interpolation {
        match self {
            Self::Held => Interpolation::Hold,
            Self::Straight => Interpolation::Linear,
            Self::Smooth => Interpolation::Smooth,
        }
    }
}

/// States by integration of an acceleration.
#[derive(Clone, Debug)]
pub struct Integrated {
    /// Position q.
    pub position: Vec<f64>,
    /// Velocity q̇.
    pub velocity: Vec<f64>,
    /// Standard deviation of the acceleration's noise.
    pub noise_std: f64,
    /// Samples at either end that are unreliable.
    pub unreliable: usize,
}

/// One recording's signals at its full rate.
#[derive(Clone, Debug)]
pub struct Track {
    /// The recording's name.
    pub name: String,
    /// Input u, as recorded.
    pub input: Vec<f64>,
    /// Position q or acceleration q̈, as recorded.
    pub sensed: Vec<f64>,
    /// Position q for nonlinear terms, smoothed as little as possible.
    pub position: Vec<f64>,
    /// Velocity q̇ for nonlinear terms, smoothed as little as possible.
    pub velocity: Vec<f64>,
    /// Whether each sample is invalid.
    pub bad: Vec<bool>,
    /// Samples of the rows of the filtered balance.
    pub rows: Vec<usize>,
    /// Whether each row is free of invalid samples.
    pub valid: Vec<bool>,
}

impl Track {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.sensed.len()
    }

    fn measured(&self, sample_rate_hz: f64) -> Measured<'_> {
        let Self { input, sensed, bad, position, velocity, .. } = self;
        Measured { input, sensed, bad, position, velocity, fine: 1, sample_rate_hz }
    }

    fn part(&self, range: std::ops::Range<usize>) -> Self {
        Self {
            name: self.name.clone(),
            input: self.input[range.clone()].to_vec(),
            sensed: self.sensed[range.clone()].to_vec(),
            bad: self.bad[range].to_vec(),
            position: Vec::new(),
            velocity: Vec::new(),
            rows: Vec::new(),
            valid: Vec::new(),
        }
    }
}

/// Signals of all recordings and the filter that they pass.
#[derive(Clone, Debug)]
pub struct States {
    /// Recordings.
    pub tracks: Vec<Track>,
    /// Measured quantity.
    pub sensed: Sensed,
    /// Samples per second, of all recordings.
    pub sample_rate_hz: f64,
    /// Standard deviation of the filter's kernel, samples.
    pub deviation: f64,
    /// Samples from one row of the balance to the next.
    pub stride: usize,
    /// Noise and band of the measured signal, from the data.
    pub band: Band,
    /// High-pass of a measured acceleration.
    pub high_pass: Option<HighPass>,
    /// Input between its samples.
    pub between: Between,
    /// Acceleration q̈ for a unit of input: the part that steps with a held input.
    pub input_per_mass: f64,
}

impl States {
    /// States of recordings with channels `u` and `q`, else `u` and `qdd`.
    ///
    /// # Errors
    ///
    /// No recordings, a missing channel, one shorter than 200 samples, samples that are not finite, sample rates that
    /// differ.
    pub fn new(recordings: &[Recording]) -> Result<Self, BalanceError> {
        let first = recordings.first().ok_or(BalanceError::NoRecordings)?;
        let sensed = Sensed::in_all(&recordings.iter().collect::<Vec<_>>())?;
        let rate = first.sample_rate_hz;
        let mut tracks = Vec::with_capacity(recordings.len());
        for recording in recordings {
            let input = recording.samples("u").ok_or_else(|| BalanceError::no_channel(recording, "u", "u"))?;
            let measured = recording.samples(sensed.channel()).unwrap_or_default();
            if (recording.sample_rate_hz / rate - 1.0).abs() > 1e-6 {
                let found = format!("{} Hz", recording.sample_rate_hz);
                return Err(BalanceError::recording(recording, found, format!("{rate} Hz as the first recording")));
            }
            if measured.len() < SETTINGS.min_samples || input.len() != measured.len() {
                let found = format!("{} samples of u and {} of the sensor", input.len(), measured.len());
                return Err(BalanceError::recording(recording, found, "as many of each, at least 200"));
            }
            if input.iter().chain(measured).any(|x| !x.is_finite()) {
                return Err(BalanceError::recording(recording, "a sample that is not finite", "finite samples"));
            }
            tracks.push(Track {
                name: recording.name(),
                input: input.to_vec(),
                sensed: measured.to_vec(),
                position: Vec::new(),
                velocity: Vec::new(),
                bad: vec![false; measured.len()],
                rows: Vec::new(),
                valid: Vec::new(),
            });
        }
        let band = Band { noise_std: 0.0, low_hz: 0.0, high_hz: rate };
        let mut states = Self {
            tracks,
            sensed,
            sample_rate_hz: rate,
            deviation: SETTINGS.min_kernel_std,
            stride: 1,
            band,
            high_pass: None,
            between: Between::Held,
            input_per_mass: 0.0,
        };
        states.learn_band()?;
        Ok(states)
    }

    /// Estimates noise and band from the measured samples, and chooses the filter by them, theory (64).
    ///
    /// # Errors
    ///
    /// Recordings too short for a spectrum.
    pub fn learn_band(&mut self) -> Result<(), BalanceError> {
        let rate = self.sample_rate_hz;
        let signals: Vec<&[f64]> = self.tracks.iter().map(|t| t.sensed.as_slice()).collect();
        self.band = noise::band(&signals, rate).ok_or(BalanceError::NoRecordings)?;
        // The gain is one half where the signal meets its noise.
        let deviation = (2.0 * 2.0f64.ln()).sqrt() * rate / (std::f64::consts::TAU * self.band.high_hz);
        let shortest = signals.iter().map(|s| s.len()).min().unwrap_or_default();
        // A slow signal in a short recording: keep at least some dozens of rows.
        self.deviation = deviation.min(shortest as f64 / SETTINGS.min_recording_std).max(SETTINGS.min_kernel_std);
        self.high_pass = (self.sensed == Sensed::Acceleration).then(|| {
            let least_hz = SETTINGS.min_corner_periods * rate / shortest as f64;
            HighPass { corner_hz: (SETTINGS.corner_share * self.band.low_hz).max(least_hz), sample_rate_hz: rate }
        });
        self.stride = ((SETTINGS.stride_std * self.deviation) as usize).max(1);
        self.prepare();
        Ok(())
    }

    /// Computes smoothed states and rows, after measured samples or the list of bad ones has changed.
    pub fn prepare(&mut self) {
        let (step, deviation, stride) = (self.step_s(), self.deviation, self.stride);
        let reach = Kernel::delayed(deviation, 0, step, 0.5, 0.2).reach;
        let margin = reach + self.high_pass.map_or(0, |pass| pass.unreliable());
        let least = SETTINGS.min_smoothing_share * SETTINGS.min_kernel_std;
        let smoothing = (SETTINGS.smoothing_share * deviation).max(least);
        for track in &mut self.tracks {
            (track.position, track.velocity) = match self.high_pass {
                Some(pass) => {
                    let mut states = (pass.apply(&track.sensed, 2), pass.apply(&track.sensed, 1));
                    if self.between == Between::Held {
                        // The part of q̈ that steps with the input holds until the next sample: its integral is half a
                        // sample later than that of a smooth signal through the same samples.
                        let late = -0.5 * step * self.input_per_mass;
                        for (state, integrals) in [(&mut states.0, 1), (&mut states.1, 0)] {
                            let stepping = pass.apply(&track.input, integrals);
                            state.iter_mut().zip(stepping).for_each(|(x, u)| *x += late * u);
                        }
                    }
                    states
                }
                None => (
                    Kernel::flat(smoothing, 0, step).everywhere(&track.sensed),
                    Kernel::flat(smoothing, 1, step).everywhere(&track.sensed),
                ),
            };
            let margin = margin.min(track.len() / 4);
            track.rows = (margin..track.len() - margin).step_by(stride).collect();
            let bad: Vec<usize> = (0..track.len()).filter(|k| track.bad[*k]).collect();
            let touched = |row: &usize| {
                let next = bad.partition_point(|b| *b + reach < *row);
                bad.get(next).is_some_and(|b| *b <= row + reach)
            };
            track.valid = track.rows.iter().map(|row| !touched(row)).collect();
        }
    }

    /// Time from one sample to the next, s.
    pub fn step_s(&self) -> f64 {
        1.0 / self.sample_rate_hz
    }

    /// Frequency at which the filter's gain is one half, Hz.
    pub fn cutoff_hz(&self) -> f64 {
        (2.0 * 2.0f64.ln()).sqrt() * self.sample_rate_hz / (std::f64::consts::TAU * self.deviation)
    }

    /// Filtered signal, row by row, of a signal at each recording's full rate.
    pub fn column(&self, signal: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
        self.filtered(0, 0.0, 0.0, |track| match self.high_pass {
            Some(pass) => pass.apply(&signal(track), 0),
            None => signal(track),
        })
    }

    /// Input u behind the filter. A held input acts half a sample late on a position, at once on an acceleration.
    pub fn input(&self) -> Vec<f64> {
        let (delay, widened) = match (self.sensed, self.between) {
            (Sensed::Position, Between::Held) => (0.5, 1.0 / 12.0),
            (Sensed::Position, Between::Straight) => (0.0, 1.0 / 6.0),
            _ => (0.0, 0.0),
        };
        self.filtered(0, delay, widened, |track| match self.high_pass {
            Some(pass) => pass.apply(&track.input, 0),
            None => track.input.clone(),
        })
    }

    /// Acceleration q̈ behind the filter.
    pub fn acceleration(&self) -> Vec<f64> {
        match self.high_pass {
            Some(pass) => self.filtered(0, 0.0, 0.0, |track| pass.apply(&track.sensed, 0)),
            None => self.filtered(2, 0.0, 0.0, |track| track.sensed.clone()),
        }
    }

    /// Velocity q̇ behind the filter.
    pub fn velocity(&self) -> Vec<f64> {
        match self.high_pass {
            Some(_) => self.filtered(0, 0.0, 0.0, |track| track.velocity.clone()),
            None => self.filtered(1, 0.0, 0.0, |track| track.sensed.clone()),
        }
    }

    /// Position q behind the filter.
    pub fn position(&self) -> Vec<f64> {
        match self.high_pass {
            Some(_) => self.filtered(0, 0.0, 0.0, |track| track.position.clone()),
            None => self.filtered(0, 0.0, 0.0, |track| track.sensed.clone()),
        }
    }

    fn filtered(&self, order: usize, delay: f64, widened: f64, signal: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
        let kernel = Kernel::delayed(self.deviation, order, self.step_s(), delay, widened);
        self.tracks.iter().flat_map(|track| kernel.at(&signal(track), &track.rows)).collect()
    }

    /// Largest |q| and |q̇| of the smoothed states.
    pub fn amplitudes(&self) -> (f64, f64) {
        let largest = |of: fn(&Track) -> &Vec<f64>| {
            self.tracks.iter().flat_map(of).fold(0.0f64, |largest, x| largest.max(x.abs()))
        };
        (largest(|t| &t.position), largest(|t| &t.velocity))
    }
}

impl States {
    /// Fitted and held-out parts, with the latter's name: every fourth recording (at least the last) is held out, of a
    /// single one the last quarter. `None` if that is too short.
    pub fn split(&self) -> Option<(Self, Self, String)> {
        let part = |tracks: Vec<Track>| {
            let mut states = Self { tracks, ..self.clone() };
            states.prepare();
            states
        };
        if let [track] = self.tracks.as_slice() {
            let at = track.len() * 3 / 4;
            let piece = |range: std::ops::Range<usize>| track.part(range);
            if track.len() - at < SETTINGS.min_samples {
                return None;
            }
            let word = format!("the last quarter of {}", track.name);
            return Some((part(vec![piece(0..at)]), part(vec![piece(at..track.len())]), word));
        }
        let count = self.tracks.len();
        let is_out = |index: usize| index % 4 == 3 || (count < 4 && index + 1 == count);
        let (test, train): (Vec<_>, Vec<_>) = (0..count).partition(|i| is_out(*i));
        let of = |indices: &[usize]| indices.iter().map(|i| self.tracks[*i].clone()).collect::<Vec<_>>();
        let word = test.iter().map(|i| self.tracks[*i].name.as_str()).collect::<Vec<_>>().join(", ");
        Some((part(of(&train)), part(of(&test)), word))
    }

    /// Position and velocity by integration of an acceleration behind a high-pass, theory (65).
    ///
    /// # Errors
    ///
    /// A recording too short for a spectrum.
    pub fn integrated(name: &str, sensed: &[f64], rate: f64) -> Result<Integrated, BalanceError> {
        let band = noise::band(&[sensed], rate).ok_or_else(|| BalanceError::BadRecording {
            recording: name.into(),
            found: format!("{} samples of qdd", sensed.len()),
            expected: format!("at least {}", SETTINGS.min_segment),
        })?;
        let least_hz = SETTINGS.min_corner_periods * rate / sensed.len() as f64;
        let pass = HighPass { corner_hz: (SETTINGS.corner_share * band.low_hz).max(least_hz), sample_rate_hz: rate };
        Ok(Integrated {
            position: pass.apply(sensed, 2),
            velocity: pass.apply(sensed, 1),
            noise_std: band.noise_std,
            unreliable: pass.unreliable(),
        })
    }

    /// The recordings as the shooting takes them.
    pub fn observed(&self) -> Observed<'_> {
        Observed {
            tracks: self.tracks.iter().map(|track| track.measured(self.sample_rate_hz)).collect(),
            sensed: self.sensed,
            interpolation: self.between.interpolation(),
        }
    }

    /// Samples of a window over which a simulation holds in spite of disturbing forces: some periods of the fastest motion.
    pub fn short_window(&self) -> usize {
        ((SETTINGS.window_periods * self.sample_rate_hz / self.band.high_hz) as usize).max(SETTINGS.min_window)
    }
}
