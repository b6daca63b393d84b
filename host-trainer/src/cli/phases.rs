//! Command `ballrace phases`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Value, json};

use super::input::Recordings;
use super::output::{Force, Outputs};
use super::settings::CliSettings;
use super::{Failure, line, write};
use crate::paper::aged_bearing;
use crate::report::phases as report;
use crate::signal::phases::machine::{Filter, Machine};
use crate::signal::phases::{FailureRule, Phases, Rules, not_positive};
use crate::signal::wavelet::Wavelet;
use crate::signal::wavelet::denoise::{Denoising, NoiseEstimate, Shrinkage, ThresholdRule};
use crate::signal::wavelet::stationary::levels_below;

/// Find when a machine began to age and to fail
///
/// Each DIR holds one machine's recordings from new to failed. Aging starts where the kurtosis leaves the limits of the healthy
/// recordings at the beginning, for as many recordings in a row as it takes for the start to move no further; failure where an
/// increment of the RMS is large. Both are sought in each channel, raw and denoised by a stationary wavelet transform. A gap
/// between recordings ends a row.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace phases data/Bearing3_3 --out phases.html\n    \
    prints when each channel began to age and to fail, and writes a page with its kurtosis and RMS")]
pub struct Args {
    #[command(flatten)]
    input: Recordings,
    /// Healthy recordings at the beginning [default: a quarter, 10 to 100]
    #[arg(long, value_name = "COUNT")]
    healthy: Option<usize>,
    /// Standard deviations of the healthy kurtosis outside of which a machine ages
    #[arg(long, default_value_t = 3.0)]
    sigmas: f64,
    /// Increment of the RMS with which an increment is compared
    #[arg(long, value_enum, default_value_t = FailureRule::Largest)]
    failure: FailureRule,
    /// Ratio of the increments from which a machine fails
    #[arg(long, default_value_t = 3.0)]
    ratio: f64,
    /// Wavelet of the denoised signal: db1 to db10, sym2 to sym10
    #[arg(long, default_value = CliSettings::DEFAULT.wavelet)]
    wavelet: String,
    /// Rule for the threshold of the wavelet's details
    #[arg(long, value_enum, default_value_t = ThresholdRule::Universal)]
    threshold: ThresholdRule,
    /// What becomes of the details
    #[arg(long, value_enum, default_value_t = Shrinkage::Soft)]
    shrinkage: Shrinkage,
    /// Levels whose noise is estimated
    #[arg(long, value_enum, default_value_t = NoiseEstimate::EachLevel)]
    noise: NoiseEstimate,
    /// Frequency, Hz, below which the wavelet's last approximation lies
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    below: f64,
    /// Print the recordings in the aging phase by all rules, beside the paper's Table 5
    #[arg(long)]
    compare: bool,
    /// Write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `phases`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let rules = args.rules()?;
    let mut outputs = Outputs::new(args.force, []).beside(&args.input.recordings);
    args.out.iter().try_for_each(|path| outputs.file("out", path))?;
    let machines = args.input.recordings.iter().map(|folder| args.machine(folder, &rules));
    let machines = machines.collect::<Result<Vec<Machine>, Failure>>()?;
    let comparison = args.compare.then(|| Comparison::new(&machines, &rules)).transpose()?;
    if let Some(path) = &args.out {
        let page = report::document(&machines, &rules).map_err(Failure::other)?;
        write(path, page.html().as_bytes())?;
    }
    if args.json {
        let machines: Vec<Value> = machines.iter().map(document).collect();
        return super::json(&json!({ "rules": rules, "machines": machines, "comparison": comparison }));
    }
    machines.iter().try_for_each(print)?;
    if let Some(comparison) = comparison {
        comparison.print()?;
    }
    args.out.as_ref().map_or(Ok(()), |path| line(format_args!("wrote {}", path.display())))
}

/// JSON document of the phases of each channel.
fn document(machine: &Machine) -> Value {
    let timeline = &machine.lives.timeline;
    let recording = |index: usize| {
        json!({ "index": index, "name": timeline.names[index],
                "time_s": timeline.times_s.as_ref().map(|times| times[index]) })
    };
    let channel = |(n, phases): (usize, &Option<Phases>)| {
        let life = &machine.lives.channels[n];
        phases.map(|phases| {
            json!({ "channel": life.channel, "denoised": life.filter == Filter::Wavelet,
                    "healthy": { "recordings": phases.healthy, "kurtosis": phases.mean, "kurtosis_std": phases.std },
                    "aging": phases.aging.map(recording), "in_a_row": phases.in_a_row,
                    "failure": phases.failure.map(recording),
                    "aging_recordings": phases.between(life.features.len()) })
        })
    };
    json!({
        "name": machine.name, "recordings": timeline.names.len(), "gaps": timeline.gaps(),
        "paper_aging_recordings": aged_bearing(&machine.name).map(|paper| paper.aging_recordings),
        "channels": machine.phases.iter().enumerate().filter_map(channel).collect::<Vec<_>>(),
    })
}

impl Args {
    fn rules(&self) -> Result<Rules, Failure> {
        let Self { healthy, sigmas, failure, ratio, below, .. } = *self;
        let rules = Rules { healthy, sigmas, failure, ratio };
        match rules.refused().or_else(|| not_positive("below", below, " of Hz")) {
            Some((option, found, expected)) => Err(Failure::option(option, found, expected)),
            None => Ok(rules),
        }
    }

    /// Machine of a folder.
    fn machine(&self, folder: &Path, rules: &Rules) -> Result<Machine, Failure> {
        let input = Recordings { recordings: vec![folder.to_owned()], ..self.input.clone() };
        let recordings = input.load(self.input.channel.as_ref().map(|channel| vec![channel.clone()]))?;
        let wavelet: Wavelet = self.wavelet.parse().map_err(|error| Failure::Input(format!("--wavelet: {error}")))?;
        let denoising = |sample_rate_hz| Denoising {
            wavelet,
            levels: levels_below(self.below, sample_rate_hz),
            rule: self.threshold,
            shrinkage: self.shrinkage,
            noise: self.noise,
        };
        Machine::new(folder, &recordings, rules, denoising).map_err(Failure::input)
    }
}

fn print(found: &Machine) -> Result<(), Failure> {
    let timeline = &found.lives.timeline;
    let span =
        timeline.times_s.as_ref().and_then(|times| times.last()).map_or(String::new(), |s| format!(" over {s:.0} s"));
    let gaps = match timeline.gaps() {
        0 => "no gap".into(),
        1 => "1 gap".into(),
        many => format!("{many} gaps"),
    };
    line(format_args!("{}: {} recordings{span}, {gaps}", found.name, timeline.names.len()))?;
    let rows = found.phases.iter().enumerate().filter_map(|(n, p)| Some(report::row(&found.lives, n, p.as_ref()?)));
    let table: Vec<[String; 7]> = std::iter::once(report::HEAD.map(String::from)).chain(rows).collect();
    let width = |column: usize| table.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..report::HEAD.len()).map(width).collect();
    for row in &table {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        line(format_args!("  {}", cells.collect::<Vec<_>>().join("  ").trim_end()))?;
    }
    match aged_bearing(&found.name) {
        Some(paper) => {
            line(format_args!("  the paper's Table 5: {} recordings in the aging phase", paper.aging_recordings))
        }
        None => Ok(()),
    }
}

/// Recordings in the aging phase by all rules, beside the paper's.
#[derive(Serialize)]
struct Comparison {
    machines: Vec<String>,
    paper: Vec<usize>,
    /// Those nearest to the paper's first.
    rows: Vec<ComparisonRow>,
}

#[derive(Serialize)]
struct ComparisonRow {
    channel: String,
    filter: Filter,
    failure: FailureRule,
    /// 0 where a machine does not age.
    recordings: Vec<usize>,
    /// Mean over the machines of |ours / the paper's − 1|.
    difference: f64,
}

impl Comparison {
    fn new(machines: &[Machine], rules: &Rules) -> Result<Self, Failure> {
        let known: Vec<(&Machine, usize)> =
            machines.iter().filter_map(|found| Some((found, aged_bearing(&found.name)?.aging_recordings))).collect();
        let Some((first, _)) = known.first() else {
            return Err(Failure::Input(
                "--compare: found no folder of the paper's Table 5, expected one such as Bearing3_3".into(),
            ));
        };
        let mut rows = Vec::new();
        for failure in FailureRule::ALL {
            let rules = Rules { failure, ..*rules };
            let phases: Vec<_> = known.iter().map(|(found, _)| found.lives.phases(&rules)).collect();
            for (n, life) in first.lives.channels.iter().enumerate() {
                let count = |((found, _), phases): (&(&Machine, usize), &Vec<Option<Phases>>)| {
                    phases.get(n).copied().flatten().and_then(|p| p.between(found.lives.timeline.names.len()))
                };
                let recordings: Vec<usize> = known.iter().zip(&phases).map(|both| count(both).unwrap_or(0)).collect();
                let off =
                    recordings.iter().zip(&known).map(|(own, (_, paper))| (*own as f64 / *paper as f64 - 1.0).abs());
                let difference = off.sum::<f64>() / known.len() as f64;
                let (channel, filter) = (life.channel.clone(), life.filter);
                rows.push(ComparisonRow { channel, filter, failure, recordings, difference });
            }
        }
        rows.sort_by(|a, b| a.difference.total_cmp(&b.difference));
        let (machines, paper) = known.iter().map(|(found, paper)| (found.name.clone(), *paper)).unzip();
        Ok(Self { machines, paper, rows })
    }

    fn print(&self) -> Result<(), Failure> {
        let names: Vec<String> =
            self.machines.iter().zip(&self.paper).map(|(name, n)| format!("{name} ({n})")).collect();
        line(format_args!("recordings in the aging phase by each rule (the paper's), mean relative difference:"))?;
        line(format_args!("  {:12} {:9} {:11} {}  difference", "channel", "signal", "failure", names.join("  ")))?;
        for row in &self.rows {
            let counts = row.recordings.iter().zip(&names).map(|(n, name)| format!("{n:>width$}", width = name.len()));
            line(format_args!(
                "  {:12} {:9} {:11} {}  {:.2}",
                row.channel,
                report::filter_name(row.filter),
                format!("{:?}", row.failure).to_lowercase(),
                counts.collect::<Vec<_>>().join("  "),
                row.difference
            ))?;
        }
        Ok(())
    }
}
