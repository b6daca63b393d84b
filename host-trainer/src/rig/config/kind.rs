//! Kinds of rig.

use std::fmt;

/// Kind of a rig, as `kind` of `rig.toml` has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RigKind {
    /// Bearing with five degrees of freedom.
    Bearing5Dof,
    /// One degree of freedom, driven by a recorded input.
    Sdof,
}

impl RigKind {
    /// All kinds, the default first.
    pub const ALL: [Self; 2] = [Self::Bearing5Dof, Self::Sdof];

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bearing5Dof => "bearing-5dof",
            Self::Sdof => "sdof",
        }
    }

    /// The kind of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for RigKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
