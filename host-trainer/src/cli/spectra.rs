//! Command `ballrace spectra`.

use std::ops::Range;
use std::path::PathBuf;

use serde_json::json;

use super::input::Recordings;
use super::output::{Force, Outputs};
use super::settings::CliSettings;
use super::{Failure, line, write};
use crate::report::spectra as report;
use crate::rig::{Machine, Rig};
use crate::signal::spectra::{Analysis, SpeedSource, Wanted};

const SETTINGS: CliSettings = CliSettings::DEFAULT;

/// Show spectrum, kurtogram, envelope, orders and speed of recordings
///
/// With --rig the bearing's characteristic frequencies are marked, and the band of the envelope is
/// the one in which they are most significant; without it, the one of largest kurtosis. The shaft
/// speed is taken from a `tacho` channel if there is one, else estimated from the recording's lines
/// around the nominal speed if they determine it.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace spectra data/r01.csv --rig rig.toml --shaft-hz 25 --out spectra.html\n  \
    writes spectra.html with the pictures, and prints the speed, the band and the strongest line")]
pub struct Args {
    #[command(flatten)]
    input: Recordings,
    /// Rig with the bearing's geometry
    #[arg(long, value_name = "rig.toml")]
    rig: Option<PathBuf>,
    /// Nominal shaft speed [default: the recording's]
    #[arg(long, value_name = "HZ")]
    shaft_hz: Option<f64>,
    /// Band of the envelope in Hz [default: chosen]
    #[arg(long, value_name = "LO:HI")]
    band: Option<String>,
    /// File for the page
    #[arg(long, value_name = "FILE.html")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Seed of the random combs that the speed is tested against
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print bands, speeds and lines as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `spectra`.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(hz) = args.shaft_hz.filter(|hz| !(hz.is_finite() && *hz > 0.0)) {
        return Err(Failure::option("shaft-hz", hz, "a positive number of Hz"));
    }
    Outputs::new(args.force, &args.rig).beside(&args.input.recordings).file("out", &args.out)?;
    let band_hz = args.band.as_deref().map(|text| band(text).ok_or(text)).transpose();
    let band_hz = band_hz
        .map_err(|text| Failure::option("band", text, "two frequencies in Hz such as 2000:4000, the lower first"))?;
    let geometry = args.rig.as_deref().map(Rig::read).transpose().map_err(Failure::input)?.map(|rig| match rig.model {
        Machine::Bearing(rig) => Ok(rig.bearing.geometry()),
        Machine::Sdof(_) => Err(Failure::option("rig", "kind = \"sdof\"", "a rig with a bearing")),
    });
    let wanted = Wanted {
        geometry: geometry.transpose()?,
        shaft_hz: args.shaft_hz,
        band_hz,
        channel: args.input.channel.clone(),
        seed: args.seed,
    };
    let recordings = args.input.load(None)?;
    if recordings.is_empty() || recordings.len() > SETTINGS.recordings_per_page {
        let found = recordings.len();
        let most = SETTINGS.recordings_per_page;
        return Err(Failure::Input(format!("RECORDING: found {found} recordings, expected 1 to {most} for one page")));
    }
    let analyses: Vec<Analysis> = recordings
        .iter()
        .map(|recording| Analysis::analyse(recording, &wanted).map_err(Failure::input))
        .collect::<Result<_, _>>()?;
    let page = report::document(&analyses).map_err(Failure::other)?.html();
    write(&args.out, page.as_bytes())?;
    if args.json {
        return super::json(&json!({ "recordings": analyses.iter().map(report::value).collect::<Vec<_>>() }));
    }
    for analysis in &analyses {
        print(analysis)?;
    }
    line(format_args!("wrote {}", args.out.display()))
}

fn print(analysis: &Analysis) -> Result<(), Failure> {
    line(report::verdict(analysis))?;
    let speed = &analysis.speed;
    let nominal = speed.nominal_hz.map_or("no nominal speed".into(), |hz| format!("nominal {hz:.3} Hz"));
    match (speed.source, speed.used_hz) {
        (Some(source), Some(hz)) => {
            let by = match source {
                SpeedSource::Tachometer => "by the channel tacho",
                SpeedSource::Estimate => "by the recording's lines",
                SpeedSource::Nominal => "as stated",
            };
            line(format_args!("  speed used: {hz:.4} Hz {by} ({nominal})"))?;
        }
        _ => line(format_args!("  no speed known ({nominal})"))?,
    }
    if let Some(why) = &speed.tachometer_error {
        line(format_args!("  the channel tacho is not used: {why}"))?;
    }
    match (&speed.estimate, &speed.not_determined) {
        (Some(e), _) => line(format_args!(
            "  by the recording's lines: {:.4} ± {:.4} Hz, {} lines",
            e.shaft_hz,
            e.standard_error_hz,
            e.lines.len()
        )),
        (None, Some(why)) => line(format_args!("  by the recording's lines: not determinable: {why}")),
        (None, None) => Ok(()),
    }
}

/// Range of two frequencies separated by a colon, the lower first.
fn band(text: &str) -> Option<Range<f64>> {
    let (low, high) = text.split_once(':')?;
    let band = low.trim().parse::<f64>().ok()?..high.trim().parse::<f64>().ok()?;
    (band.start >= 0.0 && band.start < band.end && band.end.is_finite()).then_some(band)
}
