//! Fit with its four scores: the trainings and the best of them, the causal fits, the surrogates.

use ballrace_core::states::{Alignment, StateSpec};

use super::score::{self, NullScores, Score, Scores, TrainingScores};
use super::single_fit::{SingleFit, Split, fit_once};
use super::{FitConfig, FitError, Solver, Stage, check, check_split};
use crate::recording::input::Series;

/// Scores of a fit without its model.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredModel {
    /// The four scores.
    pub scores: Scores,
    /// Nonzero coefficients.
    pub terms: usize,
    /// R² of the derivatives on the validation recordings.
    pub r2_validation: f64,
}

/// Scores of a fit, without monitor and description.
///
/// # Errors
/// As [`fit`](super::fit()).
pub fn score_fit(recordings: &[Series], sample_rate_hz: f64, config: &FitConfig) -> Result<ScoredModel, FitError> {
    let Scored { main, split, scores, .. } = scored(recordings, sample_rate_hz, config, &|_| ())?;
    let r2_validation = score::score_model(&main.model.view(), &split.validation).mean();
    Ok(ScoredModel { scores, terms: main.terms(), r2_validation })
}

/// Fit with its scores, without monitor and description.
pub(super) struct Scored {
    pub main: SingleFit,
    pub split: Split,
    pub scores: Scores,
    /// Last surrogate with its fit.
    pub surrogate: Option<(Split, SingleFit)>,
}

pub(super) fn scored(
    recordings: &[Series],
    sample_rate_hz: f64,
    config: &FitConfig,
    progress: &(dyn Fn(Stage) + Sync),
) -> Result<Scored, FitError> {
    check(recordings, config)?;
    // A decomposition split over threads would round differently with their number.
    faer::set_global_parallelism(faer::Par::Seq);
    let causal_apart = config.causal && config.spec.alignment != Alignment::Causal;
    let trainings = match config.solver {
        Solver::SindyNn { .. } => config.trainings.max(1),
        Solver::Stlsq(_) => 1,
    };
    let fits = (trainings + config.null_fits) * (1 + usize::from(causal_apart));
    let stage = |name: &str, at: usize| {
        let name = name.to_owned();
        move |share: f64| progress(Stage { name: name.clone(), done: (at as f64 + share) / fits as f64 })
    };

    let split = Split::holding_out(recordings, config.hold_out_every, config.spec.warm_up());
    check_split(&split, config)?;
    let causal_spec = StateSpec { alignment: Alignment::Causal, ..config.spec };
    let mut at = 0;
    let mut both = |split: &Split, seed: u64, name: &str| -> Result<(SingleFit, FitScores), FitError> {
        let main = fit_once(split, sample_rate_hz, config.spec, config, seed, &stage(name, at))?;
        at += 1;
        let held_out = score::score_model(&main.model.view(), &split.held_out);
        let causal = if causal_apart {
            let name = format!("{name}, causal");
            let causal = fit_once(split, sample_rate_hz, causal_spec, config, seed, &stage(&name, at))?;
            at += 1;
            score::score_model(&causal.model.view(), &split.held_out)
        } else {
            held_out.clone()
        };
        Ok((main, FitScores { held_out, causal }))
    };

    let mut fitted = Vec::new();
    for k in 0..trainings {
        fitted.push(both(&split, config.seed.wrapping_add(k as u64), &format!("fit {} of {trainings}", k + 1))?);
    }
    let of_trainings: Vec<TrainingScores> = fitted
        .iter()
        .map(|(_, scores)| TrainingScores { held_out: scores.held_out.mean(), causal: scores.causal.next_sample })
        .collect();
    let error = |(fit, _): &(SingleFit, FitScores)| fit.trained.as_ref().map_or(0.0, |t| t.validation_error);
    let best = (0..trainings).min_by(|a, b| error(&fitted[*a]).total_cmp(&error(&fitted[*b]))).unwrap_or(0);
    let (main, FitScores { held_out, causal }) = fitted.swap_remove(best);
    let mut null = Vec::new();
    let mut last_surrogate = None;
    for k in 0..config.null_fits as u64 {
        let surrogate = split.surrogate(config.null_kind, config.seed, k);
        let name = format!("null {} of {}", k + 1, config.null_fits);
        let (fitted, scores) = both(&surrogate, config.seed.wrapping_add(k), &name)?;
        null.push(NullScores {
            in_sample: score::score_model(&fitted.model.view(), &surrogate.train).mean(),
            held_out: scores.held_out.mean(),
            causal: scores.causal.next_sample,
        });
        last_surrogate = Some((surrogate, fitted));
    }
    let in_sample = score::score_model(&main.model.view(), &split.train);
    let (null_kind, trainings) = (config.null_kind, of_trainings);
    let scores = Scores { in_sample, held_out, causal, null, null_kind, trainings };
    Ok(Scored { main, split, scores, surrogate: last_surrogate })
}

/// Scores of a single fit on held-out recordings.
struct FitScores {
    held_out: Score,
    causal: Score,
}
