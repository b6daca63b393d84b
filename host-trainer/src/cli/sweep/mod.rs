//! Command `ballrace sweep`.

mod presets;

use std::path::PathBuf;

use serde_json::json;

use super::input::{Recordings, bar};
use super::output::{Force, Outputs};
use super::{Failure, line, write};
use crate::sweep::config::Config;
use crate::sweep::job::{Job, Material, Row};
use crate::sweep::preset::PresetName;
use crate::sweep::{self, table};

/// Fit a grid of models: libraries, dimensions, alignments, filters, solvers; or the paper's tables and figures
///
/// sweep.toml names the recordings and the grid; every combination is a row of OUT/sweep.csv and OUT/sweep.parquet, with R² in
/// sample, held out, causal and on a surrogate (the null) side by side. With --preset the grid is that of a table or figure of
/// the paper, on the aging phases of run-to-failure folders, and OUT/paper.html shows ours, the paper's and the null's. A row
/// that is done is kept in OUT/rows.jsonl at once: after a kill the same command goes on with the others.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace sweep --config sweep.toml --out sweep\n    \
    with a sweep.toml such as\n      recordings = [\"data/Bearing3_3\"]\n      channel = \"vertical\"\n      \
    range = [305, 310]\n      solver = [\"sindy-nn\", \"stlsq\"]\n      nd = [1, 2]\n      nmd = 8\n      nf = [1, 2]\n  \
    ballrace sweep --preset all data/Bearing3_3 data/Bearing3_1 --out paper\n    \
    writes paper/paper.html")]
pub struct Args {
    /// File with recordings and grid
    #[arg(long, value_name = "sweep.toml", required_unless_present = "preset", conflicts_with = "preset")]
    config: Option<PathBuf>,
    /// Table or figure of the paper, or all
    #[arg(long, value_enum)]
    preset: Option<PresetName>,
    /// Run-to-failure folders of a preset [default: all of the folder femto in $BALLRACE_DATA or ../shared/data]
    #[arg(value_name = "FOLDER", conflicts_with = "config")]
    bearings: Vec<PathBuf>,
    /// Channel of a preset
    #[arg(long, default_value = "vertical", conflicts_with = "config")]
    channel: String,
    /// Recordings of each aging phase, spread evenly, for a preset [default: 8 for table5, 4 for table4, else 1]
    #[arg(long, value_name = "N", conflicts_with = "config")]
    count: Option<usize>,
    /// Folder for the tables
    #[arg(long, value_name = "OUT", default_value = "sweep")]
    out: PathBuf,
    /// Print the rows as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `sweep`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let check = |recordings: &[PathBuf]| {
        let outputs = Outputs::new(Force::default(), &args.config).beside(recordings);
        let files = ["sweep.csv", "sweep.parquet", "paper.html", "best.json"].map(|name| args.out.join(name));
        outputs.folder("out", &args.out, &files)
    };
    check(&args.bearings)?;
    let rows = match (&args.config, args.preset) {
        (Some(config), _) => {
            let config = Config::read(config).map_err(Failure::input)?;
            check(&config.recordings)?;
            let material = material(&config)?;
            fitted(&config.jobs(&material), &material, args)?
        }
        (None, Some(preset)) => presets::run(args, preset)?,
        (None, None) => return Err(Failure::Input("found neither --config nor --preset, expected one".into())),
    };
    write(&args.out.join("sweep.csv"), table::csv(&rows).as_bytes())?;
    write(&args.out.join("sweep.parquet"), &table::parquet(&rows).map_err(Failure::other)?)?;
    if args.json {
        return super::json(&json!({ "rows": rows }));
    }
    print(&rows)?;
    line(format_args!("wrote {0}/sweep.csv and {0}/sweep.parquet", args.out.display()))?;
    args.preset.map_or(Ok(()), |_| line(format_args!("wrote {}/paper.html", args.out.display())))
}

/// Rows of jobs, with progress.
fn fitted(jobs: &[Job], material: &Material, args: &Args) -> Result<Vec<Row>, Failure> {
    let bar = bar("sweep");
    let rows = sweep::run(jobs, material, &args.out, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    rows.map_err(Failure::other)
}

fn material(config: &Config) -> Result<Material, Failure> {
    let source =
        Recordings { recordings: config.recordings.clone(), channel: config.channel.clone(), ..Recordings::default() };
    let recordings = source.load(config.channel.clone().map(|channel| vec![channel]))?;
    config.material(&recordings).map_err(Failure::input)
}

/// Prints the means over the recordings of each model.
fn print(rows: &[Row]) -> Result<(), Failure> {
    line("nd nmd nf functions solver    alignment filter recordings     R²  held out  causal    null  seconds")?;
    let same = |a: &Row, b: &Row| {
        let without = |row: &Row| Job { recording: None, ..row.job.clone() };
        without(a) == without(b)
    };
    for group in rows.chunk_by(same) {
        let job = &group[0].job;
        let mean = |of: fn(&Row) -> Option<f64>| {
            let known: Vec<f64> = group.iter().filter_map(of).collect();
            if known.is_empty() {
                "–".into()
            } else {
                format!("{:.4}", known.iter().sum::<f64>() / known.len() as f64)
            }
        };
        line(format_args!(
            "{:2} {:3} {:2} {:9} {:9} {:9} {:6} {:10} {:>6}  {:>8}  {:>6}  {:>6}  {:7.2} {}",
            job.sizes.nd,
            job.sizes.nmd,
            job.sizes.nf,
            group[0].functions,
            table::text(job.solver).unwrap_or_default(),
            table::text(job.alignment).unwrap_or_default(),
            job.filter,
            group.len(),
            mean(|row| row.r2),
            mean(|row| row.r2_held_out),
            mean(|row| row.r2_causal),
            mean(|row| row.r2_null),
            group.iter().map(|row| row.seconds).sum::<f64>(),
            group.iter().find_map(|row| row.error.as_deref()).unwrap_or_default()
        ))?;
    }
    Ok(())
}
