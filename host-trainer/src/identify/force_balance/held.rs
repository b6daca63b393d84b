//! Choice of the input's course between its samples.

use super::{
    equation::{Equation, Parameter, machine},
    error::BalanceError,
    regression,
    settings::BalanceSettings,
    shooting,
    states::{Between, Sensed, States},
};
use crate::rig::Rig;
use crate::rig::config::RigKey;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

impl States {
    /// Sets [`States::between`] by the least residual: of the balance with all parameters and the commonest nonlinear terms
    /// free, or for accelerations, in which a held input shows at once either way, of the simulation.
    ///
    /// # Errors
    ///
    /// A rig of another kind.
    pub fn learn_hold(&mut self, rig: &Rig) -> Result<(), BalanceError> {
        let machine = machine(rig)?;
        self.input_per_mass = machine.input_gain_n_per_unit / machine.mass_kg;
        let mut best = (Between::Held, f64::INFINITY);
        for between in [Between::Held, Between::Straight, Between::Smooth] {
            self.between = between;
            let left = match (self.sensed, between) {
                (Sensed::Position, _) => self.left_of_balance(rig)?,
                (Sensed::Acceleration, Between::Smooth) => continue,
                (Sensed::Acceleration, _) => self.left_of_simulation(rig),
            };
            if left < SETTINGS.hold_error_ratio * best.1 {
                best = (between, left);
            }
        }
        self.between = best.0;
        if self.sensed == Sensed::Acceleration {
            self.prepare();
        }
        Ok(())
    }

    fn left_of_simulation(&self, rig: &Rig) -> f64 {
        let free = [Parameter::Mass, Parameter::Damping, Parameter::Stiffness];
        let keys: Vec<RigKey> = free.iter().map(|p| p.key().into()).collect();
        let observed = self.observed();
        let spans = observed.spans(Some(self.short_window()));
        shooting::refine(rig, &keys, &observed, &spans).map_or(f64::MAX, |refined| refined.rms)
    }

    fn left_of_balance(&self, rig: &Rig) -> Result<f64, BalanceError> {
        let equation = Equation::new(rig, self)?;
        let (largest_q, largest_v) = self.amplitudes();
        let term = |of: fn(f64, f64) -> f64| {
            self.column(|t| {
                let states = t.position.iter().zip(&t.velocity);
                states.map(|(q, v)| of(q / largest_q.max(1e-300), v / largest_v.max(1e-300))).collect()
            })
        };
        let own = [Parameter::Mass, Parameter::Damping, Parameter::Stiffness, Parameter::Gravity];
        let mut columns: Vec<Vec<f64>> = own.iter().map(|p| equation.column(*p).to_vec()).collect();
        columns.extend([term(|q, _| q), term(|q, _| q * q), term(|q, _| q * q * q)]);
        columns.extend([term(|_, v| v * v.abs()), term(|_, v| (100.0 * v).tanh())]);
        let target: Vec<f64> = equation.column(Parameter::Gain).iter().map(|x| -x).collect();
        // A column that depends on earlier ones is left out.
        let mut kept: Vec<Vec<f64>> = Vec::new();
        for column in columns {
            kept.push(column);
            if !regression::undetermined(&kept).is_empty() {
                kept.pop();
            }
        }
        let groups: Vec<usize> = self.tracks.iter().map(|t| t.rows.len()).collect();
        let fit = regression::least_squares(&kept, &target, &groups, 1);
        Ok(fit.map_or(f64::MAX, |fit| regression::norm(&fit.residual)))
    }
}
