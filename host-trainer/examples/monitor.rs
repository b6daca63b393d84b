//! Fits a model to a healthy machine and runs the device's own code over a machine whose outer race acquires a defect.
//!
//! `cargo run --release -p ballrace --example monitor`

use std::path::Path;

use ballrace::model::fit::Solver;
use ballrace::model::replay::{Options, replay};
use ballrace::model::stlsq::StlsqConfig;
use ballrace::recording::input::Input;
use ballrace::rig::effect::{EffectKind, ParameterKey};
use ballrace::rig::{EffectEntry, OperatingCondition, Rig, Start};
use ballrace::{FitConfig, fit};

const RIG: &str = include_str!("../benches/rig.toml");
/// Recordings of the healthy machine, and of the machine with the defect.
const HEALTHY: usize = 10;
const FAULTY: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::parse(RIG, Path::new("rig.toml"))?;
    let defect = EffectEntry::new(
        EffectKind::OuterRaceDefect,
        &[(ParameterKey::DepthM, 2e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.57)],
    );
    let faulty = rig.clone().with_effect(defect);
    let condition = OperatingCondition { shaft_hz: 30.0, load_n: 500.0, sample_rate_hz: 25_600.0, samples: 12_800 };
    let life = (0..HEALTHY + FAULTY).map(|n| {
        let machine = if n < HEALTHY { &rig } else { &faulty };
        ballrace::simulate(machine, &condition, &Start::seeded(n as u64))
    });
    let input = Input::from_recordings(&life.collect::<Result<Vec<_>, _>>()?, Some("ay"))?;

    let config =
        FitConfig { harmonics: 0, solver: Solver::Stlsq(StlsqConfig::default()), null_fits: 0, ..FitConfig::default() };
    let healthy = &input.series[..HEALTHY];
    let model = fit(healthy, input.sample_rate_hz, &config, &|_| ())?.model;
    let run = replay(&model, &input, &Options::default(), &mut |_, _| ())?;
    for block in &run.blocks {
        println!("recording {}: {:?}, EWMA {:.1}", block.recording + 1, block.status, block.statistics.ewma);
    }
    println!("{} alarms; the defect begins at recording {}", run.summary.alarms, HEALTHY + 1);
    Ok(())
}
