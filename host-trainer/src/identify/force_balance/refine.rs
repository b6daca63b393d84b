//! Parameters of a rig with its effects by the force balance: Gauss–Newton on the residual of the whole rig, so that
//! parameters inside a term are fitted with its strength and get intervals too.

use super::{
    equation::Equation,
    gram::cholesky_solve,
    regression::{self, Fit},
    settings::BalanceSettings,
    states::States,
};
use crate::rig::Rig;
use crate::rig::config::RigKey;
use crate::stats::optimise::{Damped, Decrease, GeometricDamping, damped_search};

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Fits the numbers named by `keys`, from the rig's values on, and sets them in the rig. `None` if they are not determined.
pub fn refine(rig: &mut Rig, keys: &[RigKey], states: &States) -> Option<Fit> {
    let groups: Vec<usize> = states.tracks.iter().map(|t| t.rows.len()).collect();
    let valid: Vec<bool> = states.tracks.iter().flat_map(|t| t.valid.iter().copied()).collect();
    let mut balance = Balance { rig: rig.clone(), keys, states, valid, left: Vec::new(), slopes: Vec::new(), steps: 0 };
    balance.left = balance.residual(rig)?;
    balance.slopes = balance.linearise()?;
    let mut damping = GeometricDamping {
        value: SETTINGS.refinement_initial_damping,
        fall: SETTINGS.damping_fall,
        growth: SETTINGS.refinement_damping_growth,
        floor: SETTINGS.damping_floor,
        singular_growth: SETTINGS.refinement_damping_growth,
        singular_floor: SETTINGS.damping_floor,
    };
    damped_search(&mut balance, &mut damping, SETTINGS.refinement_steps, SETTINGS.refinement_max_damping).ok()?;
    let Balance { left, slopes, .. } = balance;
    *rig = balance.rig;
    let lags = regression::correlation_length(&left, &groups);
    // Slopes of the last step but one are near enough after convergence.
    let fit = regression::least_squares(&slopes, &left, &groups, lags)?;
    let values = keys.iter().map(|key| rig.get(*key)).collect::<Option<_>>()?;
    Some(Fit { values, covariance: fit.covariance, residual: left })
}

/// Residual of the force balance, and its derivatives, at a rig.
struct Balance<'a> {
    rig: Rig,
    keys: &'a [RigKey],
    states: &'a States,
    valid: Vec<bool>,
    left: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    steps: usize,
}

impl Balance<'_> {
    /// Residual of a rig, 0 in rows that are not valid.
    fn residual(&self, rig: &Rig) -> Option<Vec<f64>> {
        let mut left = Equation::new(rig, self.states).ok()?.target(&[]);
        left.iter_mut().zip(&self.valid).for_each(|(r, valid)| *r *= f64::from(u8::from(*valid)));
        Some(left)
    }

    /// Minus the derivatives of the residual by the keys.
    fn linearise(&self) -> Option<Vec<Vec<f64>>> {
        let slope = |key: &RigKey| {
            let value = self.rig.get(*key)?;
            let step = if value == 0.0 { 1e-6 } else { SETTINGS.refinement_difference * value.abs() };
            let mut moved = self.rig.clone();
            let step = if moved.set(*key, value + step).is_ok() { step } else { -step };
            moved.set(*key, value + step).ok()?;
            let moved = self.residual(&moved)?;
            Some(self.left.iter().zip(&moved).map(|(b, m)| (b - m) / step).collect())
        };
        self.keys.iter().map(slope).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(r: &[f64]) -> f64 {
    r.iter().map(|x| x * x).sum()
}

/// Keys that the recordings do not determine, or a rig that cannot be linearised.
struct Undetermined;

impl Damped for Balance<'_> {
    /// A rig and its residual; no residual where the rig is impossible.
    type Trial = (Rig, Option<Vec<f64>>);
    type Error = Undetermined;

    fn trial(&self, damping: f64) -> Result<Option<Self::Trial>, Undetermined> {
        let mut normal: Vec<Vec<f64>> =
            (0..self.keys.len()).map(|i| (0..=i).map(|j| dot(&self.slopes[i], &self.slopes[j])).collect()).collect();
        let right: Vec<f64> = self.slopes.iter().map(|s| dot(s, &self.left)).collect();
        let step = cholesky_solve(&mut normal, &right, damping).ok_or(Undetermined)?;
        let mut trial = self.rig.clone();
        let mut keys = self.keys.iter().zip(&step);
        let set = keys.all(|(k, s)| trial.get(*k).is_some_and(|v| trial.set(*k, v + s).is_ok()));
        let left = if set { self.residual(&trial) } else { None };
        Ok(Some((trial, left)))
    }

    fn decrease(&self, (_, left): &Self::Trial) -> Option<Decrease> {
        let (now, before) = (square(left.as_ref()?), square(&self.left));
        (now < before).then_some(Decrease { actual: 1.0 - now / before, expected: f64::NAN })
    }

    fn accept(&mut self, (rig, left): Self::Trial, decrease: Decrease) -> Result<bool, Undetermined> {
        (self.rig, self.left) = (rig, left.ok_or(Undetermined)?);
        self.steps += 1;
        if decrease.actual < SETTINGS.refinement_min_fall || self.steps == SETTINGS.refinement_steps {
            return Ok(true);
        }
        self.slopes = self.linearise().ok_or(Undetermined)?;
        Ok(false)
    }
}
