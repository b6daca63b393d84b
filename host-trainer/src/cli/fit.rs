//! Command `ballrace fit`.

use std::path::PathBuf;

use ballrace_core::states::{Orders, StateSpec};
use clap::ValueEnum;

use super::budget::DeviceArgs;
use super::input::{Recordings, bar};
use super::output::{Force, Outputs};
use super::settings::CliSettings;
use super::{Failure, json, line, write};
use crate::diagnose::causes;
use crate::model::budget::budget;
use crate::model::budget::within::{CycleLimit, fit_within};
use crate::model::file;
use crate::model::fit::choice::{AlignmentKind, ArithmeticKind, EstimatorKind, SolverKind};
use crate::model::fit::{FitConfig, Fitted, Solver, Stage, fit, terms, text};
use crate::model::sindy_nn::config::{PAPER_UNITS, TrainConfig};
use crate::model::sindy_nn::gradient::{Lambdas, SparsityNorm};
use crate::model::sindy_nn::schedule::Schedule;
use crate::model::stlsq::StlsqConfig;
use crate::report;
use crate::signal::surrogate::SurrogateKind;

const SETTINGS: CliSettings = CliSettings::DEFAULT;

/// Fit a model to recordings of the healthy machine
///
/// Prints the sparse equations and four scores side by side: R² in sample, held out, causal, and on
/// surrogates (the null).
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace fit data/Bearing3_3 --healthy 100 --out model.json\n  \
    fits SINDy-NN to the first 100 recordings of a run to failure and writes model.json\n  \
    ballrace fit corrected --diagnosis diagnosis/diagnosis.json --out model.json\n  \
    fits recordings of the corrected rig with the terms of the causes found by `diagnose`")]
pub struct Args {
    #[command(flatten)]
    input: Recordings,
    /// File for the model
    #[arg(long, value_name = "model.json")]
    out: PathBuf,
    /// Identification method
    #[arg(long, value_enum, default_value_t = SolverKind::SindyNn)]
    solver: SolverKind,
    /// Healthy recordings from the start, to which the model and its limits are fitted [default: all;
    /// of a run to failure the first quarter, at most 100]
    #[arg(long, value_name = "N")]
    healthy: Option<usize>,
    /// Model dimension n_MD, 1 to 16
    #[arg(long, default_value_t = 8, value_name = "N")]
    nmd: usize,
    /// Polynomial degree n_D, 0 for none
    #[arg(long, default_value_t = 2, value_name = "N")]
    nd: usize,
    /// Fourier harmonics n_F, 0 for none
    #[arg(long, default_value_t = 2, value_name = "N")]
    nf: usize,
    /// Add |z|^(2/3) and sgn(z)|z|^(2/3) of each variable, terms of a lubricant's film
    #[arg(long)]
    powers: bool,
    /// Alignment of the finite differences in time
    #[arg(long, value_enum, default_value_t = AlignmentKind::Half)]
    alignment: AlignmentKind,
    /// Estimator of the states of order 1 and above; all but differences need `--alignment causal`
    #[arg(long, value_enum, default_value_t = EstimatorKind::Differences)]
    estimator: EstimatorKind,
    /// Degree of a Savitzky–Golay polynomial above the order of its derivative [default: 0]
    #[arg(long, value_name = "N")]
    excess: Option<u8>,
    /// Samples of a Savitzky–Golay window for each coefficient of its polynomial [default: 1.25]
    #[arg(long, value_name = "F")]
    stretch: Option<f32>,
    /// Cut-off of the Kalman filter in cycles a sample [default: 0.22]
    #[arg(long, value_name = "F")]
    cutoff: Option<f32>,
    /// Orders of the finite differences
    #[arg(long, value_enum, default_value_t = OrdersName::Even)]
    orders: OrdersName,
    /// Result of `diagnose`: the terms of its causes are added to the library
    #[arg(long, value_name = "diagnosis.json")]
    diagnosis: Option<PathBuf>,
    /// Latent variables [default: n_MD]
    #[arg(long, value_name = "N")]
    latent: Option<usize>,
    /// Widths of the encoder's hidden layers
    #[arg(long, value_delimiter = ',', default_values_t = [PAPER_UNITS])]
    hidden: Vec<usize>,
    /// Arithmetic of the networks on the device
    #[arg(long, value_enum, default_value_t = ArithmeticKind::Float)]
    arithmetic: ArithmeticKind,
    /// Cycle limit of a sample, by the prediction of `budget`: where --hidden and --arithmetic take more, the fit takes as many
    /// units in fixed point as keep to it [default: none]
    #[arg(long, value_name = "CYCLES")]
    budget_cycles: Option<usize>,
    #[command(flatten)]
    device: DeviceArgs,
    /// λ1, λ2, λ3 of the losses
    #[arg(long, value_delimiter = ',', default_value = "0.5,0.01,0.01")]
    lambda: Vec<f64>,
    /// Norm of the coefficients that λ3 weighs
    #[arg(long, value_enum, default_value_t = SparsityNorm::default())]
    sparsity: SparsityNorm,
    /// Adam's learning rate, where the schedule begins [default: 0.01, of a constant one 0.001]
    #[arg(long, value_name = "RATE")]
    learning_rate: Option<f32>,
    /// Learning rate over the steps
    #[arg(long, value_enum, default_value_t)]
    schedule: Schedule,
    /// Samples in a batch
    #[arg(long, default_value_t = 1024)]
    batch: usize,
    /// Maximum number of epochs [default: 500; of a cosine with fewer than 256 hidden units up to 12 times as many]
    #[arg(long, value_name = "N")]
    epochs: Option<usize>,
    /// Maximum number of gradient steps [default: of a cosine 2000, with fewer than 256 hidden units up to 12 times as many; of a
    /// constant rate 6000]
    #[arg(long, value_name = "N")]
    max_steps: Option<usize>,
    /// Share of power below which a term is removed [default: chosen on validation recordings, for
    /// stlsq per equation]
    #[arg(long, value_name = "SHARE")]
    threshold: Option<f64>,
    /// Ridge penalty of stlsq on scaled coefficients
    #[arg(long, default_value_t = StlsqConfig::default().ridge)]
    ridge: f64,
    /// Hold out every N-th recording
    #[arg(long, default_value_t = 5, value_name = "N")]
    hold_out: usize,
    /// Surrogate fits for the null
    #[arg(long, default_value_t = 5, value_name = "N")]
    null: usize,
    /// What a surrogate has of its recording
    #[arg(long, value_enum, default_value_t = SurrogateKind::default())]
    null_kind: SurrogateKind,
    /// Trainings of sindy-nn from different seeds; the best on the validation recordings is the model
    #[arg(long, default_value_t = 3, value_name = "N")]
    trainings: usize,
    /// Full scale of the sensor in m/s²: samples at or beyond it count as saturated [0: 64 times the greatest magnitude of the
    /// healthy recordings]
    #[arg(long, default_value_t = 0.0, value_name = "A")]
    full_scale: f32,
    /// False alarms a day for which the monitor's limit is set. A day holds the recordings that their starts say (FEMTO: one
    /// every 10 s), or without starts as many blocks as monitoring without a pause fills
    #[arg(long, default_value_t = FitConfig::default().false_alarms_per_day, value_name = "RATE")]
    false_alarms_per_day: f64,
    /// Samples in a block of the monitor [default: a tenth of a second]
    #[arg(long, value_name = "N")]
    block: Option<u32>,
    /// Write a report with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print every term of every equation
    #[arg(long)]
    all_terms: bool,
    /// Seed of everything random
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print the report as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum OrdersName {
    Even,
    Consecutive,
}

impl Args {
    /// Checks options and outputs before the work starts.
    fn check(&self) -> Result<(), Failure> {
        let refuse = |option: &str, found: String, expected: &str| Err(Failure::option(option, found, expected));
        for (option, found, least) in [
            ("batch", self.batch, 1),
            ("hold-out", self.hold_out, 2),
            ("trainings", self.trainings, 1),
            ("epochs", self.epochs.unwrap_or(1), 1),
            ("max-steps", self.max_steps.unwrap_or(1), 1),
        ] {
            if found < least {
                return refuse(option, found.to_string(), &format!("at least {least}"));
            }
        }
        for (option, found) in [("trainings", self.trainings), ("null", self.null)] {
            if found > SETTINGS.fits {
                return refuse(option, found.to_string(), &format!("at most {}", SETTINGS.fits));
            }
        }
        if self.lambda.len() != 3 || self.lambda.iter().any(|l| !(l.is_finite() && *l >= 0.0)) {
            return refuse("lambda", format!("{:?}", self.lambda), "three numbers that are not negative");
        }
        if let Some(rate) = self.learning_rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return refuse("learning-rate", rate.to_string(), "a positive number");
        }
        if !(self.false_alarms_per_day.is_finite() && self.false_alarms_per_day > 0.0) {
            return refuse("false-alarms-per-day", self.false_alarms_per_day.to_string(), "a positive number");
        }
        if !(self.ridge.is_finite() && self.ridge >= 0.0) {
            return refuse("ridge", self.ridge.to_string(), "a number that is not negative");
        }
        if let Some(threshold) = self.threshold.filter(|t| !(0.0..1.0).contains(t)) {
            return refuse("threshold", threshold.to_string(), "a share from 0 to below 1");
        }
        self.check_estimator()?;
        let mut outputs = Outputs::new(self.force, &self.diagnosis).beside(&self.input.recordings);
        outputs.file("out", &self.out)?;
        self.report.iter().try_for_each(|path| outputs.file("report", path))
    }

    /// Checks that the estimator suits the alignment, and its parameters the estimator.
    fn check_estimator(&self) -> Result<(), Failure> {
        let kind = |kind: EstimatorKind| kind.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned());
        let found = kind(self.estimator);
        if self.estimator != EstimatorKind::Differences && self.alignment != AlignmentKind::Causal {
            let alignment = self.alignment.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned());
            return Err(Failure::Input(format!(
                "--estimator: found {found} with --alignment {alignment}, expected --alignment causal"
            )));
        }
        for (option, given, of) in [
            ("excess", self.excess.is_some(), EstimatorKind::SavitzkyGolay),
            ("stretch", self.stretch.is_some(), EstimatorKind::SavitzkyGolay),
            ("cutoff", self.cutoff.is_some(), EstimatorKind::Kalman),
        ] {
            if given && self.estimator != of {
                let expected = kind(of);
                return Err(Failure::Input(format!(
                    "--{option}: found --estimator {found}, expected --estimator {expected}, whose parameter it is"
                )));
            }
        }
        Ok(())
    }

    fn config(&self) -> FitConfig {
        let solver = match self.solver {
            SolverKind::Stlsq => {
                Solver::Stlsq(StlsqConfig { threshold: self.threshold, ridge: self.ridge, ..StlsqConfig::default() })
            }
            SolverKind::SindyNn => {
                let [derivative, latent, sparsity] =
                    std::array::from_fn(|i| self.lambda.get(i).copied().unwrap_or(0.0));
                let base = match self.schedule {
                    Schedule::Cosine => TrainConfig::default(),
                    Schedule::Constant => TrainConfig::PAPER,
                };
                Solver::SindyNn {
                    hidden: self.hidden.clone(),
                    train: TrainConfig {
                        lambdas: Lambdas { derivative, latent, sparsity, norm: self.sparsity },
                        learning_rate: self.learning_rate.unwrap_or(base.learning_rate),
                        batch: self.batch,
                        epochs: self.epochs.or(base.epochs),
                        max_steps: self.max_steps.or(base.max_steps),
                        threshold: self.threshold,
                        ..base
                    },
                }
            }
        };
        FitConfig {
            spec: StateSpec {
                dimension: self.nmd,
                orders: match self.orders {
                    OrdersName::Even => Orders::Even,
                    OrdersName::Consecutive => Orders::Consecutive,
                },
                alignment: self.alignment.into(),
                estimator: self.estimator.with(self.excess, self.stretch, self.cutoff),
            },
            degree: self.nd,
            harmonics: self.nf,
            powers: self.powers,
            latent: self.latent,
            solver,
            arithmetic: self.arithmetic.into(),
            hold_out_every: self.hold_out,
            null_fits: self.null,
            null_kind: self.null_kind,
            causal: true,
            trainings: self.trainings,
            seed: self.seed,
            block: self.block,
            full_scale: self.full_scale,
            false_alarms_per_day: self.false_alarms_per_day,
            interval_s: None,
        }
    }
}

/// Default count of healthy recordings of a run to failure.
fn healthy_by_default(recordings: usize) -> usize {
    (recordings / SETTINGS.healthy_divisor).clamp(1, SETTINGS.healthy_maximum)
}

/// Runs `fit`.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    let mut config = args.config();
    let causes = args.diagnosis.as_deref().map(causes::read).transpose().map_err(Failure::input)?;
    let entered = terms::enter(&mut config, causes.as_deref().unwrap_or_default()).map_err(Failure::input)?;
    let mut input = args.input.read(None)?;
    let total = input.series.len();
    let healthy = args.healthy.unwrap_or(if input.run_to_failure { healthy_by_default(total) } else { total });
    if healthy == 0 || healthy > total {
        return Err(Failure::option("healthy", healthy, format!("1 to {total} recordings")));
    }
    input.series.truncate(healthy);
    if input.skipped_rows > 0 {
        eprintln!("{} bad rows dropped", input.skipped_rows);
    }
    let bar = bar("fit");
    let series = input.continuous(healthy);
    // Of a recording cut at its gaps each part is a series.
    config.interval_s = input.interval_s.map(|interval| interval * healthy as f64 / series.len().max(1) as f64);
    let progress = |stage: Stage| {
        bar.set_message(stage.name);
        bar.set_position((100.0 * stage.done) as u64);
    };
    let fitted = match args.budget_cycles {
        Some(most) => {
            let limit = CycleLimit { device: args.device.config(), most };
            fit_within(&series, input.sample_rate_hz, &config, &limit, &progress).map_err(Failure::input)
        }
        None => fit(&series, input.sample_rate_hz, &config, &progress).map_err(Failure::input),
    };
    bar.finish_and_clear();
    let mut fitted = fitted?;
    fitted.report.training.channel = Some(input.channel.clone());
    fitted.report.training.entered = entered;
    // Drawn before anything is written, so that an interruption leaves nothing.
    let drawn = |path| Ok((path, report::fit::document(&fitted, &input).map_err(Failure::other)?.html()));
    let page = args.report.as_ref().map(drawn).transpose()?;
    file::write(&args.out, &fitted.model, &fitted.report).map_err(Failure::other)?;
    if let Some((path, html)) = page {
        write(path, html.as_bytes())?;
    }
    let Fitted { model, report } = &fitted;
    if args.json {
        return json(report);
    }
    line(format_args!("{} of {total} recordings taken as healthy", healthy))?;
    if causes.is_some_and(|causes| causes.is_empty()) {
        line("the diagnosis names no cause, so the library is unchanged")?;
    }
    line(text::report(report, if args.all_terms { usize::MAX } else { SETTINGS.terms }))?;
    if let Some(most) = args.budget_cycles {
        let worst = budget(&model.view(), args.device.config()).worst_cycles;
        let units = model.view().encoder.hidden_width();
        line(format_args!("{worst:.0} of {most} cycles for the most expensive sample, with {units} hidden units"))?;
    }
    line(format_args!("wrote {} ({} bytes on the device)", args.out.display(), model.bytes().len()))
}
