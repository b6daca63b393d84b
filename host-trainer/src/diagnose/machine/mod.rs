//! Diagnosis of a machine whose structure nobody knows: what it does now against what it did when it was healthy.
//!
//! The path from bearing to sensor is in both, so it cancels. Without recordings of the healthy machine, the null is the
//! recording itself, at orders that are none of its bearing's.
//!
//! | module | holds |
//! |---|---|
//! | `observation` | recordings with speed and load, and which are compared |
//! | `modulation` | squared-envelope spectra, band by band |
//! | `pattern` | lines of a defect of each part of the bearing |
//! | `comb` | combs of these lines, their depth and significance among decoys |
//! | `change` | orders of the shaft and power in bands against the baseline |
//! | `faults` | faults of the acquisition |
//! | `names` | posterior of the names |
//! | `synthesis` | held-out recordings without the cause and with it |
//! | `text` | sentences |

mod change;
mod comb;
mod faults;
mod modulation;
mod names;
mod observation;
mod pattern;
pub(crate) mod settings;
mod synthesis;
#[cfg(test)]
mod tests;
mod text;

use std::ops::Range;

use change::{Change, MovedMode};
use comb::Comb;
use modulation::{Modulation, Tones, bands};
use names::{Candidate, Class, CombNow, Evidence, candidates, is_beyond_healthy};
use observation::{Observation, held_out};
use pattern::Pattern;
use settings::{ModulationSettings, NameSettings, SynthesisSettings};
use synthesis::{Densities, Modulator, modulators, noise, passed};

use super::acquisition::Fault;
use super::result::{Cause, Diagnosis, DiagnosisResult, HeldOut, Location, Nuisance, Rejected, SCHEMA, Test, Verdict};
use super::{DiagnoseError, Task, evidence, shown};
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::Rig;
use crate::rig::config::ModelKey;
use crate::rig::effect::EffectKind;
use crate::signal::kinematics::Geometry;
use crate::stats::significance::two_sided;

/// Whether nothing of a rig's structure is known: `unknown` names the masses and the stiffnesses of every part.
pub fn is_unknown(rig: &Rig) -> bool {
    let unknown = rig.unknown_keys();
    let structure = [
        ModelKey::InnerMass,
        ModelKey::InnerStiffness,
        ModelKey::OuterMass,
        ModelKey::OuterStiffness,
        ModelKey::ResonatorMass,
        ModelKey::ResonatorStiffness,
    ];
    structure.iter().all(|key| unknown.contains(key))
}

/// Recordings by their use.
struct Data {
    /// Recordings in which causes are sought and to which they are fitted.
    fitted: Vec<Observation>,
    /// Recording to which the path is fitted where there is but one: its first half.
    half: Option<Observation>,
    held_out: Observation,
    baseline: Vec<Observation>,
    described: String,
}

impl Data {
    fn new(task: &Task) -> Result<Self, DiagnoseError> {
        let mut fitted = task.recordings.iter().map(Observation::new).collect::<Result<Vec<_>, _>>()?;
        let baseline = task.baseline.unwrap_or_default().iter().map(Observation::new).collect::<Result<Vec<_>, _>>()?;
        if let Some(at) = held_out(&fitted) {
            let held_out = fitted.remove(at);
            let described = held_out.name.clone();
            return Ok(Self { fitted, half: None, held_out, baseline, described });
        }
        let whole = fitted.first().ok_or(DiagnoseError::Empty)?;
        let middle = whole.len() / 2;
        let held_out = whole.part(middle..whole.len());
        let seconds = (whole.len() - middle) as f64 / whole.sample_rate_hz;
        let described = format!("the last {seconds:.2} s of {}: path and depth are those of the rest", whole.name);
        Ok(Self { half: Some(whole.part(0..middle)), held_out, baseline, described, fitted })
    }

    /// Recordings to which path and depth are fitted.
    fn learned(&self) -> Vec<&Observation> {
        self.half.as_ref().map_or_else(|| self.fitted.iter().collect(), |half| vec![half])
    }
}

/// What was found in the fitted recordings.
struct Found {
    bands: Vec<Range<f64>>,
    combs: Vec<CombNow>,
    changes: Vec<(usize, Change)>,
    candidates: Vec<Candidate>,
}

impl Found {
    fn new(data: &Data, geometry: &Geometry, seed: u64, progress: &dyn Fn(&str)) -> Option<Self> {
        let fastest = data.fitted.iter().map(|r| r.shaft_hz).fold(0.0, f64::max);
        let inner = geometry.orders().bpfi;
        let bands = bands(data.held_out.sample_rate_hz, inner * fastest);
        let modulation = |recordings: &[Observation], channel: usize| -> Vec<Modulation> {
            let of = |r: &Observation| {
                let highest_hz = ModulationSettings::DEFAULT.highest_ball_passes * inner * r.shaft_hz;
                let samples = r.channels[channel].as_deref()?;
                Modulation::new(samples, r.sample_rate_hz, r.shaft_hz, &bands, highest_hz, Tones::Limited)
            };
            recordings.iter().filter_map(of).collect()
        };
        let (mut combs, mut changes) = (Vec::new(), Vec::new());
        for channel in 0..CHANNELS.len() {
            progress("searching the envelopes for lines of the bearing");
            let now = modulation(&data.fitted, channel);
            let healthy: Vec<Observation> = data.baseline.iter().take(MOST_HEALTHY).cloned().collect();
            let then = modulation(&healthy, channel);
            for pattern in Pattern::ALL {
                let Some(comb) = Comb::find(&now, pattern, geometry, seed) else { continue };
                let depth = || Comb::depth_in(&then, pattern, geometry, comb.band);
                let healthy_depth = (!then.is_empty()).then(depth);
                combs.push(CombNow { comb, channel, healthy_depth });
            }
            changes.extend(Change::new(&data.fitted, &data.baseline, channel).map(|change| (channel, change)));
        }
        let candidates = candidates(&combs, &changes);
        (!bands.is_empty()).then_some(Self { bands, combs, changes, candidates })
    }

    /// The leading name of each class of evidence, if its log-odds suffice. A level says nothing beside a cause that changes it.
    fn leading(&self) -> Vec<&Candidate> {
        let stands = |c: &&Candidate| c.log_odds > NameSettings::DEFAULT.stands && c.probability > 0.5;
        let first = |class: Class| self.candidates.iter().find(|c| c.evidence.class() == class).filter(stands);
        let mut found: Vec<&Candidate> = [Class::Bearing, Class::Shaft].into_iter().filter_map(first).collect();
        if found.is_empty() {
            found.extend(first(Class::Level));
        }
        found.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
        found
    }
}

/// Greatest number of healthy recordings whose envelopes are examined: for the computing time.
const MOST_HEALTHY: usize = 12;

/// Diagnoses recordings of a machine of unknown structure, at least one, with or without a baseline.
///
/// # Errors
/// Recordings without acceleration or speed.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let machine = task.rig.bearing().ok_or(DiagnoseError::NotBearing { found: task.rig.model.kind().name() })?;
    let geometry = machine.bearing.geometry();
    let mut recordings = task.recordings.to_vec();
    let mut faults = faults::in_samples(&mut recordings, task.baseline.unwrap_or_default());
    let data = Data::new(&Task { recordings: &recordings, ..*task })?;
    faults.extend(faults::mains(&data.fitted, &data.baseline));
    let found = Found::new(&data, &geometry, task.seed, progress).ok_or(DiagnoseError::Empty)?;
    progress("synthesising held-out recordings");
    let mut causes = found.leading();
    let synthesis = |causes: &[&Candidate]| {
        let held_out = synthesised(&data, &found, causes, &geometry, task.seed);
        let (fit, left) = shown::fit(&held_out, data.described.clone(), task.seed);
        (held_out, fit, left)
    };
    let (mut held_out, mut fit, mut left) = synthesis(&causes);
    // The change of a line or of a mode is asked of the held-out recording itself: the distance of spectra shows little of it.
    let narrow_p: Vec<(EffectKind, f64)> =
        causes.iter().filter_map(|c| Some((c.kind, narrow_p_value(c, &data)?))).collect();
    let p_of = |kind: EffectKind| narrow_p.iter().find(|(of, _)| *of == kind).map(|(_, p)| *p);
    let is_borne_out = |c: &&Candidate| match p_of(c.kind) {
        Some(p_value) => p_value <= SynthesisSettings::DEFAULT.p_value,
        None => fit.p_value <= SynthesisSettings::DEFAULT.p_value && fit.after < fit.before,
    };
    let (kept, refuted): (Vec<&Candidate>, Vec<&Candidate>) = causes.into_iter().partition(is_borne_out);
    causes = kept;
    if !refuted.is_empty() {
        (held_out, fit, left) = synthesis(&causes);
    }
    // Of lines and modes alone, the least certain one counts.
    let narrow: Option<Vec<f64>> = causes.iter().map(|c| p_of(c.kind)).collect();
    if let Some(p_value) = narrow.and_then(|all| all.into_iter().reduce(f64::max)) {
        fit.p_value = p_value;
    }
    let beyond = found.changes.iter().any(|(_, change)| is_beyond_healthy(change)) || text::stands_out(&found.combs);
    let verdict = match (causes.is_empty() && faults.is_empty(), beyond) {
        (false, _) => Verdict::Mismatch,
        (true, true) => Verdict::Unexplained,
        (true, false) => Verdict::NoMismatch,
    };
    let leading = causes.first().copied();
    let mut named: Vec<Cause> = causes.iter().map(|c| named(c, &found, &data, &geometry)).collect();
    named.extend(faults.iter().map(Fault::cause));
    // Without a baseline nothing has changed that would need a cause.
    if verdict == Verdict::Unexplained && !data.baseline.is_empty() {
        named.push(unexplained(&found));
    }
    if verdict == Verdict::NoMismatch {
        left.share = 0.0;
    }
    let location = match (verdict, leading) {
        // A fault of the acquisition says itself where it is.
        (Verdict::NoMismatch, _) | (Verdict::Mismatch, None) => Location::default(),
        _ => location(leading, &found, &geometry),
    };
    let rejected = found.candidates.iter().filter(|c| causes.iter().all(|kept| kept.kind != c.kind));
    let rejected = rejected.map(|c| Rejected {
        name: c.kind.to_string(),
        why: if refuted.iter().any(|r| r.kind == c.kind) {
            "it does not improve the held-out recordings beyond chance".into()
        } else {
            text::rejected(c, &found.bands)
        },
    });
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict,
        rejected: rejected.collect(),
        location,
        terms: Vec::new(),
        nuisance: nuisance(&causes, &data),
        left,
        fit,
        causes: named,
    };
    Ok(DiagnosisResult {
        diagnosis,
        rig: task.rig.clone(),
        held_out,
        tests: tests(&found, &geometry),
        fitted: Vec::new(),
        caveats: text::caveats(verdict, &data.baseline, data.half.is_some()),
        settings: settings::document(),
    })
}

/// p-value of the change of a line or of a mode in the held-out recording; `None` for a cause that is neither.
fn narrow_p_value(cause: &Candidate, data: &Data) -> Option<f64> {
    let change = |channel: usize| Change::new(std::slice::from_ref(&data.held_out), &data.baseline, channel);
    let changed = match cause.evidence {
        Evidence::Order { channel, order, .. } => change(channel).and_then(|change| change.order_db(order)),
        Evidence::HalfOrders { channel, .. } => change(channel).and_then(|change| change.half_orders_db()),
        Evidence::Mode { channel, moved } => {
            let same = |found: &MovedMode| found.is_like(&moved);
            let scatter = 0.5 * NameSettings::DEFAULT.moved_mode[0];
            change(channel).and_then(|change| change.moved).filter(same).map(|found| [found.by_db, scatter])
        }
        Evidence::Comb(_) | Evidence::Gain { .. } => return None,
    };
    Some(changed.filter(|[db, _]| *db > 0.0).map_or(1.0, |[db, error]| two_sided(db / error)))
}

/// Held-out channels without the cause and with it; without a cause, the same twice.
fn synthesised(data: &Data, found: &Found, causes: &[&Candidate], geometry: &Geometry, seed: u64) -> Vec<HeldOut> {
    let learned = data.learned();
    let held = &data.held_out;
    let of = |channel: usize| {
        let measured = held.channels[channel].clone()?;
        let comb = comb_of(causes);
        let own = found
            .combs
            .iter()
            .find(|c| c.channel == channel && comb.is_some_and(|named| c.comb.pattern == named.comb.pattern));
        let modulated: Vec<Modulator> = own.map_or_else(Vec::new, |c| {
            let band = &found.bands[c.comb.band];
            modulators(&learned, channel, &c.comb, band.end - band.start, geometry)
        });
        let Densities { before, after } = Densities::predict(held, &learned, &data.baseline, channel, &modulated)?;
        let seed = seed.wrapping_add(channel as u64);
        let make = |density, modulators: &[Modulator], seed| {
            noise(measured.len(), held.sample_rate_hz, held.shaft_hz, density, modulators, seed)
        };
        // The same noise with the cause and without it, so that they differ by the cause alone.
        let still: Vec<Modulator> = modulated.iter().map(Modulator::still).collect();
        let before = make(&before, &still, seed);
        let after = if !causes.is_empty() {
            make(&after, &passed(&modulated, held, measured.len(), &after, seed), seed)
        } else {
            before.clone()
        };
        let name = HeldOut::name_of(&held.name, CHANNELS[channel]);
        Some(HeldOut { name, sample_rate_hz: held.sample_rate_hz, measured, before, after })
    };
    (0..CHANNELS.len()).filter_map(of).collect()
}

/// Comb of the causes.
fn comb_of<'c>(causes: &[&'c Candidate]) -> Option<&'c CombNow> {
    causes.iter().find_map(|c| match &c.evidence {
        Evidence::Comb(now) => Some(now),
        _ => None,
    })
}

fn named(candidate: &Candidate, found: &Found, data: &Data, geometry: &Geometry) -> Cause {
    Cause {
        name: candidate.kind.to_string(),
        probability: candidate.probability,
        evidence: text::evidence(candidate, &found.bands, data, geometry),
        equation: text::equation(candidate),
        signs: text::signs(candidate, &found.bands, data, geometry),
        ..Cause::default()
    }
}

/// The change that no name explains.
fn unexplained(found: &Found) -> Cause {
    Cause {
        name: Verdict::Unexplained.name().into(),
        probability: NameSettings::DEFAULT.unexplained,
        evidence: text::unexplained(&found.changes),
        ..Cause::default()
    }
}

fn location(cause: Option<&Candidate>, found: &Found, geometry: &Geometry) -> Location {
    let mut location = Location::default();
    match cause.map(|c| &c.evidence) {
        Some(Evidence::Comb(now)) => {
            let band = &found.bands[now.comb.band];
            location.frequency_hz = vec![[band.start, band.end]];
            let slip = now.comb.slip.iter().sum::<f64>() / now.comb.slip.len().max(1) as f64;
            location.order = now.comb.pattern.lines(geometry, slip, None);
            location.order.sort_by(f64::total_cmp);
            location.channel = CHANNELS[now.channel].into();
        }
        Some(Evidence::Order { channel, order, .. }) => {
            location.order = vec![*order as f64];
            location.channel = CHANNELS[*channel].into();
        }
        Some(Evidence::HalfOrders { channel, .. }) => {
            location.order = vec![0.5, 1.0, 1.5, 2.0];
            location.channel = CHANNELS[*channel].into();
        }
        Some(Evidence::Mode { channel, moved }) => {
            location.frequency_hz = vec![[moved.from_hz.min(moved.to_hz), moved.from_hz.max(moved.to_hz)]];
            location.channel = CHANNELS[*channel].into();
        }
        Some(Evidence::Gain { channel, .. }) => location.channel = CHANNELS[*channel].into(),
        None => {
            let most = found.changes.iter().max_by(|a, b| a.1.shape_db.total_cmp(&b.1.shape_db));
            if let Some((channel, change)) = most {
                location.channel = CHANNELS[*channel].into();
                location.frequency_hz = vec![change.wide_hz];
            }
        }
    }
    location
}

fn nuisance(causes: &[&Candidate], data: &Data) -> Vec<Nuisance> {
    let slip = |n: usize| comb_of(causes)?.comb.slip.get(n).copied();
    let of = |(n, r): (usize, &Observation)| Nuisance {
        recording: r.name.clone(),
        shaft_hz: None,
        slip: slip(n),
        wander: None,
    };
    data.fitted.iter().enumerate().map(of).collect()
}

/// Every statistic as a test, the most significant first.
fn tests(found: &Found, geometry: &Geometry) -> Vec<Test> {
    let combs = found.combs.iter().map(|c| text::comb_test(c, &found.bands, geometry));
    let changes = found.changes.iter().flat_map(|(channel, change)| text::change_tests(*channel, change));
    evidence::ranked(combs.chain(changes).collect())
}
