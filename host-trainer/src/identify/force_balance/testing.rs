//! Rigs, inputs and noisy recordings that the tests share.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::recording::{Channel, LoadOptions, Recording, Source, load, reference_data};
use crate::rig::{
    Rig,
    sdof::{Drive, simulate},
    test_support::parse,
};

/// Independent normal numbers.
pub fn white(seed: u64, deviation: f64, count: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| deviation * Distribution::<f64>::sample(&StandardNormal, &mut rng)).collect()
}

/// Samples per second of the synthetic recordings.
pub const RATE: f64 = 500.0;

/// Sum of tones in 0.3 to 12 Hz with random phases, of a given RMS.
pub fn multisine(seed: u64, rms: f64, count: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let tones: Vec<(f64, f64)> = (0..40).map(|_| (rng.random_range(0.3..12.0), rng.random_range(0.0..TAU))).collect();
    let size = rms * (2.0f64 / tones.len() as f64).sqrt();
    let at = |t: f64| tones.iter().map(|(hz, phase)| (TAU * hz * t + phase).sin()).sum::<f64>() * size;
    (0..count).map(|k| at(k as f64 / RATE)).collect()
}

/// A linear rig of 2 kg at 3.2 Hz, 5 % damped.
pub const LINEAR: &str = "kind = \"sdof\"\nmass_kg = 2.0\ndamping_n_s_per_m = 4.0\nstiffness_n_per_m = 800.0\n\
                          input_gain_n_per_unit = 3.0\nrestoring = \"linear\"\ngravity_n = 0.0\n";

/// The rig of a text.
pub fn rig(text: &str) -> Rig {
    parse(text)
}

/// Recordings of a rig driven by multisines of a given RMS, with channels `u` and `q` (or `qdd`) and sensor noise of a share
/// of the signal's RMS.
pub fn recordings(rig: &Rig, channel: &str, rms: f64, share: f64, count: usize, seed: u64) -> Vec<Recording> {
    let one = |index: u64| {
        let seed = seed * 100 + index;
        let input = multisine(seed, rms, count);
        let drive = Drive { input: &input, sample_rate_hz: RATE, ..Drive::default() };
        let simulated = simulate(rig, &drive).unwrap();
        let clean = &simulated.channel(channel).unwrap().samples;
        let size = (clean.iter().map(|x| x * x).sum::<f64>() / clean.len() as f64).sqrt();
        let noise = white(seed ^ 0xabcd, share * size, clean.len());
        let noisy = clean.iter().zip(noise).map(|(x, e)| x + e).collect();
        let input = simulated.channel("u").unwrap().samples.clone();
        recording(&format!("r{index}"), input, channel, noisy)
    };
    (0..4).map(one).collect()
}

/// Recording of given samples.
pub fn recording(name: &str, input: Vec<f64>, channel: &str, samples: Vec<f64>) -> Recording {
    let channels = [("u", input), (channel, samples)];
    let channels = channels.into_iter().map(|(name, samples)| Channel { name: name.into(), location: None, samples });
    Recording {
        source: Source { path: format!("{name}.csv").into(), variable: None },
        channels: channels.collect(),
        sample_rate_hz: RATE,
        ..Recording::default()
    }
}

/// DATA_EMPS and DATA_EMPS_PULSES as recordings with u and q, if there are any.
pub fn emps() -> Option<Vec<Recording>> {
    let folder = reference_data::folder("emps")?;
    let read = |file: &str, variable: &str| {
        let options =
            LoadOptions { variable: Some(variable.into()), sample_rate_hz: Some(1000.0), ..LoadOptions::default() };
        load(&[folder.join(file)], &options).unwrap().recordings.remove(0).channels.remove(0).samples
    };
    let one =
        |file: &str| Recording { sample_rate_hz: 1000.0, ..recording(file, read(file, "vir"), "q", read(file, "qm")) };
    Some(vec![one("DATA_EMPS.mat"), one("DATA_EMPS_PULSES.mat")])
}
