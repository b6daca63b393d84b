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
    /// Less gain than this in −ln L ends it.
    pub gain: f64,
    /// Greatest change of a coordinate in a step.
    pub change: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { steps: 40, gain: 0.02, change: 0.5 }
    }
}

/// How far a coordinate strays from where the search began at no cost to speak of: a factor of e². What the recordings do
/// not tell stays where it was, instead of running away along a likelihood that is flat.
const STRAYS: f64 = 2.0;

/// Keeps an angle on which nothing depends where it is.
const ANGLE_STIFFNESS: f64 = 1e-3;

/// What a search has found.
#[derive(Clone, Debug)]
pub struct Found {
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
pub fn search_from_rig(problem: &Problem) -> Result<Found, RigError> {
    search(problem, problem.start()?, &Limits::default())
}

/// Searches from a point.
///
/// # Errors
/// What the simulation refuses at the start.
pub fn search(problem: &Problem, from: Point, limits: &Limits) -> Result<Found, RigError> {
    let anchor = from.coordinates.clone();
    let pull = |point: &Point| -> f64 {
        let away = point.coordinates.iter().zip(&anchor).map(|(u, a)| ((u - a) / STRAYS).powi(2));
        0.5 * away.sum::<f64>()
    };
    let mut point = from;
    let mut expansion = problem.expand(&point)?;
    let mut damping = 1e-3;
    for _ in 0..limits.steps {
        let mut gained = None;
        while damping < 1e9 {
            let Some(next) = stepped(&point, &anchor, &expansion, damping, limits.change) else {
                damping *= 10.0;
                continue;
            };
            // Where no rig can stand there is nothing to gain.
            let misfit: f64 = problem.misfits(&next).map_or(f64::INFINITY, |m| m.iter().sum());
            let gain = expansion.misfit() + pull(&point) - misfit - pull(&next);
            if gain > 0.0 {
                gained = Some((next, gain));
                damping = (damping * 0.2).max(1e-9);
                break;
            }
            damping *= 8.0;
        }
        let Some((next, gain)) = gained else {
            return Ok(Found { point, expansion, converged: true });
        };
        point = next;
        expansion = problem.expand(&point)?;
        if gain < limits.gain {
            return Ok(Found { point, expansion, converged: true });
        }
    }
    Ok(Found { point, expansion, converged: false })
}

fn stepped(point: &Point, anchor: &[f64], expansion: &Expansion, damping: f64, most: f64) -> Option<Point> {
    let count = expansion.gradient.len();
    let coordinates = point.coordinates.len();
    let stiffness = 1.0 / (STRAYS * STRAYS);
    let system = Mat::from_fn(count, count, |a, b| {
        let value = expansion.information[(a, b)];
        let own = if a < coordinates { stiffness } else { ANGLE_STIFFNESS };
        if a == b { (value + own) * (1.0 + damping) } else { value }
    });
    let right = Mat::from_fn(count, 1, |a, _| {
        let pull = if a < coordinates { stiffness * (point.coordinates[a] - anchor[a]) } else { 0.0 };
        -expansion.gradient[a] - pull
    });
    let step = system.llt(faer::Side::Lower).ok()?.solve(&right);
    let greatest = (0..coordinates).map(|a| step[(a, 0)].abs()).fold(0.0, f64::max);
    let scale = if greatest > most { most / greatest } else { 1.0 };
    let mut next = point.clone();
    next.coordinates.iter_mut().enumerate().for_each(|(a, u)| *u += scale * step[(a, 0)]);
    for (index, angles) in next.angles.iter_mut().enumerate() {
        for (k, angle) in angles.iter_mut().enumerate() {
            *angle += (scale * step[(coordinates + 2 * index + k, 0)]).clamp(-0.3, 0.3);
        }
    }
    next.coordinates.iter().all(|u| u.is_finite()).then_some(next)
}
