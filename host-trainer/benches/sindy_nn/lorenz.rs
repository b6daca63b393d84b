//! The Lorenz problem of Champion et al. 2019: 128 inputs, widths 64-32, latent 3, polynomial degree 3,
//! 256,000 samples, batch 1024; seconds an epoch.

use std::path::PathBuf;
use std::time::Instant;

use ballrace::model::samples::Samples;
use ballrace::model::sindy_nn::config::TrainConfig;
use ballrace::model::sindy_nn::layout::Layout;
use ballrace::model::sindy_nn::train::{Sets, train};
use ballrace_core::library::Library;

use super::floor::Floor;
use super::{THREADS, median, peer};

const INPUTS: usize = 128;
const TRAJECTORIES: usize = 1024;
const STEPS: usize = 250;
const EPOCHS: usize = 3;
const RUNS: usize = 3;

pub fn run(floor: &Floor, with_peer: bool) -> Result<(), Box<dyn std::error::Error>> {
    let library = Library::new(3, 3, 0).ok_or("library")?;
    let layout = Layout::new(&[128, 64, 32, 3], &[3, 32, 64, 128], library).ok_or("layout")?;
    let samples = samples();
    let config = TrainConfig {
        epochs: Some(EPOCHS),
        max_steps: Some(usize::MAX),
        threshold: Some(0.0),
        patience: 0,
        ..TrainConfig::PAPER
    };
    println!("\nLorenz, {} samples of {INPUTS}, seconds an epoch, medians of {RUNS} in turn", samples.len());
    println!("{:12}{:>10}{:>10}{:>10}{:>10}{:>10}", "threads", "ours s", "floor s", "of floor", "torch s", "ratio");
    for threads in [1, THREADS] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let (mut ours, mut theirs) = (vec![], vec![]);
        for _ in 0..RUNS {
            let start = Instant::now();
            pool.install(|| train(&layout, &samples, Sets::default(), &config, &mut |_| ()));
            ours.push(start.elapsed().as_secs_f64() / EPOCHS as f64);
            if with_peer {
                let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("benches/sindy_nn/lorenz_peer.py");
                let told = peer(&script, &["--threads".into(), threads.to_string()])?;
                theirs.push(told["seconds"].as_f64().ok_or("seconds")?);
            }
        }
        let least = floor.seconds(&layout, samples.len() as f64, threads);
        let ours = median(ours);
        print!("{threads:<12}{ours:>10.3}{least:>10.3}{:>9.0}%", 100.0 * least / ours);
        if with_peer {
            let theirs = median(theirs);
            println!("{theirs:>10.2}{:>9.1}x", theirs / ours);
        } else {
            println!("{:>10}{:>10}", "-", "-");
        }
    }
    Ok(())
}

/// Trajectories of the Lorenz system lifted by six Legendre modes: x = Σ u_i z_i + u_(i+3) z_i³.
fn samples() -> Samples<f32> {
    let modes: Vec<[f64; 6]> = (0..INPUTS)
        .map(|k| {
            let y = -1.0 + 2.0 * k as f64 / (INPUTS - 1) as f64;
            let mut p = [1.0, y, 0.0, 0.0, 0.0, 0.0];
            for n in 1..5 {
                p[n + 1] = ((2 * n + 1) as f64 * y * p[n] - n as f64 * p[n - 1]) / (n + 1) as f64;
            }
            p
        })
        .collect();
    let rate = |z: [f64; 3]| [10.0 * (z[1] - z[0]), z[0] * (28.0 - z[2]) - z[1], z[0] * z[1] - 8.0 / 3.0 * z[2]];
    let mut out = Samples { inputs: INPUTS, ..Samples::default() };
    for t in 0..TRAJECTORIES {
        let angle = t as f64 * 2.399_963;
        let mut z = [18.0 * angle.sin(), 18.0 * angle.cos(), 25.0 + 20.0 * (0.7 * angle).sin()];
        for _ in 0..STEPS {
            let dz = rate(z);
            for mode in &modes {
                let (mut x, mut dx) = (0.0, 0.0);
                for i in 0..3 {
                    let (v, d) = (z[i] / 40.0, dz[i] / 40.0);
                    x += mode[i] * v + mode[i + 3] * v * v * v;
                    dx += (mode[i] + mode[i + 3] * 3.0 * v * v) * d;
                }
                out.x.push(x as f32);
                out.dx.push(dx as f32);
            }
            // Only the shape of the problem matters here: a small explicit step is enough.
            for _ in 0..10 {
                let dz = rate(z);
                z = std::array::from_fn(|i| z[i] + 0.002 * dz[i]);
            }
        }
    }
    out
}
