//! First stage: recordings to states, whatever their rates and lengths.

use std::ops::Range;

use super::settings::SdofSettings;
use crate::identify::force_balance::{
    BalanceError,
    shooting::{Measured, Observed},
    smoother::{self, Samples, Smoothed, SplineVariances},
    states::{Integrated, Sensed, States},
};
use crate::recording::Recording;
use crate::rig::sdof::Interpolation;
use crate::signal::surrogate::autoregression::Autoregression;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// A recording with its states.
#[derive(Clone, Debug)]
pub struct Track {
    /// Name of the recording.
    pub name: String,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Input u; 0 where the recording has none.
    pub input: Vec<f64>,
    /// Position q or acceleration q̈, as recorded; known lines are taken off.
    pub sensed: Vec<f64>,
    /// The same before anything was taken off.
    pub raw: Vec<f64>,
    /// Whether each sample is invalid.
    pub bad: Vec<bool>,
    /// Whether the machine was healthy.
    pub healthy: bool,
    /// Grid points a sample.
    pub fine: usize,
    /// States on the grid.
    pub states: Smoothed,
    /// Time of the first sample in its recording, s: after a cut.
    pub start_s: f64,
    /// Recording that it is of, as counted by the caller, and its first sample in that.
    pub origin: usize,
    /// First sample in the recording.
    pub offset: usize,
}

impl Track {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.sensed.len()
    }

    /// Samples from the first valid one to the last.
    pub fn valid(&self) -> Range<usize> {
        let first = self.bad.iter().position(|bad| !bad).unwrap_or(0);
        first..self.bad.iter().rposition(|bad| !bad).map_or(self.len(), |last| last + 1)
    }

    /// Time between samples, s.
    pub fn step_s(&self) -> f64 {
        1.0 / self.sample_rate_hz
    }

    /// Signal of position, velocity and acceleration on the grid.
    pub fn signal(&self, value: impl Fn(f64, f64, f64) -> f64) -> Vec<f64> {
        let Smoothed { position, velocity, acceleration, .. } = &self.states;
        position.iter().zip(velocity).zip(acceleration).map(|((q, v), a)| value(*q, *v, *a)).collect()
    }

    /// Input on the grid.
    pub fn grid_input(&self, interpolation: Interpolation) -> Vec<f64> {
        let points = self.states.position.len();
        let part = |point: usize| (point % self.fine) as f64 / self.fine as f64;
        (0..points).map(|p| interpolation.value(&self.input, p / self.fine, part(p))).collect()
    }

    fn measured(&self) -> Measured<'_> {
        let Self { input, sensed, bad, fine, states, sample_rate_hz, .. } = self;
        let Smoothed { position, velocity, .. } = states;
        Measured { input, sensed, bad, position, velocity, fine: *fine, sample_rate_hz: *sample_rate_hz }
    }

    fn samples(&self) -> Samples<'_> {
        Samples { position: &self.sensed, bad: &self.bad, step_s: self.step_s() }
    }
}

/// Recordings with their states.
#[derive(Clone, Debug)]
pub struct Acquired {
    /// Recordings, those under test first.
    pub tracks: Vec<Track>,
    /// Measured quantity.
    pub sensed: Sensed,
    /// Input between its samples.
    pub interpolation: Interpolation,
    /// Whether any recording has an input that is not 0.
    pub driven: bool,
    /// Standard deviation of the sensor's noise.
    pub noise_std: f64,
    /// What the sensors under test show where the machine rests at its nominal zero: taken off, within what a zero is right by.
    pub zero: f64,
    /// Time by which the sensor is late against the input, in samples: taken off.
    pub delay: f64,
    /// Sentences on what was left out.
    pub notes: Vec<String>,
}

impl Acquired {
    /// Recordings under test and of the healthy machine, with channel `q` or `qdd`, and `u` where there is an input.
    ///
    /// # Errors
    ///
    /// No recordings, one without a sensor's channel or with samples that are not finite, too few samples.
    pub fn new(recordings: &[Recording], baseline: &[Recording]) -> Result<Self, BalanceError> {
        let all: Vec<&Recording> = recordings.iter().chain(baseline).collect();
        let first = *all.first().ok_or(BalanceError::NoRecordings)?;
        let sensed = Sensed::in_all(&all)?;
        let total: usize = all.iter().map(|r| r.len()).sum();
        let share = (SETTINGS.most_samples as f64 / total.max(1) as f64).min(1.0);
        let mut tracks = Vec::new();
        for (index, recording) in all.iter().enumerate() {
            let measured = recording.samples(sensed.channel()).unwrap_or_default();
            let input = recording.samples("u").map_or_else(|| vec![0.0; measured.len()], <[f64]>::to_vec);
            if measured.len() < SETTINGS.min_recording || input.len() != measured.len() {
                let found = format!("{} samples of u and {} of the sensor", input.len(), measured.len());
                let expected = format!("as many of each, at least {}", SETTINGS.min_recording);
                return Err(BalanceError::recording(recording, found, expected));
            }
            if input.iter().chain(measured).any(|x| !x.is_finite()) {
                return Err(BalanceError::recording(recording, "a sample that is not finite", "finite samples"));
            }
            let kept = ((measured.len() as f64 * share) as usize).max(SETTINGS.min_recording);
            tracks.push(Track {
                name: recording.name(),
                sample_rate_hz: recording.sample_rate_hz,
                input: input[..kept].to_vec(),
                sensed: measured[..kept].to_vec(),
                raw: measured[..kept].to_vec(),
                bad: vec![false; kept],
                healthy: index >= recordings.len(),
                fine: 1,
                states: Smoothed::default(),
                start_s: 0.0,
                origin: index,
                offset: 0,
            });
        }
        if total < SETTINGS.min_samples {
            let expected = format!("at least {} in all recordings together", SETTINGS.min_samples);
            return Err(BalanceError::recording(first, format!("{total} samples"), expected));
        }
        let driven = tracks.iter().any(|t| t.input.iter().any(|u| *u != 0.0));
        let mut notes = Vec::new();
        if share < 1.0 {
            notes.push(format!("Of {total} samples the first {:.0} % of each recording were used.", 100.0 * share));
        }
        let interpolation = Interpolation::Hold;
        let mut acquired = Self { tracks, sensed, interpolation, driven, noise_std: 0.0, zero: 0.0, delay: 0.0, notes };
        acquired.smooth()?;
        Ok(acquired)
    }

    /// Computes the states, after samples or their validity have changed.
    ///
    /// # Errors
    ///
    /// Accelerations of recordings that are too short to be integrated.
    pub fn smooth(&mut self) -> Result<(), BalanceError> {
        if self.sensed == Sensed::Acceleration {
            return self.integrate();
        }
        let samples: Vec<Samples> = self.tracks.iter().map(Track::samples).collect();
        let nothing = || BalanceError::Nothing { expected: "a position that changes".into() };
        let variances = smoother::estimate(&samples).ok_or_else(nothing)?;
        self.noise_std = variances.noise.sqrt();
        let total: usize = self.tracks.iter().map(Track::len).sum();
        for track in &mut self.tracks {
            let states = smoother::smooth(&track.samples(), &variances, 1);
            let period = 1.0 / (frequency_hz(&states) * track.step_s()).max(1e-9);
            let room = (2 * SETTINGS.most_samples / total.max(1)).max(1);
            track.fine = ((SETTINGS.points_per_period / period).ceil() as usize).clamp(1, SETTINGS.max_fine.min(room));
            track.states = if track.fine == 1 { states } else { resmooth(track, &variances) };
        }
        Ok(())
    }

    /// States by integration behind a high-pass, theory (65).
    fn integrate(&mut self) -> Result<(), BalanceError> {
        for track in &mut self.tracks {
            let Integrated { position, velocity, noise_std: noise, unreliable } =
                States::integrated(&track.name, &track.sensed, track.sample_rate_hz)?;
            let (samples, ends) = (track.len(), unreliable.min(track.len() / SETTINGS.least_part_of_ends));
            track.bad[..ends].fill(true);
            track.bad[samples - ends..].fill(true);
            self.noise_std = self.noise_std.max(noise);
            let acceleration = track.sensed.clone();
            track.states = Smoothed { position, velocity, acceleration, velocity_std: 0.0 };
        }
        Ok(())
    }

    /// The first parts of all recordings, of about so many samples together.
    pub fn beginning(&self, samples: usize) -> Self {
        let total: usize = self.tracks.iter().map(Track::len).sum();
        let share = (samples as f64 / total.max(1) as f64).min(1.0);
        let part = |track: &Track| {
            let kept = ((track.len() as f64 * share) as usize).max(SETTINGS.min_recording.min(track.len()));
            let points = (kept - 1) * track.fine + 1;
            let mut track = track.clone();
            [&mut track.input, &mut track.sensed, &mut track.raw].into_iter().for_each(|x| x.truncate(kept));
            track.bad.truncate(kept);
            let Smoothed { position, velocity, acceleration, .. } = &mut track.states;
            [position, velocity, acceleration].into_iter().for_each(|x| x.truncate(points));
            track
        };
        Self { tracks: self.tracks.iter().map(part).collect(), ..self.clone() }
    }

    /// The recordings as the simulation takes them.
    pub fn observed(&self) -> Observed<'_> {
        Observed {
            tracks: self.tracks.iter().map(Track::measured).collect(),
            sensed: self.sensed,
            interpolation: self.interpolation,
        }
    }

    /// Takes an offset off the sensors under test, if all that is taken off is within a share of their largest signal. Returns
    /// whether it is.
    pub fn shift_zero(&mut self, offset: f64) -> bool {
        let largest = self.under_test().flat_map(|t| &t.raw).fold(0.0f64, |largest, x| largest.max(x.abs()));
        if offset == 0.0 || (self.zero + offset).abs() > SETTINGS.tolerance * largest {
            return false;
        }
        self.zero += offset;
        self.tracks.iter_mut().filter(|t| !t.healthy).flat_map(|t| &mut t.sensed).for_each(|x| *x -= offset);
        true
    }

    /// The same recordings with the input later by so many samples.
    pub fn delayed(&self, samples: f64) -> Self {
        let mut out = self.clone();
        out.delay += samples;
        for (track, recorded) in out.tracks.iter_mut().zip(&self.tracks) {
            let last = recorded.input.len() - 1;
            let one = |k: usize| {
                let at = (k as f64 - samples).clamp(0.0, last as f64);
                Interpolation::Smooth.value(&recorded.input, at as usize, at.fract())
            };
            track.input = (0..recorded.input.len()).map(one).collect();
        }
        out
    }

    /// Sentences on what was taken off that is no cause.
    pub fn taken_off(&self) -> impl Iterator<Item = String> {
        let share = 100.0 * SETTINGS.tolerance;
        let zero = (self.zero != 0.0).then(|| {
            format!(
                "The sensor shows {:.3e} at the nominal zero, less than the {share:.0} % of its largest signal that a zero is \
                 right by: no cause.",
                self.zero
            )
        });
        let delay = (self.delay != 0.0).then(|| {
            format!(
                "The sensor is {:.2} samples late against the input, as a filter before it makes it: no cause.",
                self.delay
            )
        });
        zero.into_iter().chain(delay)
    }

    /// Recordings under test.
    pub fn under_test(&self) -> impl Iterator<Item = &Track> {
        self.tracks.iter().filter(|t| !t.healthy)
    }

    /// Largest |q| and |q̇| under test.
    pub fn amplitudes(&self) -> [f64; 2] {
        let largest = |signal: fn(&Track) -> &Vec<f64>| {
            self.under_test().flat_map(signal).fold(f64::MIN_POSITIVE, |largest, x| largest.max(x.abs()))
        };
        [largest(|t| &t.states.position), largest(|t| &t.states.velocity)]
    }

    /// RMS of what an autoregression does not predict of the sensor's signal about each recording's mean.
    pub fn innovations(&self) -> f64 {
        let (mut squares, mut count) = (0.0, 0);
        for track in self.under_test() {
            let mean = track.raw.iter().sum::<f64>() / track.len() as f64;
            let moving: Vec<f64> = track.raw.iter().map(|x| x - mean).collect();
            let innovations = Autoregression::new(&moving).innovations(&moving);
            squares += innovations.iter().map(|e| e * e).sum::<f64>();
            count += innovations.len();
        }
        (squares / count.max(1) as f64).sqrt()
    }

    /// Standard deviation of the sensor's signal about each recording's mean.
    pub fn spread(&self) -> f64 {
        let (mut squares, mut count) = (0.0, 0);
        for track in self.under_test() {
            let mean = track.raw.iter().sum::<f64>() / track.len() as f64;
            squares += track.raw.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            count += track.len();
        }
        (squares / count.max(1) as f64).sqrt()
    }
}

/// Dominant frequency of the motion, Hz: of acceleration against velocity.
pub fn frequency_hz(states: &Smoothed) -> f64 {
    let spread = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
        x.iter().map(|x| (x - mean).powi(2)).sum::<f64>().sqrt()
    };
    spread(&states.acceleration) / spread(&states.velocity).max(f64::MIN_POSITIVE) / std::f64::consts::TAU
}

fn resmooth(track: &Track, variances: &SplineVariances) -> Smoothed {
    smoother::smooth(&track.samples(), variances, track.fine)
}
