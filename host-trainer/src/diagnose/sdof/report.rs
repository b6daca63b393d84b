//! Last stage: what stands, in the form of `diagnosis.json`.

use std::collections::BTreeMap;

use super::causes::Cause;
use super::curve;
use super::faults::Fault;
use super::select::gain_p;
use super::settings::SdofSettings;
use super::table::TermModel;
use super::text::{caveats, evidence, rejected, repeating};
use super::validate::SimulatedFit;
use super::verdict::{Case, Judged, Stretch};
use crate::diagnose::result::{
    Aspect, Cause as Reported, Diagnosis, DiagnosisResult, Fit, Fitted, HeldOut, Left, Location, Nuisance, Parameter,
    SCHEMA, Test, Verdict,
};
use crate::identify::force_balance::noise;
use crate::rig::Rig;
use crate::rig::config::{RigKey, RigKind};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::stats::significance::{false_discovery_rates, paired_z};

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// Ratio to the mean from which a stretch of time is named, and stretches of each recording.
const LOUD: (f64, usize) = (2.0, 20);

/// Result of a diagnosis.
pub fn result(case: &Case, judged: Judged) -> DiagnosisResult {
    let channel = case.acquired.sensed.channel();
    let mismatch = judged.verdict == Verdict::Mismatch;
    let fitted = if mismatch { judged.after.as_ref() } else { judged.before.as_ref() };
    let rig = fitted.map_or_else(|| case.task.rig.clone(), |f| f.rig.clone());
    let first = case.task.rig.effects.len();
    let equations: Vec<String> =
        (0..judged.causes.len()).map(|i| rig.effects[first + i].equation(RigKind::Sdof)).collect();
    let mut causes: Vec<Reported> = judged
        .causes
        .iter()
        .enumerate()
        .map(|(index, cause)| reported(case, &judged, cause, index, &equations[index]))
        .collect();
    let faults: &[Fault] = if mismatch { &judged.faults } else { &[] };
    causes.extend(faults.iter().map(|f| fault(f, case.table.under_test.len())));
    causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let chosen = &judged.selection.chosen;
    let terms = match judged.verdict {
        Verdict::Mismatch => curve::terms(case.table, chosen, &equations),
        Verdict::Unexplained => curve::nameless(case.table, &judged.selection.nothing).into_iter().collect(),
        Verdict::NoMismatch => Vec::new(),
    };
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict: judged.verdict,
        causes,
        rejected: rejected(case.table, &judged),
        location: location(case, &judged, channel),
        terms,
        nuisance: nuisance(case),
        left: left(case, &judged, channel),
        fit: fit(case, &judged),
    };
    let stretches: Vec<Stretch> = judged
        .stretches
        .iter()
        .map(|s| Stretch { after: if mismatch { s.after.clone() } else { s.before.clone() }, ..s.clone() })
        .collect();
    let lasting = faults.iter().filter(|f| f.lasts());
    let corrected = lasting.fold(rig, |rig, f| rig.with_effect(f.entry.clone()));
    DiagnosisResult {
        diagnosis,
        held_out: held_out(case, &stretches),
        tests: tests(case, &judged, channel),
        fitted: own(fitted),
        caveats: caveats(case, &judged),
        settings: super::settings::document(),
        rig: corrected,
    }
}

fn reported(case: &Case, judged: &Judged, cause: &Cause, index: usize, equation: &str) -> Reported {
    let effect = case.task.rig.effects.len() + index;
    let rig: Option<&Rig> = judged.after.as_ref().map(|f| &f.rig);
    let entry = rig.map_or(&cause.entry, |rig| &rig.effects[effect]);
    let (mut parameters, mut interval95) = (BTreeMap::new(), BTreeMap::new());
    for parameter in entry.definition().parameters.iter().filter(|p| p.in_vocabulary()) {
        let name = parameter.key.to_string();
        if let Some(value) = entry.number(parameter.key) {
            parameters.insert(name.clone(), Parameter::Number(value));
            let key = RigKey::Effect { index: effect, key: parameter.key };
            if let Some(half) = judged.after.as_ref().and_then(|fit| half_width(fit, key)) {
                interval95.insert(name, [value - half, value + half]);
            }
        } else if let Some(text) = entry.text(parameter.key) {
            parameters.insert(name, Parameter::Name(text.into()));
        }
    }
    Reported {
        name: entry.kind.to_string(),
        probability: judged.selection.probability(case.table, cause.term, case.task.seed),
        parameters,
        interval95,
        evidence: evidence(case.table, &judged.selection, cause, judged),
        // With one coordinate only, "q = q" is left out.
        equation: equation.trim_end_matches(", q = q").to_owned(),
        ..Reported::default()
    }
}

fn half_width(fit: &SimulatedFit, key: RigKey) -> Option<f64> {
    let index = fit.keys.iter().position(|k| *k == key)?;
    fit.values[index].1
}

fn fault(fault: &Fault, blocks: usize) -> Reported {
    let stated = fault.entry.definition().parameters.iter().filter(|p| p.in_vocabulary());
    let parameters = stated.filter_map(|p| Some((p.key.to_string(), Parameter::Number(fault.entry.number(p.key)?))));
    let blocks = blocks as f64;
    Reported {
        name: fault.entry.kind.to_string(),
        probability: SETTINGS.most_probability.min(blocks / (blocks + 2.0)),
        parameters: parameters.collect(),
        evidence: fault.evidence.clone(),
        equation: fault.entry.equation(RigKind::Sdof),
        ..Reported::default()
    }
}

fn tests(case: &Case, judged: &Judged, channel: &'static str) -> Vec<Test> {
    let (table, selection) = (case.table, &judged.selection);
    let nothing = &selection.nothing;
    let test = |what: String, model: &TermModel| (what, paired_z(&nothing.left, &model.left), gain_p(nothing, model));
    let singles = selection.singles.iter().filter_map(|trial| {
        let name = table.library.terms[trial.term].kind;
        Some(test(format!("force of {name}"), trial.model.as_ref()?))
    });
    let any = test("any force of position, speed and time".into(), &selection.rich);
    let repeating = judged.repeating.map(|found| {
        let p_value = found.p_value.max(1e-300);
        // Of a normal distribution's tail, nearly.
        (repeating(&found, case.nominal.machine.restoring), (-2.0 * p_value.ln()).sqrt(), p_value)
    });
    let mut found: Vec<(String, f64, f64)> = std::iter::once(any).chain(singles).chain(repeating).collect();
    found.sort_by(|a, b| a.2.total_cmp(&b.2).then(b.1.total_cmp(&a.1)));
    let p_values: Vec<f64> = found.iter().map(|t| t.2).collect();
    let rates = false_discovery_rates(&p_values);
    let one =
        |((what, z, p_value), q_value)| Test { aspect: Aspect::Force, channel, at: None, what, z, p_value, q_value };
    found.into_iter().zip(rates).map(one).collect()
}

fn own(fit: Option<&SimulatedFit>) -> Vec<Fitted> {
    let Some(fit) = fit else { return Vec::new() };
    let model = fit.keys.iter().zip(&fit.values).filter(|(key, _)| matches!(key, RigKey::Model(_)));
    model
        .map(|(key, (value, half))| {
            let half = half.unwrap_or(f64::INFINITY);
            (key.to_string(), *value, [value - half, value + half])
        })
        .collect()
}

fn fit(case: &Case, judged: &Judged) -> Fit {
    let seconds = judged.windows.length as f64 * case.acquired.tracks[0].step_s();
    let names: Vec<String> = case.acquired.under_test().map(|t| t.name.clone()).collect();
    let scheme = if judged.windows.by_recording { "recordings" } else { "blocks of time" };
    let fit = &judged.comparison;
    let after = if judged.verdict == Verdict::Mismatch { fit.after } else { fit.before };
    let predicted = format!(
        "RMS of measured minus predicted one sample ahead {}, in the sensor's unit",
        case.acquired.sensed.channel()
    );
    Fit {
        metric: if judged.one_step_ahead {
            predicted
        } else {
            format!(
                "RMS of measured minus simulated {}, in the sensor's unit, over windows of about {seconds:.3} s from a fitted start",
                case.acquired.sensed.channel()
            )
        },
        held_out: format!("{scheme} in turn, four folds: {}", names.join(", ")),
        before: fit.before,
        after,
        // The estimate is an upper bound where the motion fills the band.
        noise_floor: case.acquired.noise_std.min(after),
        p_value: if judged.verdict == Verdict::Mismatch { fit.p_value } else { judged.selection.rich_p_value },
    }
}

/// Held-out windows, put together recording by recording.
fn held_out(case: &Case, stretches: &[Stretch]) -> Vec<HeldOut> {
    let mut out: Vec<(usize, HeldOut)> = Vec::new();
    for stretch in stretches {
        if out.last().is_none_or(|(origin, _)| *origin != stretch.origin) {
            if out.len() == SETTINGS.traces {
                break;
            }
            let recording = &case.task.recordings[stretch.origin];
            out.push((
                stretch.origin,
                HeldOut {
                    name: recording.name(),
                    sample_rate_hz: recording.sample_rate_hz,
                    measured: Vec::new(),
                    before: Vec::new(),
                    after: Vec::new(),
                },
            ));
        }
        if let Some((_, held)) = out.last_mut() {
            held.measured.extend(&stretch.measured);
            held.before.extend(&stretch.before);
            held.after.extend(&stretch.after);
        }
    }
    out.into_iter().map(|(_, held)| held).collect()
}

fn nuisance(case: &Case) -> Vec<Nuisance> {
    let one =
        |t: &super::acquire::Track| Nuisance { recording: t.name.clone(), shaft_hz: None, slip: None, wander: None };
    case.acquired.under_test().map(one).collect()
}

fn location(case: &Case, judged: &Judged, channel: &str) -> Location {
    let mut location = Location { channel: channel.into(), ..Location::default() };
    // The residual of a rig without a mismatch is noise, and so is the location of its maximum.
    if judged.verdict == Verdict::NoMismatch {
        return location;
    }
    for fault in &judged.faults {
        let number = |key: ParameterKey| fault.entry.number(key).unwrap_or_default();
        match fault.entry.kind {
            EffectKind::MainsInterference => location.frequency_hz.push([number(ParameterKey::FrequencyHz); 2]),
            EffectKind::SensorClipping => {
                let level = number(ParameterKey::Value).abs();
                location.state = format!("|{channel}| at {level:.6}, the end of the sensor's range");
            }
            _ => location.time_s.push([number(ParameterKey::TimeS); 2]),
        }
    }
    if !judged.faults.is_empty() && judged.causes.is_empty() {
        return location;
    }
    let table = case.table;
    let residual = table.residual(&judged.selection.nothing);
    location.frequency_hz.extend(band(case, &residual));
    let rich = table.flexible(&judged.selection.nothing);
    let about = rich.columns.iter().find_map(|c| table.library.flexible.iter().position(|f| f == c));
    if let (Some(about), true) = (about, location.state.is_empty()) {
        location.state = format!("a force that depends on {}", table.library.about[about]);
    }
    let mean = residual.iter().map(|r| r * r).sum::<f64>() / residual.len().max(1) as f64;
    let mut start = 0;
    for (track, rows) in case.acquired.tracks.iter().zip(&table.library.rows) {
        let part = &residual[start..start + rows];
        start += rows;
        let (loud, count) = LOUD;
        if track.healthy || *rows < 4 * count {
            continue;
        }
        let seconds = track.len() as f64 * track.step_s() / count as f64;
        for stretch in 0..count {
            let inside = &part[stretch * rows / count..(stretch + 1) * rows / count];
            let power = inside.iter().map(|r| r * r).sum::<f64>() / inside.len().max(1) as f64;
            if power > loud * mean {
                let from = track.start_s + stretch as f64 * seconds;
                match location.time_s.last_mut().filter(|span| (span[1] - from).abs() < 0.01 * seconds) {
                    Some(span) => span[1] = from + seconds,
                    None => location.time_s.push([from, from + seconds]),
                }
            }
        }
    }
    location
}

/// Band with the middle 80 % of a residual's power in the longest recording, Hz.
fn band(case: &Case, residual: &[f64]) -> Option<[f64; 2]> {
    let rows = &case.table.library.rows;
    let longest = (0..rows.len()).max_by_key(|n| rows[*n])?;
    let start: usize = rows[..longest].iter().sum();
    let part = &residual[start..start + rows[longest]];
    let rate = case.acquired.tracks[longest].sample_rate_hz;
    if part.len() < 64 {
        return None;
    }
    let power = noise::power(&[part], (part.len() / 4 * 2).min(512));
    let total: f64 = power.iter().sum();
    let (mut sum, mut edges) = (0.0, [0.0, 0.5 * rate]);
    for (k, p) in power.iter().enumerate() {
        let hz = 0.5 * rate * k as f64 / (power.len() - 1) as f64;
        for (edge, share) in edges.iter_mut().zip([0.1, 0.9]) {
            if sum < share * total && sum + p >= share * total {
                *edge = hz;
            }
        }
        sum += p;
    }
    Some(edges)
}

fn left(case: &Case, judged: &Judged, channel: &str) -> Left {
    let share = match judged.verdict {
        Verdict::NoMismatch => 0.0,
        Verdict::Unexplained => 1.0,
        Verdict::Mismatch => 1.0 - judged.selection.explained(),
    };
    let residual = case.table.residual(&judged.selection.chosen);
    let frequency_hz = if share > 0.0 { band(case, &residual).into_iter().collect() } else { Vec::new() };
    Left { share, frequency_hz, order: Vec::new(), channel: channel.into() }
}
