//! Recordings as every command takes them.

use std::path::PathBuf;
use std::sync::Arc;

use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;
use crate::fit::Series;
use crate::recording::{LoadOptions, Recording, Unit, load};

/// Where recordings come from and how they are to be read.
#[derive(clap::Args, Debug, Clone)]
pub struct Recordings {
    /// Files or folders: FEMTO acc_*.csv, CSV with a header, .mat, .npy, .parquet, recordings.toml
    #[arg(required = true, value_name = "RECORDING")]
    pub recordings: Vec<PathBuf>,
    /// Channel to use [default: the first, or the model's]
    #[arg(long)]
    pub channel: Option<String>,
    /// Drop bad rows and count them, instead of ending with an error
    #[arg(long)]
    pub skip_bad: bool,
    /// Sample rate, where the files do not state it (or state it wrongly)
    #[arg(long, value_name = "HZ")]
    pub sample_rate: Option<f64>,
    /// Unit of the accelerations: g or m/s^2
    #[arg(long)]
    pub unit: Option<String>,
    /// Variable of a .mat file, such as X130_DE_time or bearing.gs
    #[arg(long)]
    pub variable: Option<String>,
    /// Resample to this rate, anti-aliased
    #[arg(long, value_name = "HZ")]
    pub resample: Option<f64>,
}

/// One channel of every recording.
pub struct Input {
    /// The recordings.
    pub series: Vec<Series>,
    /// Name of the channel.
    pub channel: String,
    /// Their common sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Whether they are one machine's life in order of time.
    pub run_to_failure: bool,
    /// Bad rows that were dropped.
    pub skipped_rows: usize,
}

impl Recordings {
    /// Reads one channel; `default_channel` where the user named none.
    pub fn read(&self, default_channel: Option<&str>) -> Result<Input, Failure> {
        let bar = bar("reading");
        let shown = bar.clone();
        let channel = self.channel.as_deref().or(default_channel);
        let options = LoadOptions {
            skip_bad: self.skip_bad,
            sample_rate_hz: self.sample_rate,
            unit: self.unit.as_deref().map(parse_unit).transpose()?,
            variable: self.variable.clone(),
            channels: channel.map(|c| vec![c.to_owned()]),
            resample_hz: self.resample,
            progress: Some(Arc::new(move |p| {
                shown.set_length(p.total as u64);
                shown.set_position(p.done as u64);
            })),
            ..LoadOptions::default()
        };
        let loaded = load(&self.recordings, &options).map_err(Failure::input)?;
        bar.finish_and_clear();
        for error in &loaded.skipped {
            eprintln!("skipped: {error}");
        }
        one_channel(&loaded.recordings, channel)
    }
}

fn one_channel(recordings: &[Recording], channel: Option<&str>) -> Result<Input, Failure> {
    let first = recordings.first().ok_or_else(|| Failure::Input("no recording could be read".into()))?;
    let name = match channel {
        Some(name) => name.to_owned(),
        None => first.channels.first().map(|c| c.name.clone()).unwrap_or_default(),
    };
    let mut series = Vec::with_capacity(recordings.len());
    for recording in recordings {
        let channel = recording.channel(&name).ok_or_else(|| {
            let there: Vec<_> = recording.channels.iter().map(|c| c.name.as_str()).collect();
            Failure::Input(format!("{}: found channels {}, expected `{name}`", recording.source, there.join(", ")))
        })?;
        if (recording.sample_rate_hz / first.sample_rate_hz - 1.0).abs() > 1e-6 {
            return Err(Failure::Input(format!(
                "{}: found {} Hz, expected {} Hz as {} has; --resample makes them equal",
                recording.source, recording.sample_rate_hz, first.sample_rate_hz, first.source
            )));
        }
        let samples = channel.samples.iter().map(|v| *v as f32).collect();
        series.push(Series { name: recording.name(), samples });
    }
    Ok(Input {
        series,
        channel: name,
        sample_rate_hz: first.sample_rate_hz,
        run_to_failure: recordings.len() >= 20 && recordings.iter().all(|r| r.start_s.is_some()),
        skipped_rows: recordings.iter().map(|r| r.skipped_rows).sum(),
    })
}

fn parse_unit(text: &str) -> Result<Unit, Failure> {
    Unit::parse(text).ok_or_else(|| Failure::Input(format!("--unit: found `{text}`, expected g or m/s^2")))
}

/// A progress bar on stderr, where that is a terminal.
pub fn bar(what: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:28} {wide_bar} {percent:>3} % {elapsed}");
    ProgressBar::new(100)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what.to_owned())
}
