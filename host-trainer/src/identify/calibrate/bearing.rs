//! Calibration of the 5-DoF rig by the likelihood, theory (54) to (61).

use crate::rig::config::RigKey;
use serde::Serialize;

use super::distance::log_spectral;
use super::estimate::{Estimate, Undetermined, covariance, estimates, undetermined};
use super::settings::CalibrationSettings;
use super::split::Split;
use super::{CalibrateError, transfer_path};
use crate::identify::likelihood::coordinate::{Coordinate, NOISE};
use crate::identify::likelihood::observed::{CHANNELS, Observed, accelerations};
use crate::identify::likelihood::problem::{Point, Problem};
use crate::identify::likelihood::search::{Limits, Optimum, search, search_from_rig};
use crate::identify::likelihood::whittle::judged_bins;
use crate::recording::Recording;
use crate::rig::transfer_path::TransmissionPath;
use crate::rig::{Rig, Run, Start, simulate_many};

const SETTINGS: CalibrationSettings = CalibrationSettings::DEFAULT;

/// Whether to identify a transmission path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PathChoice {
    /// If the rig alone does not fit the recordings.
    #[default]
    Auto,
    /// Never.
    None,
    /// Always.
    AllPole,
}

/// Options of a calibration.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Transmission path between rig and sensor.
    pub path: PathChoice,
    /// Seed of the simulations whose spectra are compared.
    pub seed: u64,
}

/// Fit of a rig to one channel of a held-out recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// The recording.
    pub recording: String,
    /// The channel.
    pub channel: &'static str,
    /// Log-spectral distance, theory (61), of the rig before, dB.
    pub before_db: f64,
    /// Log-spectral distance of the calibrated rig, dB.
    pub after_db: f64,
    /// Log-spectral distance of two runs of the calibrated rig with different noise, dB: a bound for every rig.
    pub floor_db: f64,
}

/// Explained part of a channel by the calibrated rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explained {
    /// The channel.
    pub channel: &'static str,
    /// Share of the power that the rig's deterministic part explains.
    pub deterministic: f64,
    /// Residual power against its variance under the rig, RMS over bands, dB; about 0.1 for a complete fit.
    pub residual_db: f64,
}

/// Result of a calibration.
#[derive(Clone, Debug, Serialize)]
pub struct Calibration {
    /// The rig.
    #[serde(skip)]
    pub rig: Rig,
    /// Parameters and noise levels; empty with a transmission path.
    pub parameters: Vec<Estimate>,
    /// Undetermined combinations of parameters.
    pub undetermined: Vec<Undetermined>,
    /// Poles of the transmission path of each channel that has one.
    pub path_poles: Vec<(String, usize)>,
    /// Angles of cage and shaft at the first sample of each recording, rad.
    pub angles_rad: Vec<(String, [f64; 2])>,
    /// Explained part of each channel, on the fitted recordings.
    pub explained: Vec<Explained>,
    /// Whether the search ended because there was no more to gain.
    pub converged: bool,
    /// Names of the held-out recordings.
    pub held_out_recordings: String,
    /// Fit to the held-out recordings.
    pub held_out: Vec<HeldOut>,
}

/// Calibrates a bearing rig to recordings of the healthy machine.
///
/// Parameters judged in `held_out` come from the other recordings, returned ones from all of them.
///
/// # Errors
/// Recordings without acceleration, speed or load, a rig that cannot run, an unknown that is a whole number.
pub fn calibrate(
    rig: &Rig,
    recordings: &[Recording],
    options: &Options,
    progress: &dyn Fn(&str),
) -> Result<Calibration, CalibrateError> {
    if recordings.is_empty() {
        return Err(CalibrateError::Empty);
    }
    let split = Split::new(recordings);
    let (all, fitted) = (Observed::from_recordings(recordings)?, Observed::from_recordings(&split.fitted)?);
    progress("searching with the recordings that are fitted");
    let (part, found) = fit(rig, &fitted)?;
    let explained = explained(&part, &found)?;
    let far = explained.iter().any(|e| e.residual_db > SETTINGS.max_residual_db);
    let wants_path = options.path == PathChoice::AllPole || options.path == PathChoice::Auto && far;
    if wants_path {
        progress("identifying the transmission path");
        let (mut judged_rig, mut final_rig) = (rig.clone(), rig.clone());
        judged_rig.paths = identify(rig, &split.fitted, options.seed)?;
        final_rig.paths = identify(rig, recordings, options.seed)?;
        let path_poles = final_rig.paths.iter().map(|p| (p.channel.clone(), p.reflection.len())).collect();
        let sought = sought(rig)?;
        let keys = sought.iter().map(|c| c.key).filter(|key| !NOISE.contains(key)).collect::<Vec<_>>();
        let free = Undetermined {
            free: keys.iter().map(RigKey::to_string).collect::<Vec<_>>().join(" · "),
            keys,
            deviation: f64::MAX,
        };
        return Ok(Calibration {
            parameters: Vec::new(),
            undetermined: if free.keys.is_empty() { Vec::new() } else { vec![free] },
            path_poles,
            angles_rad: Vec::new(),
            explained,
            converged: true,
            held_out_recordings: split.describe(),
            held_out: held_out(rig, &judged_rig, &split.held_out, options.seed)?,
            rig: final_rig,
        });
    }
    progress("searching with all recordings");
    let judged_rig = part.rig_at(&found.point.coordinates)?;
    let whole = Problem { observed: &all, rig: judged_rig.clone(), ..part.clone() };
    let last = search_from_rig(&whole)?;
    let covariance = covariance(&last.expansion, whole.coordinates.len());
    let before: Vec<f64> = whole.coordinates.iter().map(|c| rig.get(c.key).unwrap_or_default()).collect();
    let mut calibrated = whole.rig_at(&last.point.coordinates)?;
    let parameters = estimates(&whole.coordinates, &before, &last.point.coordinates, &covariance);
    // A determined parameter is no longer unknown.
    let known = |key: RigKey| parameters.iter().any(|p| p.key == key && p.determined);
    calibrated.unknown =
        rig.unknown_keys().into_iter().filter(|key| !known((*key).into())).map(|key| key.name().to_owned()).collect();
    let undetermined = undetermined(&whole.coordinates, &covariance);
    Ok(Calibration {
        undetermined,
        parameters,
        path_poles: Vec::new(),
        angles_rad: all.iter().map(|o| o.name.clone()).zip(last.point.angles.iter().copied()).collect(),
        explained,
        converged: last.converged,
        held_out_recordings: split.describe(),
        held_out: held_out(rig, &judged_rig, &split.held_out, options.seed)?,
        rig: calibrated,
    })
}

/// Sought coordinates: the unknown parameters, and the noise levels whether the rig's file calls them unknown or not.
fn sought(rig: &Rig) -> Result<Vec<Coordinate>, CalibrateError> {
    let mut keys: Vec<RigKey> = rig.unknown_keys().into_iter().map(RigKey::from).collect();
    let noise = NOISE.into_iter().filter(|key| !keys.contains(key)).collect::<Vec<_>>();
    keys.extend(noise);
    keys.into_iter()
        .map(|key| Coordinate::for_key(rig, key).ok_or_else(|| CalibrateError::Whole { key: key.to_string() }))
        .collect()
}

fn fit<'o>(rig: &Rig, observed: &'o [Observed]) -> Result<(Problem<'o>, Optimum), CalibrateError> {
    let mut rig = rig.clone();
    for (key, least) in NOISE.into_iter().zip(SETTINGS.min_noise) {
        // The logarithm of zero cannot be a start.
        if rig.get(key).is_some_and(|v| v < least) {
            rig.set(key, least)?;
        }
    }
    let all = sought(&rig)?;
    let noise_only = all.iter().filter(|c| NOISE.contains(&c.key)).cloned().collect();
    let mut problem = Problem::new(observed, rig, noise_only);
    let quick = Limits { change: SETTINGS.max_noise_change, ..Limits::default() };
    let found = search(&problem, problem.start()?, &quick)?;
    problem.rig = problem.rig_at(&found.point.coordinates)?;
    problem.coordinates = all;
    let found = search_from_rig(&problem)?;
    // The angles that suited the guess need not suit the fitted rig.
    let again = Point { angles: problem.aligned(&problem.rig_at(&found.point.coordinates)?)?, ..found.point.clone() };
    let better = search(&problem, again, &Limits::default())?;
    let best =
        if better.expansion.neg_log_likelihood() < found.expansion.neg_log_likelihood() { better } else { found };
    Ok((problem, best))
}

fn explained(problem: &Problem, found: &Optimum) -> Result<Vec<Explained>, CalibrateError> {
    let expected = problem.predict(&found.point)?;
    let of = |channel: usize| {
        let (mut total, mut left) = (0.0, 0.0);
        let mut bands = [(0.0, 0usize); SETTINGS.residual_bands];
        for (o, e) in problem.observed.iter().zip(&expected) {
            let Some(x) = &o.spectra[channel] else { continue };
            let bins = judged_bins(x, 1.0);
            for k in bins.clone() {
                let residual = (x[k] - e.mean[channel][k]).norm_sqr();
                total += x[k].norm_sqr();
                left += residual;
                let band = &mut bands[(k - bins.start) * SETTINGS.residual_bands / bins.len()];
                band.0 += residual / e.noise.variance[channel][k];
                band.1 += 1;
            }
        }
        let levels = bands.iter().filter(|(_, n)| *n > 0).map(|(sum, n)| (10.0 * (sum / *n as f64).log10()).powi(2));
        let (sum, count) = levels.fold((0.0, 0), |(s, c), v| (s + v, c + 1));
        (count > 0).then(|| Explained {
            channel: CHANNELS[channel],
            deterministic: 1.0 - left / total,
            residual_db: (sum / f64::from(count)).sqrt(),
        })
    };
    Ok([0, 1].into_iter().filter_map(of).collect())
}

/// Transmission path of each channel from a rig to recordings, theory (53).
///
/// # Errors
/// As [`calibrate`].
pub fn identify(rig: &Rig, measured: &[Recording], seed: u64) -> Result<Vec<TransmissionPath>, CalibrateError> {
    let mut bare = rig.clone();
    bare.paths.clear();
    Ok(transfer_path::identify(measured, &replicates(&bare, measured, seed)?))
}

/// Runs of a rig under the conditions of recordings, some times over, each with its own angles and noise.
fn replicates(rig: &Rig, recordings: &[Recording], seed: u64) -> Result<Vec<Recording>, CalibrateError> {
    let observed = Observed::from_recordings(recordings)?;
    let repeated = std::iter::repeat_n(&observed, SETTINGS.replicates).flatten().enumerate();
    let runs: Vec<Run> =
        repeated.map(|(index, o)| Run { rig, condition: o.condition, start: Start::of_series(seed, index) }).collect();
    Ok(simulate_many(&runs)?)
}

fn held_out(before: &Rig, after: &Rig, recordings: &[Recording], seed: u64) -> Result<Vec<HeldOut>, CalibrateError> {
    let mut out = Vec::new();
    for recording in recordings {
        let one = std::slice::from_ref(recording);
        let (old, new) = (replicates(before, one, seed)?, replicates(after, one, seed)?);
        for (channel, measured) in accelerations(recording).into_iter().enumerate() {
            let Some(measured) = measured else { continue };
            let of = |runs: &[Recording], measured: &[f64]| {
                let samples = runs.iter().filter_map(|r| r.samples(CHANNELS[channel]));
                let distances: Vec<f64> =
                    samples.filter_map(|s| log_spectral(measured, s, recording.sample_rate_hz)).collect();
                distances.iter().sum::<f64>() / distances.len().max(1) as f64
            };
            let replicate = new[0].channel(CHANNELS[channel]).map_or(&[][..], |c| &c.samples);
            out.push(HeldOut {
                recording: recording.name(),
                channel: CHANNELS[channel],
                before_db: of(&old, &measured.samples),
                after_db: of(&new, &measured.samples),
                floor_db: of(&new[1..], replicate),
            });
        }
    }
    Ok(out)
}

/// Simulation of a rig under a recording's condition, from the angles that suit the recording best, with noise by a seed.
///
/// # Errors
/// As [`calibrate`].
pub fn prediction(rig: &Rig, recording: &Recording, seed: u64) -> Result<Recording, CalibrateError> {
    let observed = [Observed::from_recording(recording)?];
    let found = search_from_rig(&Problem::of_angles(&observed, rig.clone()))?;
    let [cage_angle0_rad, shaft_angle0_rad] = found.point.angles[0];
    let start = Start { cage_angle0_rad, shaft_angle0_rad, ..Start::seeded(seed) };
    Ok(simulate_many(&[Run { rig, condition: observed[0].condition, start }])?.swap_remove(0))
}
