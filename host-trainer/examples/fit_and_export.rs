//! Fits a sparse model to simulated recordings by STLSQ, prints its scores next to their null, and writes what a device
//! takes.
//!
//! `cargo run --release -p ballrace --example fit_and_export`

use std::path::Path;

use ballrace::model::export::{Format, export};
use ballrace::model::fit::Solver;
use ballrace::model::stlsq::StlsqConfig;
use ballrace::recording::input::Input;
use ballrace::rig::{OperatingCondition, Rig, Start};
use ballrace::{FitConfig, fit};

const RIG: &str = include_str!("../benches/rig.toml");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::parse(RIG, Path::new("rig.toml"))?;
    let condition = OperatingCondition { shaft_hz: 30.0, load_n: 500.0, sample_rate_hz: 25_600.0, samples: 12_800 };
    let runs = (0..5).map(|seed| ballrace::simulate(&rig, &condition, &Start::seeded(seed)));
    let input = Input::from_recordings(&runs.collect::<Result<Vec<_>, _>>()?, Some("ay"))?;

    let config =
        FitConfig { harmonics: 0, solver: Solver::Stlsq(StlsqConfig::default()), null_fits: 1, ..FitConfig::default() };
    let fitted = fit(&input.series, input.sample_rate_hz, &config, &|_| ())?;
    let scores = &fitted.report.scores;
    println!("in sample {:.3}, held out {:.3}", scores.in_sample.mean(), scores.held_out.mean());
    for null in &scores.null {
        println!("a surrogate of the same spectrum: held out {:.3}", null.held_out);
    }
    let folder = tempfile::tempdir()?;
    for (name, format) in [("model.bin", Format::Bin), ("model.rs", Format::Rust), ("model.h", Format::C)] {
        let bytes = export(&fitted.model, format)?;
        std::fs::write(folder.path().join(name), &bytes)?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}
