//! Report of `ballrace calibrate` for a rig of one degree of freedom.

use super::held_out::{self, Quantity, Rigs};
use super::{Cell, Document, Section, Tone};
use crate::diagnose::result::{HeldOut, Location};
use crate::identify::force_balance::{HeldOutError, HeldOutTrace, Method, SdofCalibration};
use crate::recording::Recording;
use crate::report::plot::DrawError;
use crate::stats::format::significant;
use crate::stats::units::NamedUnit;

/// Report of a calibration; its pictures show a held-out recording.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(done: &SdofCalibration, recordings: &[Recording]) -> Result<Document, DrawError> {
    let held_out = done.held_out.as_ref();
    let about = match (recordings.len(), held_out) {
        (1, Some(h)) => format!("one recording; held out: {}", h.recordings),
        (count, Some(h)) => format!("{count} recordings; held out: {}", h.recordings),
        (count, None) => format!("{count} recordings; too short for a held-out part"),
    };
    let (tone, sentence) = verdict(done);
    let mut document = Document::new("A rig calibrated to a healthy machine", about, tone, sentence);
    if let (Some(trace), Some(first)) = (done.traces.first(), recordings.first()) {
        let section = Section::new("A held-out recording, measured and simulated").paragraph(
            "A free simulation of the whole stretch, driven by the recorded input alone from the initial state of the \
             smallest residual: small errors of force add up.",
        );
        let quantity = Quantity::for_channel(&done.rig, trace.channel);
        let rigs = Rigs { before: "the rig as it was", after: "the rig, calibrated" };
        let held = held(trace, first.sample_rate_hz);
        document = document.section(held_out::pictures(section, &held, quantity, rigs, &Location::default())?);
    }
    document = document.section(parameters(done));
    Ok(match held_out {
        Some(h) => document.section(errors(done, h)),
        None => document,
    })
}

/// Tone and sentence of the result.
pub fn verdict(done: &SdofCalibration) -> (Tone, String) {
    let Some(h) = &done.held_out else {
        return (
            Tone::Open,
            "The rig was calibrated; the recordings are too short to validate it on a held-out part.".into(),
        );
    };
    let tone = if h.balance_after_n < h.balance_before_n { Tone::Good } else { Tone::Open };
    let text = format!(
        "On held-out recordings the residual of the force balance is {} N with the calibrated rig; it was {} N before.",
        significant(h.balance_after_n, 3),
        significant(h.balance_before_n, 3)
    );
    (tone, text)
}

/// Estimation method in a sentence.
pub fn method(done: &SdofCalibration) -> &'static str {
    match done.method {
        Method::Simulation => "Fitted by simulation: its residual is within the sensor's noise.",
        Method::ForceBalance => {
            "Fitted by the force balance: the residual of the simulation exceeds the sensor's noise, so forces act that \
             the rig does not model."
        }
    }
}

fn held(trace: &HeldOutTrace, sample_rate_hz: f64) -> HeldOut {
    HeldOut {
        name: trace.recording.clone(),
        sample_rate_hz,
        measured: trace.measured.clone(),
        before: trace.before.clone(),
        after: trace.after.clone(),
    }
}

fn parameters(done: &SdofCalibration) -> Section {
    let row = |e: &crate::identify::force_balance::Estimate| {
        let [name, numbers @ ..] = NamedUnit::new(&e.key, e.value).row(e.guess, e.value, e.interval95);
        [Cell::text(name)].into_iter().chain(numbers.map(Cell::number)).collect()
    };
    let head = ["parameter", "before", "calibrated", "95 % interval"];
    let section =
        Section::new("Parameters").paragraph(method(done)).table("", &head, done.estimates.iter().map(row).collect());
    done.undetermined.iter().fold(section, |section, sentence| section.paragraph(format!("Undetermined: {sentence}.")))
}

fn errors(done: &SdofCalibration, h: &HeldOutError) -> Section {
    let number = |v: Option<f64>| Cell::number(v.map_or("diverges".into(), |v| significant(v, 3)));
    let rows = vec![
        vec![Cell::text("force balance, N"), number(Some(h.balance_before_n)), number(Some(h.balance_after_n))],
        vec![
            Cell::text(format!("simulation over {} s, unit of the sensor", significant(h.window_s, 2))),
            number(h.simulation_before),
            number(h.simulation_after),
        ],
    ];
    Section::new("Held-out recordings")
        .paragraph(format!(
            "Held out: {}. RMS of the residual, with parameters fitted to the other recordings. The standard deviation of \
             the sensor's noise is {}; the force balance covers frequencies below {} Hz.",
            h.recordings,
            significant(done.sensor_noise_std, 2),
            significant(done.cutoff_hz, 3)
        ))
        .table("", &["error", "before", "calibrated"], rows)
}
