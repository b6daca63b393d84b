//! Numbers of a rig by name.

use std::fmt;

use serde::{Serialize, Serializer};

use super::key::ModelKey;
use crate::rig::effect::ParameterKey;

/// Name of a number of a rig: of the machine, such as `outer.damping_n_s_per_m`, or of an effect, such as
/// `effect[1].depth_m`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RigKey {
    /// A number of the machine.
    Model(ModelKey),
    /// A parameter of an effect.
    Effect {
        /// Index of the effect, from 0; names count from 1.
        index: usize,
        /// The parameter.
        key: ParameterKey,
    },
}

impl RigKey {
    /// The key of this name.
    pub fn parse(name: &str) -> Option<Self> {
        let Some(rest) = name.strip_prefix("effect[") else { return ModelKey::parse(name).map(Self::Model) };
        let (number, parameter) = rest.split_once("].")?;
        let index = number.parse::<usize>().ok()?.checked_sub(1)?;
        Some(Self::Effect { index, key: ParameterKey::parse(parameter)? })
    }

    /// The name without the effect that it belongs to; its ending is its unit.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Model(key) => key.name(),
            Self::Effect { key, .. } => key.name(),
        }
    }
}

impl From<ModelKey> for RigKey {
    fn from(key: ModelKey) -> Self {
        Self::Model(key)
    }
}

impl fmt::Display for RigKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model(key) => f.pad(key.name()),
            Self::Effect { index, key } => f.pad(&format!("effect[{}].{key}", index + 1)),
        }
    }
}

impl Serialize for RigKey {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_names_are_read_as_they_are_written() {
        let effect = RigKey::Effect { index: 1, key: ParameterKey::DepthM };
        assert_eq!(effect.to_string(), "effect[2].depth_m");
        for key in ModelKey::ALL.iter().copied().map(RigKey::Model).chain([effect]) {
            assert_eq!(RigKey::parse(&key.to_string()), Some(key));
        }
        for wrong in ["effect[0].depth_m", "effect[1].depth", "outer", "effect[x].depth_m"] {
            assert_eq!(RigKey::parse(wrong), None, "{wrong}");
        }
    }
}
