//! Command `ballrace evaluate`.

use std::path::PathBuf;

use serde::Serialize;

use super::input::bar;
use super::output::{Force, Outputs};
use super::{Failure, json, line, write};
use crate::evaluate::cases::case_spec::{Kind, Severity};
use crate::evaluate::cases::simulator::Simulator;
use crate::evaluate::score::Score;
use crate::evaluate::table::{Summary, confusion, markdown};
use crate::evaluate::{Config, EvaluateError, evaluate, write_cases};

use super::settings::CliSettings;

const SETTINGS: CliSettings = CliSettings::DEFAULT;

/// Measure how often `diagnose` is right, on simulated cases with hidden effects
///
/// Draws machines with an effect that their rig lacks (every effect of the vocabulary at three severities, none, pairs,
/// and effects outside the vocabulary), diagnoses each from its rig and recordings alone, and compares the result with
/// the hidden effect. Prints accuracy, confusions, errors of the parameters against their intervals, and times. Cases
/// already in OUT are not repeated.
///
/// OUT then holds evaluation.md, confusion.csv, scores.json, and cases/, diagnoses/ and truth/.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace evaluate --out evaluation --kind single,control --severity plain --jobs 2"
)]
pub struct Args {
    /// Folder to write to
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Seed of all random draws
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Repetitions of the list of cases, each with new draws
    #[arg(long, default_value_t = 1)]
    rounds: usize,
    /// Simulator of the cases: `shared` is the one that the diagnosis searches with; `exact` is another one, with other forms of
    /// the effects; `real` is that one with machines whose speed, load, slip, balls and noise are not quite as stated
    #[arg(long, default_value = Simulator::Shared.name(), value_parser = Simulator::ALL.map(Simulator::name))]
    simulator: String,
    /// Only write cases and truth, and diagnose nothing
    #[arg(long)]
    cases_only: bool,
    /// Length of each of a case's four recordings, s
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Only cases of these kinds
    #[arg(long, value_delimiter = ',', value_parser = Kind::ALL.map(Kind::name))]
    kind: Vec<String>,
    /// Only single effects of these severities
    #[arg(long, value_delimiter = ',', value_parser = Severity::ALL.map(Severity::name))]
    severity: Vec<String>,
    /// Only cases with one of these effects
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    effect: Vec<String>,
    /// Only every N-th of these cases
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: usize,
    /// Cases in parallel; measured times are those of a single case only with 1
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Print the scores as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    config: &'a Config,
    summary: &'a Summary,
    scores: &'a [Score],
}

impl Args {
    fn simulator(&self) -> Simulator {
        Simulator::parse(&self.simulator).unwrap_or_default()
    }

    fn check(&self) -> Result<(), Failure> {
        let refuse = |option: &str, found: String, expected: &str| Err(Failure::option(option, found, expected));
        if !SETTINGS.case_seconds.contains(&self.seconds) {
            let [least, most] = [SETTINGS.case_seconds.start(), SETTINGS.case_seconds.end()];
            return refuse("seconds", self.seconds.to_string(), &format!("{least} to {most}"));
        }
        let (rounds, jobs) = (SETTINGS.case_rounds, SETTINGS.jobs);
        for (option, found, most) in
            [("rounds", self.rounds, rounds), ("every", self.every, rounds), ("jobs", self.jobs, jobs)]
        {
            if !(1..=most).contains(&found) {
                return refuse(option, found.to_string(), &format!("1 to {most}"));
            }
        }
        let names = Config::effect_names(self.simulator());
        if let Some(found) = self.effect.iter().find(|name| !names.contains(&name.as_str())) {
            return refuse("effect", format!("`{found}`"), &format!("one of {}", names.join(", ")));
        }
        Outputs::new(Force::default(), []).folder("out", &self.out, &[])
    }
}

/// Tables of Markdown in columns of equal width, for a terminal.
fn plain(markdown: &str) -> String {
    let cells = |line: &str| -> Vec<String> {
        line.trim_matches('|').split(" | ").map(|cell| cell.trim_matches([' ', '|']).to_owned()).collect()
    };
    let mut out = Vec::new();
    for table in markdown.split("\n\n") {
        let rows: Vec<_> = table.lines().filter(|line| !line.starts_with("|---")).map(cells).collect();
        let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|c| c.chars().count()).max();
        let row = |row: &Vec<String>| {
            let padded = row.iter().enumerate().map(|(n, cell)| format!("{cell:0$}", width(n).unwrap_or_default()));
            padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        out.push(rows.iter().map(row).collect::<Vec<_>>().join("\n"));
    }
    out.join("\n\n")
}

/// Runs `evaluate`.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    let config = Config {
        seed: args.seed,
        rounds: args.rounds,
        simulator: args.simulator(),
        seconds: args.seconds,
        kinds: args.kind.clone(),
        severities: args.severity.clone(),
        effects: args.effect.clone(),
        every: args.every,
    };
    let bar = bar("evaluate");
    let progress = |name: &str, done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        bar.set_message(name.to_owned());
    };
    let failure = |e: EvaluateError| match e {
        EvaluateError::Another { .. } | EvaluateError::Nothing => Failure::input(e),
        _ => Failure::other(e),
    };
    if args.cases_only {
        let count = write_cases(&config, &args.out, args.jobs, &progress).map_err(failure)?;
        bar.finish_and_clear();
        if args.json {
            return json(&serde_json::json!({ "config": config, "cases": count }));
        }
        return line(format_args!("wrote {count} cases to {}", args.out.join("cases").display()));
    }
    let scores = evaluate(&config, &args.out, args.jobs, &progress);
    bar.finish_and_clear();
    let scores = scores.map_err(failure)?;
    let summary = Summary::from_scores(&scores);
    let document = Document { config: &config, summary: &summary, scores: &scores };
    let text = serde_json::to_vec_pretty(&document).map_err(Failure::other)?;
    write(&args.out.join("scores.json"), &text)?;
    write(&args.out.join("confusion.csv"), confusion(&scores).as_bytes())?;
    write(&args.out.join("evaluation.md"), markdown(&scores, args.seed).as_bytes())?;
    if args.json {
        return json(&document);
    }
    line(plain(&markdown(&scores, args.seed)))?;
    line(format_args!(
        "wrote {}; cases, diagnoses and truth are in the same folder",
        args.out.join("evaluation.md").display()
    ))
}

#[cfg(test)]
mod tests {
    #[test]
    fn tables_are_columns_on_a_terminal() {
        let markdown = "| what | n |\n|---|---|\n| controls | 7/8 |\n\n| a | b |\n|---|---|\n| long name | 1 |\n";
        let expected = "what      n\ncontrols  7/8\n\na          b\nlong name  1";
        assert_eq!(super::plain(markdown), expected);
    }
}
