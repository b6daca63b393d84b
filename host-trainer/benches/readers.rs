//! Time to read a whole FEMTO bearing: ours beside polars and pandas, in one run.
//!
//! `cargo bench -p ballrace --bench readers`, with `BALLRACE_PYTHON` a Python that has polars and
//! pandas (default `python3`), and the data where `reference_data::folder` looks.
//!
//! The readers take turns, so that whatever else the machine does falls on all of them.

use std::{
    error::Error,
    fs,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    time::Instant,
};

use ballrace::recording::{LoadOptions, load, reference_data};

/// Runs of each reader that count; one more goes before them to warm up.
const RUNS: usize = 11;
const BEARING: &str = "Bearing3_3";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
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

    let one = Some(vec!["horizontal".to_owned()]);
    let ours = [
        ("ballrace, both channels", LoadOptions::default()),
        ("ballrace, one channel", LoadOptions { channels: one, ..LoadOptions::default() }),
    ];
    let mut peers = Peers::start(&folder).inspect_err(|error| eprintln!("peers left out: {error}")).ok();
    let peer_names = peers.as_ref().map_or(&[][..], |peers| &peers.names);
    let names: Vec<String> = ours.iter().map(|(name, _)| name.to_string()).chain(peer_names.iter().cloned()).collect();

    let mut seconds = vec![Vec::new(); names.len()];
    let paths = [folder];
    for _ in 0..=RUNS {
        for (index, (_, options)) in ours.iter().enumerate() {
            seconds[index].push(time_ours(&paths, options)?);
        }
        if let Some(peers) = &mut peers {
            for index in 0..peers.names.len() {
                seconds[ours.len() + index].push(peers.time(index)?);
            }
        }
    }

    println!("{BEARING}: {files} files, {:.1} MB, {RUNS} runs in turn", bytes as f64 / 1e6);
    println!("{:<36}{:>11}{:>9}{:>9}{:>9}", "", "median ms", "best ms", "MB/s", "ratio");
    let mut reference = None;
    for (name, mut seconds) in names.into_iter().zip(seconds) {
        seconds.remove(0);
        seconds.sort_by(f64::total_cmp);
        let (median, best) = (seconds[RUNS / 2], seconds[0]);
        let ratio = median / *reference.get_or_insert(median);
        let rate = bytes as f64 / 1e6 / median;
        println!("{name:<36}{:>11.1}{:>9.1}{rate:>9.0}{ratio:>9.1}", median * 1e3, best * 1e3);
    }
    Ok(())
}

fn time_ours(paths: &[PathBuf], options: &LoadOptions) -> Result<f64> {
    let start = Instant::now();
    let loaded = load(paths, options)?;
    let seconds = start.elapsed().as_secs_f64();
    std::hint::black_box(loaded);
    Ok(seconds)
}

/// The Python readers, which time themselves on request.
struct Peers {
    names: Vec<String>,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    process: Child,
}

impl Peers {
    fn start(folder: &Path) -> Result<Self> {
        let python = std::env::var_os("BALLRACE_PYTHON").unwrap_or_else(|| "python3".into());
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/readers_peer.py");
        let mut process =
            Command::new(python).arg(script).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let requests = process.stdin.take();
        let answers = BufReader::new(process.stdout.take().ok_or("no stdout")?);
        let mut peers = Self { names: Vec::new(), requests, answers, process };
        loop {
            match peers.line()? {
                name if name.is_empty() => return Ok(peers),
                name => peers.names.push(name),
            }
        }
    }

    /// Seconds that the reader of this number takes.
    fn time(&mut self, index: usize) -> Result<f64> {
        writeln!(self.requests.as_mut().ok_or("no stdin")?, "{index}")?;
        Ok(self.line()?.parse()?)
    }

    fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        match self.answers.read_line(&mut line)? {
            0 => Err("the script ended early".into()),
            _ => Ok(line.trim_end().to_owned()),
        }
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // The script ends at the end of its input.
        self.requests = None;
        let _ = self.process.wait();
    }
}
