//! Command `ballrace library`.

use serde_json::json;

use super::input::{Recordings, spinner};
use super::{Failure, line};
use crate::model::fit::choice::SolverKind;
use crate::sweep::construct::{Construction, Limits, construct};
use crate::sweep::job::{Job, Material, Row};

/// Construct a library of candidate functions in three steps
///
/// The paper's steps: the polynomial degrees n_D that reach an R², for them the dimensions n_MD, for these the harmonics n_F, each
/// fit within a time. Of all that reach it the library with the greatest R² on a part that was not fitted to is chosen, and
/// scored beside a surrogate of the recordings (the null). More than one recording is fitted together.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace library data/Bearing3_3/acc_00306.csv --channel vertical\n    \
    prints what was tried, and the chosen n_D, n_MD and n_F")]
pub struct Args {
    #[command(flatten)]
    input: Recordings,
    /// R² in sample that a library must reach
    #[arg(long, default_value_t = Limits::default().target, value_name = "R2")]
    target: f64,
    /// Longest time of a fit, s
    #[arg(long, default_value_t = Limits::default().seconds, value_name = "S")]
    seconds: f64,
    /// Solver
    #[arg(long, value_enum, default_value_t = SolverKind::Stlsq)]
    solver: SolverKind,
    /// Greatest degree n_D, 1 to 9
    #[arg(long, default_value_t = Limits::default().max_nd, value_name = "N")]
    max_nd: usize,
    /// Greatest dimension n_MD, 1 to 16
    #[arg(long, default_value_t = Limits::default().max_nmd, value_name = "N")]
    max_nmd: usize,
    /// Most harmonics n_F, 1 to 64
    #[arg(long, default_value_t = Limits::default().max_nf, value_name = "N")]
    max_nf: usize,
    /// Seed of everything random
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `library`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let limits = args.limits()?;
    let input = args.input.read(None)?;
    let material = Material { sample_rate_hz: input.sample_rate_hz, series: input.continuous(input.series.len()) };
    let job = |sizes, null| Job {
        sizes,
        solver: args.solver.into(),
        seed: args.seed,
        null,
        causal: null > 0,
        ..Job::default()
    };
    let spinner = spinner();
    let construction = construct(&limits, &mut |sizes| {
        spinner.set_message(format!("n_D {}, n_MD {}, n_F {}", sizes.nd, sizes.nmd, sizes.nf));
        job(sizes, 0).fit(&material)
    });
    let scored = construction.chosen.as_ref().map(|row| job(row.job.sizes.clone(), 1).fit(&material));
    spinner.finish_and_clear();
    if let Some(error) = scored.as_ref().and_then(|row| row.error.clone()) {
        return Err(Failure::Other(error));
    }
    if construction.chosen.is_none()
        && let Some(error) = construction.steps.iter().flat_map(|step| &step.tried).find_map(|row| row.error.clone())
    {
        return Err(Failure::Input(error));
    }
    if args.json {
        return super::json(&json!({ "limits": limits, "construction": construction, "scored": scored }));
    }
    print(&construction, scored.as_ref())
}

impl Args {
    fn limits(&self) -> Result<Limits, Failure> {
        let refuse = |option: &str, found: String, expected: &str| Err(Failure::option(option, found, expected));
        if !(self.seconds.is_finite() && self.seconds > 0.0) {
            return refuse("seconds", self.seconds.to_string(), "a positive number");
        }
        if !(self.target.is_finite() && self.target < 1.0) {
            return refuse("target", self.target.to_string(), "a number below 1");
        }
        for (option, found, most) in
            [("max-nd", self.max_nd, 9), ("max-nmd", self.max_nmd, 16), ("max-nf", self.max_nf, 64)]
        {
            if !(1..=most).contains(&found) {
                return refuse(option, found.to_string(), &format!("1 to {most}"));
            }
        }
        let Self { target, seconds, max_nd, max_nmd, max_nf, .. } = *self;
        Ok(Limits { target, seconds, max_nd, max_nmd, max_nf })
    }
}

fn print(construction: &Construction, scored: Option<&Row>) -> Result<(), Failure> {
    let number = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.4}"));
    for (n, step) in construction.steps.iter().enumerate() {
        line(format_args!("step {}: {}", n + 1, step.name))?;
        if !step.tried.is_empty() {
            line("  n_D n_MD n_F functions  in sample  validation  seconds")?;
        }
        for row in &step.tried {
            let sizes = &row.job.sizes;
            line(format_args!(
                "  {:3} {:4} {:3} {:9}  {:>9}  {:>10}  {:7.2} {}",
                sizes.nd,
                sizes.nmd,
                sizes.nf,
                row.functions,
                number(row.r2),
                number(row.r2_validation),
                row.seconds,
                row.error.as_deref().unwrap_or_default()
            ))?;
        }
        line(format_args!("  kept: {}", step.kept))?;
    }
    let Some(row) = scored else { return line(format_args!("no library chosen: {}", construction.why)) };
    let sizes = &row.job.sizes;
    line(format_args!(
        "chosen: n_D {}, n_MD {}, n_F {}, {} functions: {}",
        sizes.nd, sizes.nmd, sizes.nf, row.functions, construction.why
    ))?;
    line(format_args!(
        "R² in sample {} (null {}), held out {}, next sample {} (null {})",
        number(row.r2),
        number(row.r2_null),
        number(row.r2_held_out),
        number(row.r2_causal),
        number(row.r2_causal_null)
    ))
}
