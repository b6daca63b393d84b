//! Maximum of the likelihood: Fisher scoring with Levenberg–Marquardt damping, theory (57).

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::problem::{Expansion, Point, Problem};
use super::settings::SearchSettings;
use crate::rig::RigError;
use crate::stats::optimise::{Damped, Damping, Decrease, damped_search};

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
    let expansion = problem.expand(&from)?;
    let mut search = Search { problem, limits, anchor: from.coordinates.clone(), point: from, expansion };
    let converged = damped_search(&mut search, &mut NielsenDamping::new(), limits.steps, SETTINGS.max_damping)?;
    Ok(Optimum { point: search.point, expansion: search.expansion, converged })
}

/// State of a search: Fisher scoring on the likelihood and a weak prior around the start.
struct Search<'s, 'o> {
    problem: &'s Problem<'o>,
    limits: &'s Limits,
    /// Coordinates at the start.
    anchor: Vec<f64>,
    point: Point,
    expansion: Expansion,
}

impl Search<'_, '_> {
    /// −ln of the prior.
    fn pull(&self, point: &Point) -> f64 {
        let away = point.coordinates.iter().zip(&self.anchor).map(|(u, a)| ((u - a) / SETTINGS.prior_std).powi(2));
        0.5 * away.sum::<f64>()
    }
}

impl Damped for Search<'_, '_> {
    type Trial = (Point, f64);
    type Error = RigError;

    fn trial(&self, damping: f64) -> Result<Option<(Point, f64)>, RigError> {
        Ok(stepped(&self.point, &self.anchor, &self.expansion, damping, self.limits.change))
    }

    fn decrease(&self, (next, expected): &(Point, f64)) -> Option<Decrease> {
        // An impossible rig has no likelihood.
        let next_value: f64 = self.problem.neg_log_likelihoods(next).map_or(f64::INFINITY, |m| m.iter().sum());
        let actual = self.expansion.neg_log_likelihood() + self.pull(&self.point) - next_value - self.pull(next);
        (actual > 0.0).then_some(Decrease { actual, expected: *expected })
    }

    fn accept(&mut self, (next, _): (Point, f64), decrease: Decrease) -> Result<bool, RigError> {
        self.point = next;
        self.expansion = self.problem.expand(&self.point)?;
        let least = self.limits.least_increment.max(SETTINGS.min_share_of_excess * self.expansion.excess);
        Ok(decrease.actual < least)
    }
}

/// Damping by the ratio of actual to expected gain: H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05
/// (Technical University of Denmark). Where the curvature is not as expected, the damping stays where steps gain, instead of
/// falling after every step.
struct NielsenDamping {
    value: f64,
    growth: f64,
}

impl NielsenDamping {
    fn new() -> Self {
        Self { value: SETTINGS.initial_damping, growth: SETTINGS.damping_growth }
    }
}

impl Damping for NielsenDamping {
    fn value(&self) -> f64 {
        self.value
    }

    fn follow(&mut self, Decrease { actual, expected }: Decrease) {
        let factor = (1.0 - (2.0 * (actual / expected) - 1.0).powi(3)).max(SETTINGS.min_damping_fall);
        self.value = (self.value * factor).max(SETTINGS.min_damping);
        self.growth = SETTINGS.damping_growth;
    }

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
    fn damping_falls_where_steps_gain_as_expected_and_stays_where_they_gain_half() {
        let after = |kept: f64| {
            let mut damping = NielsenDamping::new();
            damping.follow(Decrease { actual: kept, expected: 1.0 });
            damping.value / SETTINGS.initial_damping
        };
        assert!(after(1.0) < 0.25, "{}", after(1.0));
        assert!((after(0.5) - 1.0).abs() < 1e-12, "{}", after(0.5));
        assert!(after(0.1) > 1.0 && after(0.1) < 2.0, "{}", after(0.1));
    }

    #[test]
    fn damping_rises_ever_faster_until_a_step_gains() {
        let mut damping = NielsenDamping::new();
        let mut values = vec![damping.value];
        for _ in 0..3 {
            damping.raise();
            values.push(damping.value);
        }
        let growths: Vec<f64> = values.windows(2).map(|pair| pair[1] / pair[0]).collect();
        assert!(growths.windows(2).all(|pair| (pair[1] / pair[0] - 2.0).abs() < 1e-9), "{growths:?}");
        damping.follow(Decrease { actual: 0.5, expected: 1.0 });
        let before = damping.value;
        damping.raise();
        assert!((damping.value / before - growths[0]).abs() < 1e-9);
    }
}
