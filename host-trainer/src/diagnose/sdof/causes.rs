//! Effects of the vocabulary from fitted coefficients.

use super::acquire::{Acquired, Track};
use super::table::{Table, TermModel};
use super::terms::Meaning;
use crate::identify::force_balance::{equation::Parameter, states::Sensed};
use crate::rig::effect::{EffectKind, ParameterKey, ValueKind};
use crate::rig::{EffectEntry, Value, config::SdofRig};

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
    pub free: Vec<ParameterKey>,
    /// Term of the library.
    pub term: usize,
}

impl Cause {
    /// What the sensor shows of it at the machine's nominal zero, if nothing else.
    pub fn offset(&self, machine: &SdofRig, sensed: Sensed) -> Option<f64> {
        match self.entry.kind {
            EffectKind::SensorBias => self.entry.number(ParameterKey::Value),
            EffectKind::ConstantForce if machine.stiffness_n_per_m > 0.0 && sensed == Sensed::Position => {
                Some(self.entry.number(ParameterKey::ForceN)? / machine.stiffness_n_per_m)
            }
            _ => None,
        }
    }
}

/// Causes of a model, for a machine with the model's own parameters.
pub fn causes(table: &Table, model: &TermModel, machine: &SdofRig, acquired: &Acquired) -> Vec<Cause> {
    // With another mass m all other forces were regressed on as m₀/m of theirs.
    let own = table.library.own.len();
    let is_mass = |(term, _): &(usize, usize)| table.library.terms[*term].meaning == Meaning::Change(Parameter::Mass);
    let mass = model.parts.iter().position(is_mass);
    let factor = mass.map_or(1.0, |part| 1.0 / (1.0 - model.values[own + part] / machine.mass_kg).max(0.05));
    (0..model.parts.len()).map(|part| cause(table, model, part, factor, machine, acquired)).collect()
}

fn cause(table: &Table, model: &TermModel, part: usize, factor: f64, machine: &SdofRig, acquired: &Acquired) -> Cause {
    let (index, variant) = model.parts[part];
    let term = &table.library.terms[index];
    let value = match term.meaning {
        Meaning::Change(Parameter::Mass) => (factor - 1.0) * machine.mass_kg,
        Meaning::Gain | Meaning::Mode => model.values[table.library.own.len() + part],
        _ => factor * model.values[table.library.own.len() + part],
    };
    let mut entry = term.variants[variant].entry.clone();
    let mut free = Vec::new();
    match term.meaning {
        Meaning::Strength(key) => {
            if key == ParameterKey::CubicNPerM3 && value < 0.0 {
                entry.kind = EffectKind::SofteningStiffness;
            }
            entry.set_number(key, value);
            free.push(key);
            if entry.kind == EffectKind::EndStopContact {
                free.push(ParameterKey::GapM);
            }
            if term.variants[variant].saturates() {
                free.push(ParameterKey::SaturationPerM2);
            }
        }
        Meaning::Spring(_) => free.push(ParameterKey::WidthM),
        Meaning::Change(parameter) => {
            let nominal = parameter.value_in(machine);
            let changed = (nominal + value).max(1e-6 * nominal.abs().max(1e-6));
            if parameter == Parameter::Damping && changed > FRICTION * nominal {
                entry = EffectEntry::new(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, value)]);
                free.push(ParameterKey::DampingNSPerM);
            } else {
                entry.set_number(ParameterKey::Value, changed);
                free.push(ParameterKey::Value);
            }
        }
        Meaning::Gain => {
            entry.set_number(ParameterKey::Value, 1.0 + value);
            free.push(ParameterKey::Value);
        }
        Meaning::Mode => {
            entry.set_number(ParameterKey::Gain, value);
            free.extend([ParameterKey::FrequencyHz, ParameterKey::DampingRatio, ParameterKey::Gain]);
        }
    }
    entry = bias_or_force(entry, machine, acquired);
    for parameter in entry.definition().parameters.iter().filter(|p| p.in_vocabulary()) {
        if matches!(parameter.value_kind, ValueKind::Name(_)) {
            entry.parameters.insert(parameter.key, Value::Text("mass".into()));
        }
    }
    if entry.kind == EffectKind::ConstantForce {
        free = vec![ParameterKey::ForceN];
    } else if entry.kind == EffectKind::SensorBias {
        free = vec![ParameterKey::Value];
    }
    Cause { entry, free, term: index }
}

/// A constant force and a bias of the position sensor leave the same in the balance of a linear spring. Where the mass
/// starts tells them apart: from rest at the nominal zero a bias shows in the first sample, a force only later.
fn bias_or_force(entry: EffectEntry, machine: &SdofRig, acquired: &Acquired) -> EffectEntry {
    let number = |key: ParameterKey| entry.number(key).unwrap_or_default();
    let k = machine.stiffness_n_per_m;
    let bias = match entry.kind {
        EffectKind::ConstantForce if k > 0.0 => number(ParameterKey::ForceN) / k,
        _ => return entry,
    };
    let rest = if k > 0.0 { machine.gravity_n / k } else { 0.0 };
    let begun: Vec<&Track> = acquired.under_test().filter(|track| track.offset == 0).collect();
    let begins = begun.iter().filter(|track| {
        let first = &track.sensed[..track.len().min(3)];
        let mean = first.iter().sum::<f64>() / first.len() as f64;
        let at_nominal = mean.abs().min((mean - rest).abs());
        let at_bias = (mean - bias).abs().min((mean - rest - bias).abs());
        at_bias < at_nominal && at_bias < AT_REST * bias.abs()
    });
    if 2 * begins.count() > begun.len() {
        EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, bias)])
    } else {
        EffectEntry::new(EffectKind::ConstantForce, &[(ParameterKey::ForceN, bias * k)])
    }
}
