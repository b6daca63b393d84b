//! Command `ballrace export`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::budget::DeviceArgs;
use super::output::{Force, Outputs};
use super::{Failure, json, line, write};
use crate::model::OwnedModel;
use crate::model::budget;
use crate::model::export::{self, Format, Limits};
use crate::model::file;
use crate::model::fit::choice::ArithmeticKind;

/// Write the fixed-size model for the device
///
/// Refuses a model that breaks one of the device's limits, and names the limit.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace export model.json --format c --out ballrace_model.h\n  \
    writes the model as a C array with its sizes; --format bin is used in place from flash\n\n\
    Limits of the device's code: n_MD and latent variables up to 16, polynomial degree up to 11,\n  \
    up to 6 layers of up to 1024 units; flash and RAM as stated by --max-flash and --max-ram,\n  \
    cycles of the most expensive sample by --budget-cycles, as `ballrace budget` predicts them for --target")]
pub struct Args {
    /// Model written by `ballrace fit`
    model: PathBuf,
    /// Format of the model
    #[arg(long, value_enum)]
    format: FormatName,
    /// Arithmetic of the networks [default: the model's]
    #[arg(long, value_enum)]
    arithmetic: Option<ArithmeticKind>,
    /// Output file
    #[arg(long)]
    out: PathBuf,
    /// Flash limit of the model, bytes
    #[arg(long, default_value_t = Limits::default().flash_bytes, value_name = "BYTES")]
    max_flash: usize,
    /// RAM limit of the evaluator, bytes
    #[arg(long, default_value_t = Limits::default().ram_bytes, value_name = "BYTES")]
    max_ram: usize,
    /// Cycle limit of a sample, by the prediction of `budget`; a model over it goes into fixed point if that is enough, unless
    /// --arithmetic is given, else it is refused [default: none]
    #[arg(long, value_name = "CYCLES")]
    budget_cycles: Option<usize>,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    force: Force,
    /// Print the sizes as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum FormatName {
    Json,
    Bin,
    Rust,
    C,
}

/// Runs `export`.
pub fn run(args: &Args) -> Result<(), Failure> {
    Outputs::new(args.force, [&args.model]).file("out", &args.out)?;
    let (model, _) = file::read(&args.model).map_err(Failure::input)?;
    let model = match args.arithmetic {
        Some(arithmetic) => model
            .with_arithmetic(arithmetic.into())
            .map_err(|error| Failure::Input(format!("{}, --arithmetic: {error}", args.model.display())))?,
        None => model,
    };
    let over = |model: &OwnedModel| match args.budget_cycles {
        Some(most) => budget::budget(&model.view(), args.device.config()).check_cycles(most),
        None => Ok(()),
    };
    let model = match (over(&model), args.arithmetic, model.with_arithmetic(ArithmeticKind::Fixed.into())) {
        (Err(broken), None, Ok(fixed)) if over(&fixed).is_ok() => {
            eprintln!(
                "{broken} as it is; its networks were put in fixed point (`fit --arithmetic fixed` finds the healthy level anew)"
            );
            fixed
        }
        _ => model,
    };
    let limits = Limits { flash_bytes: args.max_flash, ram_bytes: args.max_ram };
    let sizes = export::sizes(&model.view());
    limits.check(&sizes).map_err(Failure::input)?;
    over(&model).map_err(Failure::input)?;
    let format = match args.format {
        FormatName::Json => Format::Json,
        FormatName::Bin => Format::Bin,
        FormatName::Rust => Format::Rust,
        FormatName::C => Format::C,
    };
    let bytes = export::export(&model, format).map_err(Failure::other)?;
    write(&args.out, &bytes)?;
    if args.json {
        return json(&sizes);
    }
    line(format_args!("wrote {} ({} bytes)", args.out.display(), bytes.len()))?;
    line(format_args!("  flash for the model {:>8} of {} bytes", sizes.flash_bytes, limits.flash_bytes))?;
    line(format_args!("  RAM for the scratch {:>8} of {} bytes", sizes.ram_bytes, limits.ram_bytes))?;
    line(format_args!(
        "  a sample            {:>8} multiply-adds, {} sigmoids, {} sines or cosines, {} terms",
        sizes.multiply_adds, sizes.sigmoids, sizes.sines, sizes.terms
    ))
}
