//! `[[effect]]` tables.

use std::collections::BTreeMap;

use super::RigKind;
use crate::rig::effect::{Definition, EffectKind, ParameterKey, ValueKind, Values};

/// A parameter of an effect.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number in SI units.
    Number(f64),
    /// A name, of a component or a channel.
    Text(String),
}

/// An effect added to a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectEntry {
    /// Kind of the effect.
    pub kind: EffectKind,
    /// Parameters; those that have a default may be left out.
    pub parameters: BTreeMap<ParameterKey, Value>,
}

impl EffectEntry {
    /// An effect with these numbers; texts follow by [`EffectEntry::with_text`].
    pub fn new(kind: EffectKind, numbers: &[(ParameterKey, f64)]) -> Self {
        let parameters = numbers.iter().map(|(key, value)| (*key, Value::Number(*value)));
        Self { kind, parameters: parameters.collect() }
    }

    /// Sets a number.
    pub fn set_number(&mut self, key: ParameterKey, value: f64) {
        self.parameters.insert(key, Value::Number(value));
    }

    /// The entry with another number.
    #[must_use]
    pub fn with_number(mut self, key: ParameterKey, value: f64) -> Self {
        self.set_number(key, value);
        self
    }

    /// The entry with another text.
    #[must_use]
    pub fn with_text(mut self, key: ParameterKey, value: &str) -> Self {
        self.parameters.insert(key, Value::Text(value.into()));
        self
    }

    /// A number that it states; `None` where it is left at its default or is no number.
    pub fn number(&self, key: ParameterKey) -> Option<f64> {
        match self.parameters.get(&key)? {
            Value::Number(number) => Some(*number),
            Value::Text(_) => None,
        }
    }

    /// A text that it states; `None` where it is left at its default or is no text.
    pub fn text(&self, key: ParameterKey) -> Option<&str> {
        match self.parameters.get(&key)? {
            Value::Number(_) => None,
            Value::Text(text) => Some(text),
        }
    }

    /// Whether the effect is fixed to the shaft at an angle of its own.
    pub fn is_on_shaft(&self) -> bool {
        self.turned_on_shaft(0.0).is_some()
    }

    /// The effect turned on the shaft; `None` if it is not fixed to the shaft.
    pub fn turned_on_shaft(&self, by_rad: f64) -> Option<Self> {
        let number = |key: ParameterKey| self.number(key).unwrap_or_default();
        let (key, value) = match self.kind {
            EffectKind::InnerRaceDefect => (ParameterKey::AngleRad, number(ParameterKey::AngleRad) + by_rad),
            EffectKind::InnerRaceWaviness => {
                (ParameterKey::PhaseRad, number(ParameterKey::PhaseRad) - number(ParameterKey::Lobes) * by_rad)
            }
            _ => return None,
        };
        Some(self.clone().with_number(key, value))
    }

    /// Equation of the term that the effect adds to a rig of this kind, in that rig's symbols; empty where such a rig
    /// cannot have the effect.
    pub fn equation(&self, kind: RigKind) -> String {
        Values::new(self, kind).map_or_else(String::new, |values| values.equation())
    }

    /// Definition of the effect.
    pub fn definition(&self) -> &'static Definition {
        self.kind.definition()
    }

    /// First fault of the entry for a rig of this kind: key, what was found, what was expected.
    pub(crate) fn fault(&self, kind: RigKind) -> Option<(&'static str, Option<String>, String)> {
        let definition = self.definition();
        if !definition.rigs.include(kind) {
            let expected = format!("an effect that a rig of kind \"{kind}\" can have");
            return Some(("name", Some(format!("\"{}\"", self.kind)), expected));
        }
        for parameter in definition.parameters {
            let key = parameter.key.name();
            let expected = parameter.value_kind.describe(kind);
            match self.parameters.get(&parameter.key) {
                None if parameter.default_for(kind).is_none() => return Some((key, None, expected)),
                None => {}
                Some(value) => {
                    let good = match (value, parameter.value_kind) {
                        (Value::Number(number), ValueKind::Number(domain)) => domain.holds(*number),
                        (Value::Text(text), ValueKind::Name(choices)) => choices.names(kind).contains(&text.as_str()),
                        _ => false,
                    };
                    if !good {
                        return Some((key, Some(value.shown()), expected));
                    }
                }
            }
        }
        let unknown = self.parameters.keys().find(|key| definition.parameter(**key).is_none());
        unknown.map(|key| (key.name(), Some(UNKNOWN_KEY.into()), parameter_names(definition)))
    }
}

/// Found by [`EffectEntry::fault`] where a parameter is not one of the effect's.
pub(super) const UNKNOWN_KEY: &str = "an unknown key";

/// Names of an effect's parameters, for messages.
pub(super) fn parameter_names(definition: &Definition) -> String {
    let names: Vec<_> = definition.parameters.iter().map(|p| p.key.name()).collect();
    format!("one of {}", names.join(", "))
}

impl Value {
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Number(number) => format!("{number:?}"),
            Self::Text(text) => format!("{text:?}"),
        }
    }
}
