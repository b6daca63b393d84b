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

/// JSON of a trace: instructions and cycles a sample; `typical` is the median sample, one that the model evaluates.
pub fn json(trace: &Trace, setting: Setting) -> Value {
    let samples = trace.samples();
    let total = trace.total();
    let typical = at_rank(samples, samples.len() / 2);
    let worst = at_rank(samples, samples.len().saturating_sub(1));
    let mean = |sum: u64| sum as f64 / samples.len().max(1) as f64;
    let of = |counts: Option<&Counts>, pick: &dyn Fn(&Counts) -> u64| counts.map_or(0, pick);
    let mut stages = serde_json::Map::new();
    for at in 0..STAGES {
        let value = entry(
            mean(total.instructions[at]),
            [of(typical, &|c| c.instructions[at]), of(worst, &|c| c.instructions[at])],
            &|clock| mean(total.cycles.get(clock).map_or(0, |c| c[at])),
            &|clock| [typical, worst].map(|c| of(c, &|c| c.cycles.get(clock).map_or(0, |c| c[at]))),
            total.cycles.len(),
        );
        stages.insert(Stage::ALL[at].name().into(), value);
    }
    let sum = |c: &Counts| c.instructions.iter().sum();
    let whole = entry(
        mean(sum(&total)),
        [of(typical, &sum), of(worst, &sum)],
        &|clock| mean(total.total(clock)),
        &|clock| [typical, worst].map(|c| of(c, &|c| c.total(clock))),
        total.cycles.len(),
    );
    let flash = match setting.flash {
        Flash::Plain => "plain",
        Flash::Prefetch => "prefetch",
        Flash::Cached => "cached",
    };
    json!({
        "samples": samples.len(),
        "wait_states": setting.wait_states,
        "flash": flash,
        "total": whole,
        "stages": stages,
    })
}

/// The sample of this rank by nominal cycles.
fn at_rank(samples: &[Counts], rank: usize) -> Option<&Counts> {
    let mut order: Vec<_> = samples.iter().collect();
    order.sort_by_key(|sample| sample.total(0));
    order.get(rank).copied()
}

fn entry(
    instructions: f64,
    [typical, worst]: [u64; 2],
    mean: &dyn Fn(usize) -> f64,
    ranked: &dyn Fn(usize) -> [u64; 2],
    clocks: usize,
) -> Value {
    let mut value = json!({ "instructions": { "mean": round(instructions), "typical": typical, "worst": worst } });
    let names = CLOCKS.iter().map(|(name, _)| *name).chain(["cycles_flash"]);
    for (clock, name) in names.enumerate().take(clocks) {
        let [typical, worst] = ranked(clock);
        value[name] = json!({ "mean": round(mean(clock)), "typical": typical, "worst": worst });
    }
    value
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
        "stage", "instructions", "cycles", "typical", "worst", "bounds of the mean"
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
            number("cycles", "typical"),
            number("cycles", "worst"),
        );
        if with_flash {
            let _ = write!(text, "{:>10.0}{:>10.0}", number("cycles_flash", "mean"), number("cycles_flash", "worst"));
        }
        text.push('\n');
    }
    text
}
