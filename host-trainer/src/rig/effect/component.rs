//! Parts of a rig that a `component` parameter names.

use super::course::Course;
use crate::rig::assembly::Assembly;
use crate::rig::state::{DOFS, INNER_X, INNER_Y, MASS, OUTER_X, OUTER_Y, RESONATOR_Y, VelocityCovariance};

use crate::rig::config::{Machine, RigKind};

/// A part of a rig. `inner` and `outer` are the sections of that name and move in x and y; with `-x` or `-y` only
/// that direction is meant. The resonator's spring and damper sit between it and the outer race.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// The contact of balls and races.
    Bearing,
    /// Inner race and shaft.
    Inner,
    /// Horizontal motion of the inner race.
    InnerX,
    /// Vertical motion of the inner race.
    InnerY,
    /// Outer race and housing.
    Outer,
    /// Horizontal motion of the outer race.
    OuterX,
    /// Vertical motion of the outer race.
    OuterY,
    /// The resonator.
    Resonator,
    /// The mass of an sdof rig.
    Mass,
}

/// The components that an effect can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choices {
    /// Components on a support, or one direction of them.
    Supported,
    /// Sections with a mass, a stiffness and a damping.
    Sections,
    /// Components on a support, or one direction of them, and the contact.
    SupportedAndContact,
    /// Channels of the recording.
    Channels,
    /// What excites a mode of the structure: the bearing's force along the sensor or across it, or the sensor's own
    /// motion.
    Sources,
    /// Course of a change over its duration: straight, or smooth without corners.
    Shapes,
    /// Symmetry of a law over the directions of a component: along each axis by itself, or the same in every direction.
    Symmetries,
}

impl Choices {
    /// The names, for a rig of this kind.
    pub fn names(self, kind: RigKind) -> &'static [&'static str] {
        match self {
            Self::Channels if kind == RigKind::Sdof => &["all", "q", "qd", "qdd"],
            Self::Channels => &["all", "ax", "ay"],
            Self::Shapes => &Course::NAMES,
            Self::Symmetries if kind == RigKind::Sdof => &["axes"],
            Self::Symmetries => &["axes", "isotropic"],
            Self::Sources if kind == RigKind::Sdof => &["along"],
            Self::Sources => &["along", "across", "motion"],
            _ if kind == RigKind::Sdof => &["mass"],
            Self::Supported => &["outer", "inner", "resonator", "outer-x", "outer-y", "inner-x", "inner-y"],
            Self::SupportedAndContact => {
                &["outer", "inner", "resonator", "outer-x", "outer-y", "inner-x", "inner-y", "bearing"]
            }
            Self::Sections => &["outer", "inner", "resonator"],
        }
    }
}

/// Motion of a component, relative to the base of its spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motion {
    /// The degree of freedom.
    pub dof: usize,
    /// The one it is relative to, unless to the ground.
    pub base: Option<usize>,
}

impl Motion {
    /// q of the part less q of its base.
    pub fn relative(self, q: &[f64; DOFS]) -> f64 {
        q[self.dof] - self.base.map_or(0.0, |base| q[base])
    }

    /// Covariance of its velocity and another's.
    pub fn covariance(self, other: Self, VelocityCovariance(covariance): &VelocityCovariance) -> f64 {
        let with = |dof: usize| covariance[dof][other.dof] - other.base.map_or(0.0, |base| covariance[dof][base]);
        with(self.dof) - self.base.map_or(0.0, with)
    }

    /// Standard deviation of its velocity.
    fn velocity_std(self, covariance: &VelocityCovariance) -> f64 {
        self.covariance(self, covariance).max(0.0).sqrt()
    }

    /// A force on the part, and its reaction.
    pub fn push(self, value: f64, force: &mut [f64; DOFS]) {
        force[self.dof] += value;
        if let Some(base) = self.base {
            force[base] -= value;
        }
    }
}

/// A component of a certain machine.
#[derive(Clone, Debug)]
pub struct Part {
    /// Motions of the component.
    pub motions: Vec<Motion>,
    /// m, kg.
    pub mass: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub damping: f64,
}

impl Component {
    const ALL: [Self; 9] = [
        Self::Bearing,
        Self::Inner,
        Self::InnerX,
        Self::InnerY,
        Self::Outer,
        Self::OuterX,
        Self::OuterY,
        Self::Resonator,
        Self::Mass,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bearing => "bearing",
            Self::Inner => "inner",
            Self::InnerX => "inner-x",
            Self::InnerY => "inner-y",
            Self::Outer => "outer",
            Self::OuterX => "outer-x",
            Self::OuterY => "outer-y",
            Self::Resonator => "resonator",
            Self::Mass => "mass",
        }
    }

    /// The component of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|component| component.name() == name)
    }

    /// The symbols of its displacement, such as `x_p, y_p`.
    pub fn symbols(self) -> &'static str {
        match self {
            Self::Bearing => "δ_j",
            Self::Inner => "x_s, y_s",
            Self::InnerX => "x_s",
            Self::InnerY => "y_s",
            Self::Outer => "x_p, y_p",
            Self::OuterX => "x_p",
            Self::OuterY => "y_p",
            Self::Resonator => "y_b − y_p",
            Self::Mass => "q",
        }
    }

    /// The same race in the other direction.
    pub fn across(self) -> Option<Self> {
        match self {
            Self::InnerX => Some(Self::InnerY),
            Self::InnerY => Some(Self::InnerX),
            Self::OuterX => Some(Self::OuterY),
            Self::OuterY => Some(Self::OuterX),
            Self::Bearing | Self::Inner | Self::Outer | Self::Resonator | Self::Mass => None,
        }
    }

    /// The component in a machine. Where the machine has no such part it moves nowhere.
    pub fn part_of(self, machine: &Machine) -> Part {
        let ground = |dofs: &[usize]| dofs.iter().map(|&dof| Motion { dof, base: None }).collect();
        let nothing = Part { motions: Vec::new(), mass: 1.0, stiffness: 0.0, damping: 0.0 };
        let rig = match machine {
            Machine::Sdof(rig) => {
                return Part {
                    motions: ground(&[MASS]),
                    mass: rig.mass_kg,
                    stiffness: rig.stiffness_n_per_m,
                    damping: rig.damping_n_s_per_m,
                };
            }
            Machine::Bearing(rig) => rig,
        };
        let (section, motions) = match self {
            Self::Inner => (&rig.inner, ground(&[INNER_X, INNER_Y])),
            Self::InnerX => (&rig.inner, ground(&[INNER_X])),
            Self::InnerY => (&rig.inner, ground(&[INNER_Y])),
            Self::Outer => (&rig.outer, ground(&[OUTER_X, OUTER_Y])),
            Self::OuterX => (&rig.outer, ground(&[OUTER_X])),
            Self::OuterY => (&rig.outer, ground(&[OUTER_Y])),
            Self::Resonator => (&rig.resonator, vec![Motion { dof: RESONATOR_Y, base: Some(OUTER_Y) }]),
            Self::Bearing | Self::Mass => return nothing,
        };
        let (mass, stiffness, damping) = (section.mass_kg, section.stiffness_n_per_m, section.damping_n_s_per_m);
        Part { motions, mass, stiffness, damping }
    }

    /// The section of a bearing rig's file that it belongs to.
    pub fn section(self) -> &'static str {
        match self {
            Self::Inner | Self::InnerX | Self::InnerY => "inner",
            Self::Outer | Self::OuterX | Self::OuterY => "outer",
            Self::Resonator => "resonator",
            Self::Bearing => "bearing",
            Self::Mass => "",
        }
    }
}

impl Part {
    /// Adds a force law f(q, v) to each of its motions, q and v relative to the base.
    pub fn law(self, assembly: &mut Assembly, law: impl Fn(f64, f64) -> f64 + Send + Sync + 'static) {
        assembly.force(move |_, q, v, force| {
            for motion in &self.motions {
                motion.push(law(motion.relative(q), motion.relative(v)), force);
            }
        });
    }

    /// Adds a force along the displacement of all its motions together, `factor` of the square of its length times it.
    pub fn isotropic_law(self, assembly: &mut Assembly, factor: impl Fn(f64) -> f64 + Send + Sync + 'static) {
        assembly.force(move |_, q, _, force| {
            let square = self.motions.iter().map(|m| m.relative(q).powi(2)).sum::<f64>();
            self.motions.iter().for_each(|m| m.push(factor(square) * m.relative(q), force));
        });
    }

    /// Adds a force law f(v) to each of its motions, whose slope changes so fast with v that it is another where noise scatters
    /// the velocity: `mean`, at a standard deviation, is the mean of f over a normal distribution about v, and `steepest` its
    /// greatest slope, N s/m, or 0 where that is no faster than the rig.
    pub fn speed_law<M: Fn(f64) -> f64 + Send + Sync + 'static>(
        self,
        assembly: &mut Assembly,
        law: impl Fn(f64) -> f64 + Send + Sync + 'static,
        mean: impl Fn(f64) -> M,
        steepest: impl Fn(f64) -> f64,
    ) {
        assembly.depends_on_velocity_noise = true;
        let mass = self.mass;
        let Some(scatter) = &assembly.velocity_covariance else {
            assembly.declare_rate(steepest(0.0) / mass);
            return self.law(assembly, move |_, v| law(v));
        };
        let scatter: Vec<(Motion, f64)> = self.motions.iter().map(|m| (*m, m.velocity_std(scatter))).collect();
        scatter.iter().for_each(|(_, scatter)| assembly.declare_rate(steepest(*scatter) / mass));
        let laws: Vec<(Motion, M)> = scatter.into_iter().map(|(m, scatter)| (m, mean(scatter))).collect();
        assembly.force(move |_, _, v, force| {
            laws.iter().for_each(|(motion, law)| motion.push(law(motion.relative(v)), force))
        });
    }
}
