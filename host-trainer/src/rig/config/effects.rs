//! `[[effect]]` tables.

use std::collections::BTreeMap;

use crate::rig::effect::{self, Definition, ValueKind, Values};

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
    /// A name of the vocabulary that [`effect::REGISTRY`] has.
    pub name: String,
    /// Its parameters by name. Those that have a default may be left out.
    pub parameters: BTreeMap<String, Value>,
}

impl EffectEntry {
    /// An effect with these numbers; texts follow by [`EffectEntry::with_text`].
    pub fn new(name: &str, numbers: &[(&str, f64)]) -> Self {
        let parameters = numbers.iter().map(|(key, value)| (String::from(*key), Value::Number(*value)));
        Self { name: name.into(), parameters: parameters.collect() }
    }

    /// Sets a number.
    pub fn set_number(&mut self, key: &str, value: f64) {
        self.parameters.insert(key.into(), Value::Number(value));
    }

    /// The same with another number.
    #[must_use]
    pub fn with_number(mut self, key: &str, value: f64) -> Self {
        self.set_number(key, value);
        self
    }

    /// The same with another text.
    #[must_use]
    pub fn with_text(mut self, key: &str, value: &str) -> Self {
        self.parameters.insert(key.into(), Value::Text(value.into()));
        self
    }

    /// A number that it states; `None` where it is left at its default or is no number.
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.parameters.get(key)? {
            Value::Number(number) => Some(*number),
            Value::Text(_) => None,
        }
    }

    /// A text that it states; `None` where it is left at its default or is no text.
    pub fn text(&self, key: &str) -> Option<&str> {
        match self.parameters.get(key)? {
            Value::Number(_) => None,
            Value::Text(text) => Some(text),
        }
    }

    /// Whether all its numbers are plausible, as [`effect::Parameter::is_plausible`] has it.
    pub fn is_plausible(&self) -> bool {
        let parameters = self.definition().map_or(&[][..], |d| d.parameters);
        parameters.iter().all(|p| self.number(p.name).is_none_or(|value| p.is_plausible(value)))
    }

    /// Whether it is fixed to the shaft at an angle of its own.
    pub fn is_on_shaft(&self) -> bool {
        self.turned_on_shaft(0.0).is_some()
    }

    /// The same further round on the shaft; nothing of what is not fixed to it.
    pub fn turned_on_shaft(&self, by_rad: f64) -> Option<Self> {
        let number = |key: &str| self.number(key).unwrap_or_default();
        let (key, value) = match self.name.as_str() {
            "inner-race-defect" => ("angle_rad", number("angle_rad") + by_rad),
            "inner-race-waviness" => ("phase_rad", number("phase_rad") - number("lobes") * by_rad),
            _ => return None,
        };
        Some(self.clone().with_number(key, value))
    }

    /// The term that it adds to the equations of a rig of this kind, `bearing-5dof` or `sdof`, in that rig's symbols;
    /// empty where such a rig cannot have it.
    pub fn equation(&self, kind: &str) -> String {
        Values::new(self, kind).map_or_else(String::new, |values| (values.definition().equation)(&values))
    }

    /// The definition of its name.
    pub fn definition(&self) -> Option<&'static Definition> {
        effect::definition(&self.name)
    }

    /// What is wrong with it, for a rig of this kind: key, what was found, what was expected.
    pub(crate) fn fault(&self, kind: &str) -> Option<(String, Option<String>, String)> {
        let Some(definition) = self.definition() else {
            let names: Vec<_> = effect::REGISTRY.iter().map(|d| d.name).collect();
            return Some(("name".into(), Some(format!("{:?}", self.name)), format!("one of {}", names.join(", "))));
        };
        if !definition.applies_to.has(kind) {
            let expected = format!("an effect that a rig of kind {kind:?} can have");
            return Some(("name".into(), Some(format!("{:?}", self.name)), expected));
        }
        for parameter in definition.parameters {
            let expected = parameter.value_kind.describe(kind);
            match self.parameters.get(parameter.name) {
                None if parameter.default_for(kind).is_none() => return Some((parameter.name.into(), None, expected)),
                None => {}
                Some(value) => {
                    let good = match (value, parameter.value_kind) {
                        (Value::Number(number), ValueKind::Number(domain)) => domain.holds(*number),
                        (Value::Text(text), ValueKind::Name(choices)) => choices.names(kind).contains(&text.as_str()),
                        _ => false,
                    };
                    if !good {
                        return Some((parameter.name.into(), Some(value.shown()), expected));
                    }
                }
            }
        }
        let known = |key: &String| definition.parameters.iter().any(|p| p.name == key);
        let names: Vec<_> = definition.parameters.iter().map(|p| p.name).collect();
        let unknown = self.parameters.keys().find(|key| !known(key));
        unknown.map(|key| (key.clone(), Some("an unknown key".into()), format!("one of {}", names.join(", "))))
    }
}

impl Value {
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Number(number) => format!("{number:?}"),
            Self::Text(text) => format!("{text:?}"),
        }
    }
}
