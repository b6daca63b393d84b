//! Fits the costs of `ballrace budget` to traces of the device, or holds its predictions against traces of other sizes.
//!
//! `cargo run --release -p ballrace --example budget_costs -- fit|check DIR`, after `firmware-sim/cycles/budget.sh DIR`.
//! `fit` prints the tables of `host-trainer/src/model/budget/settings.rs`; `check` fails where a prediction is more than
//! 5 % off.

use std::error::Error;
use std::fs;
use std::path::Path;

use ballrace::model::budget::{self, BudgetConfig, Functions, Stage, Work};
use ballrace::model::file;
use serde_json::Value;

/// Greatest error that `check` accepts, what issue and contract ask for.
const TOLERANCE: f64 = 0.05;
/// Wait states of the traces.
const WAIT_STATES: u32 = 5;
/// Rounds of the fit. Not tuned: chosen by hand.
const ROUNDS: usize = 200_000;

/// A model with its trace.
struct Traced {
    name: String,
    bytes: Vec<u8>,
    work: Vec<(Work, f64)>,
    trace: Value,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["fit", directory] => fit(&Path::new(directory).join("fit")),
        ["check", directory] => check(&Path::new(directory).join("check")),
        _ => Err("usage: budget_costs fit|check DIR".into()),
    }
}

fn read(folder: &Path, functions: &str) -> Result<Vec<Traced>, Box<dyn Error>> {
    let mut paths: Vec<_> = fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "bin"));
    paths.sort();
    let traced = paths.iter().map(|path| {
        let (model, _) = file::read(path)?;
        let trace = serde_json::from_str(&fs::read_to_string(path.with_extension(format!("{functions}.json")))?)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Traced { name, bytes: model.bytes().to_vec(), work: budget::work(&model.view()), trace })
    });
    traced.collect()
}

/// The four numbers of a cost, of a stage in a trace.
fn measured(trace: &Value, stage: Stage) -> [f64; 4] {
    let stage = &trace["stages"][stage.name()];
    let of = |key: &str, sample: &str| stage[key][sample].as_f64().unwrap_or(f64::NAN);
    let waiting = of("cycles_flash", "evaluated") - of("cycles", "evaluated");
    let worst = of("cycles", "worst").max(of("cycles", "evaluated"));
    [of("instructions", "evaluated"), of("cycles", "evaluated"), worst, waiting / f64::from(WAIT_STATES)]
}

fn fit(folder: &Path) -> Result<(), Box<dyn Error>> {
    let exact = read(folder, "exact")?;
    let approx = read(folder, "approx")?;
    for (name, traced) in [("EXACT", &exact), ("APPROX", &approx)] {
        println!("const {name}_MEMORY: Memory = {};", memory(traced));
    }
    for work in Work::ALL {
        let [exact, approx] = [&exact, &approx].map(|traced| cost(*work, traced).map(|c| format!("{c:.2}")).join(", "));
        println!("    Row {{ work: Work::{work:?}, exact: [{exact}], approx: [{approx}] }},");
    }
    Ok(())
}

/// Memory beside the model's, the greatest of all.
fn memory(traced: &[Traced]) -> String {
    let number = |value: &Value| value.as_u64().unwrap_or(0);
    let most = |of: &dyn Fn(&Traced) -> Option<u64>| traced.iter().filter_map(of).max().unwrap_or(0);
    let code = most(&|t| number(&t.trace["flash_bytes"]).checked_sub(t.bytes.len() as u64));
    let statics = most(&|t| number(&t.trace["static_bytes"]).checked_sub(number(&t.trace["image"]["scratch_bytes"])));
    let stack = |kind: Work| {
        most(&|t| t.work.iter().any(|(work, _)| *work == kind).then(|| number(&t.trace["image"]["stack_bytes"])))
    };
    let [differences, kalman, windows] = [Work::DifferencesSample, Work::KalmanSample, Work::WindowSample].map(stack);
    format!(
        "Memory {{ code_bytes: {code}, static_bytes: {statics}, stack_differences: {differences}, \
         stack_kalman: {kalman}, stack_windows: {windows} }}"
    )
}

/// Cost of a kind of work: least squares of its stage over all models, relative to each model's whole, no cost negative.
fn cost(work: Work, traced: &[Traced]) -> [f64; 4] {
    let stage = work.stage();
    let kinds: Vec<Work> = Work::ALL.iter().copied().filter(|other| other.stage() == stage).collect();
    [0, 1, 2, 3].map(|quantity| {
        let rows: Vec<(Vec<f64>, f64)> = traced
            .iter()
            .map(|t| {
                let whole = t.trace["total"]["cycles"]["evaluated"].as_f64().unwrap_or(f64::NAN);
                let count = |kind: &Work| t.work.iter().find(|(work, _)| work == kind).map_or(0.0, |(_, n)| *n);
                (kinds.iter().map(|kind| count(kind) / whole).collect(), measured(&t.trace, stage)[quantity] / whole)
            })
            .collect();
        let found = non_negative(&rows, kinds.len());
        kinds.iter().zip(found).find(|(kind, _)| **kind == work).map_or(0.0, |(_, cost)| cost)
    })
}

/// Non-negative least squares by cyclic coordinate descent.
fn non_negative(rows: &[(Vec<f64>, f64)], columns: usize) -> Vec<f64> {
    let mut found = vec![0.0; columns];
    let mut residual: Vec<f64> = rows.iter().map(|(_, value)| *value).collect();
    let norms: Vec<f64> = (0..columns).map(|j| rows.iter().map(|(row, _)| row[j] * row[j]).sum()).collect();
    for _ in 0..ROUNDS {
        for j in (0..columns).filter(|j| norms[*j] > 0.0) {
            let slope: f64 = rows.iter().zip(&residual).map(|((row, _), r)| row[j] * r).sum();
            let next = (found[j] + slope / norms[j]).max(0.0);
            rows.iter().zip(&mut residual).for_each(|((row, _), r)| *r -= row[j] * (next - found[j]));
            found[j] = next;
        }
    }
    found
}

fn check(folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut worst = 0.0_f64;
    println!("model functions  quantity          predicted     traced   error");
    for (name, functions) in [("exact", Functions::Exact), ("approx", Functions::Approx)] {
        for traced in read(folder, name)? {
            let (model, _) = file::read(&folder.join(format!("{}.bin", traced.name)))?;
            let predict = |wait_states| {
                budget::budget(&model.view(), BudgetConfig { functions, wait_states, ..BudgetConfig::default() })
            };
            let (ideal, waiting) = (predict(0), predict(WAIT_STATES));
            let total = |key: &str, of: &str| traced.trace["total"][key][of].as_f64().unwrap_or(f64::NAN);
            let bytes = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
            for (quantity, predicted, found) in [
                ("instructions", ideal.instructions, total("instructions", "evaluated")),
                ("cycles", ideal.cycles, total("cycles", "evaluated")),
                ("worst cycles", ideal.worst_cycles, total("cycles", "worst")),
                ("cycles, flash", waiting.cycles, total("cycles_flash", "evaluated")),
                ("flash, bytes", ideal.flash_bytes as f64, bytes(&traced.trace["flash_bytes"])),
                ("static, bytes", ideal.static_bytes as f64, bytes(&traced.trace["static_bytes"])),
                ("stack, bytes", ideal.stack_bytes as f64, bytes(&traced.trace["image"]["stack_bytes"])),
            ] {
                let error = predicted / found - 1.0;
                // A number that a trace lacks is an error without bound.
                worst = worst.max(if error.is_finite() { error.abs() } else { f64::INFINITY });
                let name = &traced.name;
                println!(
                    "{name:5} {functions:10?} {quantity:14} {predicted:12.0} {found:10.0} {:+6.1} %",
                    100.0 * error
                );
            }
        }
    }
    println!("greatest error {:.1} %", 100.0 * worst);
    if worst <= TOLERANCE { Ok(()) } else { Err("a prediction is more than 5 % off".into()) }
}
