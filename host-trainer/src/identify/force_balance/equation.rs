//! Columns of the equation of motion, and its known part: theory (62).

use super::{
    error::BalanceError,
    states::{States, Track},
};
use crate::rig::{
    Rig,
    assembly::Assembly,
    config::{Machine, ModelKey, Restoring, SdofRig},
    simulate::assemble,
    state::{DOFS, Instant, MASS},
};

/// A parameter of the rig as a column of the balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Mass m, column q̈.
    Mass,
    /// Damping c, column q̇.
    Damping,
    /// Stiffness k, column g(q).
    Stiffness,
    /// Input gain, column −u.
    Gain,
    /// Constant force G, column −1.
    Gravity,
}

impl Parameter {
    /// All parameters.
    pub const ALL: [Self; 5] = [Self::Mass, Self::Damping, Self::Stiffness, Self::Gain, Self::Gravity];

    /// Key in `rig.toml`.
    pub fn key(self) -> ModelKey {
        match self {
            Self::Mass => ModelKey::Mass,
            Self::Damping => ModelKey::Damping,
            Self::Stiffness => ModelKey::Stiffness,
            Self::Gain => ModelKey::InputGain,
            Self::Gravity => ModelKey::Gravity,
        }
    }

    /// Unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Mass => "kg",
            Self::Damping => "N s/m",
            Self::Stiffness => "N/m",
            Self::Gain => "N/unit",
            Self::Gravity => "N",
        }
    }

    /// Value of the parameter in a rig.
    pub fn value_in(self, rig: &SdofRig) -> f64 {
        match self {
            Self::Mass => rig.mass_kg,
            Self::Damping => rig.damping_n_s_per_m,
            Self::Stiffness => rig.stiffness_n_per_m,
            Self::Gain => rig.input_gain_n_per_unit,
            Self::Gravity => rig.gravity_n,
        }
    }
}

/// The five columns that the rig's own parameters multiply: Σ p_i X_i = 0 for a machine without effects.
#[derive(Clone, Debug)]
pub struct Equation {
    /// Columns in the order of [`Parameter::ALL`], each of [`States::rows`] rows.
    pub columns: [Vec<f64>; 5],
    /// Force of the effects that the rig already has, N.
    pub effects: Vec<f64>,
    /// The rig.
    pub rig: SdofRig,
}

impl Equation {
    /// The columns of a rig.
    ///
    /// # Errors
    ///
    /// A rig that is not of one degree of freedom.
    pub fn new(rig: &Rig, states: &States) -> Result<Self, BalanceError> {
        let assembly = assemble(rig);
        let rig = match &assembly.machine {
            Machine::Sdof(machine) => machine.clone(),
            model => return Err(BalanceError::NotSdof { found: model.kind().name() }),
        };
        let effects = states.column(|track| forces(&assembly, track, states.step_s()));
        let restoring = match rig.restoring {
            Restoring::Linear => states.position(),
            // Only the nonlinear part sin q − q is taken from smoothed states.
            Restoring::Pendulum => {
                let beyond = states.column(|track| track.position.iter().map(|q| q.sin() - q).collect());
                states.position().iter().zip(beyond).map(|(q, beyond)| q + beyond).collect()
            }
        };
        let negative = |column: Vec<f64>| column.into_iter().map(|x| -x).collect();
        let columns = [
            states.acceleration(),
            states.velocity(),
            restoring,
            negative(states.input()),
            states.column(|track| vec![-1.0; track.len()]),
        ];
        Ok(Self { columns, effects, rig })
    }

    /// A parameter's column.
    pub fn column(&self, parameter: Parameter) -> &[f64] {
        &self.columns[parameter as usize]
    }

    /// Target of the regression, N: gain · u + gravity − m q̈ − c q̇ − k g(q) plus effects, without the terms of `unknown`.
    pub fn target(&self, unknown: &[Parameter]) -> Vec<f64> {
        let mut target = self.effects.clone();
        for parameter in Parameter::ALL.into_iter().filter(|p| !unknown.contains(p)) {
            let value = parameter.value_in(&self.rig);
            target.iter_mut().zip(self.column(parameter)).for_each(|(y, x)| *y -= value * x);
        }
        target
    }
}

/// Force of an assembly's effects on the mass at each sample of a recording, N.
pub fn forces(assembly: &Assembly, track: &Track, step_s: f64) -> Vec<f64> {
    let (mut q, mut v) = ([0.0; DOFS], [0.0; DOFS]);
    let one = |k: usize| {
        let at = Instant { time_s: k as f64 * step_s, ..Instant::default() };
        (q[MASS], v[MASS]) = (track.position[k], track.velocity[k]);
        let mut sum = [0.0; DOFS];
        assembly.forces.iter().for_each(|force| force(&at, &q, &v, &mut sum));
        sum[MASS]
    };
    (0..track.len()).map(one).collect()
}

/// Machine of a rig of one degree of freedom.
///
/// # Errors
///
/// A rig of another kind.
pub fn machine(rig: &Rig) -> Result<&SdofRig, BalanceError> {
    match &rig.model {
        Machine::Sdof(machine) => Ok(machine),
        model => Err(BalanceError::NotSdof { found: model.kind().name() }),
    }
}

/// Parameters named by the rig's `unknown`.
pub fn unknown(rig: &Rig) -> Vec<Parameter> {
    let keys = rig.unknown_keys();
    Parameter::ALL.into_iter().filter(|p| keys.iter().any(|k| *k == p.key())).collect()
}
