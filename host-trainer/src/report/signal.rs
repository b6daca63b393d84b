//! Sections on recordings: what has changed between two times, and what the model makes of it.

use ballrace_core::model::Model;

use super::Section;
use crate::model::trace::Trace;
use crate::recording::input::Input;
use crate::recording::input::Series;
use crate::report::plot::{DrawError, density, derivative, envelope, residual};
use crate::signal::envelope::envelope_spectrum;
use crate::signal::spectrum::{band_of_most_gain, welch};

/// Recordings that a spectrum is averaged over.
const AVERAGED: usize = 5;
/// Samples in a window of numbers: few enough that single periods can be seen.
const SHOWN: usize = 512;
const SHOWN_CLOSE: usize = 128;
/// Derivatives whose prediction is shown.
const PANELS: usize = 2;

/// Two times of a machine's life.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'i> {
    early: &'i [Series],
    late: &'i [Series],
    sample_rate_hz: f64,
    /// Rate at which balls pass a point of the outer race, Hz, where it is known.
    ball_pass_hz: Option<f64>,
}

impl<'i> Comparison<'i> {
    /// The first recordings beside the last; `None` for fewer than two.
    pub fn from_input(input: &'i Input, ball_pass_hz: Option<f64>) -> Option<Self> {
        let count = AVERAGED.min(input.series.len() / 2);
        let early = input.series.get(..count).filter(|s| !s.is_empty())?;
        let late = input.series.get(input.series.len() - count..)?;
        Some(Self { early, late, sample_rate_hz: input.sample_rate_hz, ball_pass_hz })
    }

    /// Densities and envelope spectra.
    ///
    /// # Errors
    /// What the drawing library says.
    pub fn spectra(&self) -> Result<Section, DrawError> {
        let section = Section::new("What has changed in the spectrum");
        let (early, late) = (samples(self.early), samples(self.late));
        let (early_name, late_name) = (name("early", self.early), name("late", self.late));
        let rate = self.sample_rate_hz;
        let segment = segment(&[self.early, self.late].concat());
        let (Some(a), Some(b)) = (welch(&early, rate, segment), welch(&late, rate, segment)) else {
            return Ok(section.paragraph("The recordings are too short for a spectrum."));
        };
        // An eighth of what there is: wide enough for the fastest modulation of interest, and for one mode.
        let band = band_of_most_gain(&a, &b, rate / 16.0);
        let svg = density::svg((&early_name, &a), Some((&late_name, &b)), Some(&band))?;
        let section = section.figure(svg, format!(
            "Power spectral density (Welch, Hann window of {segment} samples, {:.1} Hz apart), averaged over the recordings named. \
             Shaded: of all bands of {:.0} Hz up to 80 % of Nyquist's frequency, the one in which the late recordings have gained most.",
            a.step_hz, band.end - band.start
        ));
        let (Some(a), Some(b)) = (envelope_spectrum(&early, rate, &band), envelope_spectrum(&late, rate, &band)) else {
            return Ok(section);
        };
        let up_to = self.ball_pass_hz.map_or(1000.0, |rate| 6.5 * rate).min(0.5 * (band.end - band.start));
        let mark = self.ball_pass_hz.map(|rate| ("BPFO", rate));
        let svg = envelope::svg((&early_name, &a), (&late_name, &b), up_to, mark)?;
        let known = match self.ball_pass_hz {
            Some(_) => "Impacts at the rate of passing balls stand as lines at the dashed marks.",
            None => "Repeated impacts stand as evenly spaced lines.",
        };
        Ok(section.figure(svg, format!(
            "Spectrum of the envelope in the shaded band, {:.0} to {:.0} Hz (analytic signal, Hann window, {:.1} Hz apart). {known}",
            band.start, band.end, a.step_hz
        )))
    }

    /// Prediction and residual of the model on one recording of each time.
    ///
    /// # Errors
    /// What the drawing library says.
    pub fn prediction(&self, model: &Model<'_>) -> Result<Section, DrawError> {
        let (Some(early), Some(late)) = (self.early.first(), self.late.last()) else {
            return Ok(Section::new("What the model predicts"));
        };
        let of = |series: &Series| middle(model, series, self.sample_rate_hz, SHOWN);
        let (a, b) = (of(early), of(late));
        let (name_a, name_b) = (format!("early: {}", early.name), format!("late: {}", late.name));
        let section = prediction(model, early, self.sample_rate_hz)?;
        Ok(section.figure(
            residual::svg((&name_a, &a), (&name_b, &b))?,
            "Residual, measured minus predicted, over its healthy standard deviation: root mean square over the derivatives at \
             each sample, early above late on one scale. 20 dB are a factor of ten; dashed, the healthy machine's. Its mean \
             square over a block is the level that the monitor judges.",
        ))
    }
}

/// The density of the recordings of a fit.
///
/// # Errors
/// What the drawing library says.
pub fn density_of(series: &[Series], sample_rate_hz: f64) -> Result<Section, DrawError> {
    let section = Section::new("The recordings' spectrum");
    let segment = segment(series);
    let Some(spectrum) = welch(&samples(series), sample_rate_hz, segment) else {
        return Ok(section.paragraph("The recordings are too short for a spectrum."));
    };
    let svg = density::svg((&name("fitted and held out", series), &spectrum), None, None)?;
    let step = spectrum.step_hz;
    Ok(section.figure(
        svg,
        format!(
            "Power spectral density (Welch, Hann window of {segment} samples, {step:.1} Hz apart), averaged over all."
        ),
    ))
}

/// Measured and predicted derivatives in the middle of a recording.
///
/// # Errors
/// What the drawing library says.
pub fn prediction(model: &Model<'_>, series: &Series, sample_rate_hz: f64) -> Result<Section, DrawError> {
    let window = middle(model, series, sample_rate_hz, SHOWN_CLOSE);
    let section = Section::new("What the model predicts");
    if window.residual.is_empty() {
        return Ok(section.paragraph(format!("{} is too short to show.", series.name)));
    }
    // The first and the last: the coarsest and the finest difference.
    let mut chosen = vec![0, window.names.len() - 1];
    chosen.dedup();
    chosen.truncate(PANELS);
    Ok(section.figure(
        derivative::svg(&window, &chosen)?,
        format!(
            "Derivatives of {} as measured and as predicted by the device's own code, in standard z of the healthy \
             recordings: the lowest and the highest difference of the model.",
            series.name
        ),
    ))
}

fn middle(model: &Model<'_>, series: &Series, sample_rate_hz: f64, count: usize) -> Trace {
    let start = series.samples.len().saturating_sub(count) / 2;
    Trace::record(model, &series.samples, sample_rate_hz, start..start + count)
}

fn samples(series: &[Series]) -> Vec<&[f32]> {
    series.iter().map(|s| s.samples.as_slice()).collect()
}

/// A power of two that gives a recording several segments: fine lines, yet little scatter.
fn segment(series: &[Series]) -> usize {
    let shortest = series.iter().map(|s| s.samples.len()).min().unwrap_or(0);
    (1usize << (shortest / 3).max(1).ilog2()).clamp(64, 2048).min(shortest)
}

fn name(what: &str, series: &[Series]) -> String {
    match series {
        [] => what.to_owned(),
        [only] => format!("{what}: {}", only.name),
        [first, .., last] => format!("{what}: {} to {}", first.name, last.name),
    }
}
