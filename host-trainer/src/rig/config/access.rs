//! Numbers of a rig by their dotted name.

use std::path::Path;

use super::effects::UNKNOWN_KEY;
use super::{BearingRig, Domain, EffectEntry, Machine, ModelKey, Rig, RigKey, Value};
use crate::rig::error::RigError;

/// Name of the rig in errors without a file.
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

    /// The rig with one more effect.
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

    /// The effect that a number is a parameter of.
    pub fn effect_of(&self, key: RigKey) -> Option<&EffectEntry> {
        match key {
            RigKey::Model(_) => None,
            RigKey::Effect { index, .. } => self.effects.get(index),
        }
    }

    /// Names of all numbers, effects' included.
    pub fn keys(&self) -> Vec<RigKey> {
        let model = self.model.keys().iter().map(|key| RigKey::Model(*key));
        let effects = self.effects.iter().enumerate().flat_map(|(index, effect)| {
            let numbers = effect.parameters.iter().filter(|(_, value)| matches!(value, Value::Number(_)));
            numbers.map(move |(key, _)| RigKey::Effect { index, key: *key })
        });
        model.chain(effects).collect()
    }

    /// The number of this name; `None` where the rig has no such number, or leaves it at its default.
    pub fn get(&self, key: impl Into<RigKey>) -> Option<f64> {
        match (key.into(), &self.model) {
            (RigKey::Effect { index, key }, _) => self.effects.get(index)?.number(key),
            (RigKey::Model(ModelKey::Balls), Machine::Bearing(rig)) => Some(rig.bearing.balls as f64),
            // Fields are found in one place only, which gives them to be changed.
            (RigKey::Model(key), model) => model.clone().field(key).copied(),
        }
    }

    /// Sets the number of this name.
    ///
    /// # Errors
    ///
    /// A name that the rig has not, or a number that it cannot be.
    pub fn set(&mut self, key: impl Into<RigKey>, value: f64) -> Result<(), RigError> {
        let key = key.into();
        let domain = self.domain(key).ok_or_else(|| RigError::UnknownKey {
            path: NO_FILE.into(),
            key: key.to_string(),
            expected: format!("one of {}", self.keys().iter().map(RigKey::to_string).collect::<Vec<_>>().join(", ")),
        })?;
        if !domain.holds(value) {
            return Err(RigError::BadValue {
                path: NO_FILE.into(),
                key: key.to_string(),
                found: format!("{value:?}"),
                expected: domain.describe(),
            });
        }
        match key {
            RigKey::Effect { index, key } => self.effects[index].set_number(key, value),
            RigKey::Model(key) => self.model.set_number(key, value),
        }
        Ok(())
    }

    /// Domain of the number of this name; of effects' parameters also of those left at their default.
    pub fn domain(&self, key: RigKey) -> Option<Domain> {
        match key {
            RigKey::Model(key) => self.model.keys().contains(&key).then(|| key.domain()),
            RigKey::Effect { index, key } => self.effects.get(index)?.definition().parameter(key)?.value_kind.number(),
        }
    }

    /// The numbers that `unknown` names, sections spelled out.
    pub fn unknown_keys(&self) -> Vec<ModelKey> {
        let mut keys = Vec::new();
        for name in &self.unknown {
            for key in self.model.keys() {
                let in_section = key.name().split_once('.').is_some_and(|(section, _)| section == name);
                if (in_section || key.name() == name) && !keys.contains(key) {
                    keys.push(*key);
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
            let value = self.get(*key).unwrap_or(f64::NAN);
            if !key.domain().holds(value) {
                return Err(RigError::BadValue {
                    path: path.into(),
                    key: key.name().into(),
                    found: format!("{value:?}"),
                    expected: key.domain().describe(),
                });
            }
        }
        if let Some(rig) = self.bearing() {
            let bearing = &rig.bearing;
            if bearing.ball_diameter_m >= bearing.pitch_diameter_m {
                return Err(RigError::BadValue {
                    path: path.into(),
                    key: ModelKey::BallDiameter.to_string(),
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
                    Some(found) if found == UNKNOWN_KEY => RigError::UnknownKey { path, key, expected },
                    Some(found) => RigError::BadValue { path, key, found, expected },
                });
            }
        }
        Ok(())
    }
}

impl Machine {
    pub(super) fn set_number(&mut self, key: ModelKey, value: f64) {
        match (self, key) {
            (Self::Bearing(rig), ModelKey::Balls) => rig.bearing.balls = value as usize,
            (machine, key) => {
                if let Some(field) = machine.field(key) {
                    *field = value;
                }
            }
        }
    }
}
