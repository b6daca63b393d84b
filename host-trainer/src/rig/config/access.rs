//! Numbers of a rig by their dotted name.

use std::path::Path;

use super::{BearingRig, Domain, EffectEntry, Machine, Rig, Value};
use crate::rig::error::RigError;

/// What an error names where there is no file.
const NO_FILE: &str = "rig";

impl Rig {
    /// A rig without effects.
    pub fn new(model: Machine) -> Self {
        Self {
            model,
            unknown: Vec::new(),
            effects: Vec::new(),
            paths: Vec::new(),
            document: toml_edit::DocumentMut::new(),
        }
    }

    /// The same rig with one more effect.
    pub fn with_effect(mut self, effect: EffectEntry) -> Self {
        self.effects.push(effect);
        self
    }

    /// The machine of a bearing rig; `None` for a rig of another kind.
    pub fn bearing(&self) -> Option<&BearingRig> {
        match &self.model {
            Machine::Bearing(machine) => Some(machine),
            Machine::Sdof(_) => None,
        }
    }

    /// The effect that a dotted name such as `effect[2].depth_m` is a parameter of.
    pub fn effect_of(&self, key: &str) -> Option<&EffectEntry> {
        self.effects.get(effect_key(key)?.0)
    }

    /// Names of all numbers, effects' included.
    pub fn keys(&self) -> Vec<String> {
        let model = self.model.keys().iter().map(|key| key.name.to_owned());
        let effects = self.effects.iter().enumerate().flat_map(|(index, effect)| {
            let numbers = effect.parameters.iter().filter(|(_, value)| matches!(value, Value::Number(_)));
            numbers.map(move |(key, _)| format!("effect[{}].{key}", index + 1))
        });
        model.chain(effects).collect()
    }

    /// The number of this name.
    pub fn get(&self, key: &str) -> Option<f64> {
        if let Some((index, parameter)) = effect_key(key) {
            return self.effects.get(index)?.number(parameter);
        }
        match (&self.model, key) {
            (Machine::Bearing(rig), "bearing.balls") => Some(rig.bearing.balls as f64),
            // Fields are found in one place only, which gives them to be changed.
            (model, _) => model.clone().field(key).copied(),
        }
    }

    /// Sets the number of this name.
    ///
    /// # Errors
    ///
    /// A name that is none, or a number that it cannot be.
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), RigError> {
        let domain = self.domain(key).ok_or_else(|| RigError::UnknownKey {
            path: NO_FILE.into(),
            key: key.into(),
            expected: format!("one of {}", self.keys().join(", ")),
        })?;
        if !domain.holds(value) {
            return Err(RigError::BadValue {
                path: NO_FILE.into(),
                key: key.into(),
                found: format!("{value:?}"),
                expected: domain.describe(),
            });
        }
        if let Some((index, parameter)) = effect_key(key) {
            self.effects[index].set_number(parameter, value);
        } else {
            self.model.set_number(key, value);
        }
        Ok(())
    }

    /// What the number of this name may be; effects' parameters also where they are left at their default.
    pub fn domain(&self, key: &str) -> Option<Domain> {
        if let Some((index, parameter)) = effect_key(key) {
            let definition = self.effects.get(index)?.definition()?;
            return definition.parameters.iter().find(|p| p.name == parameter)?.value_kind.number();
        }
        self.model.keys().iter().find(|k| k.name == key).map(|k| k.domain)
    }

    /// The numbers that `unknown` names, sections spelled out.
    pub fn unknown_keys(&self) -> Vec<String> {
        let mut keys = Vec::new();
        for name in &self.unknown {
            for key in self.model.keys() {
                let in_section = key.name.split_once('.').is_some_and(|(section, _)| section == name);
                if (in_section || key.name == name) && !keys.iter().any(|k| k == key.name) {
                    keys.push(key.name.to_owned());
                }
            }
        }
        keys
    }

    /// Checks everything that [`Rig::read`] checks, for a rig made or changed in memory.
    ///
    /// # Errors
    ///
    /// The first impossible value.
    pub fn check(&self) -> Result<(), RigError> {
        self.check_as(Path::new(NO_FILE))
    }

    pub(super) fn check_as(&self, path: &Path) -> Result<(), RigError> {
        for key in self.model.keys() {
            let value = self.get(key.name).unwrap_or(f64::NAN);
            if !key.domain.holds(value) {
                return Err(RigError::BadValue {
                    path: path.into(),
                    key: key.name.into(),
                    found: format!("{value:?}"),
                    expected: key.domain.describe(),
                });
            }
        }
        if let Some(rig) = self.bearing() {
            let bearing = &rig.bearing;
            if bearing.ball_diameter_m >= bearing.pitch_diameter_m {
                return Err(RigError::BadValue {
                    path: path.into(),
                    key: "bearing.ball_diameter_m".into(),
                    found: format!("{:?}", bearing.ball_diameter_m),
                    expected: format!("a number below pitch_diameter_m, {:?}", bearing.pitch_diameter_m),
                });
            }
        }
        for (index, effect) in self.effects.iter().enumerate() {
            if let Some((key, found, expected)) = effect.fault(self.model.kind()) {
                let key = format!("effect[{}].{key}", index + 1);
                let path = path.into();
                return Err(match found {
                    None => RigError::MissingKey { path, key, expected },
                    Some(found) if found == "an unknown key" => RigError::UnknownKey { path, key, expected },
                    Some(found) => RigError::BadValue { path, key, found, expected },
                });
            }
        }
        Ok(())
    }
}

impl Machine {
    pub(super) fn set_number(&mut self, key: &str, value: f64) {
        match self {
            Self::Bearing(rig) if key == "bearing.balls" => rig.bearing.balls = value as usize,
            _ => {
                if let Some(field) = self.field(key) {
                    *field = value;
                }
            }
        }
    }
}

/// `effect[2].depth_m` as index 1 and `depth_m`.
fn effect_key(key: &str) -> Option<(usize, &str)> {
    let (number, parameter) = key.strip_prefix("effect[")?.split_once("].")?;
    Some((number.parse::<usize>().ok()?.checked_sub(1)?, parameter))
}
