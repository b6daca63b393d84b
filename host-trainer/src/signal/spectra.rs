//! What a recording shows of its machine: the band that tells most, the lines in it, the speed, the orders.
//!
//! The steps of [`signal`](crate::signal), one after the other, each choice with its reason.

use std::ops::Range;

use serde::Serialize;

use crate::recording::Recording;
use crate::signal::band::band_for_lines;
use crate::signal::characteristic::{Characteristic, Family, Speeds, list};
use crate::signal::coherence::coherence;
use crate::signal::envelope::envelope_spectrum;
use crate::signal::kinematics::Geometry;
use crate::signal::kurtogram::{Kurtogram, kurtogram};
use crate::signal::lines::{Line, Marked};
use crate::signal::order::{OrderSpectrum, ShaftAngle, order_spectrum};
use crate::signal::spectrum::{Spectrum, USABLE, welch};
use crate::signal::speed::{SpeedEstimate, SpeedSearch, estimate};
use crate::signal::synchronous::{Synchronous, average};

/// Samples of a segment of the density, at most.
const SEGMENT: usize = 4096;
/// Harmonics and sidebands that lines are listed for.
const HARMONICS: u32 = 3;
const SIDEBANDS: i32 = 1;
/// Narrowest band of the kurtogram where no bearing is known: wide enough for repetitions up to half of it.
const NARROWEST_HZ: f64 = 400.0;
/// ln of the probability from which a band is chosen for its lines.
const SURE: f64 = -6.9;
/// Relative distance from where kinematics put a line in which it is looked for: slip.
const SLIP: f64 = 0.01;
/// Samples that resolve the carriers of the coherence.
const CARRIERS: usize = 256;

/// What is known or wanted beside the recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// The bearing.
    pub geometry: Option<Geometry>,
    /// Nominal speed, over the recording's own.
    pub shaft_hz: Option<f64>,
    /// Band of the envelope, instead of one that is chosen.
    pub band_hz: Option<Range<f64>>,
    /// Channel, instead of the first.
    pub channel: Option<String>,
    /// Seed of the speed's null.
    pub seed: u64,
}

/// Why a recording cannot be shown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectraError {
    /// It has not the channel.
    #[error("{recording}: found channels {found}, expected `{expected}`")]
    Channel {
        /// The recording.
        recording: String,
        /// Its channels.
        found: String,
        /// The channel.
        expected: String,
    },
    /// It is too short, in one piece.
    #[error("{recording}: found {found} samples in one piece, expected at least {least}")]
    TooShort {
        /// The recording.
        recording: String,
        /// Samples of its longest piece.
        found: usize,
        /// The least.
        least: usize,
    },
    /// The band is not within what the recording holds.
    #[error("{recording}: found band {low}:{high} Hz, expected one between 0 and Nyquist's {nyquist} Hz")]
    Band {
        /// The recording.
        recording: String,
        /// Lower edge, Hz.
        low: f64,
        /// Upper edge, Hz.
        high: f64,
        /// Nyquist's frequency, Hz.
        nyquist: f64,
    },
}

/// Where the speed comes from that frequencies are marked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpeedSource {
    /// The tachometer's pulses.
    Tachometer,
    /// The recording's own lines.
    Estimate,
    /// What was stated.
    Nominal,
}

/// The shaft's speed, by all that speaks of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// What was stated, Hz.
    pub nominal_hz: Option<f64>,
    /// Mean over the tachometer's pulses, Hz.
    pub tachometer_hz: Option<f64>,
    /// Why there is a tachometer and no speed by it.
    pub tachometer_error: Option<String>,
    /// By the recording's lines.
    pub estimate: Option<SpeedEstimate>,
    /// Why there is none.
    pub not_determined: Option<String>,
    /// The one that frequencies are marked by, Hz.
    pub used_hz: Option<f64>,
    /// Where that comes from.
    pub source: Option<SpeedSource>,
}

/// Why a band was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BandChoice {
    /// It was stated.
    Stated,
    /// It shows the lines of a family.
    Lines(Family),
    /// It has the greatest kurtosis.
    Kurtosis,
    /// Nothing stands out: all that a converter's filter leaves alone.
    Nothing,
}

/// The band that the envelope is taken of.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// From edge to edge, Hz.
    pub band_hz: Range<f64>,
    /// Why this.
    pub choice: BandChoice,
    /// ln of the probability that noise shows such lines somewhere; only for [`BandChoice::Lines`].
    pub log_p_value: Option<f64>,
}

/// A characteristic frequency and what is there in the envelope's spectrum.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarkedLine {
    /// Which.
    #[serde(flatten)]
    pub characteristic: Characteristic,
    /// The line; amplitudes in the unit of the recording.
    pub line: Line,
}

/// All of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// Name of the recording.
    pub name: String,
    /// Where it was read from.
    pub file: String,
    /// The channel.
    pub channel: String,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Length of what was looked at, s: the longest piece without a gap.
    pub duration_s: f64,
    /// The speed.
    pub speed: Speed,
    /// Power density.
    pub density: Spectrum,
    /// Kurtosis of bands.
    pub kurtogram: Option<Kurtogram>,
    /// The band of the envelope.
    pub band: Band,
    /// Amplitude spectrum of the envelope in the band.
    pub envelope: Spectrum,
    /// Enhanced envelope spectrum over the band: mean squared coherence.
    pub coherence: Option<Spectrum>,
    /// Characteristic frequencies in the envelope's spectrum.
    pub lines: Vec<MarkedLine>,
    /// Amplitudes over orders of the shaft.
    pub orders: Option<OrderSpectrum>,
    /// What repeats with the shaft; only by a tachometer.
    pub synchronous: Option<Synchronous>,
}

impl Analysis {
    /// Of a recording.
    ///
    /// # Errors
    /// No such channel, too few samples, a band that is not there.
    pub fn analyse(recording: &Recording, wanted: &Wanted) -> Result<Self, SpectraError> {
        let rate = recording.sample_rate_hz;
        let channel = match &wanted.channel {
            Some(name) => recording.channel(name),
            None => recording.channels.iter().find(|c| c.name != "tacho"),
        };
        let channel = channel.ok_or_else(|| SpectraError::Channel {
            recording: recording.source.to_string(),
            found: recording.channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", "),
            expected: wanted.channel.clone().unwrap_or_else(|| "one that is not tacho".into()),
        })?;
        let piece = longest_piece(recording);
        let samples = &channel.samples[piece.clone()];
        let short =
            || SpectraError::TooShort { recording: recording.source.to_string(), found: samples.len(), least: 256 };
        if samples.len() < 256 {
            return Err(short());
        }
        if let Some(band) =
            wanted.band_hz.as_ref().filter(|b| !(b.start >= 0.0 && b.start < b.end && b.end <= 0.5 * rate))
        {
            let recording = recording.source.to_string();
            return Err(SpectraError::Band { recording, low: band.start, high: band.end, nyquist: 0.5 * rate });
        }
        let tacho = recording.channel("tacho").map(|t| ShaftAngle::from_tacho(&t.samples[piece.clone()], rate));
        let speed = speed(samples, rate, wanted.shaft_hz.or(recording.shaft_hz), tacho.as_ref(), wanted);
        let slip = match (&speed.estimate, speed.source) {
            (Some(estimate), Some(SpeedSource::Estimate)) => estimate.slip.map_or(0.0, |(slip, _)| slip),
            _ => 0.0,
        };
        let speeds = speed.used_hz.map(|shaft_hz| Speeds { shaft_hz, geometry: wanted.geometry, slip });
        let segment = (1usize << (samples.len() / 3).max(8).ilog2()).min(SEGMENT);
        let density = welch(&[samples], rate, segment).ok_or_else(short)?;
        let fastest = speeds.as_ref().and_then(|s| s.base_hz(Family::Inner)).map_or(NARROWEST_HZ, |f| 2.0 * f);
        let kurtogram = kurtogram(samples, rate, fastest);
        let band = choose(samples, rate, speeds.as_ref(), kurtogram.as_ref(), wanted);
        let envelope = envelope_spectrum(&[samples], rate, &band.band_hz).ok_or_else(short)?;
        let marked = Marked::new(&envelope);
        let width = 0.9 * (band.band_hz.end - band.band_hz.start);
        let expected = speeds.as_ref().map_or_else(Vec::new, |s| list(s, width, HARMONICS, SIDEBANDS));
        let find = |characteristic: Characteristic| {
            // The shaft does not slip; ball passes do, unless the slip is known.
            let bearing = characteristic.law.cage != 0.0 && slip == 0.0;
            let tolerance = if bearing { SLIP * characteristic.frequency_hz } else { 0.0 };
            let line = marked.line(characteristic.frequency_hz, tolerance)?;
            Some(MarkedLine { characteristic, line })
        };
        let lines = expected.into_iter().filter_map(find).collect();
        let highest = envelope_range_hz(speeds.as_ref(), &band.band_hz);
        let coherence =
            coherence(samples, rate, CARRIERS, highest).map(|c| c.enhanced_envelope_spectrum(&band.band_hz));
        let pulses = tacho.and_then(Result::ok);
        let angle = pulses.clone().or_else(|| speed.used_hz.map(ShaftAngle::constant));
        Ok(Self {
            name: recording.name(),
            file: recording.source.to_string(),
            channel: channel.name.clone(),
            sample_rate_hz: rate,
            duration_s: samples.len() as f64 / rate,
            orders: angle.and_then(|angle| order_spectrum(samples, rate, &angle)),
            synchronous: pulses.and_then(|angle| average(samples, rate, &angle, 1)),
            speed,
            density,
            kurtogram,
            band,
            envelope,
            coherence,
            lines,
        })
    }

    /// Up to where the envelope's spectrum is worth showing, Hz.
    pub fn shown_hz(&self) -> f64 {
        let last = self.lines.iter().filter(|l| l.characteristic.sideband == 0).map(|l| l.characteristic.frequency_hz);
        let last = last.fold(0.0, f64::max);
        let width = self.band.band_hz.end - self.band.band_hz.start;
        (if last > 0.0 { 1.12 * last } else { 1000.0 }).min(0.9 * width)
    }

    /// The family whose first harmonics stand out most of the envelope's spectrum, with the strongest of them; `None`
    /// where none does beyond chance.
    pub fn strongest(&self) -> Option<&MarkedLine> {
        let own =
            self.lines.iter().filter(|l| l.characteristic.sideband == 0 && l.characteristic.family != Family::Cage);
        let sure = own.filter(|l| l.line.p_value < 1e-4);
        sure.max_by(|a, b| a.line.ratio.total_cmp(&b.line.ratio))
    }
}

/// Samples between two gaps, most of them.
fn longest_piece(recording: &Recording) -> Range<usize> {
    let starts = std::iter::once(0).chain(recording.gaps.iter().map(|gap| gap + 1));
    let ends = recording.gaps.iter().map(|gap| gap + 1).chain([recording.len()]);
    starts.zip(ends).map(|(a, b)| a..b.max(a)).max_by_key(|piece| piece.len()).unwrap_or(0..0)
}

fn speed<E: ToString>(
    samples: &[f64],
    rate: f64,
    nominal_hz: Option<f64>,
    tacho: Option<&Result<ShaftAngle, E>>,
    wanted: &Wanted,
) -> Speed {
    let tachometer_hz = tacho.and_then(|t| t.as_ref().ok()).map(ShaftAngle::mean_hz);
    let search = nominal_hz
        .or(tachometer_hz)
        .map(|nominal_hz| SpeedSearch { seed: wanted.seed, ..SpeedSearch::around(nominal_hz, wanted.geometry) });
    let found = search.map(|search| estimate(samples, rate, &search));
    let (estimate, not_determined) = match found {
        Some(Ok(estimate)) => (Some(estimate), None),
        Some(Err(why)) => (None, Some(why.to_string())),
        None => (None, Some("no nominal speed is known to look around".into())),
    };
    let by = [
        (tachometer_hz, SpeedSource::Tachometer),
        (estimate.as_ref().map(|e| e.shaft_hz), SpeedSource::Estimate),
        (nominal_hz, SpeedSource::Nominal),
    ];
    let used = by.into_iter().find_map(|(hz, source)| Some((hz?, source)));
    let tachometer_error = tacho.and_then(|t| t.as_ref().err()).map(ToString::to_string);
    Speed {
        nominal_hz,
        tachometer_hz,
        tachometer_error,
        estimate,
        not_determined,
        used_hz: used.map(|(hz, _)| hz),
        source: used.map(|(_, source)| source),
    }
}

fn choose(samples: &[f64], rate: f64, speeds: Option<&Speeds>, kurtogram: Option<&Kurtogram>, wanted: &Wanted) -> Band {
    let plain = |band_hz, choice| Band { band_hz, choice, log_p_value: None };
    if let Some(band) = &wanted.band_hz {
        return plain(band.clone(), BandChoice::Stated);
    }
    let families = [Family::Outer, Family::Inner, Family::Ball];
    let shown = families.into_iter().filter_map(|family| {
        let base = speeds?.base_hz(family)?;
        let lines: Vec<f64> = (1..=HARMONICS).map(|h| f64::from(h) * base).collect();
        let tolerance = if speeds?.slip == 0.0 { SLIP } else { 0.1 * SLIP };
        Some((family, band_for_lines(samples, rate, &lines, tolerance)?))
    });
    let best = shown.min_by(|a, b| a.1.log_p_value.total_cmp(&b.1.log_p_value));
    if let Some((family, band)) = best.filter(|(_, band)| band.log_p_value < SURE) {
        return Band { band_hz: band.band_hz, choice: BandChoice::Lines(family), log_p_value: Some(band.log_p_value) };
    }
    match kurtogram.and_then(Kurtogram::best) {
        Some(cell) => plain(cell.band_hz(), BandChoice::Kurtosis),
        None => plain(0.05 * rate..0.5 * USABLE * rate, BandChoice::Nothing),
    }
}

/// Highest rate of modulation that is looked for, Hz.
fn envelope_range_hz(speeds: Option<&Speeds>, band_hz: &Range<f64>) -> f64 {
    let wanted = speeds.and_then(|s| s.base_hz(Family::Inner)).map_or(1000.0, |f| 1.12 * f64::from(HARMONICS) * f);
    wanted.min(band_hz.end - band_hz.start)
}
