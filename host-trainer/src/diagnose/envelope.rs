//! Diagnosis of real recordings by envelope lines, for a structure between bearing and sensor that no rig models.
//!
//! Waveforms and spectra of the rig cannot be compared then. A local defect modulates the power at the rate of its
//! impacts, in whatever band the structure carries them: each kind has a comb of lines in the envelope spectrum, at
//! frequencies given by the geometry (R. B. Randall, J. Antoni, "Rolling element bearing diagnostics – a tutorial", MSSP 25
//! (2011) 485–520; theory (26)). A kind is named if its comb is far above those of the other kinds and of the baseline.
//! Everything else that differs from the baseline is unexplained.

use crate::rig::config::RigKind;
use crate::rig::effect::{EffectKind, ParameterKey};
use std::collections::BTreeMap;

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::result::{
    Aspect, Cause, Diagnosis, DiagnosisResult, Fit, HeldOut, Left, Location, Rejected, SCHEMA, Test, Verdict,
};
use super::{DiagnoseError, Task};
use super::{baseline_test, evidence, locate};
use crate::identify::calibrate::bearing::{Options, PathChoice, calibrate, identify};
use crate::identify::calibrate::distance::log_spectral;
use crate::identify::calibrate::split::Split;
use crate::identify::likelihood::coordinate::NOISE;
use crate::identify::likelihood::observed::{CHANNELS, Observed, accelerations};
use crate::recording::Recording;
use crate::rig::simulate::simulate_all;
use crate::rig::{EffectEntry, Rig, Run, Start};
use crate::signal::band::{LineBand, band_for_lines};
use crate::signal::characteristic::Family;
use crate::signal::kinematics::Orders;

/// Level above which a comb names a kind: geometric mean of its lines over the noise around, per second of recording. Chosen
/// between 70 and 216, the highest wrong and the lowest right one of thirteen recordings of two public data sets.
const LINES_PER_S: f64 = 100.0;
/// Ratio of that level to those of the other kinds, and of the baseline, that names a kind; chosen on the same recordings.
const TIMES: f64 = 5.0;
/// Relative tolerance for slip and for an error of the stated speed.
const TOLERANCE: f64 = 0.02;
/// Log-spectral distance beyond the baseline's own above which recordings differ from it, dB.
const DIFFERS_DB: f64 = 1.5;
/// Analysed length of a recording, s.
const MOST_S: f64 = 6.0;

/// Kinds of local defect.
const KINDS: [EffectKind; 3] = [EffectKind::OuterRaceDefect, EffectKind::InnerRaceDefect, EffectKind::BallDefect];

/// Comb of lines in one channel of one recording.
struct Comb {
    /// ln of the geometric mean of the lines' ratios for each second.
    level: f64,
    lines: LineBand,
    channel: usize,
}

/// Orders of the lines of a kind: impacts of theory (26) with harmonics and sidebands.
fn lines(kind: EffectKind, orders: &Orders) -> Vec<f64> {
    match kind {
        EffectKind::OuterRaceDefect => vec![orders.bpfo, 2.0 * orders.bpfo, 3.0 * orders.bpfo],
        EffectKind::InnerRaceDefect => vec![orders.bpfi, 2.0 * orders.bpfi, orders.bpfi - 1.0, orders.bpfi + 1.0],
        _ => {
            let strikes = orders.ball_strikes();
            vec![strikes, 2.0 * strikes, strikes - orders.ftf, strikes + orders.ftf]
        }
    }
}

/// Comb of a kind in the channel of its highest level.
fn comb(recording: &Recording, kind: EffectKind, orders: &Orders) -> Option<Comb> {
    let shaft_hz = recording.shaft_hz?;
    let lines_hz: Vec<f64> = lines(kind, orders).iter().map(|order| order * shaft_hz).collect();
    let found = accelerations(recording).into_iter().enumerate().filter_map(|(channel, found)| {
        let samples = &found?.samples;
        let count = samples.len().min((MOST_S * recording.sample_rate_hz) as usize);
        let lines = band_for_lines(&samples[..count], recording.sample_rate_hz, &lines_hz, TOLERANCE)?;
        let seconds = count as f64 / recording.sample_rate_hz;
        let level = lines.ratios.iter().map(|r| (r / seconds).max(1e-3).ln()).sum::<f64>() / lines.ratios.len() as f64;
        Some(Comb { level, lines, channel })
    });
    found.max_by(|a, b| a.level.total_cmp(&b.level))
}

/// Mean level of a kind's comb over recordings.
fn level(recordings: &[Recording], kind: EffectKind, orders: &Orders) -> f64 {
    let levels: Vec<f64> = recordings.iter().filter_map(|r| comb(r, kind, orders)).map(|c| c.level).collect();
    if levels.is_empty() { f64::NEG_INFINITY } else { levels.iter().sum::<f64>() / levels.len() as f64 }
}

/// Rig with its identified transfer path; `None` if a rig of five degrees of freedom fits the waveforms without one.
///
/// # Errors
/// As [`calibrate`].
pub fn beyond_the_rig(rig: &Rig, recordings: &[Recording], seed: u64) -> Result<Option<Rig>, DiagnoseError> {
    let done = calibrate(rig, recordings, &Options { path: PathChoice::Auto, seed }, &|_| ())?;
    // If the ball passes are found to the sample, the rig is of the right kind, whatever else it lacks.
    let follows = done.explained.iter().any(|e| e.deterministic > FOLLOWS);
    Ok(if done.rig.paths.is_empty() || follows { None } else { Some(done.rig) })
}

/// Deterministic share of the power above which a rig is of the right kind, even with a dominant fault.
const FOLLOWS: f64 = 0.012;

/// Rig with its noise scaled until its ball-pass lines are as strong as the baseline's; without a baseline, until they vanish,
/// as their healthy level is then unknown. The transfer path is identified anew.
fn weighed(
    rig: &Rig,
    baseline: Option<&[Recording]>,
    fitted: &[Recording],
    orders: &Orders,
    seed: u64,
) -> Result<Rig, DiagnoseError> {
    let from = baseline.unwrap_or(fitted);
    let few = &from[..from.len().min(MOST_WEIGHED)];
    let target = baseline.map_or(f64::NEG_INFINITY, |_| level(few, KINDS[0], orders));
    for power in (0..9).map(|k| 10f64.powi(k)) {
        let mut tried = rig.clone();
        for (key, factor) in NOISE.into_iter().zip([power, f64::sqrt(power)]) {
            tried.set(key, tried.get(key).unwrap_or_default() * factor)?;
        }
        tried.paths = identify(&tried, few, seed)?;
        let Some(made) = simulated(&tried, few, seed)? else { continue };
        if level(&made, KINDS[0], orders) < target.max(0.0) + HIDDEN {
            return Ok(tried);
        }
    }
    Ok(rig.clone())
}

/// ln of the ratio by which ball-pass lines may exceed their target level.
const HIDDEN: f64 = 0.5;
/// Maximum count of recordings for that scaling.
const MOST_WEIGHED: usize = 8;

/// Diagnoses recordings by envelope lines. The rig has the transfer path of the baseline, or of the recordings themselves.
///
/// # Errors
/// Recordings without acceleration, speed or load; a rig that cannot run.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let Task { rig, baseline, recordings, seed } = *task;
    let machine = rig.bearing().ok_or(DiagnoseError::NotBearing { found: rig.model.kind().name() })?;
    let orders = machine.bearing.geometry().orders();
    progress("scaling the rig's noise");
    let split = Split::new(recordings);
    let rig = &weighed(rig, baseline, &split.fitted, &orders, seed)?;
    progress("searching for envelope lines of local defects");
    let levels: Vec<f64> = KINDS.iter().map(|kind| level(recordings, *kind, &orders)).collect();
    let usual: Option<Vec<f64>> = baseline.map(|b| KINDS.iter().map(|kind| level(b, *kind, &orders)).collect());
    let mut ranked: Vec<usize> = (0..KINDS.len()).collect();
    ranked.sort_by(|a, b| levels[*b].total_cmp(&levels[*a]));
    let (best, next) = (ranked[0], ranked[1]);
    let clear = levels[best] > LINES_PER_S.ln()
        && levels[best] > levels[next] + TIMES.ln()
        && usual.as_ref().is_none_or(|u| levels[best] > u[best] + TIMES.ln());
    let tests = match baseline {
        Some(baseline) => {
            progress("comparing with the baseline");
            baseline_test::tests(&machine.bearing.geometry(), baseline, recordings)?
        }
        None => recordings.first().map_or_else(Vec::new, |first| combs(first, &orders)),
    };
    let validation = if clear { sized(rig, KINDS[best], &orders, &split, seed, progress)? } else { None };
    let stands = validation.as_ref().is_some_and(|p| p.after + 2.0 * p.floor < p.before && p.p_value < 1e-3);
    let apart_db = distance(rig, baseline.unwrap_or(&split.fitted), seed)?;
    let verdict = match (stands, baseline) {
        (true, _) => Verdict::Mismatch,
        (false, Some(_)) if distance(rig, recordings, seed)? <= apart_db + DIFFERS_DB => Verdict::NoMismatch,
        (false, _) => Verdict::Unexplained,
    };
    let rejected = ranked.iter().filter(|k| !(stands && **k == best)).map(|k| Rejected {
        name: KINDS[*k].to_string(),
        why: format!(
            "its envelope lines are {:.1} times the noise per second{}; {LINES_PER_S} and {TIMES} times any other are required",
            levels[*k].exp(),
            usual.as_ref().map_or(String::new(), |u| format!(", {:.1} in the baseline", u[*k].exp()))
        ),
    });
    let rejected = rejected.collect();
    let mut caveats = vec![
        "The structure between bearing and sensor is not the rig's: only envelope lines were compared, and the size of a \
         defect follows from a transfer path that was identified, not measured."
            .to_owned(),
    ];
    let (mut corrected, mut causes) = (rig.clone(), Vec::new());
    let Shown { fit, location, held_out } = match validation.filter(|_| stands) {
        Some(validation) => {
            corrected = corrected.with_effect(validation.effect.clone());
            causes.push(cause(&validation, &levels, best, next));
            validation.shown(&lines(KINDS[best], &orders), &split)
        }
        None => {
            caveats.extend(caveats_without_cause(baseline));
            let location = match verdict {
                Verdict::NoMismatch => Location::default(),
                _ => locate::locate(rig, rig, &tests),
            };
            without_cause(rig, &split, apart_db, location, seed)?
        }
    };
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict,
        causes,
        rejected,
        location,
        terms: Vec::new(),
        nuisance: Vec::new(),
        left: Left::default(),
        fit,
    };
    Ok(DiagnosisResult { diagnosis, rig: corrected, held_out, tests, fitted: Vec::new(), caveats })
}

/// Fit, location and traces of held-out recordings.
struct Shown {
    fit: Fit,
    location: Location,
    held_out: Vec<HeldOut>,
}

fn caveats_without_cause(baseline: Option<&[Recording]>) -> Vec<String> {
    let mut out = vec!["Only local defects are sought in recordings of this kind.".to_owned()];
    if let Some(baseline) = baseline.filter(|b| b.len() < FEW) {
        out.push(format!(
            "Recordings of the healthy machine: {}. These are too few to estimate the variation between recordings: a \
             difference may come from the mounting or the environment.",
            baseline.len()
        ));
    }
    out
}

/// Log-spectral distance of held-out recordings to the rig; the floor is that of the recordings of its transfer path.
fn without_cause(
    rig: &Rig,
    split: &Split,
    apart_db: f64,
    location: Location,
    seed: u64,
) -> Result<Shown, DiagnoseError> {
    let before = distance(rig, &split.held_out, seed)?;
    let fit = Fit {
        metric: "log-spectral distance, dB".into(),
        held_out: split.describe(),
        before,
        after: before,
        noise_floor: apart_db,
        p_value: 1.0,
    };
    let made = simulated(rig, &split.held_out, seed)?;
    let held_out = made.map_or_else(Vec::new, |made| traces(&split.held_out, &made, &made));
    Ok(Shown { fit, location, held_out })
}

/// Count of healthy recordings from which the variation between them is known.
const FEW: usize = 6;

/// Tests of a recording's envelope for the comb of each kind of defect, against noise; a healthy bearing shows it weakly.
fn combs(recording: &Recording, orders: &Orders) -> Vec<Test> {
    let of = |kind: &EffectKind| {
        let Comb { lines: found, channel, .. } = comb(recording, *kind, orders)?;
        let (hz, channel) = (&found.band_hz, CHANNELS[channel]);
        Some(Test {
            aspect: Aspect::Comb,
            channel,
            at: Some([hz.start, hz.end]),
            what: format!(
                "{channel}, comb of {} in the envelope of {:.0} to {:.0} Hz",
                family(*kind).name(),
                hz.start,
                hz.end
            ),
            z: (found.strength - 1.0) * (found.ratios.len() as f64).sqrt(),
            p_value: found.log_p_value.exp(),
            q_value: 1.0,
        })
    };
    evidence::ranked(KINDS.iter().filter_map(of).collect())
}

/// Family of the lines of a kind.
fn family(kind: EffectKind) -> Family {
    match kind {
        EffectKind::OuterRaceDefect => Family::Outer,
        EffectKind::InnerRaceDefect => Family::Inner,
        _ => Family::Ball,
    }
}

fn cause(validation: &SizedPit, levels: &[f64], best: usize, next: usize) -> Cause {
    let odds = (levels[best] - levels[next]).exp();
    Cause {
        name: KINDS[best].to_string(),
        probability: odds / (1.0 + odds),
        parameters: validation.effect.parameters.iter().map(|(key, value)| (key.to_string(), value.into())).collect(),
        interval95: BTreeMap::new(),
        evidence: format!(
            "In the envelope of {:.0} to {:.0} Hz its lines are {:.0} times the noise per second, {odds:.0} times those of the next kind ({}).",
            validation.band.band_hz.start,
            validation.band.band_hz.end,
            levels[best].exp(),
            KINDS[next]
        ),
        equation: validation.effect.equation(RigKind::Bearing5Dof),
    }
}

/// Defect of estimated depth, with its fit to held-out recordings.
struct SizedPit {
    effect: EffectEntry,
    before: f64,
    after: f64,
    floor: f64,
    p_value: f64,
    band: LineBand,
    channel: usize,
    traces: Vec<HeldOut>,
}

impl SizedPit {
    /// Fit and location of the defect; `lines` are the orders of its comb at pure rolling.
    fn shown(self, lines: &[f64], split: &Split) -> Shown {
        let fit = Fit {
            metric: "level of the envelope lines, difference from the measurement, dB".into(),
            held_out: split.describe(),
            before: self.before,
            after: self.after,
            noise_floor: self.floor,
            p_value: self.p_value,
        };
        let location = Location {
            frequency_hz: vec![[self.band.band_hz.start, self.band.band_hz.end]],
            order: lines.iter().map(|o| o * self.band.scale).collect(),
            channel: CHANNELS[self.channel].into(),
            ..Location::default()
        };
        Shown { fit, location, held_out: self.traces }
    }
}

/// Defect whose depth gives the comb level of the fitted recordings, with its fit to the held-out ones.
fn sized(
    rig: &Rig,
    kind: EffectKind,
    orders: &Orders,
    split: &Split,
    seed: u64,
    progress: &dyn Fn(&str),
) -> Result<Option<SizedPit>, DiagnoseError> {
    progress("estimating the depth of the defect");
    let db = 10.0 / std::f64::consts::LN_10;
    let target = level(&split.fitted, kind, orders);
    let mut best: Option<(f64, EffectEntry)> = None;
    for depth in (0..18).map(|k| 1e-8 * 10f64.powf(0.25 * f64::from(k))) {
        let mut effect = EffectEntry::new(kind, &[(ParameterKey::DepthM, depth), (ParameterKey::WidthRad, 0.05)]);
        if kind == EffectKind::OuterRaceDefect {
            effect.set_number(ParameterKey::AngleRad, std::f64::consts::FRAC_PI_2);
        }
        let Some(made) = simulated(&rig.clone().with_effect(effect.clone()), &split.fitted, seed)? else { continue };
        let apart = (level(&made, kind, orders) - target).abs();
        if best.as_ref().is_none_or(|(least, _)| apart < *least) {
            best = Some((apart, effect));
        }
    }
    let Some((_, effect)) = best else { return Ok(None) };
    let (Some(old), Some(new), Some(again)) = (
        simulated(rig, &split.held_out, seed)?,
        simulated(&rig.clone().with_effect(effect.clone()), &split.held_out, seed)?,
        simulated(&rig.clone().with_effect(effect.clone()), &split.held_out, seed.wrapping_add(1))?,
    ) else {
        return Ok(None);
    };
    let measured = level(&split.held_out, kind, orders);
    let apart = |made: &[Recording]| db * (level(made, kind, orders) - measured).abs();
    let shown = split.held_out.iter().filter_map(|r| comb(r, kind, orders)).max_by(|a, b| a.level.total_cmp(&b.level));
    let Some(shown) = shown else { return Ok(None) };
    let floor = db * (level(&again, kind, orders) - level(&new, kind, orders)).abs();
    Ok(Some(SizedPit {
        effect,
        before: apart(&old),
        after: apart(&new),
        floor,
        p_value: shown.lines.log_p_value.exp().max(f64::MIN_POSITIVE),
        band: shown.lines,
        channel: shown.channel,
        traces: traces(&split.held_out, &old, &new),
    }))
}

/// Held-out recordings with two simulations of each.
fn traces(held_out: &[Recording], old: &[Recording], new: &[Recording]) -> Vec<HeldOut> {
    let mut traces = Vec::new();
    for ((recording, old), new) in held_out.iter().zip(old).zip(new) {
        for (channel, found) in accelerations(recording).into_iter().enumerate() {
            let Some(found) = found else { continue };
            let of = |r: &Recording| r.channel(CHANNELS[channel]).map_or_else(Vec::new, |c| c.samples.clone());
            traces.push(HeldOut {
                name: format!("{}-{}", recording.name(), CHANNELS[channel]),
                sample_rate_hz: recording.sample_rate_hz,
                measured: found.samples.clone(),
                before: of(old),
                after: of(new),
            });
        }
    }
    traces
}

/// Simulations of a rig under the conditions of recordings; `None` if one diverges.
fn simulated(rig: &Rig, recordings: &[Recording], seed: u64) -> Result<Option<Vec<Recording>>, DiagnoseError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut runs = Vec::new();
    for recording in recordings {
        let condition = Observed::from_recording(recording)?.condition;
        runs.push(Run { rig, condition, start: Start::seeded(random.random()) });
    }
    Ok(simulate_all(&runs)?.into_iter().collect::<Result<Vec<_>, _>>().ok())
}

/// Mean log-spectral distance between recordings and the rig's simulations of them, dB.
fn distance(rig: &Rig, of: &[Recording], seed: u64) -> Result<f64, DiagnoseError> {
    let Some(made) = simulated(rig, of, seed)? else { return Ok(f64::INFINITY) };
    let mut all = Vec::new();
    for (recording, made) in of.iter().zip(&made) {
        for (channel, found) in accelerations(recording).into_iter().enumerate() {
            if let (Some(a), Some(b)) = (found, made.channel(CHANNELS[channel])) {
                all.extend(log_spectral(&a.samples, &b.samples, recording.sample_rate_hz));
            }
        }
    }
    Ok(all.iter().sum::<f64>() / all.len().max(1) as f64)
}
