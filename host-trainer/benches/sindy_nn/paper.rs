//! The paper's settings (Table 2) on one FEMTO recording, 500 epochs, beside `torch_sindy_nn.py`.

use std::path::PathBuf;
use std::time::Instant;

use ballrace::model::samples::Samples;
use ballrace::model::sindy_nn::config::TrainConfig;
use ballrace::model::sindy_nn::engine::Engine;
use ballrace::model::sindy_nn::gradient::Lambdas;
use ballrace::model::sindy_nn::layout::Layout;
use ballrace::model::sindy_nn::train::{Sets, train};
use ballrace::model::states::{Scales, rows};
use ballrace::recording::{LoadOptions, load, reference_data};
use ballrace_core::library::Library;
use ballrace_core::states::{Alignment, Estimator, Orders, StateSpec};

use super::floor::Floor;
use super::{THREADS, median, peer};

const RUNS: usize = 5;
const RECORDING: &str = "Bearing3_3/acc_00100.csv";

pub fn run(floor: &Floor, with_peer: bool) -> Result<(), Box<dyn std::error::Error>> {
    let Some(femto) = reference_data::folder("femto") else { return Ok(()) };
    let file = femto.join(RECORDING);
    let layout = Layout::new(&[8, 256, 8], &[8, 256, 8], Library::new(8, 2, 2).ok_or("library")?).ok_or("layout")?;
    // As the peer: no thresholding, no early stop.
    let config = TrainConfig { threshold: Some(0.0), patience: 0, ..TrainConfig::PAPER };
    let epochs = config.epochs.ok_or("epochs")?;
    println!("\npaper's settings, {RECORDING}, {epochs} epochs, {THREADS} threads, medians of {RUNS} in turn");
    println!(
        "{:12}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>9}",
        "alignment", "ours s", "floor s", "of floor", "torch s", "ratio", "loss", "R²"
    );
    for (name, alignment) in [("half", Alignment::Half), ("forward", Alignment::Forward)] {
        let samples = samples(&file, alignment)?;
        let (mut ours, mut losses, mut scores) = (vec![], vec![], vec![]);
        let (mut theirs, mut their_losses, mut their_scores) = (vec![], vec![], vec![]);
        for seed in 0..RUNS as u64 {
            let config = TrainConfig { seed, ..config.clone() };
            let start = Instant::now();
            let trained = train(&layout, &samples, Sets::default(), &config, &mut |_| ());
            ours.push(start.elapsed().as_secs_f64());
            let [loss, score] = data_loss_and_score(&layout, &trained.parameters, &samples);
            losses.push(loss);
            scores.push(score);
            if with_peer {
                let arguments = [
                    file.display().to_string(),
                    "--alignment".into(),
                    name.into(),
                    "--threads".into(),
                    THREADS.to_string(),
                ];
                let told = peer(&peers().join("torch_sindy_nn.py"), &arguments)?;
                theirs.push(told["seconds"].as_f64().ok_or("seconds")?);
                let (score, reconstruction) = (told["r2"].as_f64(), told["r2_recon"].as_f64());
                let (score, reconstruction) = (score.ok_or("r2")?, reconstruction.ok_or("r2_recon")?);
                their_losses.push(1.0 - reconstruction + Lambdas::PAPER.derivative * (1.0 - score));
                their_scores.push(score);
            }
        }
        let least = floor.seconds(&layout, (epochs * samples.len()) as f64, THREADS);
        let ours = median(ours);
        print!("{name:12}{ours:>10.3}{least:>10.3}{:>9.0}%", 100.0 * least / ours);
        if with_peer {
            let theirs = median(theirs);
            print!("{theirs:>10.2}{:>9.1}x", theirs / ours);
        } else {
            print!("{:>10}{:>10}", "-", "-");
        }
        println!("{:>10.5}{:>9.4}", median(losses), median(scores));
        if with_peer {
            println!("{:>72}{:>10.5}{:>9.4}", "torch", median(their_losses), median(their_scores));
        }
    }
    Ok(())
}

/// L_recon + λ1 L_dx/dt over all samples (the last batch's loss, which the peer prints, is that of a
/// random fifth of them), and the mean R² of the derivatives; standardised targets have variance 1.
fn data_loss_and_score(layout: &Layout, parameters: &[f32], samples: &Samples<f32>) -> [f64; 2] {
    let all: Vec<u32> = (0..samples.len() as u32).collect();
    let losses = Engine::new(layout.clone(), all.len()).evaluate(parameters, samples, &all, Lambdas::PAPER);
    [losses.reconstruction + Lambdas::PAPER.derivative * losses.derivative, 1.0 - losses.derivative]
}

fn peers() -> PathBuf {
    std::env::var_os("BALLRACE_PEERS")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/peers"), PathBuf::from)
}

/// Vertical channel, as the peer takes it.
fn samples(file: &std::path::Path, alignment: Alignment) -> Result<Samples<f32>, Box<dyn std::error::Error>> {
    let options = LoadOptions { channels: Some(vec!["vertical".into()]), ..LoadOptions::default() };
    let loaded = load(&[file.to_owned()], &options)?;
    let channel = loaded.recordings[0].channel("vertical").ok_or("no vertical channel")?;
    let recording: Vec<f32> = channel.samples.iter().map(|v| *v as f32).collect();
    let mut samples = rows(
        &recording,
        StateSpec { dimension: 8, orders: Orders::Even, alignment, estimator: Estimator::Differences },
    );
    Scales::from_rows(std::slice::from_ref(&samples)).apply(&mut samples);
    Ok(samples)
}
