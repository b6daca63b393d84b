//! Command `ballrace monitor`.

use std::path::PathBuf;

use ballrace_core::monitor::MonitorConfig;
use ballrace_firmware_sim::event::Event;
use ballrace_firmware_sim::faults::{FaultPlan, Injected};
use serde_json::Value;

use super::input::{Recordings, bar};
use super::output::{Force, Outputs};
use super::{Failure, line, write};
use crate::model::file;
use crate::model::replay::{self, Options, Replayed};
use crate::recording::input::Input;
use crate::report;
use crate::report::monitor::Vibration;
use crate::report::plot::time_axis::TimeAxis;
use crate::report::plot::trend;
use crate::signal::indicators::{Indicators, IsoClass};

/// Run the device's own code over recordings
///
/// Prints one JSON line for each event on stdout (`starting`, `healthy`, `anomalous`, `blind`, `fault`,
/// `summary`), and a readable summary on stderr.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace monitor --model model.bin data/Bearing3_3 --plot trend.svg\n  \
    raises an alarm when the residual leaves its healthy limits; add --fault nan:0.001,gap:1e-5x200 to see a bad sensor")]
pub struct Args {
    #[command(flatten)]
    input: Recordings,
    /// Model written by `fit`, or its binary or JSON form written by `export`
    #[arg(long)]
    model: PathBuf,
    /// Inject faults into the samples: drop:P, gap:PxN, stuck:PxN, saturate:LEVEL, nan:P, flip:P, comma-separated
    #[arg(long, value_name = "SPEC")]
    fault: Option<String>,
    /// Seed of the injected faults
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Play at the recording's rate times this factor [default: as fast as possible]
    #[arg(long, value_name = "FACTOR")]
    pace: Option<f64>,
    /// Print every block of the monitor as well, and each recording's vibration indicators
    #[arg(long)]
    blocks: bool,
    /// Group and support of the machine, for the zones of vibration velocity by ISO 20816-3
    #[arg(long, value_name = "CLASS")]
    iso_class: Option<IsoClass>,
    /// Write a plot of the statistics over the recordings
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Write a report with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the samples that reached the device as little-endian f32, the input of the bare-metal image
    #[arg(long, value_name = "FILE.f32")]
    samples_out: Option<PathBuf>,
    #[cfg(feature = "fleet")]
    #[command(flatten)]
    publish: super::publish::Publish,
    #[command(flatten)]
    force: Force,
    /// One JSON document with all events instead of lines
    #[arg(long)]
    json: bool,
}

/// Runs `monitor`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let plan: FaultPlan =
        args.fault.as_deref().unwrap_or("").parse().map_err(|e| Failure::Input(format!("--fault: {e}")))?;
    if args.pace.is_some_and(|p| !(p.is_finite() && p > 0.0)) {
        return Err(Failure::Input("--pace: expected a positive factor".into()));
    }
    let mut outputs = Outputs::new(args.force, [&args.model]).beside(&args.input.recordings);
    for (option, path) in [("plot", &args.plot), ("report", &args.report), ("samples-out", &args.samples_out)] {
        path.iter().try_for_each(|path| outputs.file(option, path))?;
    }
    let (model, fitted) = file::read(&args.model).map_err(Failure::input)?;
    let input = args.input.read(fitted.as_ref().and_then(|r| r.training.channel.as_deref()))?;

    note_channel(args, fitted.as_ref().and_then(|report| report.training.channel.as_deref()), &input.channel);
    let indicators = Indicators::of_each(&input);
    let vibration = Vibration { indicators: &indicators, class: args.iso_class };
    #[cfg(feature = "fleet")]
    let mut publication = args.publish.connect(&model)?;
    let mut events = Vec::new();
    let mut failed = None;
    // Number of recordings whose indicators are emitted, and the EWMA at the end of the present one.
    let (mut emitted, mut ewma) = (0, None);
    let bar = bar("monitor");
    bar.set_length(input.series.len() as u64);
    let options = Options { plan, seed: args.seed, pace: args.pace, keep_samples: args.samples_out.is_some() };
    let replayed = replay::replay(&model, &input, &options, &mut |event, done| {
        bar.set_position(done as u64);
        #[cfg(feature = "fleet")]
        if let Some(Err(error)) = publication.as_mut().map(|publication| publication.event(event)) {
            failed.get_or_insert(error);
        }
        let mut print = |value: Value| {
            if args.json {
                events.push(value);
            } else if let Err(error) = bar.suspend(|| line(value)) {
                failed.get_or_insert(error);
            }
        };
        while emitted < done.min(indicators.len()) {
            if args.json || args.blocks {
                print(vibration.event(&input, emitted, ewma));
            }
            emitted += 1;
        }
        if let Event::Block(block) = event {
            ewma = Some(block.statistics.ewma);
            if !args.blocks {
                return;
            }
        }
        match serde_json::to_value(event) {
            Ok(value) => print(value),
            Err(error) => drop(failed.get_or_insert(Failure::other(error))),
        }
    })
    .map_err(Failure::input)?;
    bar.finish_and_clear();
    if let Some(error) = failed {
        return Err(error);
    }
    if let Some(path) = &args.plot {
        let svg =
            trend::svg(&replayed.blocks, &model.view().monitor, &TimeAxis::of(&input), None).map_err(Failure::other)?;
        write(path, svg.as_bytes())?;
    }
    if let Some(path) = &args.report {
        let page = report::monitor::document(&model, &input, &replayed, &vibration).map_err(Failure::other)?;
        write(path, page.html().as_bytes())?;
    }
    if let Some(path) = &args.samples_out {
        let bytes: Vec<u8> = replayed.samples.iter().flat_map(|s| s.to_le_bytes()).collect();
        write(path, &bytes)?;
    }
    #[cfg(feature = "fleet")]
    if let Some(publication) = publication {
        publication.finish()?;
    }
    summarise(&replayed, &input);
    eprintln!("{}", report::monitor::severity(&vibration));
    eprintln!("{}", stated_rate(&model.view().monitor));
    if args.json { super::json(&Value::from(events)) } else { Ok(()) }
}

/// Says on stderr where the model is of another channel than the recordings, or does not say of which.
fn note_channel(args: &Args, of_model: Option<&str>, found: &str) {
    match of_model {
        Some(channel) if channel == found => {}
        Some(channel) => {
            eprintln!(
                "note: the model is of channel {channel}, the recordings' is {found}: what is other need not be a fault"
            );
        }
        None => {
            let model = args.model.display();
            eprintln!("note: {model} does not say which channel it is of; it runs over the channel {found}");
        }
    }
}

/// Prints a readable summary on stderr.
fn summarise(replayed: &Replayed, input: &Input) {
    let s = &replayed.summary;
    let seconds = s.samples as f64 / input.sample_rate_hz;
    eprintln!(
        "{} recordings, {} samples ({seconds:.1} s), {} evaluated, {} blocks in {:.2} s ({:.1} times real time)",
        s.recordings,
        s.samples,
        s.evaluated,
        s.blocks,
        replayed.seconds,
        seconds / replayed.seconds.max(1e-9)
    );
    match &s.first_alarm {
        Some(alarm) => eprintln!(
            "first alarm in {} (recording {} of {}), {} alarm{} in all",
            alarm.recording,
            alarm.recording_index + 1,
            s.recordings,
            s.alarms,
            if s.alarms == 1 { "" } else { "s" }
        ),
        None => eprintln!("no alarm"),
    }
    let f = &s.faults;
    if f.total() > 0 {
        eprintln!(
            "invalid samples: {} non-finite, {} saturated, {} stuck, {} missing",
            f.non_finite, f.saturated, f.stuck, f.missing
        );
    }
    if replayed.injected != Injected::default() {
        eprintln!("injected: {:?}", replayed.injected);
    }
    eprintln!("status at the end: {}", serde_json::to_string(&s.status).unwrap_or_default().trim_matches('"'));
}

/// Rate of false alarms that the model's limit was set for, as a sentence.
fn stated_rate(limits: &MonitorConfig) -> String {
    let factor = (limits.limit * limits.healthy_spread).exp();
    if limits.false_alarms_per_day > 0.0 {
        format!(
            "limit at a factor of {factor:.2} in power, for {} false alarms a day of {:.0} blocks; it rests on {} healthy blocks",
            limits.false_alarms_per_day, limits.blocks_per_day, limits.healthy_blocks
        )
    } else {
        format!("limit at a factor of {factor:.2} in power; the model states no rate of false alarms")
    }
}
