//! Second stage: what the rig knows of itself. Which unknown parameters are fitted, and what anchors the balance.

use super::acquire::Acquired;
use super::causes::Cause;
use super::settings::SdofSettings;
use crate::identify::force_balance::{equation::Parameter, gram::cholesky_solve, predictor::Operator, states::Sensed};
use crate::rig::Rig;
use crate::rig::config::{Restoring, SdofRig};
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// Greatest relative error of a parameter that is stated as known.
fn tolerance(parameter: Parameter) -> f64 {
    match parameter {
        Parameter::Damping => SETTINGS.tolerance_of_damping,
        _ => SETTINGS.tolerance,
    }
}

/// The rig with its unknown parameters.
#[derive(Clone, Debug)]
pub struct Nominal {
    /// The machine; unknown parameters at their estimates.
    pub machine: SdofRig,
    /// The machine as it was stated.
    pub stated: SdofRig,
    /// Parameters that are fitted with every hypothesis.
    pub unknown: Vec<Parameter>,
    /// Known parameters that were fitted within what a statement is right by.
    pub adjusted: Vec<Parameter>,
    /// Sentences on parameters that are not determined.
    pub notes: Vec<String>,
}

impl Nominal {
    /// Decides which of the parameters named as unknown can be fitted, and estimates them roughly.
    pub fn new(machine: &SdofRig, unknown: Vec<Parameter>, acquired: &Acquired) -> Self {
        let mut nominal = Self {
            machine: machine.clone(),
            stated: machine.clone(),
            unknown,
            adjusted: Vec::new(),
            notes: Vec::new(),
        };
        // Damping that the file has none of is a cause, viscous friction.
        nominal.unknown.retain(|p| *p != Parameter::Damping || machine.damping_n_s_per_m != 0.0);
        if !acquired.driven {
            nominal.unknown.retain(|p| *p != Parameter::Gain);
        }
        nominal.anchor(acquired.driven);
        for parameter in nominal.estimate(acquired) {
            nominal.unknown.retain(|p| *p != parameter);
            nominal.notes.push(format!("{} does not show in these recordings; it keeps its value.", parameter.key()));
        }
        nominal
    }

    /// Fixes a parameter where all that the balance holds is unknown: it determines only their ratios.
    fn anchor(&mut self, driven: bool) {
        if self.anchors(driven).next().is_some() {
            return;
        }
        let fixed = if driven && self.unknown.contains(&Parameter::Gain) { Parameter::Gain } else { Parameter::Mass };
        if self.unknown.contains(&fixed) {
            self.unknown.retain(|p| *p != fixed);
            self.notes.push(format!(
                "Only ratios of the unknown parameters show in these recordings; {} keeps its value and so sets the scale.",
                fixed.key()
            ));
        }
    }

    /// Known parameters that fix the scale of the forces.
    pub fn anchors(&self, driven: bool) -> impl Iterator<Item = Parameter> {
        [Parameter::Mass, Parameter::Gain, Parameter::Stiffness, Parameter::Gravity].into_iter().filter(move |p| {
            let shows = *p != Parameter::Gain || driven;
            shows && p.value_in(&self.machine) != 0.0 && !self.unknown.contains(p)
        })
    }

    /// Whether the mass is too small to show: its velocity follows the force within half a sample. The position is then the
    /// integral of the force, which dry friction stops; only predictions from one sample to the next mean anything.
    pub fn is_overdamped(&self, acquired: &Acquired) -> bool {
        let step = acquired.tracks.iter().map(super::acquire::Track::step_s).fold(f64::INFINITY, f64::min);
        self.machine.mass_kg < 0.5 * step * self.machine.damping_n_s_per_m
    }

    /// Linear part of the rig.
    pub fn operator(&self, sensed: Sensed) -> Operator {
        Operator {
            mass: self.machine.mass_kg,
            damping: self.machine.damping_n_s_per_m,
            stiffness: self.machine.stiffness_n_per_m,
            accelerometer: sensed == Sensed::Acceleration,
        }
    }

    /// g(q) of the restoring force.
    pub fn restoring(&self, q: f64) -> f64 {
        match self.machine.restoring {
            Restoring::Linear => q,
            Restoring::Pendulum => q.sin(),
        }
    }

    /// Force that a unit of a parameter adds to the right-hand side, from the states; the input's is its own.
    pub fn unit_force(&self, parameter: Parameter, q: f64, v: f64, a: f64) -> f64 {
        match parameter {
            Parameter::Mass => -a,
            Parameter::Damping => -v,
            Parameter::Stiffness => -self.restoring(q),
            Parameter::Gain => 0.0,
            Parameter::Gravity => 1.0,
        }
    }

    /// Force that the rig without its input lacks at a state, N.
    pub fn balance(&self, q: f64, v: f64, a: f64) -> f64 {
        use Parameter::{Damping, Gravity, Mass, Stiffness};
        let of = |parameter: Parameter| parameter.value_in(&self.machine) * self.unit_force(parameter, q, v, a);
        -[Mass, Damping, Stiffness, Gravity].map(of).iter().sum::<f64>()
    }

    /// Changes a parameter by an estimate of its difference, within its domain.
    pub fn add(&mut self, parameter: Parameter, change: f64) {
        let value = parameter.value_in(&self.machine) + change;
        let field = match parameter {
            Parameter::Mass => &mut self.machine.mass_kg,
            Parameter::Damping => &mut self.machine.damping_n_s_per_m,
            Parameter::Stiffness => &mut self.machine.stiffness_n_per_m,
            Parameter::Gain => &mut self.machine.input_gain_n_per_unit,
            Parameter::Gravity => &mut self.machine.gravity_n,
        };
        match parameter {
            Parameter::Mass if value > 0.0 => *field = value,
            Parameter::Mass => {}
            Parameter::Damping | Parameter::Stiffness => *field = value.max(0.0),
            Parameter::Gain | Parameter::Gravity => *field = value,
        }
    }

    /// Parameters whose values are not those of the rig as it was given.
    pub fn fitted(&self) -> impl Iterator<Item = Parameter> {
        self.unknown.iter().chain(&self.adjusted).copied()
    }

    /// A rig with the fitted parameters.
    pub fn rig(&self, given: &Rig) -> Rig {
        let mut rig = given.clone();
        for parameter in self.fitted() {
            // A value outside the parameter's domain leaves the one that was given.
            let _ = rig.set(parameter.key(), parameter.value_in(&self.machine));
        }
        rig
    }

    /// Takes the chosen changes that are within what a statement of a parameter is right by into the rig: they are no causes.
    /// Returns whether there were any.
    pub fn adjust(&mut self, causes: &[Cause]) -> bool {
        let before = self.machine.clone();
        for cause in causes {
            let Some(fitted) = cause.entry.number(ParameterKey::Value) else { continue };
            let (parameter, fitted) = match cause.entry.kind {
                EffectKind::MassChange => (Parameter::Mass, fitted),
                EffectKind::StiffnessChange => (Parameter::Stiffness, fitted),
                EffectKind::DampingChange => (Parameter::Damping, fitted),
                // What scales all that a linear machine does.
                EffectKind::SensorGain => (Parameter::Gain, fitted * before.input_gain_n_per_unit),
                _ => continue,
            };
            let factor = fitted / parameter.value_in(&self.stated);
            if (factor - 1.0).abs() <= tolerance(parameter) {
                self.add(parameter, fitted - parameter.value_in(&before));
                if !self.adjusted.contains(&parameter) {
                    self.adjusted.push(parameter);
                }
            }
        }
        self.machine != before
    }

    /// Sentences on the known parameters that were adjusted.
    pub fn adjustments(&self) -> impl Iterator<Item = String> {
        self.adjusted.iter().map(|parameter| {
            format!(
                "{} fits at {:.2} % of its stated value, within the {:.0} % that a statement is right by: no cause.",
                parameter.key(),
                100.0 * parameter.value_in(&self.machine) / parameter.value_in(&self.stated),
                100.0 * tolerance(*parameter)
            )
        })
    }

    /// Least squares of the force balance on the smoothed states; returns parameters that do not show.
    fn estimate(&mut self, acquired: &Acquired) -> Vec<Parameter> {
        let mut hidden = Vec::new();
        let mut free: Vec<Parameter> = Vec::new();
        let rows = |parameter: Parameter| -> Vec<f64> {
            let of = |track: &super::acquire::Track| {
                if parameter == Parameter::Gain {
                    track.grid_input(acquired.interpolation)
                } else {
                    track.signal(|q, v, a| self.unit_force(parameter, q, v, a))
                }
            };
            acquired.tracks.iter().flat_map(of).collect()
        };
        let known: Vec<(Parameter, Vec<f64>)> = Parameter::ALL.into_iter().map(|p| (p, rows(p))).collect();
        let column = |p: Parameter| &known[p as usize].1;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        // A parameter whose column depends on those before it is left out; the mass comes first, the gain last.
        for parameter in self.unknown.clone() {
            free.push(parameter);
            let mut normal: Vec<Vec<f64>> =
                (0..free.len()).map(|i| (0..=i).map(|j| dot(column(free[i]), column(free[j]))).collect()).collect();
            if cholesky_solve(&mut normal, &vec![0.0; free.len()], 0.0).is_none() {
                free.pop();
                hidden.push(parameter);
            }
        }
        let mut target = vec![0.0; known[0].1.len()];
        for (parameter, column) in known.iter().filter(|(p, _)| !free.contains(p)) {
            let value = parameter.value_in(&self.machine);
            target.iter_mut().zip(column).for_each(|(y, x)| *y -= value * x);
        }
        let mut normal: Vec<Vec<f64>> =
            (0..free.len()).map(|i| (0..=i).map(|j| dot(column(free[i]), column(free[j]))).collect()).collect();
        let right: Vec<f64> = free.iter().map(|p| dot(column(*p), &target)).collect();
        if let Some(values) = cholesky_solve(&mut normal, &right, 0.0) {
            for (parameter, value) in free.iter().zip(values) {
                let change = value - parameter.value_in(&self.machine);
                self.add(*parameter, change);
            }
        }
        hidden
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::force_balance::{equation, testing};
    use crate::rig::EffectEntry;

    /// Rounds of adjustments add up to no more than the tolerance of what was stated, with one sentence.
    #[test]
    fn tolerance_counts_from_what_was_stated() {
        let rig = testing::rig(testing::LINEAR);
        let acquired = Acquired::new(&testing::recordings(&rig, "q", 1.0, 0.01, 1000, 1), &[]).unwrap();
        let mut nominal = Nominal::new(equation::machine(&rig).unwrap(), Vec::new(), &acquired);
        let stiffness = |value: f64| {
            let entry = EffectEntry::new(EffectKind::StiffnessChange, &[(ParameterKey::Value, value)]);
            [Cause { entry, free: Vec::new(), term: 0 }]
        };
        assert!(nominal.adjust(&stiffness(806.0)) && !nominal.adjust(&stiffness(812.0)));
        assert!(nominal.adjust(&stiffness(804.0)));
        assert_eq!(nominal.machine.stiffness_n_per_m, 804.0);
        let notes: Vec<String> = nominal.adjustments().collect();
        assert!(notes.len() == 1 && notes[0].starts_with("stiffness_n_per_m fits at 100.50 %"), "{notes:?}");
    }
}
