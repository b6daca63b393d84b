//! Diagnoses a machine of one degree of freedom whose rig leaves out dry friction.
//!
//! `cargo run --release -p ballrace --example diagnose`

use std::path::Path;

use ballrace::rig::effect::{EffectKind, ParameterKey};
use ballrace::rig::sdof::{self, Drive};
use ballrace::rig::{EffectEntry, Rig};
use ballrace::{Task, diagnose};

const RIG: &str = r#"
kind = "sdof"
mass_kg = 2.0
damping_n_s_per_m = 4.0
stiffness_n_per_m = 800.0
input_gain_n_per_unit = 3.0
restoring = "linear"
gravity_n = 0.0
"#;
const RATE_HZ: f64 = 500.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::parse(RIG, Path::new("rig.toml"))?;
    let machine =
        rig.clone().with_effect(EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 0.5)]));
    let recordings = (0..4).map(|n| {
        let tones = |t: f64| (0..8).map(|k| (f64::from(2 + 3 * k + n) * t + f64::from(k * k)).sin()).sum::<f64>();
        let input: Vec<f64> = (0..3000).map(|k| 0.5 * tones(f64::from(k) / RATE_HZ)).collect();
        let mut recording =
            sdof::simulate(&machine, &Drive { input: &input, sample_rate_hz: RATE_HZ, ..Drive::default() })?;
        recording.channels.retain(|channel| ["u", "q"].contains(&channel.name.as_str()));
        Ok::<_, ballrace::rig::RigError>(recording)
    });
    let recordings = recordings.collect::<Result<Vec<_>, _>>()?;

    let task = Task { rig: &rig, baseline: None, recordings: &recordings, seed: 1 };
    let result = diagnose(&task, &|step| eprintln!("{step}"))?;
    println!("{}", result.diagnosis.verdict.name());
    for cause in &result.diagnosis.causes {
        println!("{} {:?} with probability {:.3}: {}", cause.name, cause.parameters, cause.probability, cause.evidence);
    }
    Ok(())
}
