//! Terms of diagnosed causes in the library of a fit: of each cause those that its definition states
//! ([`LibraryTerms`]). A library only grows by them.

use ballrace_core::states::{MAX_DIMENSION, Orders};
use serde::{Deserialize, Serialize};

use super::FitConfig;
use crate::rig::effect::{Adds, EffectKind, LibraryTerms};

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

/// Adds the terms of causes to a library, and says of each cause what was added.
///
/// # Errors
/// A mode for which the device has no states left.
pub fn enter(config: &mut FitConfig, causes: &[EffectKind]) -> Result<Vec<Entered>, NoRoom> {
    let mut all = Vec::with_capacity(causes.len());
    for cause in causes {
        let LibraryTerms { adds, why } = cause.definition().library;
        let (changed, what) = match adds {
            Adds::Nothing => (false, "the library stays as it is".to_owned()),
            Adds::Degree(degree) if config.degree >= degree => {
                (false, format!("{} are in the library already", monomials(degree)))
            }
            Adds::Degree(degree) => {
                let before = std::mem::replace(&mut config.degree, degree);
                (true, format!("{} enter, n_D {before} becomes {degree}", monomials(degree)))
            }
            Adds::Powers if config.powers => (false, "powers of two thirds are in the library already".to_owned()),
            Adds::Powers => {
                config.powers = true;
                (true, "powers of two thirds of each state enter".to_owned())
            }
            Adds::Mode => {
                let before = config.spec.dimension;
                let states = states_of_a_mode(config.spec.orders);
                let found = before + states;
                if found > MAX_DIMENSION {
                    return Err(NoRoom { cause: cause.to_string(), found });
                }
                config.spec.dimension = found;
                config.latent = config.latent.map(|latent| (latent + states).min(MAX_DIMENSION));
                let more = if states == 1 { "one more state".to_owned() } else { format!("{states} more states") };
                (true, format!("the terms of {more} enter, n_MD {before} becomes {found}"))
            }
        };
        all.push(Entered { cause: cause.to_string(), changed, words: format!("{what} ({why})") });
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
    use ballrace_core::network::Arithmetic;
    use ballrace_core::states::{Alignment, Estimator, StateSpec};

    use super::*;
    use crate::model::fit::Solver;
    use crate::model::stlsq::StlsqConfig;
    use crate::signal::surrogate::SurrogateKind;

    fn config(dimension: usize, orders: Orders, degree: usize) -> FitConfig {
        FitConfig {
            spec: StateSpec { dimension, orders, alignment: Alignment::Causal, estimator: Estimator::Differences },
            degree,
            harmonics: 0,
            powers: false,
            latent: None,
            solver: Solver::Stlsq(StlsqConfig::default()),
            arithmetic: Arithmetic::Float,
            hold_out_every: 5,
            null_fits: 0,
            null_kind: SurrogateKind::default(),
            causal: true,
            trainings: 1,
            ..FitConfig::default()
        }
    }

    fn entered(config: &mut FitConfig, cause: EffectKind) -> Entered {
        enter(config, &[cause]).unwrap().remove(0)
    }

    #[test]
    fn a_mode_brings_two_orders_of_difference() {
        for (orders, dimension) in [(Orders::Even, 5), (Orders::Consecutive, 6)] {
            let mut config = config(4, orders, 2);
            let before = config.spec.orders.highest(4);
            assert!(entered(&mut config, EffectKind::StructuralResonance).changed);
            assert_eq!(config.spec.dimension, dimension);
            assert_eq!(config.spec.orders.highest(dimension), before + 2);
        }
        let mut full = config(15, Orders::Consecutive, 2);
        let error = enter(&mut full, &[EffectKind::StructuralResonance]).unwrap_err();
        assert_eq!(error.found, 17);
        assert_eq!(full.spec.dimension, 15);
    }

    #[test]
    fn degrees_only_grow_and_what_goes_by_an_angle_adds_nothing() {
        let mut one = config(4, Orders::Even, 2);
        let cubic = entered(&mut one, EffectKind::HardeningStiffness);
        assert_eq!((one.degree, cubic.changed), (3, true));
        assert_eq!(
            cubic.line(),
            "for hardening-stiffness: products of three states enter, n_D 2 becomes 3 (its force is cubic)"
        );
        assert!(!entered(&mut one, EffectKind::AsymmetricStiffness).changed && one.degree == 3);
        let before = one.clone();
        for cause in [
            EffectKind::OuterRaceDefect,
            EffectKind::Unbalance,
            EffectKind::LoadStep,
            EffectKind::CageSlip,
            EffectKind::SensorGain,
        ] {
            let told = entered(&mut one, cause);
            assert!(!told.changed && told.words.starts_with("the library stays as it is"), "{}", told.words);
        }
        assert_eq!(one, before);
    }
}
