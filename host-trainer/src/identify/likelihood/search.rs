//! The most likely point: Fisher scoring, damped as Levenberg and Marquardt do.

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::problem::{Expansion, Point, Problem};
use crate::rig::RigError;

/// When a search ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Steps at most.
    pub steps: usize,
    /// Less gain than this in −ln L ends it, and less than [`OF_EXCESS`] of what is left.
    pub least_increment: f64,
    /// Greatest change of a coordinate in a step.
    pub change: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { steps: 40, least_increment: 0.02, change: 0.5 }
    }
}

/// How far a coordinate strays from where the search began at no cost to speak of: a factor of e². What the recordings do
/// not tell stays where it was, instead of running away along a likelihood that is flat.
const PRIOR_STD: f64 = 2.0;

/// Share of what is left above chance that a gain must come to: a rig that leaves 10⁶ is wrong by more than any last step mends.
const LEAST_SHARE_OF_EXCESS: f64 = 1e-5;

/// Keeps an angle on which nothing depends where it is.
const ANGLE_STIFFNESS: f64 = 1e-3;

/// What a search has found.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// The most likely point.
    pub point: Point,
    /// The likelihood around it.
    pub expansion: Expansion,
    /// Whether it ended because there was no more to gain.
    pub converged: bool,
}

/// Searches from the rig's own values and the angles that suit it best, as far as there is anything to gain.
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
        let away = point.coordinates.iter().zip(&anchor).map(|(u, a)| ((u - a) / PRIOR_STD).powi(2));
        0.5 * away.sum::<f64>()
    };
    let mut point = from;
    let mut expansion = problem.expand(&point)?;
    let mut damping = Damping::new();
    for _ in 0..limits.steps {
        let mut gained = None;
        while damping.value < Damping::MOST {
            let Some((next, promised)) = stepped(&point, &anchor, &expansion, damping.value, limits.change) else {
                damping.raise();
                continue;
            };
            // Where no rig can stand there is nothing to gain.
            let neg_log_likelihood: f64 = problem.neg_log_likelihoods(&next).map_or(f64::INFINITY, |m| m.iter().sum());
            let gain = expansion.neg_log_likelihood() + pull(&point) - neg_log_likelihood - pull(&next);
            if gain > 0.0 {
                gained = Some((next, gain));
                damping.follow(gain / promised);
                break;
            }
            damping.raise();
        }
        let Some((next, gain)) = gained else {
            return Ok(Optimum { point, expansion, converged: true });
        };
        point = next;
        expansion = problem.expand(&point)?;
        if gain < limits.least_increment.max(LEAST_SHARE_OF_EXCESS * expansion.excess) {
            return Ok(Optimum { point, expansion, converged: true });
        }
    }
    Ok(Optimum { point, expansion, converged: false })
}

/// Damping by how far steps keep what they promise: H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05
/// (Technical University of Denmark). Where the curvature is not as expected it stays where steps gain, instead of trying at
/// every step whether less would do.
struct Damping {
    value: f64,
    growth: f64,
}

impl Damping {
    const START: f64 = 1e-3;
    const LEAST: f64 = 1e-9;
    /// Where a search ends that gains nothing.
    const MOST: f64 = 1e9;
    const GROWTH: f64 = 4.0;

    fn new() -> Self {
        Self { value: Self::START, growth: Self::GROWTH }
    }

    /// After a step that gained this share of what it promised.
    fn follow(&mut self, kept: f64) {
        self.value = (self.value * (1.0 - (2.0 * kept - 1.0).powi(3)).max(0.2)).max(Self::LEAST);
        self.growth = Self::GROWTH;
    }

    /// After a step that gained nothing.
    fn raise(&mut self) {
        self.value *= self.growth;
        self.growth *= 2.0;
    }
}

/// The next point, and what it promises to gain in −ln L.
fn stepped(point: &Point, anchor: &[f64], expansion: &Expansion, damping: f64, most: f64) -> Option<(Point, f64)> {
    let count = expansion.gradient.len();
    let coordinates = point.coordinates.len();
    let stiffness = 1.0 / (PRIOR_STD * PRIOR_STD);
    let undamped = |a: usize| expansion.information[(a, a)] + if a < coordinates { stiffness } else { ANGLE_STIFFNESS };
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
    let promised = scale * along(&right) - 0.5 * scale * scale * curvature;
    let mut next = point.clone();
    next.coordinates.iter_mut().enumerate().for_each(|(a, u)| *u += scale * step[(a, 0)]);
    for (index, angles) in next.angles.iter_mut().enumerate() {
        for (k, angle) in angles.iter_mut().enumerate() {
            *angle += (scale * step[(coordinates + 2 * index + k, 0)]).clamp(-0.3, 0.3);
        }
    }
    next.coordinates.iter().all(|u| u.is_finite()).then_some((next, promised))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_falls_where_steps_keep_their_promise_and_stays_where_they_keep_half() {
        let after = |kept: f64| {
            let mut damping = Damping::new();
            damping.follow(kept);
            damping.value / Damping::START
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
