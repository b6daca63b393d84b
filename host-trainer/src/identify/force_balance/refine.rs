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

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Fits the numbers named by `keys`, from the rig's values on, and sets them in the rig. `None` if they are not determined.
pub fn refine(rig: &mut Rig, keys: &[RigKey], states: &States) -> Option<Fit> {
    let residual = |rig: &Rig| Equation::new(rig, states).ok().map(|e| e.target(&[]));
    let square = |r: &[f64]| r.iter().map(|x| x * x).sum::<f64>();
    let groups: Vec<usize> = states.tracks.iter().map(|t| t.rows.len()).collect();
    let valid: Vec<bool> = states.tracks.iter().flat_map(|t| t.valid.iter().copied()).collect();
    let masked = |rig: &Rig| {
        let mut left = residual(rig)?;
        left.iter_mut().zip(&valid).for_each(|(r, valid)| *r *= f64::from(u8::from(*valid)));
        Some(left)
    };
    let mut left = masked(rig)?;
    let mut damping = SETTINGS.refinement_initial_damping;
    let mut slopes = Vec::new();
    for _ in 0..SETTINGS.refinement_steps {
        slopes.clear();
        for key in keys {
            let value = rig.get(*key)?;
            let step = if value == 0.0 { 1e-6 } else { SETTINGS.refinement_difference * value.abs() };
            let mut moved = rig.clone();
            let step = if moved.set(*key, value + step).is_ok() { step } else { -step };
            moved.set(*key, value + step).ok()?;
            let moved = masked(&moved)?;
            slopes.push(left.iter().zip(&moved).map(|(b, m)| (b - m) / step).collect::<Vec<f64>>());
        }
        let mut better = None;
        while damping < SETTINGS.refinement_max_damping {
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let mut normal: Vec<Vec<f64>> =
                (0..keys.len()).map(|i| (0..=i).map(|j| dot(&slopes[i], &slopes[j])).collect()).collect();
            let right: Vec<f64> = slopes.iter().map(|s| dot(s, &left)).collect();
            let step = cholesky_solve(&mut normal, &right, damping)?;
            let mut trial = rig.clone();
            let set = keys.iter().zip(&step).all(|(k, s)| trial.get(*k).is_some_and(|v| trial.set(*k, v + s).is_ok()));
            let now = set.then(|| masked(&trial)).flatten().filter(|now| square(now) < square(&left));
            if let Some(now) = now {
                better = Some((trial, now));
                break;
            }
            damping = f64::max(damping, SETTINGS.damping_floor) * SETTINGS.refinement_damping_growth;
        }
        let Some((trial, now)) = better else { break };
        let fall = 1.0 - square(&now) / square(&left);
        (*rig, left) = (trial, now);
        damping *= SETTINGS.damping_fall;
        if fall < SETTINGS.refinement_min_fall {
            break;
        }
    }
    let lags = regression::correlation_length(&left, &groups);
    // Slopes of the last step but one are near enough after convergence.
    let fit = regression::least_squares(&slopes, &left, &groups, lags)?;
    let values = keys.iter().map(|key| rig.get(*key)).collect::<Option<_>>()?;
    Some(Fit { values, covariance: fit.covariance, residual: left })
}
