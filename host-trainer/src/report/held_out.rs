//! Pictures of a held-out recording next to its simulation, before and after the correction.

use std::ops::Range;

use super::settings::ReportSettings;
use super::{Cell, Section};
use crate::diagnose::result::{HeldOut, Location};
use crate::identify::calibrate::distance::log_spectral;
use crate::report::plot::DrawError;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::marks::Mark;
use crate::report::plot::style::{EARLY, LATE, MEASURED};
use crate::rig::config::{Machine, Restoring, Rig};
use crate::signal::spectrum::welch;
use crate::stats::format::{capital, significant};

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Physical quantity of a held-out signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Position, m: compared over time.
    Position,
    /// Angle, rad: compared over time.
    Angle,
    /// Acceleration, m/s²: compared by its spectrum.
    Acceleration,
}

impl Quantity {
    /// Quantity of a rig's channel.
    pub fn for_channel(rig: &Rig, channel: &str) -> Self {
        match &rig.model {
            Machine::Sdof(machine) if channel == "q" => match machine.restoring {
                Restoring::Linear => Self::Position,
                Restoring::Pendulum => Self::Angle,
            },
            _ => Self::Acceleration,
        }
    }
}

/// Names of the two rigs in a picture.
#[derive(Clone, Copy, Debug)]
pub struct Rigs<'t> {
    /// Name of the rig before the correction.
    pub before: &'t str,
    /// Name of the rig after it.
    pub after: &'t str,
}

/// Section with the pictures of one recording added.
///
/// # Errors
/// Errors of the drawing library.
pub fn pictures(
    section: Section,
    held: &HeldOut,
    quantity: Quantity,
    rigs: Rigs<'_>,
    location: &Location,
) -> Result<Section, DrawError> {
    match quantity {
        Quantity::Position => course(section, held, rigs, ["position, m", "measured − simulated, m"]),
        Quantity::Angle => course(section, held, rigs, ["angle, rad", "measured − simulated, rad"]),
        Quantity::Acceleration => acceleration(section, held, rigs, location),
    }
}

fn course(section: Section, held: &HeldOut, rigs: Rigs<'_>, axes: [&str; 2]) -> Result<Section, DrawError> {
    let whole = 0..held.measured.len();
    let until = held.measured.len() as f64 / held.sample_rate_hz;
    let axis = |y| Names { x: "time, s", y };
    let [rms_before, rms_after] = errors(held);
    let (before, after) = (residual(held, &held.before), residual(held, &held.after));
    let names = [rigs.before, rigs.after].map(|rig| format!("residual of {rig}"));
    let mut courses = vec![
        curve(held, "measured", &held.measured, MEASURED, &whole),
        curve(held, rigs.after, &held.after, EARLY, &whole),
    ];
    let mut left = vec![curve(held, &names[1], &after, EARLY, &whole)];
    let mut caption = format!("{}: residual, RMS {}.", held.name, significant(rms_after, 3));
    if held.before != held.after {
        courses.insert(0, curve(held, rigs.before, &held.before, LATE, &whole));
        left.insert(0, curve(held, &names[0], &before, LATE, &whole));
        caption = format!(
            "{}: residual, RMS {} before and {} after.",
            held.name,
            significant(rms_before, 3),
            significant(rms_after, 3)
        );
    }
    let section = section
        .figure(
            comparison::svg(&courses, 0.0..until, axis(axes[0]), &[])?,
            format!("{}: measured and simulated.", held.name),
        )
        .figure(comparison::svg(&left, 0.0..until, axis(axes[1]), &[])?, caption);
    if rms_before < SETTINGS.enlarged_ratio * rms_after {
        return Ok(section);
    }
    // On the scale of the residual before, it is a line at zero.
    let svg = comparison::svg(&left[left.len() - 1..], 0.0..until, axis(axes[1]), &[])?;
    Ok(section.figure(svg, format!("{}: residual after, enlarged.", held.name)))
}

fn acceleration(section: Section, held: &HeldOut, rigs: Rigs<'_>, location: &Location) -> Result<Section, DrawError> {
    let mut signals = vec![
        ("measured", &held.measured, MEASURED),
        (rigs.before, &held.before, LATE),
        (rigs.after, &held.after, EARLY),
    ];
    if held.before == held.after {
        signals.remove(1);
    }
    let marks = marks(location);
    let dashed = if marks.is_empty() { "" } else { "; dashed, the edges of bands with a mismatch" };
    let nyquist_hz = 0.5 * held.sample_rate_hz;
    let whole = (0.0..nyquist_hz, SETTINGS.segment, "power spectral density");
    // Segments overlap by half.
    let long = 2 * held.measured.len() / (SETTINGS.enlarged_segments + 1);
    let enlarged = enlarged_hz(location, nyquist_hz).map(|range| (range, long.max(SETTINGS.segment), "enlarged"));
    let mut section = section;
    for (range, segment, what) in std::iter::once(whole).chain(enlarged) {
        let density = |samples| density_db(samples, held.sample_rate_hz, segment);
        let curves =
            signals.iter().map(|(name, samples, color)| Some(Curve { name, points: density(samples)?, color: *color }));
        let spectra: Vec<Curve<'_>> = curves.flatten().collect();
        if !spectra.is_empty() {
            let names = Names { x: "frequency, Hz", y: "density, dB re 1 (m/s²)²/Hz" };
            let picture = comparison::svg(&spectra, range, names, &marks)?;
            section = section.figure(picture, format!("{}: {what}{dashed}.", held.name));
        }
    }
    let Shown { samples: shown, why } = stretch(held);
    let range = shown.start as f64 / held.sample_rate_hz..shown.end as f64 / held.sample_rate_hz;
    let courses: Vec<Curve<'_>> =
        signals.iter().map(|(name, samples, color)| curve(held, name, samples, *color, &shown)).collect();
    let names = Names { x: "time, s", y: "acceleration, m/s²" };
    let caption = match why {
        Why::Residual => format!("{}: the stretch in which the residual of {} is largest.", held.name, rigs.after),
        Why::Gain => format!("{}: the stretch in which {} improves most on {}.", held.name, rigs.after, rigs.before),
        Why::Loudest => format!(
            "{}: the loudest stretch measured. {} meets spectrum and modulation, not the instants: compare heights and \
             intervals, not samples.",
            held.name,
            capital(rigs.after)
        ),
    };
    Ok(section.figure(comparison::svg(&courses, range, names, &[])?, caption))
}

/// Points of a power spectral density in dB over segments of at most some samples; `None` of too few samples.
fn density_db(samples: &[f64], sample_rate_hz: f64, segment: usize) -> Option<Vec<(f64, f64)>> {
    let spectrum = welch(&[samples], sample_rate_hz, segment.min(samples.len()))?;
    // The mean was subtracted: its two bins hold nothing of the machine.
    Some(spectrum.points().skip(2).map(|(f, v)| (f, 10.0 * v.max(1e-30).log10())).collect())
}

/// Range around the bands of a mismatch, as wide again on either side, where the spectrum up to some frequency hardly shows them.
fn enlarged_hz(location: &Location, nyquist_hz: f64) -> Option<Range<f64>> {
    let bands = location.frequency_hz.iter();
    let [low, high] = bands.copied().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    let range = (2.0 * low - high).max(0.0)..(2.0 * high - low).min(nyquist_hz);
    (range.end - range.start < SETTINGS.enlarged_share * nyquist_hz).then_some(range)
}

fn marks(location: &Location) -> Vec<Mark> {
    let edges = |[low, high]: &[f64; 2]| {
        let name = format!("{} to {} Hz", significant(*low, 3), significant(*high, 3));
        [Mark { at: *low, name }, Mark { at: *high, name: String::new() }]
    };
    // More would hide the curves.
    location.frequency_hz.iter().take(3).flat_map(edges).collect()
}

/// Stretch of a recording that is shown over time.
struct Shown {
    samples: Range<usize>,
    why: Why,
}

/// What a stretch is shown for.
enum Why {
    /// Largest residual of a rig that was not corrected.
    Residual,
    /// Largest gain of the correction.
    Gain,
    /// Largest measured signal: the correction does not lessen the residual, since the instants are not those measured.
    Loudest,
}

/// Window in which the correction gains most or, without one or where it gains nothing in time, what is measured is largest.
fn stretch(held: &HeldOut) -> Shown {
    let [before, after] = errors(held);
    let why = if held.before == held.after {
        Why::Residual
    } else if after < SETTINGS.gain * before {
        Why::Gain
    } else {
        // Of two signals that have nothing to do with each other either may err a little less.
        Why::Loudest
    };
    let square = |of: &[f64], k: usize| (held.measured[k] - of[k]).powi(2);
    let score = |k: usize| match why {
        Why::Residual => square(&held.before, k),
        Why::Gain => square(&held.before, k) - square(&held.after, k),
        Why::Loudest => held.measured[k].powi(2),
    };
    let count = held.measured.len();
    let width = SETTINGS.zoom.min(count);
    let total = |from: usize| (from..from + width).map(score).sum::<f64>();
    let starts = (0..=count - width).step_by((width / 2).max(1));
    let start = starts.max_by(|a, b| total(*a).total_cmp(&total(*b))).unwrap_or(0);
    Shown { samples: start..start + width, why }
}

/// Curve of a signal over some samples, thinned to minimum and maximum of each stretch if there are many.
fn curve<'t>(
    held: &HeldOut,
    name: &'t str,
    samples: &[f64],
    color: plotters::style::RGBColor,
    shown: &Range<usize>,
) -> Curve<'t> {
    let at = |k: usize| (k as f64 / held.sample_rate_hz, samples[k]);
    let stretch = shown.len().div_ceil(SETTINGS.points / 2).max(1);
    let points = if stretch <= 2 {
        shown.clone().map(at).collect()
    } else {
        let ends = |from: usize| {
            let inside = from..(from + stretch).min(shown.end);
            let least = inside.clone().min_by(|a, b| samples[*a].total_cmp(&samples[*b])).unwrap_or(from);
            let most = inside.max_by(|a, b| samples[*a].total_cmp(&samples[*b])).unwrap_or(from);
            [at(least.min(most)), at(least.max(most))]
        };
        shown.clone().step_by(stretch).flat_map(ends).collect()
    };
    Curve { name, points, color }
}

/// Residual: measured minus simulated.
fn residual(held: &HeldOut, of: &[f64]) -> Vec<f64> {
    held.measured.iter().zip(of).map(|(m, s)| m - s).collect()
}

/// Root mean square.
fn rms(samples: &[f64]) -> f64 {
    (samples.iter().map(|v| v * v).sum::<f64>() / samples.len().max(1) as f64).sqrt()
}

/// RMS of measured minus simulated, before and after.
pub fn errors(held: &HeldOut) -> [f64; 2] {
    [rms(&residual(held, &held.before)), rms(&residual(held, &held.after))]
}

/// Head and rows of a table of RMS errors and, of accelerations, log-spectral distances.
pub fn table(held: &[HeldOut], quantity: Quantity) -> (Vec<&'static str>, Vec<Vec<Cell>>) {
    let spectral = quantity == Quantity::Acceleration;
    let mut head = vec!["recording", "error before, RMS", "after, RMS"];
    if spectral {
        head.extend(["log-spectral distance before, dB", "after, dB"]);
    }
    let row = |h: &HeldOut| {
        let mut row = vec![Cell::text(&h.name)];
        row.extend(errors(h).map(|v| Cell::number(significant(v, 3))));
        if spectral {
            let distance = |of: &[f64]| log_spectral(&h.measured, of, h.sample_rate_hz);
            let text = |d: Option<f64>| Cell::number(d.map_or("–".into(), |d| format!("{d:.2}")));
            row.extend([text(distance(&h.before)), text(distance(&h.after))]);
        }
        row
    };
    (head, held.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bands that the whole spectrum hardly shows are drawn enlarged, wide ones not.
    #[test]
    fn narrow_bands_are_enlarged() {
        let within = |bands: &[[f64; 2]]| {
            let location = Location { frequency_hz: bands.to_vec(), ..Location::default() };
            enlarged_hz(&location, 12_800.0)
        };
        assert_eq!(within(&[[50.0, 80.0], [90.0, 110.0]]), Some(0.0..170.0));
        assert_eq!(within(&[[12_700.0, 12_790.0]]), Some(12_610.0..12_800.0));
        assert_eq!(within(&[[50.0, 80.0], [2000.0, 2100.0]]), None);
        assert_eq!(within(&[]), None);
    }

    /// A burst in the second half is shown where the correction meets it; of a correction of other instants the loudest
    /// stretch measured is, and the caption does not speak of a gain.
    #[test]
    fn stretch_is_what_its_caption_says() {
        let count = 4 * SETTINGS.zoom;
        let burst = |at: usize| -> Vec<f64> {
            (0..count).map(|k| if (at..at + 40).contains(&k) { 5.0 } else { (0.3 * k as f64).sin() }).collect()
        };
        let caption = |after: Vec<f64>| {
            let (measured, before) = (burst(3 * SETTINGS.zoom), burst(count));
            let held = HeldOut { name: "r04".into(), sample_rate_hz: 25_600.0, measured, before, after };
            let shown = stretch(&held);
            assert!(shown.samples.contains(&(3 * SETTINGS.zoom)), "{:?}", shown.samples);
            let rigs = Rigs { before: "the rig", after: "the corrected rig" };
            let section =
                pictures(Section::new(""), &held, Quantity::Acceleration, rigs, &Location::default()).unwrap();
            format!("{section:?}")
        };
        assert!(caption(burst(3 * SETTINGS.zoom)).contains("in which the corrected rig improves most on the rig"));
        let apart = caption(burst(SETTINGS.zoom));
        assert!(apart.contains("the loudest stretch measured. The corrected rig meets") && !apart.contains("improves"));
        assert!(caption(burst(count)).contains("the residual of the corrected rig is largest"));
    }
}
