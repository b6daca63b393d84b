//! Effects of the vocabulary from fitted coefficients.

use super::{
    table::{Table, TermModel},
    terms::Meaning,
};
use crate::identify::force_balance::{equation::Parameter, states::States};
use crate::rig::{EffectEntry, Value, config::SdofRig, effect::ValueKind};

/// Multiple of the nominal damping from which a damping is called friction that the nominal model has not.
const FRICTION: f64 = 5.0;
/// Distance of the first samples from a bias, as a share of it, at which they are taken to begin there.
const AT_REST: f64 = 0.5;

/// Effect with its fitted parameters.
#[derive(Clone, Debug)]
pub struct Cause {
    /// Effect with its values.
    pub entry: EffectEntry,
    /// Parameters that a fit changes.
    pub free: Vec<&'static str>,
    /// Term of the library.
    pub term: usize,
}

/// Causes of a model, for a machine with the model's own parameters.
pub fn causes(table: &Table, model: &TermModel, machine: &SdofRig, states: &States) -> Vec<Cause> {
    (0..model.parts.len()).map(|part| cause(table, model, part, machine, states)).collect()
}

fn cause(table: &Table, model: &TermModel, part: usize, machine: &SdofRig, states: &States) -> Cause {
    let (index, variant) = model.parts[part];
    let term = &table.library.terms[index];
    let coefficients = table.coefficients(model, part);
    let value = coefficients[0];
    let mut entry = term.variants[variant].entry.clone();
    let mut free = Vec::new();
    match term.meaning {
        Meaning::Strength(key) => {
            if key == "cubic_n_per_m3" && value < 0.0 {
                entry.name = "softening-stiffness".into();
            }
            entry.set_number(key, value);
            free.push(key);
            if entry.name == "end-stop-contact" {
                free.push("gap_m");
            }
        }
        Meaning::Spring => free.push("width_m"),
        Meaning::Change(parameter) => {
            let nominal = parameter.value_in(machine);
            let changed = (nominal + value).max(1e-6 * nominal.abs().max(1e-6));
            if parameter == Parameter::Damping && changed > FRICTION * nominal {
                entry = EffectEntry::new("viscous-friction", &[("damping_n_s_per_m", value)]);
                free.push("damping_n_s_per_m");
            } else {
                entry.set_number("value", changed);
                free.push("value");
            }
        }
        Meaning::Gain => {
            entry.set_number("value", 1.0 / (1.0 + value));
            free.push("value");
        }
        Meaning::Bias => {
            entry.set_number("value", -value);
            free.push("value");
        }
        Meaning::Mode => {
            let gain = -(coefficients[0].signum()) * 0.1;
            entry.set_number("gain", gain);
            free.extend(["frequency_hz", "damping_ratio", "gain"]);
        }
    }
    entry = bias_or_force(entry, machine, states);
    if let Some(definition) = entry.definition() {
        for parameter in definition.parameters.iter().filter(|p| p.in_vocabulary()) {
            if matches!(parameter.value_kind, ValueKind::Name(_)) {
                entry.parameters.insert(parameter.name.into(), Value::Text("mass".into()));
            }
        }
    }
    if entry.name == "constant-force" {
        free = vec!["force_n"];
    } else if entry.name == "sensor-bias" {
        free = vec!["value"];
    }
    Cause { entry, free, term: index }
}

/// A constant force and a bias of the position sensor leave the same in the balance of a linear spring. Where the mass
/// starts tells them apart: from rest at the nominal zero a bias shows in the first sample, a force only later.
fn bias_or_force(entry: EffectEntry, machine: &SdofRig, states: &States) -> EffectEntry {
    let number = |key: &str| entry.number(key).unwrap_or_default();
    let k = machine.stiffness_n_per_m;
    let bias = match entry.name.as_str() {
        "constant-force" if k > 0.0 => number("force_n") / k,
        "sensor-bias" => number("value"),
        _ => return entry,
    };
    let rest = if k > 0.0 { machine.gravity_n / k } else { 0.0 };
    let begins = states.tracks.iter().filter(|track| {
        let first = &track.sensed[..track.len().min(3)];
        let mean = first.iter().sum::<f64>() / first.len() as f64;
        let at_nominal = mean.abs().min((mean - rest).abs());
        let at_bias = (mean - bias).abs().min((mean - rest - bias).abs());
        at_bias < at_nominal && at_bias < AT_REST * bias.abs()
    });
    if 2 * begins.count() > states.tracks.len() {
        EffectEntry::new("sensor-bias", &[("value", bias)])
    } else {
        EffectEntry::new("constant-force", &[("force_n", bias * k)])
    }
}
