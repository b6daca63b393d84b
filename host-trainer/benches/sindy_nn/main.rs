//! Time to train SINDy-NN: ours beside PyTorch in one run, and beside what the processor could do at best.
//!
//! `cargo bench -p ballrace --bench sindy_nn [-- paper | lorenz | ours]`, with `BALLRACE_PYTHON` a
//! Python that has numpy and torch (default `python3`) and `BALLRACE_PEERS` the folder of
//! `torch_sindy_nn.py` (default `../shared/peers` beside the workspace). Two threads for everyone.
//!
//! The floor is the time that the multiply-adds and sigmoids alone would take on all threads, at the
//! rates that a loop of nothing else reaches on this machine in the same minute.

mod floor;
mod lorenz;
mod paper;

const THREADS: usize = 2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let chosen: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let wanted = |name: &str| chosen.is_empty() || chosen.iter().any(|c| c == name);
    rayon::ThreadPoolBuilder::new().num_threads(THREADS).build_global()?;
    let floor = floor::measure();
    println!(
        "one thread: {:.1} G multiply-adds/s, {:.2} G sigmoids/s at best",
        floor.multiply_adds / 1e9,
        floor.sigmoids / 1e9
    );
    let with_peer = !chosen.iter().any(|c| c == "ours");
    if wanted("paper") || wanted("ours") {
        paper::run(&floor, with_peer)?;
    }
    if wanted("lorenz") || wanted("ours") {
        lorenz::run(&floor, with_peer)?;
    }
    Ok(())
}

/// Median of some values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The last line a peer prints, as JSON.
fn peer(script: &std::path::Path, arguments: &[String]) -> Result<serde_json::Value, Box<dyn std::error::Error>> {
    let python = std::env::var("BALLRACE_PYTHON").unwrap_or_else(|_| "python3".into());
    let output = std::process::Command::new(python).arg(script).args(arguments).output()?;
    let text = String::from_utf8(output.stdout)?;
    let last = text.lines().last().ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
    Ok(serde_json::from_str(last)?)
}
