//! Analysis of one recording by the steps of [`signal`](crate::signal): speed, band, envelope lines, orders.

use std::ops::Range;

use serde::Serialize;

use crate::recording::{Recording, resample};
use crate::signal::band::band_for_lines;
use crate::signal::characteristic::{Characteristic, Family, Speeds, list};
use crate::signal::coherence::coherence;
use crate::signal::envelope::envelope_spectrum;
use crate::signal::indicators::longest_piece;
use crate::signal::kinematics::Geometry;
use crate::signal::kurtogram::{Kurtogram, kurtogram_of_pieces};
use crate::signal::lines::{Line, Marked};
use crate::signal::order::{OrderSpectrum, ShaftAngle, order_spectrum};
use crate::signal::settings::SpectraSettings;
use crate::signal::spectrum::{Spectrum, USABLE, welch};
use crate::signal::speed::{SpeedEstimate, SpeedSearch, estimate};
use crate::signal::synchronous::{Synchronous, average};

const SETTINGS: SpectraSettings = SpectraSettings::DEFAULT;

/// Options of an analysis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Bearing geometry, if known.
    pub geometry: Option<Geometry>,
    /// Nominal speed, Hz; overrides the recording's own.
    pub shaft_hz: Option<f64>,
    /// Band of the envelope, Hz; `None`: chosen.
    pub band_hz: Option<Range<f64>>,
    /// Channel; `None`: the first.
    pub channel: Option<String>,
    /// Seed of the speed's permutation test.
    pub seed: u64,
}

/// Failure of an analysis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectraError {
    /// No such channel.
    #[error("{recording}: found channels {found}, expected `{expected}`")]
    Channel {
        /// Name of the recording.
        recording: String,
        /// Names of its channels.
        found: String,
        /// Name of the channel.
        expected: String,
    },
    /// Too few samples without a gap.
    #[error("{recording}: found {found} samples in one piece, expected at least {least}")]
    TooShort {
        /// Name of the recording.
        recording: String,
        /// Samples of its longest piece without a gap.
        found: usize,
        /// Least number of samples.
        least: usize,
    },
    /// Channel that never varies.
    #[error("{recording}, channel `{channel}`: found {value} in all samples, expected a signal that varies")]
    Flat {
        /// Name of the recording.
        recording: String,
        /// Name of the channel.
        channel: String,
        /// Value of all samples.
        value: f64,
    },
    /// Speed that the sample rate cannot show.
    #[error("{recording}, shaft_hz: found {found}, expected less than half the sample rate of {sample_rate_hz} Hz")]
    Speed {
        /// Name of the recording.
        recording: String,
        /// Speed, Hz.
        found: f64,
        /// Sample rate, Hz.
        sample_rate_hz: f64,
    },
    /// Band outside 0 to Nyquist's frequency.
    #[error("{recording}: found band {low}:{high} Hz, expected one between 0 and Nyquist's {nyquist} Hz")]
    Band {
        /// Name of the recording.
        recording: String,
        /// Lower edge, Hz.
        low: f64,
        /// Upper edge, Hz.
        high: f64,
        /// Nyquist's frequency, Hz.
        nyquist: f64,
    },
}

/// Source of the speed that frequencies are marked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpeedSource {
    /// The tachometer's pulses.
    Tachometer,
    /// The recording's own lines.
    Estimate,
    /// The stated speed.
    Nominal,
}

/// Shaft speed from all sources.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// Stated speed, Hz.
    pub nominal_hz: Option<f64>,
    /// Mean over the tachometer's pulses, Hz.
    pub tachometer_hz: Option<f64>,
    /// Error of the tachometer channel, if any.
    pub tachometer_error: Option<String>,
    /// Estimate from the recording's lines.
    pub estimate: Option<SpeedEstimate>,
    /// Reason for a missing estimate.
    pub not_determined: Option<String>,
    /// Speed that frequencies are marked by, Hz.
    pub used_hz: Option<f64>,
    /// Source of `used_hz`.
    pub source: Option<SpeedSource>,
}

/// Reason for a band.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BandChoice {
    /// Stated by the user.
    Stated,
    /// Lines of a family in its envelope.
    Lines(Family),
    /// Greatest kurtosis.
    Kurtosis,
    /// No significant lines or kurtosis: the converter's passband.
    Nothing,
}

/// Band of the envelope.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Edges of the band, Hz.
    pub band_hz: Range<f64>,
    /// Reason for the band.
    pub choice: BandChoice,
    /// ln of the lines' p-value over all bands tried; only for [`BandChoice::Lines`].
    pub log_p_value: Option<f64>,
}

/// A characteristic frequency with its line in the envelope's spectrum.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarkedLine {
    /// Characteristic frequency.
    #[serde(flatten)]
    pub characteristic: Characteristic,
    /// Line; amplitudes in the unit of the recording.
    pub line: Line,
}

/// Analysis of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// Name of the recording.
    pub name: String,
    /// Source file.
    pub file: String,
    /// Name of the channel.
    pub channel: String,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Duration of the longest piece without a gap, which is analysed, s.
    pub duration_s: f64,
    /// Shaft speed.
    pub speed: Speed,
    /// Power spectral density.
    pub density: Spectrum,
    /// Kurtogram; `None` for too few samples.
    pub kurtogram: Option<Kurtogram>,
    /// Band of the envelope.
    pub band: Band,
    /// Amplitude spectrum of the envelope in the band.
    pub envelope: Spectrum,
    /// Enhanced envelope spectrum over the band: mean squared coherence.
    pub coherence: Option<Spectrum>,
    /// Characteristic frequencies in the envelope's spectrum.
    pub lines: Vec<MarkedLine>,
    /// Amplitudes over orders of the shaft.
    pub orders: Option<OrderSpectrum>,
    /// Synchronous average; `None` without a tachometer.
    pub synchronous: Option<Synchronous>,
}

impl Analysis {
    /// Analyses a recording; one that was resampled up, at its own rate: above half of it there is only the filter's rest.
    ///
    /// # Errors
    /// No such channel, too few samples, a channel that never varies, a speed or a band outside 0 to Nyquist's frequency.
    pub fn analyse(recording: &Recording, wanted: &Wanted) -> Result<Self, SpectraError> {
        let own = recording.resampled_from_hz.map(|own| resample::recording(recording.clone(), own));
        let recording = own.as_ref().unwrap_or(recording);
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
        let piece = longest_piece(recording.len(), &recording.gaps);
        let samples = &channel.samples[piece.clone()];
        let short = || SpectraError::TooShort {
            recording: recording.source.to_string(),
            found: samples.len(),
            least: SETTINGS.min_samples,
        };
        if samples.len() < SETTINGS.min_samples {
            return Err(short());
        }
        if let Some(value) = channel.constant() {
            let (recording, channel) = (recording.source.to_string(), channel.name.clone());
            return Err(SpectraError::Flat { recording, channel, value });
        }
        let nominal_hz = wanted.shaft_hz.or(recording.shaft_hz);
        if let Some(found) = nominal_hz.filter(|hz| *hz >= 0.5 * rate) {
            let recording = recording.source.to_string();
            return Err(SpectraError::Speed { recording, found, sample_rate_hz: rate });
        }
        if let Some(band) =
            wanted.band_hz.as_ref().filter(|b| !(b.start >= 0.0 && b.start < b.end && b.end <= 0.5 * rate))
        {
            let recording = recording.source.to_string();
            return Err(SpectraError::Band { recording, low: band.start, high: band.end, nyquist: 0.5 * rate });
        }
        let tacho = recording.channel("tacho").map(|t| ShaftAngle::from_tacho(&t.samples[piece.clone()], rate));
        let pieces = pieces(samples);
        // A speed wanders over a long recording, so that its lines are those of a piece.
        let middle = pieces[pieces.len() / 2];
        let speed = speed(middle, rate, nominal_hz, tacho.as_ref(), wanted);
        let slip = match (&speed.estimate, speed.source) {
            (Some(estimate), Some(SpeedSource::Estimate)) => estimate.slip.map_or(0.0, |(slip, _)| slip),
            _ => 0.0,
        };
        let speeds = speed.used_hz.map(|shaft_hz| Speeds { shaft_hz, geometry: wanted.geometry, slip });
        let segment = (1usize << (samples.len() / 3).max(8).ilog2()).min(SETTINGS.max_segment);
        let density = welch(&[samples], rate, segment).ok_or_else(short)?;
        let fastest =
            speeds.as_ref().and_then(|s| s.base_hz(Family::Inner)).map_or(SETTINGS.min_bandwidth_hz, |f| 2.0 * f);
        let kurtogram = kurtogram_of_pieces(&pieces, rate, fastest);
        let band = choose(middle, rate, speeds.as_ref(), kurtogram.as_ref(), wanted);
        let envelope = envelope_spectrum(&pieces, rate, &band.band_hz).ok_or_else(short)?;
        let marked = Marked::new(&envelope);
        let width = SETTINGS.envelope_share * (band.band_hz.end - band.band_hz.start);
        let listed = |s| list(s, width, SETTINGS.harmonics, SETTINGS.sidebands);
        let expected = speeds.as_ref().map_or_else(Vec::new, listed);
        let find = |characteristic: Characteristic| {
            // Ball passes slip, the shaft does not.
            let bearing = characteristic.law.cage != 0.0 && slip == 0.0;
            let tolerance = if bearing { SETTINGS.slip_tolerance * characteristic.frequency_hz } else { 0.0 };
            let line = marked.line(characteristic.frequency_hz, tolerance)?;
            Some(MarkedLine { characteristic, line })
        };
        let lines = expected.into_iter().filter_map(find).collect();
        let highest = envelope_range_hz(speeds.as_ref(), &band.band_hz);
        let coherence = enhanced_envelope_spectrum(samples, rate, highest, &band.band_hz);
        let pulses = tacho.and_then(Result::ok);
        // Angles count from the recording's start.
        let turned = &samples[..samples.len().min(SETTINGS.max_piece)];
        let angle = pulses.clone().or_else(|| speed.used_hz.map(ShaftAngle::constant));
        Ok(Self {
            name: recording.name(),
            file: recording.source.to_string(),
            channel: channel.name.clone(),
            sample_rate_hz: rate,
            duration_s: samples.len() as f64 / rate,
            orders: angle.and_then(|angle| order_spectrum(turned, rate, &angle)),
            synchronous: pulses.and_then(|angle| average(turned, rate, &angle, 1)),
            speed,
            density,
            kurtogram,
            band,
            envelope,
            coherence,
            lines,
        })
    }

    /// Highest frequency of the envelope's spectrum to plot, Hz.
    pub fn shown_hz(&self) -> f64 {
        let last = self.lines.iter().filter(|l| l.characteristic.sideband == 0).map(|l| l.characteristic.frequency_hz);
        let last = last.fold(0.0, f64::max);
        let width = self.band.band_hz.end - self.band.band_hz.start;
        let wanted = if last > 0.0 { SETTINGS.range_factor * last } else { SETTINGS.default_range_hz };
        wanted.min(SETTINGS.envelope_share * width)
    }

    /// Harmonic of greatest power over noise in the envelope's spectrum, the cage's left out; `None` if none is
    /// significant.
    pub fn strongest(&self) -> Option<&MarkedLine> {
        let own =
            self.lines.iter().filter(|l| l.characteristic.sideband == 0 && l.characteristic.family != Family::Cage);
        let sure = own.filter(|l| l.line.p_value < SETTINGS.line_p_value);
        sure.max_by(|a, b| a.line.ratio.total_cmp(&b.line.ratio))
    }
}

/// Equal pieces of a long recording; a shorter one whole.
fn pieces(samples: &[f64]) -> Vec<&[f64]> {
    let count = samples.len().div_ceil(SETTINGS.max_piece).max(1);
    match count {
        1 => vec![samples],
        _ => samples.chunks_exact(samples.len() / count / SETTINGS.piece_multiple * SETTINGS.piece_multiple).collect(),
    }
}

/// Enhanced envelope spectrum of a band, of a long recording the mean over some pieces.
fn enhanced_envelope_spectrum(samples: &[f64], rate: f64, highest_hz: f64, band_hz: &Range<f64>) -> Option<Spectrum> {
    let length = samples.len().min(SETTINGS.coherence_piece);
    let count = (samples.len() / length.max(1)).min(SETTINGS.coherence_pieces);
    let step = (samples.len() - length).checked_div(count.saturating_sub(1)).unwrap_or(0);
    let mut mean: Option<Spectrum> = None;
    for k in 0..count {
        let piece = &samples[k * step..k * step + length];
        let found = coherence(piece, rate, SETTINGS.coherence_window, highest_hz)?.enhanced_envelope_spectrum(band_hz);
        let mean =
            mean.get_or_insert_with(|| Spectrum { step_hz: found.step_hz, values: vec![0.0; found.values.len()] });
        mean.values.iter_mut().zip(&found.values).for_each(|(m, v)| *m += v / count as f64);
    }
    mean
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
        None => (None, Some("no nominal speed is known to search around".into())),
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
        let lines: Vec<f64> = (1..=SETTINGS.harmonics).map(|h| f64::from(h) * base).collect();
        let unknown = SETTINGS.slip_tolerance;
        let tolerance = if speeds?.slip == 0.0 { unknown } else { SETTINGS.known_slip_factor * unknown };
        Some((family, band_for_lines(samples, rate, &lines, tolerance)?))
    });
    let best = shown.min_by(|a, b| a.1.log_p_value.total_cmp(&b.1.log_p_value));
    if let Some((family, band)) = best.filter(|(_, band)| band.log_p_value < SETTINGS.max_log_p_value) {
        return Band { band_hz: band.band_hz, choice: BandChoice::Lines(family), log_p_value: Some(band.log_p_value) };
    }
    match kurtogram.and_then(Kurtogram::best) {
        Some(cell) => plain(cell.band_hz(), BandChoice::Kurtosis),
        None => plain(0.05 * rate..0.5 * USABLE * rate, BandChoice::Nothing),
    }
}

/// Highest modulation frequency of the coherence, Hz.
fn envelope_range_hz(speeds: Option<&Speeds>, band_hz: &Range<f64>) -> f64 {
    let highest = |f: f64| SETTINGS.range_factor * f64::from(SETTINGS.harmonics) * f;
    let wanted = speeds.and_then(|s| s.base_hz(Family::Inner)).map_or(SETTINGS.default_range_hz, highest);
    wanted.min(band_hz.end - band_hz.start)
}
