//! Presets of `ballrace sweep`: the paper's tables and figures on run-to-failure folders.

use std::path::Path;

use super::{Args, fitted};
use crate::cli::bearings::{self, Aging};
use crate::cli::input::Recordings;
use crate::cli::settings::CliSettings;
use crate::cli::{Failure, write};
use crate::model::baseline::LinearPredictor;
use crate::model::fit::{FitConfig, Solver, Split, fit};
use crate::model::sindy_nn::config::{PAPER_UNITS, TrainConfig};
use crate::model::{OwnedModel, file};
use crate::recording::input::Series;
use crate::report::paper::{self, Baseline, Page, PresetRows};
use crate::rivals::windows::linear_r_squared;
use crate::rivals::{self, Task};
use crate::signal::phases::Rules;
use crate::signal::phases::machine::Machine;
use crate::sweep::job::{Material, Row};
use crate::sweep::life::{self, Life};
use crate::sweep::preset::{Preset, PresetName};

const SETTINGS: CliSettings = CliSettings::DEFAULT;

/// Rows of the presets; writes the page.
pub fn run(args: &Args, name: PresetName) -> Result<Vec<Row>, Failure> {
    if args.count == Some(0) {
        return Err(Failure::option("count", 0, "at least 1"));
    }
    let loaded = bearings::aging(&args.bearings, &args.channel, |folder, name| load(args, folder, name))?;
    let lives: Vec<Life> = loaded.into_iter().map(|aging| aging.value).collect();
    let presets = name.presets();
    let (material, jobs) = life::grid(&lives, &presets, args.count).map_err(Failure::input)?;
    let rows = fitted(&jobs.concat(), &material, args)?;
    let mut left = rows.as_slice();
    let by_preset = presets.iter().zip(&jobs).map(|(preset, jobs)| {
        let (own, rest) = left.split_at(jobs.len());
        left = rest;
        PresetRows { preset: *preset, rows: own }
    });
    let by_preset: Vec<PresetRows<'_>> = by_preset.collect();
    let baselines = by_preset.iter().find(|own| own.preset == Preset::Table4).map(|own| baselines(own.rows, &material));
    let first = life::of_paper(&lives).map_err(Failure::input)?;
    let (model, series) = best_model(args, first)?;
    let machines: Vec<Machine> = lives
        .iter()
        .map(|life| Machine { name: life.bearing.name.clone(), lives: life.lives.clone(), phases: life.phases.clone() })
        .collect();
    let page = paper::document(&Page {
        presets: &by_preset,
        machines: machines.iter().collect(),
        bearing: &first.bearing.name,
        channel: &args.channel,
        rules: Rules::default(),
        baselines: baselines.unwrap_or_default(),
        model: &model,
        shown: series,
        sample_rate_hz: first.sample_rate_hz,
    });
    write(&args.out.join("paper.html"), page.map_err(Failure::other)?.html().as_bytes())?;
    Ok(rows)
}

/// Folder; `None` if its channel does not age.
fn load(args: &Args, folder: &Path, name: String) -> Result<Option<Aging<Life>>, Failure> {
    let source = Recordings {
        recordings: vec![folder.to_owned()],
        channel: Some(args.channel.clone()),
        ..Recordings::default()
    };
    let recordings = source.load(Some(vec![args.channel.clone()]))?;
    let wavelet = SETTINGS.wavelet.parse().map_err(Failure::other)?;
    let life = Life::new(&name, &recordings, &args.channel, wavelet).map_err(Failure::input)?;
    Ok(life.map(|value| Aging { name, sample_rate_hz: value.sample_rate_hz, value }))
}

/// Scores of the linear baselines on the recordings of some rows, fitted and held out as the models are.
fn baselines(rows: &[Row], material: &Material) -> Vec<Baseline> {
    let names: std::collections::BTreeSet<&String> = rows.iter().filter_map(|row| row.job.recording.as_ref()).collect();
    let chosen = material.series.iter().filter(|series| names.contains(&series.name));
    let config = FitConfig::default();
    let splits: Vec<Split> = chosen
        .map(|series| Split::holding_out(std::slice::from_ref(series), config.hold_out_every, config.spec.warm_up()))
        .collect();
    let mean = |of: &dyn Fn(&Split) -> Option<f64>| {
        let scores: Option<Vec<f64>> = splits.iter().map(of).collect();
        scores.map(|scores| scores.iter().sum::<f64>() / scores.len() as f64)
    };
    let next = |model: fn(&[Series]) -> Option<LinearPredictor>| {
        mean(&|split| Some(model(&split.train)?.r_squared(&split.held_out)))
    };
    let windows = |split: &Split| {
        let parts = rivals::Parts::new(split, Task::Derivatives(config.spec));
        linear_r_squared(&parts.train, &parts.held_out)
    };
    let baseline = |name, r2_causal| Baseline { name, r2_causal, ..Baseline::default() };
    vec![
        Baseline {
            name: "least squares on the rivals' window",
            r2: mean(&|split| Some(windows(split)?[0])),
            r2_held_out: mean(&|split| Some(windows(split)?[1])),
            r2_causal: next(|train| LinearPredictor::fit(train, WINDOW)),
        },
        baseline("persistence: the present sample", next(|_| Some(LinearPredictor::persistence()))),
        baseline("autoregression of order 64", next(|train| LinearPredictor::fit(train, 64))),
    ]
}

/// Samples of the rivals' window.
const WINDOW: usize = rivals::settings::SETTINGS.window;

/// The paper's best model on the middle recording of an aging phase, and that recording.
fn best_model<'a>(args: &Args, loaded: &'a Life) -> Result<(OwnedModel, &'a Series), Failure> {
    let aging = &loaded.bearing.aging;
    let series = &loaded.series[(aging.start + aging.end) / 2];
    let solver = Solver::SindyNn { hidden: vec![PAPER_UNITS], train: TrainConfig::PAPER };
    let config = FitConfig { solver, null_fits: 0, causal: false, trainings: 1, ..FitConfig::default() };
    let fitted = fit(std::slice::from_ref(series), loaded.sample_rate_hz, &config, &|_| ());
    let mut fitted = fitted.map_err(Failure::other)?;
    fitted.report.training.channel = Some(args.channel.clone());
    file::write(&args.out.join("best.json"), &fitted.model, &fitted.report).map_err(Failure::other)?;
    Ok((fitted.model, series))
}
