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
use crate::stats::format::significant;

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
    let segment = SETTINGS.segment.min(held.measured.len());
    let spectra: Vec<Curve<'_>> = signals
        .iter()
        .filter_map(|(name, samples, color)| {
            let spectrum = welch(&[samples.as_slice()], held.sample_rate_hz, segment)?;
            // The mean was subtracted: its two bins hold nothing of the machine.
            let points = spectrum.points().skip(2).map(|(f, v)| (f, 10.0 * v.max(1e-30).log10())).collect();
            Some(Curve { name, points, color: *color })
        })
        .collect();
    let mut section = section;
    let marks = marks(location);
    let dashed = if marks.is_empty() { "" } else { "; dashed, the edges of bands with a mismatch" };
    if !spectra.is_empty() {
        let names = Names { x: "frequency, Hz", y: "density, dB re 1 (m/s²)²/Hz" };
        section = section.figure(
            comparison::svg(&spectra, 0.0..0.5 * held.sample_rate_hz, names, &marks)?,
            format!("{}: power spectral density{dashed}.", held.name),
        );
    }
    let shown = loudest(held);
    let range = shown.start as f64 / held.sample_rate_hz..shown.end as f64 / held.sample_rate_hz;
    let courses: Vec<Curve<'_>> =
        signals.iter().map(|(name, samples, color)| curve(held, name, samples, *color, &shown)).collect();
    let names = Names { x: "time, s", y: "acceleration, m/s²" };
    let caption = if held.before == held.after {
        format!("{}: the stretch in which the residual of {} is largest.", held.name, rigs.after)
    } else {
        format!("{}: the stretch in which {} improves most on {}.", held.name, rigs.after, rigs.before)
    };
    Ok(section.figure(comparison::svg(&courses, range, names, &[])?, caption))
}

fn marks(location: &Location) -> Vec<Mark> {
    let edges = |[low, high]: &[f64; 2]| {
        let name = format!("{} to {} Hz", significant(*low, 3), significant(*high, 3));
        [Mark { at: *low, name }, Mark { at: *high, name: String::new() }]
    };
    // More would hide the curves.
    location.frequency_hz.iter().take(3).flat_map(edges).collect()
}

/// Window in which the corrected rig gains most or, without a correction, the residual is largest.
fn loudest(held: &HeldOut) -> Range<usize> {
    let count = held.measured.len();
    let width = SETTINGS.zoom.min(count);
    let corrected = held.before != held.after;
    let gain = |from: usize| -> f64 {
        let square = |of: &[f64], k: usize| (held.measured[k] - of[k]).powi(2);
        let after = |k: usize| if corrected { square(&held.after, k) } else { 0.0 };
        (from..from + width).map(|k| square(&held.before, k) - after(k)).sum()
    };
    let starts = (0..=count - width).step_by((width / 2).max(1));
    let start = starts.max_by(|a, b| gain(*a).total_cmp(&gain(*b))).unwrap_or(0);
    start..start + width
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
