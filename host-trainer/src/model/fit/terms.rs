//! What a diagnosed cause adds to the library: the nearest thing to it that the device's library can have.
//!
//! The device computes monomials, sines and cosines of the virtual states, no other functions. So a cause that is a
//! function of the state brings the lowest monomials that have its shape, one that brings the machine a mode more
//! brings the states for it, and a force that goes by an angle or a time brings nothing. Nothing ever goes out.

use ballrace_core::states::{MAX_DIMENSION, Orders};
use serde::{Deserialize, Serialize};

use super::FitConfig;

/// What a cause adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adds {
    /// Monomials up to this degree: n_D becomes at least that.
    Degree(usize),
    /// A mode: it moves by an equation of the second order, so two orders of difference more.
    Mode,
    /// No function of the states.
    Nothing,
}

use Adds::{Degree, Mode, Nothing};

const ANGLE: &str = "its force goes by an angle, which is no function of the states";
const OUTSIDE: &str = "it pushes from outside, which is no function of the states";
const PACE: &str = "it changes how fast angles pass, which is no function of the states";
const SENSOR: &str = "it is not the machine's, and a model of the machine must not learn it";
const LINEAR: &str = "it is linear in the states";
const ODD: &str = "it is odd, and cubes are the lowest odd powers that bend";
const EVEN: &str = "it acts on one side only, and squares are the lowest powers that tell the sides apart";

/// Every cause of the vocabulary, what it adds, and why that.
const TABLE: &[(&str, Adds, &str)] = &[
    ("outer-race-defect", Nothing, ANGLE),
    ("inner-race-defect", Nothing, ANGLE),
    ("ball-defect", Nothing, ANGLE),
    ("outer-race-waviness", Nothing, ANGLE),
    ("inner-race-waviness", Nothing, ANGLE),
    ("unbalance", Nothing, ANGLE),
    ("misalignment", Nothing, ANGLE),
    ("excess-clearance", Degree(2), EVEN),
    ("hardening-stiffness", Degree(3), "its force is cubic"),
    ("softening-stiffness", Degree(3), "its force is cubic"),
    ("asymmetric-stiffness", Degree(2), "its force is quadratic"),
    ("stiffness-change", Degree(1), LINEAR),
    ("damping-change", Degree(1), LINEAR),
    ("mass-change", Degree(1), LINEAR),
    ("coulomb-friction", Degree(3), ODD),
    ("viscous-friction", Degree(1), LINEAR),
    ("quadratic-drag", Degree(3), ODD),
    ("end-stop-contact", Degree(2), EVEN),
    ("backlash", Degree(3), ODD),
    ("constant-force", Degree(1), "it is a constant, which comes with the polynomial part"),
    ("structural-resonance", Mode, "a mode takes two orders of difference more"),
    ("load-step", Nothing, OUTSIDE),
    ("speed-drift", Nothing, PACE),
    ("shock", Nothing, OUTSIDE),
    ("cage-slip", Nothing, PACE),
    ("contact-exponent", Degree(2), EVEN),
    ("mains-interference", Nothing, SENSOR),
    ("sensor-bias", Nothing, SENSOR),
    ("sensor-gain", Nothing, SENSOR),
    ("sensor-clipping", Nothing, SENSOR),
    ("dropped-samples", Nothing, SENSOR),
    ("unexplained", Nothing, "what nothing explains has no terms"),
];

/// A cause and what it brought into the library.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entered {
    /// Name in the vocabulary.
    pub cause: String,
    /// Whether the library was changed for it.
    pub changed: bool,
    /// What came in and why, or why nothing did, in words.
    pub words: String,
}

impl Entered {
    /// As a line.
    pub fn line(&self) -> String {
        format!("for {}: {}", self.cause, self.words)
    }
}

/// A cause whose terms the device cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{cause}: with it n_MD would be {found}, expected at most {MAX_DIMENSION}, which the device can have; a smaller n_MD leaves room"
)]
pub struct NoRoom {
    /// The cause.
    pub cause: String,
    /// The dimension with it.
    pub found: usize,
}

/// What a cause adds; `None` for a name that the vocabulary has not.
pub fn terms_for(cause: &str) -> Option<Adds> {
    row(cause).map(|(adds, _)| adds)
}

/// Names of the vocabulary.
pub fn names() -> impl Iterator<Item = &'static str> {
    TABLE.iter().map(|(name, ..)| *name)
}

fn row(cause: &str) -> Option<(Adds, &'static str)> {
    TABLE.iter().find(|(name, ..)| *name == cause).map(|(_, adds, why)| (*adds, *why))
}

/// Lets the terms of causes enter a library, and says of each what came in. A name that the vocabulary has not adds
/// nothing.
///
/// # Errors
/// A mode for which the device has no states left.
pub fn enter(config: &mut FitConfig, causes: &[String]) -> Result<Vec<Entered>, NoRoom> {
    let mut all = Vec::with_capacity(causes.len());
    for cause in causes {
        let (adds, why) = row(cause).unwrap_or((Nothing, "it is not of the vocabulary"));
        let (changed, what) = match adds {
            Nothing => (false, "the library stays as it is".to_owned()),
            Degree(degree) if config.degree >= degree => {
                (false, format!("{} are in the library already", monomials(degree)))
            }
            Degree(degree) => {
                let before = std::mem::replace(&mut config.degree, degree);
                (true, format!("{} enter, n_D {before} becomes {degree}", monomials(degree)))
            }
            Mode => {
                let before = config.spec.dimension;
                let states = states_of_a_mode(config.spec.orders);
                let found = before + states;
                if found > MAX_DIMENSION {
                    return Err(NoRoom { cause: cause.clone(), found });
                }
                config.spec.dimension = found;
                config.latent = config.latent.map(|latent| (latent + states).min(MAX_DIMENSION));
                let more = if states == 1 { "one more state".to_owned() } else { format!("{states} more states") };
                (true, format!("the terms of {more} enter, n_MD {before} becomes {found}"))
            }
        };
        all.push(Entered { cause: cause.clone(), changed, words: format!("{what} ({why})") });
    }
    Ok(all)
}

/// States that reach two orders of difference further.
fn states_of_a_mode(orders: Orders) -> usize {
    match orders {
        Orders::Even => 1,
        Orders::Consecutive => 2,
    }
}

fn monomials(degree: usize) -> &'static str {
    match degree {
        0 | 1 => "linear terms",
        2 => "products of two states",
        _ => "products of three states",
    }
}

#[cfg(test)]
mod tests {
    use ballrace_core::states::{Alignment, StateSpec};

    use super::*;
    use crate::model::fit::Solver;
    use crate::model::stlsq::StlsqConfig;
    use crate::rig::effect::REGISTRY;

    fn config(dimension: usize, orders: Orders, degree: usize) -> FitConfig {
        FitConfig {
            spec: StateSpec { dimension, orders, alignment: Alignment::Causal },
            degree,
            harmonics: 0,
            latent: None,
            solver: Solver::Stlsq(StlsqConfig::default()),
            hold_out_every: 5,
            null_fits: 0,
            seed: 0,
            block: None,
            full_scale: 0.0,
        }
    }

    fn entered(config: &mut FitConfig, cause: &str) -> Entered {
        enter(config, &[cause.to_owned()]).unwrap().remove(0)
    }

    #[test]
    fn every_cause_of_the_vocabulary_is_answered_once() {
        let mut vocabulary: Vec<&str> = REGISTRY.iter().map(|d| d.name).chain(["unexplained"]).collect();
        let mut answered: Vec<&str> = names().collect();
        vocabulary.sort_unstable();
        answered.sort_unstable();
        assert_eq!(answered, vocabulary);
        assert_eq!(terms_for("gremlins"), None);
    }

    #[test]
    fn a_mode_brings_two_orders_of_difference() {
        for (orders, dimension) in [(Orders::Even, 5), (Orders::Consecutive, 6)] {
            let mut config = config(4, orders, 2);
            let before = config.spec.orders.highest(4);
            assert!(entered(&mut config, "structural-resonance").changed);
            assert_eq!(config.spec.dimension, dimension);
            assert_eq!(config.spec.orders.highest(dimension), before + 2);
        }
        let mut full = config(15, Orders::Consecutive, 2);
        let error = enter(&mut full, &["structural-resonance".into()]).unwrap_err();
        assert_eq!(error.found, 17);
        assert_eq!(full.spec.dimension, 15);
    }

    #[test]
    fn degrees_only_grow_and_what_goes_by_an_angle_adds_nothing() {
        let mut one = config(4, Orders::Even, 2);
        let cubic = entered(&mut one, "hardening-stiffness");
        assert_eq!((one.degree, cubic.changed), (3, true));
        assert_eq!(
            cubic.line(),
            "for hardening-stiffness: products of three states enter, n_D 2 becomes 3 (its force is cubic)"
        );
        assert!(!entered(&mut one, "asymmetric-stiffness").changed && one.degree == 3);
        let before = one.clone();
        for cause in ["outer-race-defect", "unbalance", "load-step", "cage-slip", "sensor-gain"] {
            let told = entered(&mut one, cause);
            assert!(!told.changed && told.words.starts_with("the library stays as it is"), "{}", told.words);
        }
        assert_eq!(one, before);
    }
}
