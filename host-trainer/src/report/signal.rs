//! Sections on recordings: change between an early and a late time, prediction and residual.

use ballrace_core::model::Model;

use super::Section;
use super::settings::ReportSettings;
use crate::model::trace::Trace;
use crate::recording::input::Input;
use crate::recording::input::Series;
use crate::report::plot::{DrawError, density, derivative, envelope, residual};
use crate::signal::envelope::envelope_spectrum;
use crate::signal::spectrum::{band_of_most_gain, welch};

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Early and late recordings of a machine.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'i> {
    early: &'i [Series],
    late: &'i [Series],
    sample_rate_hz: f64,
    /// Ball-pass frequency of the outer race, Hz, if known.
    ball_pass_hz: Option<f64>,
}

impl<'i> Comparison<'i> {
    /// First and last recordings of an input; `None` for fewer than two.
    pub fn from_input(input: &'i Input, ball_pass_hz: Option<f64>) -> Option<Self> {
        let count = SETTINGS.averaged.min(input.series.len() / 2);
        let early = input.series.get(..count).filter(|s| !s.is_empty())?;
        let late = input.series.get(input.series.len() - count..)?;
        Some(Self { early, late, sample_rate_hz: input.sample_rate_hz, ball_pass_hz })
    }

    /// Section with power spectral densities and envelope spectra.
    ///
    /// # Errors
    /// Errors of the drawing library.
    pub fn spectra(&self) -> Result<Section, DrawError> {
        let section = Section::new("What has changed in the spectrum");
        let (early, late) = (samples(self.early), samples(self.late));
        let (early_name, late_name) = (name("early", self.early), name("late", self.late));
        let rate = self.sample_rate_hz;
        let segment = segment(&[self.early, self.late].concat());
        let (Some(a), Some(b)) = (welch(&early, rate, segment), welch(&late, rate, segment)) else {
            return Ok(section.paragraph("The recordings are too short for a spectrum."));
        };
        // An eighth of the band: wide enough for the fastest modulation of interest, and for one mode.
        let band = band_of_most_gain(&a, &b, rate / 16.0);
        let svg = density::svg((&early_name, &a), Some((&late_name, &b)), Some(&band))?;
        let section = section.figure(svg, format!(
            "Power spectral density (Welch, Hann window of {segment} samples, {:.1} Hz apart), averaged over the recordings named. \
             Shaded: of all bands of {:.0} Hz up to 80 % of Nyquist's frequency, the one with the largest increase from early to late.",
            a.step_hz, band.end - band.start
        ));
        let (Some(a), Some(b)) = (envelope_spectrum(&early, rate, &band), envelope_spectrum(&late, rate, &band)) else {
            return Ok(section);
        };
        let up_to = self.ball_pass_hz.map_or(1000.0, |rate| 6.5 * rate).min(0.5 * (band.end - band.start));
        let mark = self.ball_pass_hz.map(|rate| ("BPFO", rate));
        let svg = envelope::svg((&early_name, &a), (&late_name, &b), up_to, mark)?;
        let known = match self.ball_pass_hz {
            Some(_) => "Impacts at the ball-pass frequency give lines at the dashed marks.",
            None => "Repeated impacts give evenly spaced lines.",
        };
        Ok(section.figure(svg, format!(
            "Spectrum of the envelope in the shaded band, {:.0} to {:.0} Hz (analytic signal, Hann window, {:.1} Hz apart). {known}",
            band.start, band.end, a.step_hz
        )))
    }

    /// Section with prediction and residual of the model on an early and a late recording.
    ///
    /// # Errors
    /// Errors of the drawing library.
    pub fn prediction(&self, model: &Model<'_>) -> Result<Section, DrawError> {
        let (Some(early), Some(late)) = (self.early.first(), self.late.last()) else {
            return Ok(Section::new("What the model predicts"));
        };
        let of = |series: &Series| middle(model, series, self.sample_rate_hz, SETTINGS.window);
        let (a, b) = (of(early), of(late));
        let (name_a, name_b) = (format!("early: {}", early.name), format!("late: {}", late.name));
        let section = prediction(model, early, self.sample_rate_hz)?;
        Ok(section.figure(
            residual::svg((&name_a, &a), (&name_b, &b))?,
            "Residual, measured minus predicted, over its healthy standard deviation: RMS over the derivatives at each sample, \
             early above late on one scale. 20 dB are a factor of ten; dashed, the healthy level. Its mean square over a block \
             is the level that the monitor evaluates.",
        ))
    }
}

/// Section with the power spectral density of the recordings of a fit.
///
/// # Errors
/// Errors of the drawing library.
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

/// Section with measured and predicted derivatives in the middle of a recording.
///
/// # Errors
/// Errors of the drawing library.
pub fn prediction(model: &Model<'_>, series: &Series, sample_rate_hz: f64) -> Result<Section, DrawError> {
    let window = middle(model, series, sample_rate_hz, SETTINGS.close_window);
    let section = Section::new("What the model predicts");
    if window.residual.is_empty() {
        return Ok(section.paragraph(format!("{} is too short to show.", series.name)));
    }
    // The first and the last: the coarsest and the finest difference.
    let mut chosen = vec![0, window.names.len() - 1];
    chosen.dedup();
    chosen.truncate(SETTINGS.panels);
    Ok(section.figure(
        derivative::svg(&window, &chosen)?,
        format!(
            "Derivatives of {}, measured and predicted by the device's own code, in standard deviations of the healthy \
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

/// Segment length of Welch's method: a power of two that gives each recording several segments.
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
