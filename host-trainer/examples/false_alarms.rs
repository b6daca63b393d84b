//! False alarms of the monitor: the stated rate on simulated healthy machines and on noise, and the first alarm on runs to
//! failure beside RMS and kurtosis.
//!
//! `cargo run --release -p ballrace --example false_alarms [MACHINES]` (1,000 by default; 0 for the runs to failure alone)
//!
//! The runs to failure are FEMTO bearings in `$BALLRACE_DATA`, then `../shared/data`, and are skipped where neither is there.

use ballrace::model::fit::Solver;
use ballrace::model::fit::limits::{HealthyBlocks, MAX_DRIFT, Rate, limit};
use ballrace::model::replay::{Options, Replayed, replay};
use ballrace::model::stlsq::StlsqConfig;
use ballrace::recording::input::Input;
use ballrace::recording::{LoadOptions, reference_data};
use ballrace::{FitConfig, fit};
use ballrace_core::monitor::{Monitor, MonitorConfig, Status};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{StandardNormal, StudentT};
use rayon::prelude::*;

/// A recording of one block every ten seconds.
const BLOCKS_PER_DAY: f64 = 8640.0;
/// Blocks that each simulated machine is monitored for after its healthy record: eleven hours.
const MONITORED: usize = 4000;

/// Healthy machine whose log level is simulated.
#[derive(Clone, Copy)]
enum Machine {
    /// Drift of any size that the limit's prior holds possible, and noise.
    Drifting,
    /// Independent Gaussian noise.
    White,
    /// Independent noise with the tails of Student's t, 3 degrees of freedom.
    HeavyTails,
    /// AR(1) noise with this coefficient.
    Correlated(f64),
    /// Random walk, σ 0.005 a block, for as long as it is monitored.
    RandomWalk,
}

impl Machine {
    fn levels(self, healthy: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let noise = 0.05 * 4f64.powf(rng.random());
        let time = 10.0 * healthy as f64;
        let drift = MAX_DRIFT * rng.random::<f64>();
        let mut state = drift * rng.sample::<f64, _>(StandardNormal);
        (0..healthy + MONITORED)
            .map(|_| {
                let normal: f64 = rng.sample(StandardNormal);
                let other: f64 = rng.sample(StandardNormal);
                match self {
                    Self::Drifting => {
                        state = (-1.0 / time).exp() * state + drift * (2.0 / time).sqrt() * other;
                        state + noise * normal
                    }
                    Self::White => noise * normal,
                    Self::HeavyTails => noise * rng.sample(StudentT::new(3.0).expect("positive degrees of freedom")),
                    Self::Correlated(a) => {
                        state = a * state + noise * (1.0 - a * a).sqrt() * normal;
                        state
                    }
                    Self::RandomWalk => {
                        state += 0.005 * other;
                        state + noise * normal
                    }
                }
            })
            .collect()
    }
}

/// Whether the device's own monitor alarms, one sample a block, with the limit of the healthy record.
fn alarms(machine: Machine, healthy: usize, rate: &Rate, seed: u64) -> bool {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let levels = machine.levels(healthy, &mut rng);
    let record = &levels[..healthy];
    let found = limit(
        &HealthyBlocks { log_levels: record, held_out: healthy / 5, noise_floor: 0.01 },
        rate,
        MonitorConfig::new(1, 0.0, 1.0).ewma_weight,
        seed,
    );
    let centre = record.iter().sum::<f64>() / healthy as f64;
    let limits = MonitorConfig {
        limit: (found.log_power / found.spread) as f32,
        ..MonitorConfig::new(1, centre as f32, found.spread as f32)
    };
    let mut monitor = Monitor::new(limits);
    levels[healthy..].iter().any(|level| {
        let report = monitor.residual([(0.5 * level).exp() as f32].into_iter());
        report.is_some_and(|report| report.status == Status::Anomalous)
    })
}

/// Wilson's 95 % interval of a share.
fn wilson(count: usize, of: usize) -> (f64, f64) {
    let (n, z) = (of as f64, 1.96);
    let p = count as f64 / n;
    let (centre, half) = (p + z * z / (2.0 * n), z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt());
    let scale = 1.0 + z * z / n;
    (((centre - half) / scale).max(0.0), (centre + half) / scale)
}

fn simulated(machines: usize) {
    println!(
        "| healthy machines | healthy blocks | stated, a day | alarmed | observed, a day | 95 % interval |\n|---|---|---|---|---|---|"
    );
    let rows = [
        ("drift as allowed for", Machine::Drifting, 40, 0.1),
        ("drift as allowed for", Machine::Drifting, 100, 0.1),
        ("drift as allowed for", Machine::Drifting, 40, 1.0),
        ("white noise", Machine::White, 40, 0.1),
        ("heavy tails, t₃", Machine::HeavyTails, 40, 0.1),
        ("AR(1), 0.5", Machine::Correlated(0.5), 40, 0.1),
        ("AR(1), 0.9", Machine::Correlated(0.9), 40, 0.1),
        ("random walk", Machine::RandomWalk, 40, 0.1),
    ];
    for (name, machine, healthy, stated) in rows {
        let rate = Rate { false_alarms_per_day: stated, blocks_per_day: BLOCKS_PER_DAY };
        let alarmed = |k: &usize| alarms(machine, healthy, &rate, *k as u64);
        let count = (0..machines).into_par_iter().filter(alarmed).count();
        let a_day = |share: f64| (0.0 - (1.0 - share).ln()) * BLOCKS_PER_DAY / MONITORED as f64;
        let (low, high) = wilson(count, machines);
        println!(
            "| {name} | {healthy} | {stated} | {count} of {machines} | {:.3} | {:.3} to {:.3} |",
            a_day(count as f64 / machines as f64),
            a_day(low),
            a_day(high)
        );
    }
}

/// Recording, from 1, at which a feature is so many healthy standard deviations above its mean for the third time running.
fn three_running(feature: &[f64], healthy: usize, sigmas: f64) -> Option<usize> {
    let n = healthy as f64;
    let mean = feature[..healthy].iter().sum::<f64>() / n;
    let spread = (feature[..healthy].iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    feature.windows(3).position(|w| w.iter().all(|v| *v > mean + sigmas * spread)).map(|at| at + 3)
}

/// RMS and kurtosis of each recording.
fn features(input: &Input) -> (Vec<f64>, Vec<f64>) {
    let of = |samples: &[f32]| {
        let n = samples.len() as f64;
        let mean = samples.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        let moment = |k: i32| samples.iter().map(|v| (f64::from(*v) - mean).powi(k)).sum::<f64>() / n;
        (moment(2).sqrt(), moment(4) / moment(2).powi(2))
    };
    input.series.iter().map(|s| of(&s.samples)).unzip()
}

/// First alarm and the recording at which the monitor was healthy again for the last time, from 1.
fn course(run: &Replayed) -> (Option<usize>, Option<usize>) {
    let first = run.summary.first_alarm.as_ref().map(|a| a.recording_index as usize + 1);
    let mut cleared =
        run.blocks.windows(2).filter(|w| w[0].status == Status::Anomalous && w[1].status == Status::Healthy);
    (first, cleared.next_back().map(|w| w[1].recording + 1))
}

fn runs_to_failure() -> Result<(), Box<dyn std::error::Error>> {
    let Some(folder) = reference_data::folder("femto") else {
        println!("runs to failure skipped: no reference data");
        return Ok(());
    };
    println!(
        "\n| solver | bearing | channel | healthy | limit, factor | first alarm | share of life | cleared | RMS 3σ | kurtosis 3σ | RMS 5σ |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let text = |at: Option<usize>| at.map_or("-".to_owned(), |at| at.to_string());
    let bearings = [
        ("Bearing3_3", &[40, 60, 80, 100][..]),
        ("Bearing3_1", &[40, 60, 80, 100]),
        ("Bearing2_7", &[40, 60, 80, 100]),
        ("Bearing1_4", &[20, 40]),
    ];
    for (bearing, counts) in bearings {
        for channel in ["horizontal", "vertical"] {
            let options = LoadOptions { channels: Some(vec![channel.into()]), ..LoadOptions::default() };
            let loaded = ballrace::load(&[folder.join(bearing)], &options)?;
            let input = Input::from_recordings(&loaded.recordings, Some(channel))?;
            let (rms, kurtosis) = features(&input);
            let solvers = [("stlsq", Solver::Stlsq(StlsqConfig::default())), ("sindy-nn", FitConfig::default().solver)];
            for ((name, solver), healthy) in solvers.iter().flat_map(|s| counts.iter().map(move |healthy| (s, healthy)))
            {
                let config = FitConfig {
                    solver: solver.clone(),
                    null_fits: 0,
                    causal: false,
                    trainings: 1,
                    interval_s: input.interval_s,
                    ..FitConfig::default()
                };
                let fitted = fit(&input.continuous(*healthy), input.sample_rate_hz, &config, &|_| ())?;
                let run = replay(&fitted.model, &input, &Options::default(), &mut |_, _| ())?;
                let (first, cleared) = course(&run);
                let share = first.map_or("-".into(), |f| format!("{:.0} %", 100.0 * f as f64 / rms.len() as f64));
                println!(
                    "| {name} | {bearing} | {channel} | {healthy} | {:.2} | {} | {share} | {} | {} | {} | {} |",
                    fitted.report.monitor.limit.log_power.exp(),
                    text(first),
                    text(cleared),
                    text(three_running(&rms, *healthy, 3.0)),
                    text(three_running(&kurtosis, *healthy, 3.0)),
                    text(three_running(&rms, *healthy, 5.0))
                );
            }
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machines = std::env::args().nth(1).map_or(Ok(1000), |text| text.parse())?;
    if machines > 0 {
        simulated(machines);
    }
    runs_to_failure()
}
