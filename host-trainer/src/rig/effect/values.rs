//! An effect's parameters with defaults filled in.

use super::{DefaultValue, Definition, component::Component};
use crate::rig::config::{EffectEntry, Value};

/// Parameters of one effect of a rig that has been checked.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    entry: &'a EffectEntry,
    definition: &'static Definition,
    kind: &'a str,
}

impl<'a> Values<'a> {
    /// Those of an entry, for a rig of this kind; `None` where the entry does not fit
    /// (which [`Rig::check`](crate::rig::Rig::check) explains).
    pub fn new(entry: &'a EffectEntry, kind: &'a str) -> Option<Self> {
        let definition = entry.definition().filter(|_| entry.fault(kind).is_none())?;
        Some(Self { entry, definition, kind })
    }

    /// The effect's definition.
    pub fn definition(&self) -> &'static Definition {
        self.definition
    }

    /// The kind of rig.
    pub fn kind(&self) -> &str {
        self.kind
    }

    /// A number. A name that the effect does not have is NaN.
    pub fn number(&self, name: &str) -> f64 {
        match (self.entry.parameters.get(name), self.default(name)) {
            (Some(Value::Number(number)), _) => *number,
            (None, Some(DefaultValue::Number(number))) => number,
            _ => f64::NAN,
        }
    }

    /// The component.
    pub fn component(&self) -> Component {
        self.name("component").and_then(Component::parse).unwrap_or(Component::Mass)
    }

    /// Which channels an effect of the sensor is in.
    pub fn channels(&self) -> impl Fn(&str) -> bool + Send + Sync + 'static {
        let name = self.name("channel").unwrap_or("all").to_owned();
        move |channel| name == "all" || name == channel
    }

    fn name(&self, parameter: &str) -> Option<&str> {
        match (self.entry.parameters.get(parameter), self.default(parameter)) {
            (Some(Value::Text(text)), _) => Some(text),
            (None, Some(DefaultValue::Name(name))) => Some(name),
            _ => None,
        }
    }

    fn default(&self, name: &str) -> Option<DefaultValue> {
        self.definition.parameters.iter().find(|p| p.name == name)?.default_for(self.kind)
    }
}
