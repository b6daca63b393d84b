//! Table and JSON of a trace.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::stage::Stage;
use crate::timing::Flash;
use crate::trace::{CLOCKS, Counts, STAGES, Trace};

/// What a trace is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Wait states of the flash; 0 for none.
    pub wait_states: u32,
    /// How flash is read.
    pub flash: Flash,
}

/// JSON of a trace: instructions and cycles a sample, as mean of all, as mean of those that the model evaluates, and of the
/// worst.
pub fn json(trace: &Trace, setting: Setting) -> Value {
    let samples = trace.samples();
    let total = trace.total();
    let (evaluated, count) = trace.evaluated();
    let worst = samples.iter().max_by_key(|sample| sample.total(0));
    let numbers = |pick: &dyn Fn(&Counts) -> u64| {
        let mean = |sum: u64, count: usize| round(sum as f64 / count.max(1) as f64);
        json!({
            "mean": mean(pick(&total), samples.len()),
            "evaluated": mean(pick(&evaluated), count),
            "worst": worst.map_or(0, pick),
        })
    };
    let entry = |instructions: &dyn Fn(&Counts) -> u64, cycles: &dyn Fn(&Counts, usize) -> u64| {
        let mut value = json!({ "instructions": numbers(instructions) });
        let names = CLOCKS.iter().map(|(name, _)| *name).chain(["cycles_flash"]);
        for (clock, name) in names.enumerate().take(total.cycles.len()) {
            value[name] = numbers(&|counts| cycles(counts, clock));
        }
        value
    };
    let stages: serde_json::Map<_, _> = (0..STAGES)
        .map(|at| {
            let value = entry(&|c| c.instructions[at], &|c, clock| c.cycles.get(clock).map_or(0, |c| c[at]));
            (Stage::ALL[at].name().to_owned(), value)
        })
        .collect();
    let whole = entry(&|c| c.instructions.iter().sum(), &|c, clock| c.total(clock));
    let flash = match setting.flash {
        Flash::Plain => "plain",
        Flash::Prefetch => "prefetch",
        Flash::Cached => "cached",
    };
    json!({
        "samples": samples.len(),
        "evaluated_samples": count,
        "wait_states": setting.wait_states,
        "flash": flash,
        "total": whole,
        "stages": stages,
    })
}

fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// Table of a trace's JSON.
pub fn table(json: &Value) -> String {
    let with_flash = json["total"].get("cycles_flash").is_some();
    let mut text = format!(
        "{} samples; cycles a sample on a Cortex-M4F without wait states, [shortest, longest] by the manual's ranges",
        json["samples"],
    );
    if with_flash {
        let _ = write!(
            text,
            "; at the right with {} wait states, {} flash",
            json["wait_states"],
            json["flash"].as_str().unwrap_or("")
        );
    }
    let _ = write!(
        text,
        "\n{:12}{:>13}{:>10}{:>10}{:>10}{:>21}",
        "stage", "instructions", "cycles", "evaluated", "worst", "bounds of the mean"
    );
    text.push_str(if with_flash { "     flash     worst\n" } else { "\n" });
    let stages = json["stages"].as_object().into_iter().flatten().map(|(name, value)| (name.as_str(), value));
    for (name, row) in stages.chain([("total", &json["total"])]) {
        let number = |key: &str, of: &str| row[key][of].as_f64().unwrap_or(f64::NAN);
        let bounds = format!("[{:.0}, {:.0}]", number("cycles_low", "mean"), number("cycles_high", "mean"));
        let _ = write!(
            text,
            "{name:12}{:>13.0}{:>10.0}{:>10.0}{:>10.0}{bounds:>21}",
            number("instructions", "mean"),
            number("cycles", "mean"),
            number("cycles", "evaluated"),
            number("cycles", "worst"),
        );
        if with_flash {
            let _ = write!(text, "{:>10.0}{:>10.0}", number("cycles_flash", "mean"), number("cycles_flash", "worst"));
        }
        text.push('\n');
    }
    text
}
