//! Maximum of the likelihood: Fisher scoring with Levenberg–Marquardt damping, theory (57).

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::problem::{Expansion, Point, Problem};
use super::settings::SearchSettings;
use crate::rig::RigError;

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Limits of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Most steps.
    pub steps: usize,
    /// Gain in −ln L below which a search ends; [`SearchSettings::min_share_of_excess`] may end it earlier.
    pub least_increment: f64,
    /// Greatest change of a coordinate in a step.
    pub change: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { steps: 40, least_increment: 0.02, change: 0.5 }
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// Point of greatest likelihood.
    pub point: Point,
    /// Likelihood around the point.
    pub expansion: Expansion,
    /// Whether the search ended because there was no more to gain.
    pub converged: bool,
}

/// Searches from the rig's own values and its best angles until there is no more to gain.
///
/// # Errors
/// What the simulation refuses at the start.
pub fn search_from_rig(problem: &Problem) -> Result<Optimum, RigError> {
    search(problem, problem.start()?, &Limits::default())
}

/// Searches from a point.
///
/// # Errors
/// What the simulation refuses at the start.
pub fn search(problem: &Problem, from: Point, limits: &Limits) -> Result<Optimum, RigError> {
    let anchor = from.coordinates.clone();
    let pull = |point: &Point| -> f64 {
        let away = point.coordinates.iter().zip(&anchor).map(|(u, a)| ((u - a) / SETTINGS.prior_std).powi(2));
        0.5 * away.sum::<f64>()
    };
    let mut point = from;
    let mut expansion = problem.expand(&point)?;
    let mut damping = Damping::new();
    for _ in 0..limits.steps {
        let mut gained = None;
        while damping.value < SETTINGS.max_damping {
            let Some((next, expected)) = stepped(&point, &anchor, &expansion, damping.value, limits.change) else {
                damping.raise();
                continue;
            };
            // An impossible rig has no likelihood.
            let neg_log_likelihood: f64 = problem.neg_log_likelihoods(&next).map_or(f64::INFINITY, |m| m.iter().sum());
            let gain = expansion.neg_log_likelihood() + pull(&point) - neg_log_likelihood - pull(&next);
            if gain > 0.0 {
                gained = Some((next, gain));
                damping.follow(gain / expected);
                break;
            }
            damping.raise();
        }
        let Some((next, gain)) = gained else {
            return Ok(Optimum { point, expansion, converged: true });
        };
        point = next;
        expansion = problem.expand(&point)?;
        if gain < limits.least_increment.max(SETTINGS.min_share_of_excess * expansion.excess) {
            return Ok(Optimum { point, expansion, converged: true });
        }
    }
    Ok(Optimum { point, expansion, converged: false })
}

/// Damping by the ratio of actual to expected gain: H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05
/// (Technical University of Denmark). Where the curvature is not as expected, the damping stays where steps gain, instead of
/// falling after every step.
struct Damping {
    value: f64,
    growth: f64,
}

impl Damping {
    fn new() -> Self {
        Self { value: SETTINGS.initial_damping, growth: SETTINGS.damping_growth }
    }

    /// Adapts the damping after a step that gained the share `kept` of its expected gain.
    fn follow(&mut self, kept: f64) {
        let factor = (1.0 - (2.0 * kept - 1.0).powi(3)).max(SETTINGS.min_damping_fall);
        self.value = (self.value * factor).max(SETTINGS.min_damping);
        self.growth = SETTINGS.damping_growth;
    }

    /// Raises the damping after a step without gain.
    fn raise(&mut self) {
        self.value *= self.growth;
        self.growth *= 2.0;
    }
}

/// Next point, and its expected gain in −ln L.
fn stepped(point: &Point, anchor: &[f64], expansion: &Expansion, damping: f64, most: f64) -> Option<(Point, f64)> {
    let count = expansion.gradient.len();
    let coordinates = point.coordinates.len();
    let stiffness = 1.0 / (SETTINGS.prior_std * SETTINGS.prior_std);
    let undamped =
        |a: usize| expansion.information[(a, a)] + if a < coordinates { stiffness } else { SETTINGS.angle_stiffness };
    let system =
        Mat::from_fn(
            count,
            count,
            |a, b| {
                if a == b { undamped(a) * (1.0 + damping) } else { expansion.information[(a, b)] }
            },
        );
    let right = Mat::from_fn(count, 1, |a, _| {
        let pull = if a < coordinates { stiffness * (point.coordinates[a] - anchor[a]) } else { 0.0 };
        -expansion.gradient[a] - pull
    });
    let step = system.llt(faer::Side::Lower).ok()?.solve(&right);
    let greatest = (0..coordinates).map(|a| step[(a, 0)].abs()).fold(0.0, f64::max);
    let scale = if greatest > most { most / greatest } else { 1.0 };
    let along = |of: &Mat<f64>| -> f64 { (0..count).map(|a| step[(a, 0)] * of[(a, 0)]).sum() };
    let curvature =
        along(&(&system * &step)) - damping * (0..count).map(|a| undamped(a) * step[(a, 0)].powi(2)).sum::<f64>();
    let expected = scale * along(&right) - 0.5 * scale * scale * curvature;
    let most_angle = SETTINGS.max_angle_change_rad;
    let mut next = point.clone();
    next.coordinates.iter_mut().enumerate().for_each(|(a, u)| *u += scale * step[(a, 0)]);
    for (index, angles) in next.angles.iter_mut().enumerate() {
        for (k, angle) in angles.iter_mut().enumerate() {
            *angle += (scale * step[(coordinates + 2 * index + k, 0)]).clamp(-most_angle, most_angle);
        }
    }
    next.coordinates.iter().all(|u| u.is_finite()).then_some((next, expected))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_falls_where_steps_keep_their_promise_and_stays_where_they_keep_half() {
        let after = |kept: f64| {
            let mut damping = Damping::new();
            damping.follow(kept);
            damping.value / SETTINGS.initial_damping
        };
        assert!(after(1.0) < 0.25, "{}", after(1.0));
        assert!((after(0.5) - 1.0).abs() < 1e-12, "{}", after(0.5));
        assert!(after(0.1) > 1.0 && after(0.1) < 2.0, "{}", after(0.1));
    }

    #[test]
    fn damping_rises_ever_faster_until_a_step_gains() {
        let mut damping = Damping::new();
        let mut values = vec![damping.value];
        for _ in 0..3 {
            damping.raise();
            values.push(damping.value);
        }
        let growths: Vec<f64> = values.windows(2).map(|pair| pair[1] / pair[0]).collect();
        assert!(growths.windows(2).all(|pair| (pair[1] / pair[0] - 2.0).abs() < 1e-9), "{growths:?}");
        damping.follow(0.5);
        let before = damping.value;
        damping.raise();
        assert!((damping.value / before - growths[0]).abs() < 1e-9);
    }
}
