//! Time to read a whole FEMTO bearing: ours beside polars and pandas, in one run.
//!
//! `cargo bench -p ballrace --bench readers`, with `BALLRACE_PYTHON` a Python that has polars and
//! pandas (default `python3`), and the data where `reference_data::folder` looks.

use std::{
    collections::BTreeMap,
    error::Error,
    fs,
    path::Path,
    process::{Command, Stdio},
    time::Instant,
};

use ballrace::recording::{LoadOptions, load, reference_data};

const RUNS: usize = 11;
const BEARING: &str = "Bearing3_3";

fn main() -> Result<(), Box<dyn Error>> {
    let Some(femto) = reference_data::folder("femto") else {
        return Ok(());
    };
    let folder = femto.join(BEARING);
    // Also puts every file into the cache of the operating system, for everyone.
    let mut bytes = 0;
    let mut files = 0;
    for entry in fs::read_dir(&folder)? {
        bytes += fs::read(entry?.path())?.len();
        files += 1;
    }

    let mut rows = Vec::new();
    let both = time_ours(&folder, &LoadOptions::default())?;
    rows.push(("ballrace, both channels".to_owned(), both));
    let channels = Some(vec!["horizontal".to_owned()]);
    let one = time_ours(
        &folder,
        &LoadOptions {
            channels,
            ..LoadOptions::default()
        },
    )?;
    rows.push(("ballrace, one channel".to_owned(), one));
    match time_peers(&folder) {
        Ok(peers) => rows.extend(peers),
        Err(error) => eprintln!("peers left out: {error}"),
    }

    println!(
        "{BEARING}: {files} files, {:.1} MB, median of {RUNS} runs",
        bytes as f64 / 1e6
    );
    println!("{:<44}{:>10}{:>10}{:>9}", "", "ms", "MB/s", "ratio");
    for (name, seconds) in rows {
        let (ms, rate) = (seconds * 1e3, bytes as f64 / 1e6 / seconds);
        println!("{name:<44}{ms:>10.1}{rate:>10.0}{:>9.1}", seconds / both);
    }
    Ok(())
}

fn time_ours(folder: &Path, options: &LoadOptions) -> Result<f64, Box<dyn Error>> {
    let mut seconds = Vec::with_capacity(RUNS);
    for _ in 0..=RUNS {
        let start = Instant::now();
        let loaded = load(&[folder.into()], options)?;
        seconds.push(start.elapsed().as_secs_f64());
        std::hint::black_box(loaded);
    }
    // The first run warms up, as the peers' does.
    seconds.remove(0);
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[RUNS / 2])
}

/// Medians in seconds, by name. The script times itself, so starting Python does not count.
fn time_peers(folder: &Path) -> Result<BTreeMap<String, f64>, Box<dyn Error>> {
    let python = std::env::var_os("BALLRACE_PYTHON").unwrap_or_else(|| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/readers_peer.py");
    let output = Command::new(python)
        .arg(script)
        .arg(folder)
        .arg(RUNS.to_string())
        .stderr(Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("the script ended with {}", output.status).into());
    }
    let text = String::from_utf8(output.stdout)?;
    text.lines()
        .map(|line| {
            let (name, seconds) = line.split_once('\t').ok_or("a line without a tab")?;
            Ok((name.to_owned(), seconds.parse()?))
        })
        .collect()
}
