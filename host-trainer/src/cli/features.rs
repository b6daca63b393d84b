//! Command `ballrace features`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::bearings::{self, Aging};
use super::input::{Recordings, bar};
use super::output::{Force, Outputs};
use super::{Failure, line, write};
use crate::features::answer::{Answer, SetScore};
use crate::features::faults::{self, Measurements, RECORDS, SAMPLE_RATE_HZ};
use crate::features::findings::{signed, verdict};
use crate::features::life::Life;
use crate::features::measure::{Measured, measure};
use crate::features::{FEWEST_BEARINGS, Study, study};
use crate::recording::input::{Input, Series};
use crate::recording::reference_data;
use crate::report::features::{self as report, two};
use crate::signal::phases::life::{Features, Timeline};
use crate::signal::phases::{Rules, phases};
use crate::stats::format::by_chance;

/// Measure what fitted coefficients tell as features, beyond RMS, kurtosis and the null's coefficients
///
/// Of every recording: RMS and kurtosis, the coefficients of a fit of a small polynomial library (n_D 1 and 2, n_MD 4), and those
/// of the same fit to surrogates of the recording (the null). One linear method then tells aging phases apart, orders the
/// remaining life, and names the damaged part of the CWRU records, each bearing predicted by the others alone.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace features data/Bearing3_3 data/Bearing3_1 data/Bearing2_7 --out features.html\n    \
    prints the scores of every set of features on each bearing, and writes a page with pictures"
)]
pub struct Args {
    /// Run-to-failure folders, at least three [default: all of the folder femto in $BALLRACE_DATA or ../shared/data]
    #[arg(value_name = "FOLDER")]
    bearings: Vec<PathBuf>,
    /// Channel of the folders
    #[arg(long, default_value = "vertical")]
    channel: String,
    /// Folder with the CWRU records [default: the folder cwru there, if it is there]
    #[arg(long, value_name = "FOLDER")]
    cwru: Option<PathBuf>,
    /// Seed of the surrogates and of the draws of blocks
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `features`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::new(args.force, []).beside(&args.bearings);
    args.out.iter().try_for_each(|path| outputs.file("out", path))?;
    let lives = lives(args)?;
    let cwru = args.cwru.clone().or_else(|| reference_data::folder("cwru"));
    let records = cwru.map_or(Ok(Vec::new()), |folder| records(&folder, args.seed))?;
    let bar = bar("leaving bearings out");
    let study = study(&lives, &records, args.seed, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    if let Some(path) = &args.out {
        let page = report::document(&study, &lives, &args.channel).map_err(Failure::other)?;
        write(path, page.html().as_bytes())?;
    }
    if args.json {
        return super::json(&document(&study, &lives, args));
    }
    print(&study)?;
    args.out.as_ref().map_or(Ok(()), |path| line(format_args!("wrote {}", path.display())))
}

/// Lives of the folders whose channel ages.
fn lives(args: &Args) -> Result<Vec<Life>, Failure> {
    let lives = bearings::aging(&args.bearings, &args.channel, |folder, name| life(folder, name, args))?;
    if lives.len() < FEWEST_BEARINGS {
        return Err(Failure::Input(format!(
            "found {} folders with an aging phase, expected at least {FEWEST_BEARINGS}: one is left out, and of the others one \
             more to choose the penalty",
            lives.len()
        )));
    }
    Ok(lives.into_iter().map(|life| life.value).collect())
}

/// Life of a folder; `None` if it does not age.
fn life(folder: &Path, name: String, args: &Args) -> Result<Option<Aging<Life>>, Failure> {
    let source = Recordings { recordings: vec![folder.to_owned()], ..Recordings::default() };
    let recordings = source.load(Some(vec![args.channel.clone()]))?;
    let input = Input::from_recordings(&recordings, Some(&args.channel)).map_err(Failure::input)?;
    let channel = recordings.iter().filter_map(|recording| recording.channel(&args.channel));
    let features: Vec<Features> = channel.map(|channel| Features::new(&channel.samples)).collect();
    let found = phases(&features, &Timeline::new(&recordings).follows, &Rules::default());
    let Some((aging, failure)) = found.and_then(|found| Some((found.aging?, found.failure))) else { return Ok(None) };
    let measured = measured(&format!("{name}: fitting"), &input.series, args.seed)?;
    let value = Life { name: name.clone(), measured, aging, failure };
    Ok(Some(Aging { name, sample_rate_hz: input.sample_rate_hz, value }))
}

/// Features of the CWRU records, segment by segment.
fn records(folder: &Path, seed: u64) -> Result<Vec<Measurements>, Failure> {
    let one = |record: &faults::Record| {
        let source = Recordings {
            recordings: vec![folder.join(record.file)],
            variable: Some(record.variable()),
            sample_rate: Some(SAMPLE_RATE_HZ),
            ..Recordings::default()
        };
        let input = source.read(None)?;
        let segments: Vec<Series> = input.series.iter().flat_map(faults::segments).collect();
        let measured = measured(&format!("record {}: fitting", record.number), &segments, seed)?;
        Ok(Measurements { record: *record, measured })
    };
    RECORDS.iter().map(one).collect()
}

fn measured(what: &str, series: &[Series], seed: u64) -> Result<Vec<Measured>, Failure> {
    let bar = bar(what);
    bar.set_length(series.len() as u64);
    let measured = measure(series, seed, &|| bar.inc(1)).map_err(Failure::input);
    bar.finish_and_clear();
    measured
}

fn document(study: &Study, lives: &[Life], args: &Args) -> Value {
    let life = |life: &Life| json!({ "name": life.name, "recordings": life.measured.len(), "aging": life.aging, "failure": life.failure });
    json!({
        "channel": args.channel, "seed": args.seed, "bearings": lives.iter().map(life).collect::<Vec<_>>(),
        "verdict": study.verdict(), "lives": study.lives, "faults": study.faults,
    })
}

fn print(study: &Study) -> Result<(), Failure> {
    for (name, answer) in study.answers() {
        line(format_args!("{name}:"))?;
        line(format_args!("  {:38} {}   mean  95 %", "features", answer.bearings.join("  ")))?;
        answer.sets.iter().try_for_each(|set| print_set(answer, set))?;
        for gain in &answer.gains {
            line(format_args!(
                "  {} beyond {}: {} ({} to {}), {}",
                gain.with.name(),
                gain.without.name(),
                signed(gain.gain),
                signed(gain.interval95[0]),
                signed(gain.interval95[1]),
                verdict(gain.verdict)
            ))?;
        }
    }
    line(study.verdict())
}

fn print_set(answer: &Answer, set: &SetScore) -> Result<(), Failure> {
    let scores = answer.bearings.iter().zip(&set.scores);
    let scores: Vec<String> =
        scores.map(|(name, score)| format!("{:>1$}", two(*score), name.chars().count())).collect();
    let [low, high] = set.interval95.map(two);
    let accuracy = Answer::balanced_accuracy(set).filter(|_| set.p_value.is_none());
    let accuracy = accuracy.map_or(String::new(), |accuracy| format!(", balanced accuracy {}", two(accuracy)));
    let p_value = set.p_value.map_or(String::new(), |p_value| format!(", {}", by_chance(p_value)));
    let same = set.same_bearings.map_or(String::new(), |share| format!(", {} on the same records", two(share)));
    let (name, mean) = (set.set.name(), two(set.mean));
    line(format_args!("  {name:38} {}  {mean:>5}  {low} to {high}{accuracy}{p_value}{same}", scores.join("  ")))
}
