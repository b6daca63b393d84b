//! Sections on a fitted model.

use super::settings::ReportSettings;
use super::{Cell, Section, Tone};
use crate::model::export::Sizes;
use crate::model::fit::report::Report;
use crate::model::fit::text;
use crate::model::fit::verdict::kept;
use crate::model::path::PathPoint;
use crate::report::plot::DrawError;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::marks::Mark;
use crate::report::plot::style::{EARLY, LATE, MEASURED};

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Tone of a fit's verdict: open for a model that is not beyond its null, as its residual may still
/// show a fault.
pub fn tone(report: &Report) -> Tone {
    if report.verdict.beyond_null { Tone::Good } else { Tone::Open }
}

/// The four scores with their meaning.
pub fn scores(report: &Report) -> Section {
    let s = &report.scores;
    let row = |name: &str, value: String, null: String, meaning: &str| {
        vec![Cell::text(name), Cell::number(value), Cell::number(null), Cell::text(meaning)]
    };
    let null = text::null(s, |n| Some(n.held_out));
    let (mean, spread) = null.split_once(" ± ").map_or((null.as_str(), None), |(mean, spread)| (mean, Some(spread)));
    let rows = vec![
        row(
            "in sample",
            format!("{:.4}", s.in_sample.mean()),
            text::null(s, |n| Some(n.in_sample)),
            "Fit to the recordings that the model was fitted to: the usual and most optimistic figure.",
        ),
        row(
            "held out",
            format!("{:.4}", s.held_out.mean()),
            text::null(s, |n| Some(n.held_out)),
            "Fit to recordings that no coefficient, threshold or choice comes from: the loss against “in sample” is overfitting.",
        ),
        row(
            "causal",
            text::optional(s.causal.next_sample),
            text::null(s, |n| n.causal),
            "Prediction of the next sample from past samples only, on held-out recordings: the one figure that no algebra of differences can raise.",
        ),
        row(
            "null",
            mean.to_owned(),
            spread.map_or(String::new(), |spread| format!("± {spread}")),
            &format!(
                "Held-out figure of the same fit to surrogates with {}: a model has found dynamics only where it exceeds this.",
                kept(s.null_kind)
            ),
        ),
    ];
    Section::new("Four scores")
        .paragraph(format!(
            "R² of the predicted derivatives (mean over {}), and of the next sample where causal; 1 is perfect, 0 is no better than the mean. \
             Null: mean ± standard deviation over {} surrogate fits.",
            s.in_sample.derivatives.len(),
            s.null.len()
        ))
        .table("", &["score", "R²", "of surrogates", "meaning"], rows)
}

/// Sparse equations, the terms of most power first.
pub fn equations(report: &Report) -> Section {
    let t = &report.training;
    let shown = report.equations.iter().take(SETTINGS.equations);
    let lines = shown.map(|equation| text::sum(equation, SETTINGS.terms)).collect();
    let variables = match report.equations.first().is_some_and(|e| e.r_squared_held_out.is_none()) {
        true => "z are the latent variables of the encoder; the decoder maps their rates to derivatives",
        false => "z are the scaled virtual states",
    };
    Section::new("Sparse equations")
        .paragraph(format!(
            "{} coefficients kept of {}; {variables}. {}; {}. The terms of most power first, at most {} an equation.",
            report.terms_kept,
            t.functions * report.equations.len(),
            t.solver,
            t.states,
            SETTINGS.terms
        ))
        .equations(lines)
}

/// Memory and operations of the model on the device.
pub fn sizes(sizes: &Sizes) -> Section {
    let row = |name: &str, value: usize, unit: &str| vec![Cell::text(name), Cell::number(value), Cell::text(unit)];
    let rows = vec![
        row("model in flash", sizes.flash_bytes, "bytes"),
        row("scratch in RAM", sizes.ram_bytes, "bytes"),
        row("multiply-adds", sizes.multiply_adds, "a sample"),
        row("sigmoids", sizes.sigmoids, "a sample"),
        row("sines and cosines", sizes.sines, "a sample"),
        row("library terms", sizes.terms, "a sample"),
        row("coefficients", sizes.coefficients, "not zero"),
    ];
    Section::new("On the device").table("", &[], rows)
}

/// Data and options of the fit.
pub fn training(report: &Report) -> Section {
    let (t, m) = (&report.training, &report.monitor);
    let row = |name: &str, value: String| vec![Cell::text(name), Cell::text(value)];
    let within = if t.within_recording { " (the last two fifths of the only one)" } else { "" };
    let mut rows = vec![
        row(
            "recordings",
            format!(
                "{} fitted, {} for validation, {} held out{within}",
                t.recordings.len(),
                t.validation.len(),
                t.held_out.len()
            ),
        ),
        row("channel", t.channel.clone().unwrap_or_else(|| "-".into())),
        row("sample rate", format!("{} Hz", t.sample_rate_hz)),
        row("range", format!("{:.2} to {:.2} m/s²", t.range_m_per_s2.0, t.range_m_per_s2.1)),
        row("solver", t.solver.clone()),
        row("states", t.states.clone()),
        row("seed", t.seed.to_string()),
    ];
    if let Some(steps) = t.steps {
        let early = if t.stopped_early == Some(true) { ", stopped early" } else { "" };
        rows.push(row("gradient steps", format!("{steps}{early}")));
    }
    rows.extend(t.entered.iter().map(|e| row("library", e.line())));
    rows.push(row(
        "healthy level",
        format!(
            "{:.3} times or divided by {:.3} over {} blocks of {} samples (mean squared residual in healthy standard deviations)",
            m.healthy_mean,
            m.healthy_spread.exp(),
            m.healthy_blocks,
            m.block
        ),
    ));
    rows.push(row("limit", m.basis()));
    rows.push(row("condition number", format!("{:.2e} of the library", report.diagnosis.condition_number)));
    Section::new("The fit").table("", &[], rows)
}

/// R² of each derivative.
pub fn derivatives(report: &Report, names: &[String]) -> Section {
    let s = &report.scores;
    let rows = names.iter().zip(s.in_sample.derivatives.iter().zip(&s.held_out.derivatives));
    let rows = rows.map(|(name, (a, b))| {
        vec![Cell::text(name.clone()), Cell::number(format!("{a:.4}")), Cell::number(format!("{b:.4}"))]
    });
    Section::new("Each derivative").table(
        "R² of each predicted difference of the acceleration",
        &["derivative", "in sample", "held out"],
        rows.collect(),
    )
}

/// Score against number of terms: the Pareto front; `None` for a report without a path.
///
/// # Errors
/// Errors of the drawing library.
pub fn path(report: &Report) -> Result<Option<Section>, DrawError> {
    let place = |terms: usize| (terms.max(1) as f64).log10();
    let curve = |name, color, of: fn(&PathPoint) -> Option<f64>| {
        let mut points: Vec<(f64, f64)> = report.path.iter().filter_map(|p| Some((place(p.terms), of(p)?))).collect();
        points.reverse();
        Curve { name, points, color }
    };
    let (Some(most), Some(least)) = (report.path.first(), report.path.last()) else { return Ok(None) };
    let x = place(least.terms) - 0.05..place(most.terms) + 0.05;
    let mut curves = vec![curve("validation", LATE, |p| p.validation), curve("held out", EARLY, |p| p.held_out)];
    let null: Vec<f64> = report.scores.null.iter().map(|null| null.held_out).collect();
    if !null.is_empty() {
        let mean = null.iter().sum::<f64>() / null.len() as f64;
        let points = vec![(x.start, mean), (x.end - 1e-9, mean)];
        curves.push(Curve { name: "held out, null", points, color: MEASURED });
    }
    let chosen = Mark { at: place(report.terms_kept), name: format!("{} terms", report.terms_kept) };
    let svg = comparison::svg(&curves, x, Names { x: "terms, log₁₀", y: "R² of the derivatives" }, &[chosen])?;
    Ok(Some(Section::new("Score against number of terms").figure(
        svg,
        "Each point is a model with the terms that are worth more than a growing threshold. Unless a threshold is stated, the fewest terms within one standard error of the best on the validation recordings are chosen; the held-out recordings choose nothing.",
    )))
}
