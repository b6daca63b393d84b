//! Report of `ballrace fit`.

use super::{Document, model, signal};
use crate::model::export;
use crate::model::fit::Fitted;
use crate::model::trace::Trace;
use crate::recording::input::Input;
use crate::report::plot::DrawError;
use crate::stats::format::capital;

/// Report of a fit and its recordings.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(fitted: &Fitted, input: &Input) -> Result<Document, DrawError> {
    let (view, report) = (fitted.model.view(), &fitted.report);
    let about = format!("{} recordings, channel {}, {} Hz", input.series.len(), input.channel, input.sample_rate_hz);
    let mut document = Document::new("A model of the healthy machine", about, model::tone(report), verdict(fitted))
        .section(model::scores(report));
    // A held-out recording shows the quality of the model; a single recording is shown itself.
    let held_out = input.series.iter().find(|s| report.training.held_out.contains(&s.name));
    if let Some(series) = held_out.or(input.series.first()) {
        document = document.section(signal::prediction(&view, series, input.sample_rate_hz)?);
    }
    document = document.sections(model::path(report)?);
    let names = Trace::record(&view, &[], input.sample_rate_hz, 0..0).names;
    Ok(document.sections([
        model::derivatives(report, &names),
        model::equations(report),
        signal::density_of(&input.series, input.sample_rate_hz)?,
        model::sizes(&export::sizes(&view)),
        model::training(report),
    ]))
}

/// Verdict of the fit as a sentence.
fn verdict(fitted: &Fitted) -> String {
    format!("{}.", capital(&fitted.report.verdict.words))
}
