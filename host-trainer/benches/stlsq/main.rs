//! STLSQ of given columns: ours beside pysindy in one run, on the same numbers.
//!
//! `cargo bench -p ballrace --bench stlsq`, with `BALLRACE_PYTHON` a Python that has pysindy (default `python3`). The data are those
//! of the Lorenz system, whose cubic library has 20 columns: rows of Θ and ẋ are made by both sides from the same trajectory, and only
//! the regression is timed. Both have one thread.

use std::time::Instant;

use ballrace::model::stlsq::{RFactor, StlsqConfig, fit};
use ballrace_core::library::Library;
use faer::Mat;

const ROWS: usize = 100_000;
const RUNS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let library = Library::new(3, 3, 0).ok_or("library")?;
    let (states, rates) = lorenz();
    let mut row = vec![0.0f32; library.len()];
    let mut theta = Mat::zeros(ROWS, library.len());
    for s in 0..ROWS {
        library.row(&states[s].map(|v| v as f32), &mut row);
        row.iter().enumerate().for_each(|(t, v)| theta[(s, t)] = f64::from(*v));
    }
    let targets = Mat::from_fn(ROWS, 3, |s, o| rates[s][o]);
    let config = StlsqConfig { threshold: Some(1e-3), ..StlsqConfig::default() };
    let mut ours = Vec::new();
    let mut terms = Vec::new();
    for _ in 0..RUNS {
        let start = Instant::now();
        let factor = RFactor::from_matrices(theta.as_ref(), targets.as_ref());
        let equations = fit(&factor, &[], &config);
        ours.push(1e3 * start.elapsed().as_secs_f64());
        terms = equations.iter().map(|equation| equation.terms()).collect();
    }
    ours.sort_by(f64::total_cmp);
    let ours = ours[RUNS / 2];
    println!("STLSQ of {ROWS} x {}, one thread, medians of {RUNS}: ours {ours:.2} ms, {terms:?} terms", library.len());
    let python = std::env::var("BALLRACE_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/stlsq/peer.py");
    let output = std::process::Command::new(python).args([script, &ROWS.to_string(), &RUNS.to_string()]).output()?;
    let told = String::from_utf8(output.stdout)?;
    let Some(theirs) = told.lines().last().and_then(|line| serde_json::from_str::<serde_json::Value>(line).ok()) else {
        println!("pysindy: not run: {}", String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default());
        return Ok(());
    };
    let median = theirs["median_ms"].as_f64().ok_or("median_ms")?;
    println!("pysindy {}: {median:.1} ms, {} terms; ratio {:.1}", theirs["version"], theirs["terms"], median / ours);
    Ok(())
}

/// States and rates of the Lorenz system (σ 10, ρ 28, β 8/3) by steps of Runge and Kutta, every 2 ms.
fn lorenz() -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let rate = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let moved = |a: [f64; 3], b: [f64; 3], h: f64| std::array::from_fn(|i| a[i] + h * b[i]);
    let h = 0.002;
    let mut state = [-8.0, 8.0, 27.0];
    let mut states = Vec::with_capacity(ROWS);
    for _ in 0..ROWS {
        states.push(state);
        let k1 = rate(state);
        let k2 = rate(moved(state, k1, h / 2.0));
        let k3 = rate(moved(state, k2, h / 2.0));
        let k4 = rate(moved(state, k3, h));
        state = std::array::from_fn(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let rates = states.iter().map(|s| rate(*s)).collect();
    (states, rates)
}
