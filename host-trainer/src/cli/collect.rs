//! Command `ballrace collect`.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ballrace_core::telemetry::{NAME_RULE, is_name};
use serde_json::json;

use super::broker::{Broker, failure};
use super::{Failure, line};
use crate::fleet::collect::{CollectError, Notice, Options, collect};
use crate::fleet::store::{Counts, Store};
use crate::recording::bounded;

/// Interval of the progress lines.
const PROGRESS: Duration = Duration::from_secs(5);

/// Collect the messages of machines from an MQTT broker into SQLite, and into Parquet if wanted
///
/// Each message is stored before it is acknowledged, once: killed and started again, the collector goes on where it was,
/// and the broker keeps what comes meanwhile. Messages that are too long, malformed or of an unknown machine are counted and
/// dropped.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace collect mqtts://broker.example/plant1 --ca ca.pem --user collector \
    --password-file password.txt --machines machines.txt --out fleet.sqlite")]
pub struct Args {
    /// Broker and prefix of the topics: mqtt://HOST[:PORT][/PREFIX] or mqtts://…
    address: String,
    /// SQLite file, continued if it is there
    #[arg(long, value_name = "FILE.sqlite")]
    out: PathBuf,
    /// Also write Parquet, DIR/machine=NAME/day=DATE/*.parquet, every 5 minutes and at the end
    #[arg(long, value_name = "DIR")]
    parquet: Option<PathBuf>,
    /// Known machines, one name a line; messages of others are dropped [default: all are known]
    #[arg(long, value_name = "FILE")]
    machines: Option<PathBuf>,
    #[command(flatten)]
    broker: Broker,
    /// End after this time, s [default: never]
    #[arg(long = "for", value_name = "SECONDS")]
    end_after: Option<f64>,
    /// End after this time without a message, s [default: never]
    #[arg(long, value_name = "SECONDS")]
    until_idle: Option<f64>,
    /// Print the counts as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `collect`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let link = args.broker.link(&args.address)?;
    let options = Options {
        known: args.machines.as_deref().map(names).transpose()?,
        end_after: seconds("for", args.end_after)?,
        until_idle: seconds("until-idle", args.until_idle)?,
        parquet: args.parquet.clone(),
    };
    if let Some(found) = args.parquet.as_ref().filter(|path| path.exists() && !path.is_dir()) {
        return Err(Failure::option("parquet", found.display(), "a folder"));
    }
    let mut store = Store::open(&args.out).map_err(Failure::input)?;
    let mut printed = Instant::now();
    let counts = collect(&link, &mut store, &options, &mut |notice| match notice {
        Notice::Connected { kept } => {
            let session = if *kept { "the broker kept the session" } else { "a new session" };
            eprintln!("connected to {}, {session}", link.broker());
        }
        Notice::Lost { error, wait } => eprintln!("{error}; next attempt in {:.1} s", wait.as_secs_f64()),
        Notice::Stored(counts) => {
            if printed.elapsed() >= PROGRESS {
                printed = Instant::now();
                eprintln!("{}", text(counts));
            }
        }
    })
    .map_err(|error| match error {
        CollectError::Link(error) => failure(error),
        CollectError::Store(error) => Failure::other(error),
        CollectError::Partitions(error) => Failure::other(error),
    })?;
    let all = store.counts().map_err(Failure::other)?;
    if args.json {
        return super::json(
            &json!({ "schema": "ballrace-collect/1", "file": args.out, "counts": counts, "in_all": all }),
        );
    }
    line(text(&counts))
}

fn text(counts: &Counts) -> String {
    let Counts { accepted, duplicates, too_long, malformed, unknown_machine } = counts;
    format!(
        "{accepted} messages stored; dropped: {duplicates} duplicates, {too_long} too long, {malformed} malformed, \
         {unknown_machine} of unknown machines"
    )
}

fn seconds(option: &str, value: Option<f64>) -> Result<Option<Duration>, Failure> {
    let wrong = |value: f64| Failure::option(option, value, "a positive number of seconds");
    let Some(value) = value else { return Ok(None) };
    match Duration::try_from_secs_f64(value) {
        Ok(duration) if !duration.is_zero() => Ok(Some(duration)),
        _ => Err(wrong(value)),
    }
}

/// Names of the known machines, one a line; empty lines and lines that begin with `#` are skipped.
fn names(path: &Path) -> Result<HashSet<String>, Failure> {
    let failed = |error: std::io::Error| Failure::Input(format!("{}: {error}", path.display()));
    let bytes = bounded::settings(path).map_err(failed)?;
    let text = String::from_utf8(bytes).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
    let mut names = HashSet::new();
    for (row, name) in text.lines().enumerate().map(|(row, line)| (row + 1, line.trim())) {
        if name.is_empty() || name.starts_with('#') {
            continue;
        }
        if !is_name(name) {
            let path = path.display();
            return Err(Failure::Input(format!("{path}, row {row}: found {name:?}, expected {NAME_RULE}")));
        }
        names.insert(name.to_owned());
    }
    if names.is_empty() {
        return Err(Failure::Input(format!("{}: found no name, expected one a line", path.display())));
    }
    Ok(names)
}
