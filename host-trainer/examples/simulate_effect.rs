//! Simulates a bearing with and without a defect of its outer race, and compares the envelope's line at BPFO.
//!
//! `cargo run --release -p ballrace --example simulate_effect`

use std::path::Path;

use ballrace::rig::effect::{EffectKind, ParameterKey};
use ballrace::rig::{EffectEntry, OperatingCondition, Rig, Start};
use ballrace::signal::{envelope::envelope_spectrum, lines::Marked};

const RIG: &str = include_str!("../benches/rig.toml");
/// Band of the resonator, Hz.
const BAND_HZ: std::ops::Range<f64> = 4000.0..7000.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let nominal = Rig::parse(RIG, Path::new("rig.toml"))?;
    let defect = EffectEntry::new(
        EffectKind::OuterRaceDefect,
        &[(ParameterKey::DepthM, 2e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.57)],
    );
    let condition = OperatingCondition { shaft_hz: 30.0, load_n: 500.0, sample_rate_hz: 25_600.0, samples: 51_200 };
    let bpfo_hz = nominal.bearing().ok_or("a bearing rig")?.bearing.geometry().orders().bpfo * condition.shaft_hz;
    for (name, rig) in [("healthy", nominal.clone()), ("defect", nominal.with_effect(defect))] {
        let recording = ballrace::simulate(&rig, &condition, &Start::seeded(1))?;
        let samples = &recording.channel("ay").ok_or("a vertical channel")?.samples;
        let spectrum =
            envelope_spectrum(&[samples.as_slice()], condition.sample_rate_hz, &BAND_HZ).ok_or("too short")?;
        let line = Marked::new(&spectrum).line(bpfo_hz, 0.5).ok_or("no line")?;
        println!(
            "{name}: {:.5} m/s² at BPFO {bpfo_hz:.1} Hz, {:.0} times the background",
            line.amplitude,
            line.ratio.sqrt()
        );
    }
    Ok(())
}
