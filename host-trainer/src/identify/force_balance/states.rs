//! From recordings to states and forces on one grid, all behind the same filter.
//!
//! A rig of one degree of freedom obeys m q̈ + c q̇ + k g(q) + Σ β T(q, q̇, t) = gain · u + gravity. Convolved with a
//! kernel it still does, term by term: h ∗ q̈ is h″ ∗ q, and h ∗ T is the kernel over the term at each sample. So linear
//! terms are taken from the raw position, and nonlinear ones from states smoothed only as much as the sensor's noise
//! asks for, then passed through the same kernel as the force. Where the acceleration is measured, position and speed
//! are its integrals without what lies below the band, and every term loses the same.

use super::{
    error::BalanceError,
    filter::{HighPass, Kernel, NARROWEST},
    noise::{self, Band},
};
use crate::recording::Recording;

/// Shortest recording, samples.
const SHORTEST: usize = 200;

/// What the sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensed {
    /// q.
    Position,
    /// q̈.
    Acceleration,
}

impl Sensed {
    /// The channel's name in recordings.
    pub fn channel(self) -> &'static str {
        match self {
            Self::Position => "q",
            Self::Acceleration => "qdd",
        }
    }
}

/// An input between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// The last sample's value until the next, as of a converter: half a sample late.
    Held,
    /// A straight line from one to the next.
    Straight,
    /// As its band allows: it was sampled itself.
    Smooth,
}

/// One recording's signals at its full rate.
#[derive(Clone, Debug)]
pub struct Track {
    /// The recording's name.
    pub name: String,
    /// u, as recorded.
    pub input: Vec<f64>,
    /// q or q̈, as recorded.
    pub sensed: Vec<f64>,
    /// q, smoothed as little as nonlinear terms bear.
    pub position: Vec<f64>,
    /// q̇, likewise.
    pub velocity: Vec<f64>,
    /// Samples that are not to be believed.
    pub bad: Vec<bool>,
    /// Samples at which the filtered balance is drawn up.
    pub rows: Vec<usize>,
    /// Of each row, whether nothing bad reaches into it.
    pub valid: Vec<bool>,
}

impl Track {
    /// Samples.
    pub fn len(&self) -> usize {
        self.sensed.len()
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

    /// Whether there are none, which [`States::new`] refuses.
    pub fn is_empty(&self) -> bool {
        self.sensed.is_empty()
    }
}

/// All recordings' signals and the filter they pass.
#[derive(Clone, Debug)]
pub struct States {
    /// The recordings.
    pub tracks: Vec<Track>,
    /// What was measured.
    pub sensed: Sensed,
    /// Samples per second, of all recordings.
    pub sample_rate_hz: f64,
    /// Standard deviation of the filter's kernel, samples.
    pub deviation: f64,
    /// Samples from one row of the balance to the next.
    pub stride: usize,
    /// Noise and band of the measured signal, from the data.
    pub band: Band,
    /// Below what a measured acceleration is not integrated.
    pub high_pass: Option<HighPass>,
    /// What the input did between its samples.
    pub between: Between,
    /// q̈ for a unit of input, of which an acceleration that steps with a held input is made.
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
        let sensed = if recordings.iter().all(|r| named(r, "q").is_some()) {
            Sensed::Position
        } else if recordings.iter().all(|r| named(r, "qdd").is_some()) {
            Sensed::Acceleration
        } else {
            let lacks = recordings.iter().find(|r| named(r, "q").is_none()).unwrap_or(first);
            return Err(lacking(lacks, "q or qdd"));
        };
        let rate = first.sample_rate_hz;
        let mut tracks = Vec::with_capacity(recordings.len());
        for recording in recordings {
            let input = named(recording, "u").ok_or_else(|| lacking(recording, "u"))?;
            let measured = named(recording, sensed.channel()).unwrap_or_default();
            if (recording.sample_rate_hz / rate - 1.0).abs() > 1e-6 {
                let found = format!("{} Hz", recording.sample_rate_hz);
                return Err(refuse(recording, &found, &format!("{rate} Hz as the first recording")));
            }
            if measured.len() < SHORTEST || input.len() != measured.len() {
                let found = format!("{} samples of u and {} of the sensor", input.len(), measured.len());
                return Err(refuse(recording, &found, "as many of each, at least 200"));
            }
            if input.iter().chain(measured).any(|x| !x.is_finite()) {
                return Err(refuse(recording, "a sample that is not finite", "finite samples"));
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
            deviation: NARROWEST,
            stride: 1,
            band,
            high_pass: None,
            between: Between::Held,
            input_per_mass: 0.0,
        };
        states.learn_band()?;
        Ok(states)
    }

    /// Learns noise and band from the measured samples, and chooses the filter by them.
    ///
    /// # Errors
    ///
    /// Recordings too short for a spectrum.
    pub fn learn_band(&mut self) -> Result<(), BalanceError> {
        let rate = self.sample_rate_hz;
        let signals: Vec<&[f64]> = self.tracks.iter().map(|t| t.sensed.as_slice()).collect();
        self.band = noise::band(&signals, rate).ok_or(BalanceError::NoRecordings)?;
        // Half the amplitude is left where the signal meets its noise.
        let deviation = (2.0 * 2.0f64.ln()).sqrt() * rate / (std::f64::consts::TAU * self.band.high_hz);
        let shortest = signals.iter().map(|s| s.len()).min().unwrap_or_default();
        // A slow signal in a short recording: keep at least some dozens of rows.
        self.deviation = deviation.min(shortest as f64 / 60.0).max(NARROWEST);
        self.high_pass = (self.sensed == Sensed::Acceleration).then(|| {
            let corner_hz = (0.7 * self.band.low_hz).max(4.0 * rate / shortest as f64);
            HighPass { corner_hz, sample_rate_hz: rate }
        });
        self.stride = ((1.5 * self.deviation) as usize).max(1);
        self.prepare();
        Ok(())
    }

    /// Draws up smoothed states and rows anew, after measured samples or the list of bad ones has changed.
    pub fn prepare(&mut self) {
        let (step, deviation, stride) = (self.step_s(), self.deviation, self.stride);
        let reach = Kernel::delayed(deviation, 0, step, 0.5, 0.2).reach;
        let margin = reach + self.high_pass.map_or(0, |h| (2.0 * self.sample_rate_hz / h.corner_hz) as usize);
        // Flat to 7e-4 where the signal meets its noise.
        let smoothing = (0.5 * deviation).max(0.75 * NARROWEST);
        for track in &mut self.tracks {
            (track.position, track.velocity) = match self.high_pass {
                Some(pass) => {
                    let mut states = (pass.apply(&track.sensed, 2), pass.apply(&track.sensed, 1));
                    if self.between == Between::Held {
                        // The part of q̈ that steps with the input stays until the next sample: its integral is half a
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

    /// Frequency at which the filter leaves half the amplitude, Hz.
    pub fn cutoff_hz(&self) -> f64 {
        (2.0 * 2.0f64.ln()).sqrt() * self.sample_rate_hz / (std::f64::consts::TAU * self.deviation)
    }

    /// Rows of all recordings.
    pub fn rows(&self) -> usize {
        self.tracks.iter().map(|t| t.rows.len()).sum()
    }

    /// A signal of each recording's full rate, filtered, row by row.
    pub fn column(&self, signal: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
        self.filtered(0, 0.0, 0.0, |track| match self.high_pass {
            Some(pass) => pass.apply(&signal(track), 0),
            None => signal(track),
        })
    }

    /// u behind the filter. Held, it acts half a sample late on a position; an acceleration follows it at once.
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

    /// q̈ behind the filter.
    pub fn acceleration(&self) -> Vec<f64> {
        match self.high_pass {
            Some(pass) => self.filtered(0, 0.0, 0.0, |track| pass.apply(&track.sensed, 0)),
            None => self.filtered(2, 0.0, 0.0, |track| track.sensed.clone()),
        }
    }

    /// q̇ behind the filter.
    pub fn velocity(&self) -> Vec<f64> {
        match self.high_pass {
            Some(_) => self.filtered(0, 0.0, 0.0, |track| track.velocity.clone()),
            None => self.filtered(1, 0.0, 0.0, |track| track.sensed.clone()),
        }
    }

    /// q behind the filter.
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

    /// Weights with which a sample's noise enters the balance m q̈ + c q̇ + k q.
    pub fn noise_kernel(&self, mass: f64, damping: f64, stiffness: f64) -> Vec<f64> {
        let kernel = |order| Kernel::gaussian(self.deviation, order, self.step_s()).taps;
        if self.sensed == Sensed::Acceleration {
            return kernel(0).iter().map(|h| h * mass).collect();
        }
        let (h, d, dd) = (kernel(0), kernel(1), kernel(2));
        (0..h.len()).map(|j| mass * dd[j] + damping * d[j] + stiffness * h[j]).collect()
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
    /// Two parts, one to fit and one to judge by, with a word on the latter: every fourth recording (at least the last),
    /// of a single one the last quarter. `None` where that is too short.
    pub fn split(&self) -> Option<(Self, Self, String)> {
        let part = |tracks: Vec<Track>| {
            let mut states = Self { tracks, ..self.clone() };
            states.prepare();
            states
        };
        if let [track] = self.tracks.as_slice() {
            let at = track.len() * 3 / 4;
            let piece = |range: std::ops::Range<usize>| track.part(range);
            if track.len() - at < SHORTEST {
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

    /// Cuts a recording in two at a sample, which goes with the later part. Whether both parts were long enough.
    pub fn cut(&mut self, track: usize, at: usize) -> bool {
        let whole = &self.tracks[track];
        if at < SHORTEST || whole.len() - at < SHORTEST {
            return false;
        }
        let part = |range: std::ops::Range<usize>| whole.part(range);
        let parts = [part(0..at), part(at..whole.len())];
        self.tracks.splice(track..=track, parts);
        true
    }

    /// Samples of a window over which a simulation is believed though forces disturb the machine: eight periods of the
    /// fastest motion, at least 100 samples.
    pub fn short_window(&self) -> usize {
        ((8.0 * self.sample_rate_hz / self.band.high_hz) as usize).max(100)
    }
}

fn named<'a>(recording: &'a Recording, channel: &str) -> Option<&'a [f64]> {
    // By its name, or as the manifest calls it: channels = { vir = "u" }.
    recording.channel(channel).map(|c| c.samples.as_slice())
}

fn lacking(recording: &Recording, channel: &str) -> BalanceError {
    let there: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
    let found = format!("no channel {channel} among {}", there.join(", "));
    refuse(recording, &found, "one; `channels = { NAME = \"u\" }` in the manifest says which is which")
}

fn refuse(recording: &Recording, found: &str, expected: &str) -> BalanceError {
    BalanceError::BadRecording {
        recording: recording.source.to_string(),
        found: found.into(),
        expected: expected.into(),
    }
}
