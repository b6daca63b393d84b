//! An effect's parameters with defaults filled in.

use super::{
    DefaultValue, Definition, ParameterKey, component::Component, course::Course, structural_resonance::Source,
};
use crate::rig::config::{EffectEntry, RigKind, Value};

/// Parameters of one effect of a rig that has been checked.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    entry: &'a EffectEntry,
    definition: &'static Definition,
    kind: RigKind,
}

impl<'a> Values<'a> {
    /// Parameters of an entry, for a rig of this kind; `None` if the entry is at fault
    /// (which [`Rig::check`](crate::rig::Rig::check) explains).
    pub fn new(entry: &'a EffectEntry, kind: RigKind) -> Option<Self> {
        entry.fault(kind).is_none().then(|| Self { entry, definition: entry.definition(), kind })
    }

    /// The effect's definition.
    pub fn definition(&self) -> &'static Definition {
        self.definition
    }

    /// The term that the effect adds to the rig's equations, with its numbers; what is added negative is subtracted.
    pub fn equation(&self) -> String {
        (self.definition.equation)(self).replace("+ -", "− ")
    }

    /// The kind of rig.
    pub fn kind(&self) -> RigKind {
        self.kind
    }

    /// A number. A name that the effect does not have is NaN.
    pub fn number(&self, key: ParameterKey) -> f64 {
        match (self.entry.parameters.get(&key), self.default(key)) {
            (Some(Value::Number(number)), _) => *number,
            (None, Some(DefaultValue::Number(number))) => number,
            _ => f64::NAN,
        }
    }

    /// The component.
    pub fn component(&self) -> Component {
        self.name(ParameterKey::Component).and_then(Component::parse).unwrap_or(Component::Mass)
    }

    /// Test whether an effect of the acquisition is in a channel.
    pub fn channels(&self) -> impl Fn(&str) -> bool + Send + Sync + 'static {
        let name = self.name(ParameterKey::Channel).unwrap_or("all").to_owned();
        move |channel| name == "all" || name == channel
    }

    /// What excites a mode of the structure.
    pub fn source(&self) -> Source {
        match self.name(ParameterKey::Source) {
            Some("across") => Source::Across,
            Some("motion") => Source::Motion,
            _ => Source::Along,
        }
    }

    /// The course of a change.
    pub fn course(&self) -> Course {
        self.name(ParameterKey::Shape).and_then(Course::parse).unwrap_or_default()
    }

    /// Whether a law is the same in every direction.
    pub fn is_isotropic(&self) -> bool {
        self.name(ParameterKey::Symmetry) == Some("isotropic")
    }

    fn name(&self, key: ParameterKey) -> Option<&str> {
        match (self.entry.parameters.get(&key), self.default(key)) {
            (Some(Value::Text(text)), _) => Some(text),
            (None, Some(DefaultValue::Name(name))) => Some(name),
            _ => None,
        }
    }

    fn default(&self, key: ParameterKey) -> Option<DefaultValue> {
        self.definition.parameter(key)?.default_for(self.kind)
    }
}
