//! Fit of a model that keeps to a budget of cycles: as asked for if that does, else with fewer hidden units, in fixed point.

use std::ops::Range;

use ballrace_core::Word;
use ballrace_core::model::Model;
use ballrace_core::network::{Arithmetic, Network, fixed};

use super::settings::LEAST_UNITS;
use super::{BudgetConfig, budget};
use crate::model::export::BreaksLimit;
use crate::model::fit::{FitConfig, FitError, Fitted, Solver, Stage, fit};
use crate::recording::input::Series;

/// Cycles that the most expensive sample may take, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleLimit {
    /// Device.
    pub device: BudgetConfig,
    /// Greatest number of cycles.
    pub most: usize,
}

impl CycleLimit {
    /// Checks a model.
    ///
    /// # Errors
    /// [`BreaksLimit`] with the cycles predicted.
    pub fn check(&self, model: &Model<'_>) -> Result<(), BreaksLimit> {
        budget(model, self.device).check_cycles(self.most)
    }
}

/// Failure of a fit within a budget.
#[derive(Debug, thiserror::Error)]
pub enum WithinError {
    /// Of the fit.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// No number of hidden units is small enough.
    #[error(
        "{0}, also with {LEAST_UNITS} hidden units in fixed point; fewer terms (--nd, --nf) or a smaller --nmd may help"
    )]
    Budget(BreaksLimit),
}

/// Fits a model within a limit. The greatest number of hidden units is sought on quick fits (one training, no null, no causal
/// fit), since what a model costs beside its networks depends on the terms that it keeps.
///
/// # Errors
/// [`WithinError`]: of the fit, or if no model keeps to the limit.
pub fn fit_within(
    recordings: &[Series],
    sample_rate_hz: f64,
    config: &FitConfig,
    limit: &CycleLimit,
    progress: &(dyn Fn(Stage) + Sync),
) -> Result<Fitted, WithinError> {
    let mut config = config.clone();
    // Numbers of units that kept to the limit and that did not.
    let (mut passed, mut failed) = (0, usize::MAX);
    let mut settled = false;
    loop {
        let quick = FitConfig { null_fits: 0, trainings: 1, causal: false, ..config.clone() };
        let fitted = fit(recordings, sample_rate_hz, if settled { &config } else { &quick }, progress)?;
        let model = fitted.model.view();
        let units = model.encoder.hidden_width();
        let as_asked = model.encoder.arithmetic() == Arithmetic::Float;
        let most_within = |range: Range<usize>| range.rev().find(|units| limit.check_with(&model, *units));
        let next = match limit.check(&model) {
            Ok(()) if settled => return Ok(fitted),
            Ok(()) if as_asked || failed == usize::MAX => None,
            Ok(()) => {
                passed = units;
                most_within(units + 1..failed)
            }
            Err(broken) => {
                // In fixed point as many units take fewer cycles.
                failed = if as_asked { units + 1 } else { units };
                if settled {
                    passed = 0;
                }
                match most_within(LEAST_UNITS.max(passed + 1)..failed) {
                    Some(units) => Some(units),
                    None if passed > 0 => {
                        set(&mut config, passed);
                        None
                    }
                    None => return Err(WithinError::Budget(broken)),
                }
            }
        };
        settled = next.is_none();
        if let Some(units) = next {
            set(&mut config, units);
        }
    }
}

/// Asks for so many hidden units in fixed point.
fn set(config: &mut FitConfig, units: usize) {
    if let Solver::SindyNn { hidden, .. } = &mut config.solver {
        *hidden = vec![units];
        config.arithmetic = Arithmetic::Fixed;
    }
}

impl CycleLimit {
    /// Whether a model would keep to the limit with its networks in fixed point and so many hidden units; never for a model
    /// without networks.
    fn check_with(&self, model: &Model<'_>, units: usize) -> bool {
        if model.encoder.hidden_width() == 0 {
            return false;
        }
        let words_of = |widths: &[u16; 3]| Some(vec![Word::default(); fixed::word_count(widths)?]);
        let checked = || {
            let [inputs, latent, units] = [
                u16::try_from(model.input.len()).ok()?,
                u16::try_from(model.latent()).ok()?,
                u16::try_from(units).ok()?,
            ];
            let (up, down) = ([inputs, units, latent], [latent, units, inputs]);
            let (up_words, down_words) = (words_of(&up)?, words_of(&down)?);
            let encoder = Network::new(&up, Arithmetic::Fixed, &up_words)?;
            let decoder = Network::new(&down, Arithmetic::Fixed, &down_words)?;
            Some(self.check(&Model { encoder, decoder, ..model.clone() }).is_ok())
        };
        checked().unwrap_or(false)
    }
}
