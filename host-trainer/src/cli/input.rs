//! Options of all commands that read recordings, and progress display.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;
use super::settings::CliSettings;
use crate::recording::input::Input;
use crate::recording::{LoadOptions, Recording, Unit, load};

const SETTINGS: CliSettings = CliSettings::DEFAULT;

/// Sources of recordings and options of reading them.
#[derive(clap::Args, Debug, Clone, Default)]
pub struct Recordings {
    /// Files or folders: FEMTO acc_*.csv, CSV with a header, .mat, .npy, .parquet, recordings.toml
    #[arg(required = true, value_name = "RECORDING")]
    pub recordings: Vec<PathBuf>,
    /// Channel to use [default: the first, or the model's]
    #[arg(long)]
    pub channel: Option<String>,
    /// Drop and count bad rows instead of failing
    #[arg(long)]
    pub skip_bad: bool,
    /// Sample rate, if the files do not state it or state it wrongly
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

impl Recordings {
    /// One channel of the recordings; `default_channel` if the user named none.
    pub fn read(&self, default_channel: Option<&str>) -> Result<Input, Failure> {
        let channel = self.channel.as_deref().or(default_channel);
        let recordings = self.load(channel.map(|c| vec![c.to_owned()]))?;
        Input::from_recordings(&recordings, channel).map_err(Failure::input)
    }

    /// Recordings with some channels, or all.
    pub fn load(&self, channels: Option<Vec<String>>) -> Result<Vec<Recording>, Failure> {
        let bar = bar("reading");
        let shown = bar.clone();
        let options = LoadOptions {
            skip_bad: self.skip_bad,
            sample_rate_hz: self.sample_rate,
            unit: self.unit.as_deref().map(parse_unit).transpose()?,
            variable: self.variable.clone(),
            channels,
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
        Ok(loaded.recordings)
    }
}

/// Unit of `--unit`.
pub(super) fn parse_unit(text: &str) -> Result<Unit, Failure> {
    Unit::parse(text).ok_or_else(|| Failure::option("unit", format!("`{text}`"), "g or m/s^2"))
}

/// Progress bar on stderr; without a terminal a line every few seconds.
pub fn bar(what: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:28} {wide_bar} {percent:>3} % {elapsed} ({eta} left)");
    let bar = ProgressBar::new(100)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what.to_owned());
    in_lines(&bar);
    bar
}

/// Line on stderr with the current step; without a terminal one every few seconds.
pub fn spinner() -> ProgressBar {
    let spinner = ProgressBar::new_spinner();
    spinner.enable_steady_tick(Duration::from_millis(120));
    in_lines(&spinner);
    spinner
}

/// Prints a bar that no terminal shows in lines, until it is finished or dropped.
fn in_lines(bar: &ProgressBar) {
    if std::io::stderr().is_terminal() {
        return;
    }
    let (bar, begun) = (bar.downgrade(), Instant::now());
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(SETTINGS.line_every);
            let Some(bar) = bar.upgrade().filter(|bar| !bar.is_finished()) else { return };
            let share = bar.length().filter(|of| *of > 0).map(|of| bar.position() as f64 / of as f64);
            eprintln!("{}", progress(begun.elapsed().as_secs_f64(), &bar.message(), share));
        }
    });
}

/// Time passed, step, and of a share done what is left.
fn progress(passed_s: f64, step: &str, share: Option<f64>) -> String {
    let done = match share {
        Some(share) if share > 0.0 => {
            let left_s = passed_s * (1.0 - share).max(0.0) / share;
            format!(", {:.0} %, about {left_s:.0} s left", 100.0 * share)
        }
        _ => String::new(),
    };
    format!("{passed_s:.0} s: {step}{done}")
}

#[cfg(test)]
mod tests {
    #[test]
    fn progress_in_a_line_says_what_is_left() {
        assert_eq!(super::progress(10.0, "fit", Some(0.25)), "10 s: fit, 25 %, about 30 s left");
        assert_eq!(super::progress(5.2, "searching", None), "5 s: searching");
    }
}
