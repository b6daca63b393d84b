//! Report of a fit as text for a terminal.

use std::fmt::Write;

use super::report::{EquationReport, Report};
use super::score::{NullScores, Scores};

/// Text of the report, with at most `most_terms` terms of each equation.
pub fn report(report: &Report, most_terms: usize) -> String {
    let t = &report.training;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{} recordings fitted, {} for validation, {} held out{}; channel {}, {} Hz",
        t.recordings.len(),
        t.validation.len(),
        t.held_out.len(),
        if t.within_recording { " (the last two fifths of the only recording)" } else { "" },
        t.channel.as_deref().unwrap_or("-"),
        t.sample_rate_hz
    );
    let training = match (t.steps, t.stopped_early) {
        (Some(steps), Some(true)) => format!(", {steps} steps, stopped early"),
        (Some(steps), _) => format!(", {steps} steps"),
        _ => String::new(),
    };
    let _ = writeln!(out, "{}; {}; {} functions{training}", t.solver, t.states, t.functions);
    for entered in &t.entered {
        let _ = writeln!(out, "{}", entered.line());
    }
    out += &scores(&report.scores);
    let _ = writeln!(out, "\nverdict: {}", report.verdict.words);
    for equation in &report.equations {
        let _ = writeln!(out, "\n{}{}", sum(equation, most_terms), held_out(equation));
        for term in equation.terms.iter().take(most_terms) {
            let physical = term.physical.map_or(String::new(), |p| format!("   physical {p:>12.5e}"));
            let share = 100.0 * term.share;
            let _ = writeln!(out, "    {:14}{:>12.5}{physical}   share {share:>6.2} %", term.name, term.coefficient);
        }
    }
    out += &path(report);
    let d = &report.diagnosis;
    let noise = report.terms_noise_would_keep.map_or(String::new(), |n| {
        format!(
            ", {:.1} an equation, where the null keeps {n:.1}",
            report.terms_kept as f64 / report.equations.len().max(1) as f64
        )
    });
    let _ = writeln!(
        out,
        "\n{} coefficients kept{noise}; condition number {:.3e} (of the terms used {:.3e})",
        report.terms_kept, d.condition_number, d.condition_number_used
    );
    let _ = writeln!(out, "\nmonitor: {}", report.monitor.basis());
    for (a, b, r) in d.inseparable.iter().take(10) {
        let name = |term: &usize| t.terms.get(*term).map_or("?", String::as_str);
        let _ = writeln!(out, "inseparable: {} and {} (correlation {r:.4})", name(a), name(b));
    }
    if d.inseparable.len() > 10 {
        let _ = writeln!(out, "… and {} more such pairs (--json has all)", d.inseparable.len() - 10);
    }
    out
}

/// Table of the path from all terms to few.
fn path(report: &Report) -> String {
    let points = report.path.chunk_by(|a, b| a.terms == b.terms).filter_map(|equal| equal.first());
    let rows: String = points
        .map(|p| {
            let (validation, held_out) = (optional(p.validation), optional(p.held_out));
            format!("{:>10.1e}{:>8}{validation:>12}{held_out:>10}\n", p.threshold, p.terms)
        })
        .collect();
    if rows.is_empty() {
        return rows;
    }
    format!("\n{:>10}{:>8}{:>12}{:>10}\n{rows}", "threshold", "terms", "validation", "held out")
}

/// Table of the four scores.
pub fn scores(s: &Scores) -> String {
    let row = |name: &str, score: &str, null: &str| format!("{name:32}{score:>10}{null:>20}\n");
    let number = |score: f64| format!("{score:.4}");
    [
        "\n".to_owned(),
        row("R²", "", "null"),
        row("in sample, derivatives (mean)", &number(s.in_sample.mean()), &null(s, |n| Some(n.in_sample))),
        row("held out, derivatives (mean)", &number(s.held_out.mean()), &null(s, |n| Some(n.held_out))),
        row("causal, next sample, held out", &optional(s.causal.next_sample), &null(s, |n| n.causal)),
    ]
    .concat()
}

/// Mean and standard deviation of one score over the surrogates; "-" without any.
pub fn null(scores: &Scores, pick: fn(&NullScores) -> Option<f64>) -> String {
    let values: Vec<f64> = scores.null.iter().filter_map(pick).collect();
    if values.is_empty() {
        return "-".to_owned();
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    format!("{mean:.4} ± {:.4}", variance.sqrt())
}

/// An optional score; "-" if missing.
pub fn optional(score: Option<f64>) -> String {
    score.map_or("-".to_owned(), |v| format!("{v:.4}"))
}

/// Equation as text, such as `dz0/dt = 0.12 z1 − 0.3 z0^2 + … 4 more`.
pub fn sum(equation: &EquationReport, most_terms: usize) -> String {
    let shown = &equation.terms[..most_terms.min(equation.terms.len())];
    let mut sum = String::new();
    for (n, term) in shown.iter().enumerate() {
        sum += match (n, term.coefficient < 0.0) {
            (0, false) => "",
            (0, true) => "−",
            (_, false) => " + ",
            (_, true) => " − ",
        };
        let name = if term.name == "1" { String::new() } else { format!(" {}", term.name) };
        let _ = write!(sum, "{:.4}{name}", term.coefficient.abs());
    }
    let left = equation.terms.len() - shown.len();
    let rest = if left > 0 { format!(" + … {left} more") } else { String::new() };
    format!("{} = {}{rest}", equation.name, if sum.is_empty() { "0" } else { &sum })
}

fn held_out(equation: &EquationReport) -> String {
    equation.r_squared_held_out.map_or(String::new(), |r| format!("   (held-out R² {r:.4})"))
}
