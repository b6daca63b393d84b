//! Optimisation: golden section, and one damped search for all that is fitted by least squares or likelihood.

use super::cancel;
use super::settings::GoldenSectionSettings;

const SETTINGS: GoldenSectionSettings = GoldenSectionSettings::DEFAULT;

/// Argument of the maximum of a unimodal function between `a` and `b`, by golden-section search.
pub fn golden_section(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_895;
    for _ in 0..SETTINGS.iterations {
        let (left, right) = (b - RATIO * (b - a), a + RATIO * (b - a));
        if f(left) > f(right) { b = right } else { a = left }
    }
    0.5 * (a + b)
}

/// A problem that a [damped search](damped_search) solves: least squares by Gauss–Newton, or a likelihood by Fisher
/// scoring.
pub trait Damped {
    /// A trial point.
    type Trial;
    /// Reason to end without a result.
    type Error;

    /// Trial point at a damping; `None` if the damped system cannot be solved.
    ///
    /// # Errors
    /// A system that no damping makes solvable.
    fn trial(&self, damping: f64) -> Result<Option<Self::Trial>, Self::Error>;

    /// Decrease of the objective at a trial point; `None` if there is none, or if the point is not admissible.
    fn decrease(&self, trial: &Self::Trial) -> Option<Decrease>;

    /// Moves to a trial point and linearises there; true if that was the last step.
    ///
    /// # Errors
    /// A point that cannot be linearised.
    fn accept(&mut self, trial: Self::Trial, decrease: Decrease) -> Result<bool, Self::Error>;
}

/// Decrease of an objective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decrease {
    /// Decrease found, in the objective's unit.
    pub actual: f64,
    /// Decrease expected of the linearisation; NaN if not known.
    pub expected: f64,
}

/// Adaptation of a damping.
pub trait Damping {
    /// Current damping.
    fn value(&self) -> f64;

    /// Adapts the damping after a step that decreased the objective.
    fn follow(&mut self, decrease: Decrease);

    /// Raises the damping after a trial without decrease.
    fn raise(&mut self);

    /// Raises the damping after a system that could not be solved.
    fn raise_singular(&mut self) {
        self.raise();
    }
}

/// Searches by damped steps (K. Levenberg, Quarterly of Applied Mathematics 2 (1944) 164–168; D. W. Marquardt, Journal of
/// the SIAM 11 (1963) 431–441) until a step is the last, none decreases the objective at less than `max_damping`, or `steps`
/// are taken. Returns whether the search ended by itself.
///
/// # Errors
/// Those of the problem.
pub fn damped_search<P: Damped>(
    problem: &mut P,
    damping: &mut impl Damping,
    steps: usize,
    max_damping: f64,
) -> Result<bool, P::Error> {
    for _ in 0..steps {
        let mut found = None;
        while damping.value() < max_damping {
            cancel::check();
            let Some(trial) = problem.trial(damping.value())? else {
                damping.raise_singular();
                continue;
            };
            if let Some(decrease) = problem.decrease(&trial) {
                damping.follow(decrease);
                found = Some((trial, decrease));
                break;
            }
            damping.raise();
        }
        let Some((trial, decrease)) = found else { return Ok(true) };
        if problem.accept(trial, decrease)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Damping that falls by a factor after every step and grows by another after every trial without decrease.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct GeometricDamping {
    /// Current damping.
    pub value: f64,
    /// Factor after a step.
    pub fall: f64,
    /// Factor after a trial without decrease.
    pub growth: f64,
    /// Least damping that grows.
    pub floor: f64,
    /// Factor after a system that could not be solved.
    pub singular_growth: f64,
    /// Least damping that grows after such a system.
    pub singular_floor: f64,
}

impl Damping for GeometricDamping {
    fn value(&self) -> f64 {
        self.value
    }

    fn follow(&mut self, _: Decrease) {
        self.value *= self.fall;
    }

    fn raise(&mut self) {
        self.value = f64::max(self.value, self.floor) * self.growth;
    }

    fn raise_singular(&mut self) {
        self.value = f64::max(self.value, self.singular_floor) * self.singular_growth;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Least squares of ln y on a line through two points, which has the solution (1, 2).
    struct Exponential {
        at: [f64; 2],
    }

    impl Exponential {
        fn residual(at: [f64; 2]) -> [f64; 2] {
            [0.0, 1.0].map(|x: f64| (1.0 + 2.0 * x).exp() - (at[0] + at[1] * x).exp())
        }

        fn square(at: [f64; 2]) -> f64 {
            Self::residual(at).iter().map(|r| r * r).sum()
        }
    }

    impl Damped for Exponential {
        type Trial = [f64; 2];
        type Error = ();

        fn trial(&self, damping: f64) -> Result<Option<[f64; 2]>, ()> {
            let slopes = [0.0, 1.0].map(|x: f64| [1.0, x].map(|d| d * (self.at[0] + self.at[1] * x).exp()));
            let r = Self::residual(self.at);
            let normal = |i: usize, j: usize| {
                let sum: f64 = slopes.iter().map(|s| s[i] * s[j]).sum();
                if i == j { sum * (1.0 + damping) } else { sum }
            };
            let right = [0, 1].map(|i| slopes.iter().zip(r).map(|(s, r)| s[i] * r).sum::<f64>());
            let determinant = normal(0, 0) * normal(1, 1) - normal(0, 1).powi(2);
            let step = [
                (right[0] * normal(1, 1) - right[1] * normal(0, 1)) / determinant,
                (right[1] * normal(0, 0) - right[0] * normal(0, 1)) / determinant,
            ];
            Ok(Some([self.at[0] + step[0], self.at[1] + step[1]]))
        }

        fn decrease(&self, trial: &[f64; 2]) -> Option<Decrease> {
            let actual = Self::square(self.at) - Self::square(*trial);
            (actual > 0.0).then_some(Decrease { actual, expected: f64::NAN })
        }

        fn accept(&mut self, trial: [f64; 2], decrease: Decrease) -> Result<bool, ()> {
            self.at = trial;
            Ok(decrease.actual < 1e-20)
        }
    }

    #[test]
    fn invariant_a_damped_search_comes_to_the_least_squares() {
        let mut damping = GeometricDamping {
            value: 1e-3,
            fall: 0.3,
            growth: 8.0,
            floor: 1e-7,
            singular_growth: 10.0,
            singular_floor: 1e-9,
        };
        let mut problem = Exponential { at: [3.0, -2.0] };
        assert!(damped_search(&mut problem, &mut damping, 200, 1e9).unwrap());
        assert!((problem.at[0] - 1.0).abs() < 1e-6 && (problem.at[1] - 2.0).abs() < 1e-6, "{:?}", problem.at);
    }
}
