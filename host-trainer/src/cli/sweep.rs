//! Command `ballrace sweep`.

use std::path::PathBuf;

use serde_json::json;

use super::input::{Recordings, bar};
use super::{Failure, line, write};
use crate::recording::input::Input;
use crate::sweep::config::Config;
use crate::sweep::job::{Job, Material, Row};
use crate::sweep::{self, table};

/// Fit a grid of models: libraries, dimensions, alignments, filters, solvers
///
/// sweep.toml names the recordings and the grid; every combination is a row of OUT/sweep.csv and OUT/sweep.parquet, with R² in
/// sample, held out, causal and on a phase-randomised surrogate (the null) side by side. A row that is done is kept in
/// OUT/rows.jsonl at once: after a kill the same command goes on with the others.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace sweep --config sweep.toml --out sweep\n    \
    with a sweep.toml such as\n      recordings = [\"data/Bearing3_3\"]\n      channel = \"vertical\"\n      \
    range = [305, 310]\n      solver = [\"sindy-nn\", \"stlsq\"]\n      nd = [1, 2]\n      nmd = 8\n      nf = [1, 2]")]
pub struct Args {
    /// File with recordings and grid
    #[arg(long, value_name = "sweep.toml")]
    config: PathBuf,
    /// Folder for the tables
    #[arg(long, value_name = "OUT", default_value = "sweep")]
    out: PathBuf,
    /// Print the rows as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `sweep`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let config = Config::read(&args.config).map_err(Failure::input)?;
    let material = material(&config)?;
    let bar = bar("sweep");
    let rows = sweep::run(&config, &material, &args.out, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    let rows = rows.map_err(Failure::other)?;
    write(&args.out.join("sweep.csv"), table::csv(&rows).as_bytes())?;
    write(&args.out.join("sweep.parquet"), &table::parquet(&rows).map_err(Failure::other)?)?;
    if args.json {
        return super::json(&json!({ "rows": rows }));
    }
    print(&rows)?;
    line(format_args!("wrote {0}/sweep.csv and {0}/sweep.parquet", args.out.display()))
}

fn material(config: &Config) -> Result<Material, Failure> {
    let source =
        Recordings { recordings: config.recordings.clone(), channel: config.channel.clone(), ..Recordings::default() };
    let recordings = source.load(config.channel.clone().map(|channel| vec![channel]))?;
    let mut input = Input::from_recordings(&recordings, config.channel.as_deref()).map_err(Failure::input)?;
    // Files of two folders may have one name.
    for (series, recording) in input.series.iter_mut().zip(&recordings) {
        let path = &recording.source.path;
        series.name = path.strip_prefix(&config.base).unwrap_or(path).display().to_string();
    }
    let [first, end] = config.range.unwrap_or([0, input.series.len()]);
    let Some(series) = input.series.get(first..end) else {
        return Err(Failure::Input(format!(
            "range: found [{first}, {end}], expected within 0 to {}",
            input.series.len()
        )));
    };
    Ok(Material { series: series.to_vec(), sample_rate_hz: input.sample_rate_hz })
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
