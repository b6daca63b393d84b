//! Diagnosis of the rig of one degree of freedom by its force balance, theory (66) to (69).

use super::{
    acquisition,
    causes::{self, Cause},
    decide::{self, Decision},
    events,
    finding::{CauseParameter, Fault, Finding, FoundCause, HeldOutFit},
    locate,
    table::Table,
    terms::{SoughtBy, sought_by},
    text,
};
use crate::diagnose::result::Verdict;
use crate::identify::force_balance::{
    BalanceError, calibrate,
    equation::{self, Parameter},
    refine,
    regression::Fit,
    shooting,
    states::{Sensed, States},
    traces::{self, HeldOutTrace},
};
use crate::recording::Recording;
use crate::rig::config::RigKey;
use crate::rig::effect::{EffectKind, Site};
use crate::rig::{Rig, config::Machine};
use crate::stats::significance::shares;

/// Limits of a lack of fit that flexible columns without a name reveal: p-value, and share of the error that they explain.
const LEFT: (f64, f64) = (0.005, 0.08);
/// Share of the explainable error that causes must explain to be accepted.
const EXPLAINS: f64 = 0.93;

/// Ratio of the simulation's RMS residual to the sensor's noise below which the rig has no mismatch.
const ACQUITS: f64 = 1.03;

/// Diagnoses a rig of one degree of freedom: named causes, no mismatch, or a mismatch that no cause of the vocabulary
/// explains.
///
/// `baseline` are recordings of the healthy machine: unknown parameters are fitted to them and to the others alike,
/// effects act on the others only. Without any, unknown parameters are fitted together with each hypothesis.
///
/// # Errors
///
/// As [`super::calibrate_sdof`], but for a rig of which nothing is unknown.
pub fn diagnose_sdof(
    rig: &Rig,
    baseline: Option<&[Recording]>,
    recordings: &[Recording],
    seed: u64,
) -> Result<Finding, BalanceError> {
    let machine = equation::machine(rig)?;
    if recordings.is_empty() {
        return Err(BalanceError::NoRecordings);
    }
    let baseline = baseline.unwrap_or_default();
    let all: Vec<Recording> = recordings.iter().chain(baseline).cloned().collect();
    let mut states = States::new(&all)?;
    let mut count = recordings.len();
    let mut faults = acquisition::clean(&mut states, &mut count)?;
    states.learn_hold(rig)?;
    let healthy: Vec<bool> = (0..states.tracks.len()).map(|index| index >= count).collect();
    // Damping absent from the nominal rig is that of viscous friction.
    let none = |p: &Parameter| *p == Parameter::Damping && machine.damping_n_s_per_m == 0.0;
    let unknown: Vec<Parameter> = equation::unknown(rig).into_iter().filter(|p| !none(p)).collect();
    let unknown = separable(rig, &states, unknown)?;
    let judge = |states: &States| {
        let nothing = || BalanceError::Nothing { expected: "parameters that the recordings determine".into() };
        let coarse = Table::new(rig, states, &healthy, &unknown, &[])?;
        let first = decide::decide(&coarse, seed).ok_or_else(nothing)?;
        let table = Table::new(rig, states, &healthy, &unknown, &first.found(&coarse))?;
        let decision = decide::decide(&table, seed).ok_or_else(nothing)?;
        Ok::<_, BalanceError>((table, decision))
    };
    let (mut table, mut decision) = judge(&states)?;
    if faults.iter().any(|f| f.entry.kind == EffectKind::SensorClipping) {
        // Nearly every row has clipped samples; a simulation needs no rows.
        if explained_by_clipping(rig, &states, &unknown, count) {
            decision = decision.acquitted();
        }
    } else if let Some(fault) = events::shock(&mut states, &table, &decision, count) {
        faults.push(fault);
        (table, decision) = judge(&states)?;
    }
    let keys: Vec<RigKey> = unknown.iter().map(|p| p.key().into()).collect();
    let under_test = States { tracks: states.tracks[..count].to_vec(), ..states.clone() };
    // Where the balance is at its limits (integrals of an acceleration lack frequencies below the band) the simulation
    // decides: a rig whose residual is the sensor's noise has no mismatch.
    let doubtful = under_test.sensed == Sensed::Acceleration || decision.chosen.parts.is_empty();
    if doubtful && verdict(&decision, &faults) != Verdict::NoMismatch && faults.is_empty() {
        let simulated = shooting::refine(rig, &keys, &under_test, None);
        if simulated.is_some_and(|r| r.rms < ACQUITS * under_test.band.noise_std) {
            decision = decision.acquitted();
        }
    }
    let verdict = verdict(&decision, &faults);
    let case =
        Case { rig, states: &under_test, table: &table, decision: &decision, faults: &faults, unknown: &unknown };
    Ok(case.finding(verdict, !baseline.is_empty(), seed))
}

/// Whether the rig, its unknown parameters fitted, explains all samples that are not clipped, or too few rows are left to
/// decide.
fn explained_by_clipping(rig: &Rig, states: &States, unknown: &[Parameter], count: usize) -> bool {
    let under_test = States { tracks: states.tracks[..count].to_vec(), ..states.clone() };
    let keys: Vec<RigKey> = unknown.iter().map(|p| p.key().into()).collect();
    let simulated = shooting::refine(rig, &keys, &under_test, None);
    let valid = under_test.tracks.iter().flat_map(|t| &t.valid).filter(|v| **v).count();
    simulated.is_some_and(|r| calibrate::consistent(&r, &under_test)) || 5 * valid < 2 * under_test.rows()
}

/// Unknown parameters that the recordings determine jointly.
fn separable(rig: &Rig, states: &States, unknown: Vec<Parameter>) -> Result<Vec<Parameter>, BalanceError> {
    let equation = equation::Equation::new(rig, states)?;
    Ok(calibrate::determined(&equation, &unknown).0)
}

fn verdict(decision: &Decision, faults: &[Fault]) -> Verdict {
    let structured = decision.rich_p_value < LEFT.0 && decision.left_to_explain() > LEFT.1;
    let named = !decision.chosen.parts.is_empty();
    match (named, structured) {
        (true, true) if decision.explained() < EXPLAINS => Verdict::Unexplained,
        (true, _) => Verdict::Mismatch,
        (false, true) if faults.is_empty() => Verdict::Unexplained,
        (false, _) if !faults.is_empty() => Verdict::Mismatch,
        (false, _) => Verdict::NoMismatch,
    }
}

/// Inputs of a finding.
struct Case<'a> {
    rig: &'a Rig,
    states: &'a States,
    table: &'a Table,
    decision: &'a Decision,
    faults: &'a [Fault],
    unknown: &'a [Parameter],
}

impl Case<'_> {
    fn finding(&self, verdict: Verdict, told: bool, seed: u64) -> Finding {
        let decision = self.decision;
        let named = if verdict == Verdict::Mismatch { &decision.chosen } else { &decision.nothing };
        let mut rig = self.rig.clone();
        // The rig's own parameters take the values of this model.
        for ((parameter, _), value) in self.table.library.own.iter().zip(&named.values) {
            let value = if rig.domain(parameter.key().into()).is_some_and(|d| d.holds(*value)) { *value } else { 1e-9 };
            let _ = rig.set(parameter.key(), value);
        }
        let Machine::Sdof(machine) = rig.model.clone() else { unreachable!("checked at the start") };
        let causes = causes::causes(self.table, named, &machine, self.states);
        let plain = rig.clone();
        let (rig, own, parameters) = fitted(rig, &causes, if told { &[] } else { self.unknown }, self.states);
        let mut found: Vec<FoundCause> = causes
            .iter()
            .zip(parameters)
            .enumerate()
            .map(|(index, (cause, parameters))| FoundCause {
                name: cause.entry.kind.to_string(),
                probability: self.probability(cause.term, seed),
                evidence: text::evidence(self.table, decision, index, cause.entry.kind, self.states),
                equation: text::equation(&rig, self.rig.effects.len() + index),
                entry: rig.effects[self.rig.effects.len() + index].clone(),
                parameters,
            })
            .collect();
        found.extend(self.faults.iter().map(Fault::cause));
        found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let rows = self.table.rows().max(1) as f64;
        let root = |sum: f64| (sum / rows).sqrt();
        let fit = HeldOutFit {
            metric: "RMS of the whitened force-balance residual, cross-validated; 1 is the disturbance".into(),
            held_out: text::held_out(self.states),
            before: root(decision.nothing.total()),
            after: root(named.total()),
            noise_floor: self.table.floor.sqrt(),
            explainable: root(decision.rich.total().min(decision.chosen.total())),
            explained_share: if verdict == Verdict::Mismatch { decision.explained() } else { 0.0 },
            p_value: if named.parts.is_empty() { decision.rich_p_value } else { decision.p_value },
        };
        let traces = traces(&plain, &rig, self.rig.effects.len(), &causes, self.unknown, self.states);
        // Clipping and mains interference are in every recording; lost samples and shocks in one.
        let lasting = |fault: &&Fault| sought_by(fault.entry.kind) == Some(SoughtBy::Acquisition);
        let rig = self.faults.iter().filter(lasting).fold(rig, |rig, fault| rig.with_effect(fault.entry.clone()));
        Finding {
            verdict,
            causes: if verdict == Verdict::Mismatch { found } else { Vec::new() },
            rejected: text::rejected(self.table, decision, &causes),
            location: locate::locate(self.table, &decision.nothing, self.states),
            fit,
            own,
            sensor_noise_std: self.states.band.noise_std,
            tests: text::tests(self.table, decision, seed),
            traces,
            rig,
        }
    }

    fn probability(&self, term: usize, seed: u64) -> f64 {
        let models: Vec<&[f64]> = self.decision.rivals.iter().map(|m| m.left.as_slice()).collect();
        let won = shares(&models, seed);
        let with = self.decision.rivals.iter().zip(won).filter(|(m, _)| m.parts.iter().any(|(t, _)| *t == term));
        let share: f64 = with.map(|(_, share)| share).sum();
        // A permutation test resolves no p-value below one in its count.
        share.min(1.0 - self.decision.p_value).clamp(0.0, 1.0)
    }
}

/// Traces of the held-out recordings. `plain` is the rig with its unknown parameters fitted, `corrected` that rig with the
/// causes; from the effect of index `first` on these are refitted without the held-out recordings. Each simulation starts
/// from the initial state of the smallest residual.
pub fn traces(
    plain: &Rig,
    corrected: &Rig,
    first: usize,
    causes: &[Cause],
    unknown: &[Parameter],
    states: &States,
) -> Vec<HeldOutTrace> {
    let Some((train, test, _)) = states.split() else { return Vec::new() };
    let again: Vec<Cause> = causes
        .iter()
        .zip(&corrected.effects[first..])
        .map(|(cause, entry)| Cause { entry: entry.clone(), ..cause.clone() })
        .collect();
    let mut base = corrected.clone();
    base.effects.truncate(first);
    let after = fitted(base, &again, unknown, &train).0;
    let before = fitted(plain.clone(), &[], unknown, &train).0;
    traces::simulated(&before, &after, &test)
}

/// Joint fit of causes and the rig's unknown parameters: rig, unknown parameters and each cause's parameters with intervals.
pub fn fitted(
    mut rig: Rig,
    causes: &[Cause],
    unknown: &[Parameter],
    states: &States,
) -> (Rig, Vec<CauseParameter>, Vec<Vec<CauseParameter>>) {
    let first = rig.effects.len();
    let mut keys: Vec<RigKey> = unknown.iter().map(|p| p.key().into()).collect();
    for (index, cause) in causes.iter().enumerate() {
        rig = rig.with_effect(cause.entry.clone());
        keys.extend(cause.free.iter().map(|key| RigKey::Effect { index: first + index, key: *key }));
    }
    let mut fit: Option<Fit> = None;
    if !keys.is_empty() {
        // Effects of the sensor are no forces.
        let sensor = |c: &Cause| {
            c.entry.definition().site == Site::Acquisition || c.entry.kind == EffectKind::StructuralResonance
        };
        if !causes.iter().any(sensor) {
            let mut moved = rig.clone();
            fit = refine::refine(&mut moved, &keys, states);
            if fit.is_some() {
                rig = moved;
            }
        }
        let simulated = shooting::refine(&rig, &keys, states, None);
        if let Some(better) = simulated.filter(|r| calibrate::consistent(r, states) || fit.is_none()) {
            rig = better.rig;
            fit = Some(better.fit);
        }
    }
    let number = |index: usize, name: &str| CauseParameter {
        name: name.to_owned(),
        value: rig.get(keys[index]).unwrap_or(f64::NAN),
        interval95: fit.as_ref().map(|fit| {
            let (value, half) = (fit.values[index], fit.half_widths()[index]);
            [value - half, value + half]
        }),
    };
    let own = unknown.iter().enumerate().map(|(index, p)| number(index, p.key().name())).collect();
    let mut next = unknown.len();
    let each = causes.iter().map(|cause| {
        let mut numbers: Vec<CauseParameter> = Vec::new();
        let fitted: Vec<CauseParameter> =
            cause.free.iter().enumerate().map(|(i, name)| number(next + i, name.name())).collect();
        next += cause.free.len();
        for parameter in cause.entry.definition().parameters {
            if let Some(fitted) = fitted.iter().find(|f| f.name == parameter.key.name()) {
                numbers.push(fitted.clone());
            } else if let (true, Some(value)) = (parameter.in_vocabulary(), cause.entry.number(parameter.key)) {
                numbers.push(CauseParameter { name: parameter.key.to_string(), value, interval95: None });
            }
        }
        numbers.retain(|n| {
            cause.entry.definition().parameters.iter().any(|p| p.key.name() == n.name && p.in_vocabulary())
        });
        numbers
    });
    let each = each.collect();
    (rig.clone(), own, each)
}

#[cfg(test)]
mod tests;
