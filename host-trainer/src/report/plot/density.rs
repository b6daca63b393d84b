//! Power spectral densities, early and late.

use std::ops::Range;

use super::DrawError;
use super::style::{self, Axes, EARLY, Entry, HEIGHT, INK, LATE};
use crate::signal::spectrum::Spectrum;

/// Density with its name.
pub type Named<'s> = (&'s str, &'s Spectrum);

/// Picture of the early and, if there is one, the late density, dB re 1 (m/s²)²/Hz; the band of the
/// envelope is shaded.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(early: Named<'_>, late: Option<Named<'_>>, band_hz: Option<&Range<f64>>) -> Result<String, DrawError> {
    // The mean was subtracted: its bin holds nothing of the machine.
    let decibels = |s: &Spectrum| s.points().skip(1).map(|(f, v)| (f, 10.0 * v.log10())).collect::<Vec<_>>();
    let early_points = decibels(early.1);
    let late_points = late.map(|(name, spectrum)| (name, decibels(spectrum)));
    let all = || early_points.iter().chain(late_points.iter().flat_map(|(_, points)| points));
    let y = style::range(all().map(|(_, v)| *v), 0.06).ok_or_else(DrawError::empty)?;
    let x = 0.0..all().map(|(f, _)| *f).fold(0.0, f64::max);
    let mut legend: Vec<Entry<'_>> = vec![(early.0, EARLY)];
    legend.extend(late_points.iter().map(|(name, _)| (*name, LATE)));
    style::picture(HEIGHT, |area| {
        let axes = Axes { x, y: y.clone(), x_name: "frequency, Hz", y_name: "density, dB re 1 (m/s²)²/Hz" };
        let mut chart = style::chart(area, &axes, &legend)?;
        if let Some(band) = band_hz {
            style::shade(&mut chart, band.clone(), y.clone(), INK)?;
        }
        style::line(&mut chart, early_points.iter().copied(), style::stroke(EARLY, 2))?;
        match &late_points {
            Some((_, points)) => style::line(&mut chart, points.iter().copied(), style::stroke(LATE, 2)),
            None => Ok(()),
        }
    })
}
