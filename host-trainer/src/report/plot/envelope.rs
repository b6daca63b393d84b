//! Envelope spectra, early and late.

use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::density::Named;
use super::style::{self, ALARM, Axes, EARLY, HEIGHT, LATE};

/// Picture of both envelope spectra up to a frequency; harmonics of `mark` are marked.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(early: Named<'_>, late: Named<'_>, up_to_hz: f64, mark: Option<(&str, f64)>) -> Result<String, DrawError> {
    let points = |named: Named<'_>| named.1.points().skip(1).take_while(|(f, _)| *f <= up_to_hz).collect::<Vec<_>>();
    let (early_points, late_points) = (points(early), points(late));
    let all = || early_points.iter().chain(&late_points);
    let top = all().map(|(_, v)| *v).filter(|v| v.is_finite()).fold(0.0, f64::max);
    if top <= 0.0 {
        return Err(DrawError::empty());
    }
    let top = 1.18 * top;
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: 0.0..up_to_hz, y: 0.0..top, x_name: "frequency, Hz", y_name: "envelope amplitude, m/s²" };
        let mut chart = style::chart(area, &axes, &[(early.0, EARLY), (late.0, LATE)])?;
        if let Some((name, rate)) = mark {
            let harmonics = (1..).map(|k| (k, f64::from(k) * rate)).take_while(|(_, f)| *f < up_to_hz);
            for (k, f) in harmonics {
                style::dashed(&mut chart, (f, 0.0), (f, top), ALARM)?;
                let text = if k == 1 { format!("{name} {f:.1} Hz") } else { format!("{k}×") };
                style::word(&mut chart, &text, (f + 0.004 * up_to_hz, 0.985 * top), HPos::Left, ALARM)?;
            }
        }
        style::line(&mut chart, early_points.iter().copied(), style::stroke(EARLY, 2))?;
        style::line(&mut chart, late_points.iter().copied(), style::stroke(LATE, 2))
    })
}
