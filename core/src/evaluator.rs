//! Evaluation of a model step by step, x → z → ż → ẋ, theory (6), (10), (11) and (23), in fixed memory.

use crate::Floats;
use crate::dynamics::FACTORS;
use crate::model::{Input, Model};
use crate::states::{Alignment, VirtualStates};

/// Evaluator of a model. All memory is a caller's slice of [`scratch_len`] floats.
#[derive(Debug)]
pub struct Evaluator<'a, 's> {
    model: &'a Model<'a>,
    /// Reciprocals of the model's divisors: a division takes fourteen cycles, and there are three for each input.
    reciprocals: Reciprocals<'s>,
    /// Virtual states; `None` for models whose states are given directly.
    virtual_states: Option<VirtualStates<'s>>,
    /// Raw states of the newest evaluation.
    states: &'s mut [f32],
    /// Measured derivatives, scaled.
    derivatives: &'s mut [f32],
    scaled: &'s mut [f32],
    /// Latent variables, then ones.
    latent: &'s mut [f32; FACTORS],
    latent_rate: &'s mut [f32],
    predicted: &'s mut [f32],
    /// Prediction of causal models made one sample ago, for the derivatives measured now.
    awaited: &'s mut [f32],
    hidden: &'s mut [f32],
    /// Whether `awaited` of a causal model holds a prediction.
    awaiting: bool,
    /// Predicted next sample of a causal model.
    next_sample: Option<f32>,
}

/// Reciprocals of scales and spreads.
#[derive(Debug)]
struct Reciprocals<'s> {
    states: &'s [f32],
    derivatives: &'s [f32],
    residual_spread: &'s [f32],
}

/// Result of one step, in the model's scaled units unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<'e> {
    /// Virtual states x, in physical units.
    pub states: &'e [f32],
    /// Latent variables z = φ(x).
    pub latent: &'e [f32],
    /// Rates ż = Θ(z) Ξ of the latent variables.
    pub latent_rate: &'e [f32],
    /// Predicted derivatives ∇ψ(z) ż of `states`. A causal model's belong to the next sample.
    pub predicted: &'e [f32],
    /// Measured derivatives of this step's target instant.
    pub measured: &'e [f32],
    /// Prediction of `measured`: for a causal model that of the step before.
    pub expected: &'e [f32],
    /// Whether `measured` and `expected` belong together; false in the first step of a causal model.
    pub comparable: bool,
    /// Predicted next sample, theory (23), m/s²; only for causal models of virtual states.
    pub next_sample: Option<f32>,
    /// Reciprocals of the residuals' healthy spreads.
    spread_reciprocals: &'e [f32],
}

impl Step<'_> {
    /// Residuals measured − expected; empty if not comparable.
    pub fn residuals(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        let count = if self.comparable { self.measured.len() } else { 0 };
        self.measured.iter().zip(self.expected).take(count).map(|(m, e)| m - e)
    }

    /// Residuals over their healthy spreads; empty if not comparable.
    pub fn normalised_residuals(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.residuals().zip(self.spread_reciprocals).map(|(residual, reciprocal)| residual * reciprocal)
    }
}

/// Number of floats that [`Evaluator::new`] needs for a model.
pub fn scratch_len(model: &Model<'_>) -> usize {
    let memory = match model.input {
        Input::VirtualStates(spec) => spec.memory_len(),
        Input::Direct(_) => 0,
    };
    memory + 8 * model.input.len() + FACTORS + model.latent() + hidden_len(model)
}

fn hidden_len(model: &Model<'_>) -> usize {
    model.encoder.forward_scratch_len().max(model.decoder.tangent_scratch_len())
}

impl<'a, 's> Evaluator<'a, 's> {
    /// Evaluator before the first sample; `None` if `scratch` has fewer than [`scratch_len`] floats.
    pub fn new(model: &'a Model<'a>, scratch: &'s mut [f32]) -> Option<Self> {
        let scratch = scratch.get_mut(..scratch_len(model))?;
        scratch.fill(0.0);
        let (inputs, latent) = (model.input.len(), model.latent());
        let mut rest = scratch;
        let mut take = |count: usize| -> Option<&'s mut [f32]> {
            let (taken, left) = core::mem::take(&mut rest).split_at_mut_checked(count)?;
            rest = left;
            Some(taken)
        };
        let virtual_states = match model.input {
            Input::VirtualStates(spec) => Some(VirtualStates::new(spec, take(spec.memory_len())?)?),
            Input::Direct(_) => None,
        };
        let mut reciprocals_of = |values: Floats<'_>| -> Option<&'s [f32]> {
            let taken = take(inputs)?;
            taken.iter_mut().zip(values.iter()).for_each(|(to, value)| *to = 1.0 / value);
            Some(taken)
        };
        let reciprocals = Reciprocals {
            states: reciprocals_of(model.states.scale)?,
            derivatives: reciprocals_of(model.derivatives.scale)?,
            residual_spread: reciprocals_of(model.residual_spread)?,
        };
        let variables = take(FACTORS)?.first_chunk_mut()?;
        *variables = [1.0; FACTORS];
        Some(Self {
            model,
            reciprocals,
            virtual_states,
            states: take(inputs)?,
            derivatives: take(inputs)?,
            scaled: take(inputs)?,
            latent: variables,
            latent_rate: take(latent)?,
            predicted: take(inputs)?,
            awaited: take(inputs)?,
            hidden: take(hidden_len(model))?,
            awaiting: false,
            next_sample: None,
        })
    }

    /// Model that is evaluated.
    pub fn model(&self) -> &'a Model<'a> {
        self.model
    }

    /// Resets the states: the next sample does not continue the last.
    pub fn reset(&mut self) {
        if let Some(states) = &mut self.virtual_states {
            states.reset();
        }
        self.awaiting = false;
        self.next_sample = None;
    }

    /// One step with a sample of the acceleration, m/s². `None` while the differences fill, and for a model whose
    /// states are given directly. The sample must be finite ([`crate::input_check`] ensures it).
    pub fn step(&mut self, sample: f32) -> Option<Step<'_>> {
        let streaming = self.virtual_states.as_mut()?;
        if !streaming.push(sample, self.states, self.derivatives) {
            self.awaiting = false;
            return None;
        }
        let Input::VirtualStates(spec) = self.model.input else { return None };
        let causal = spec.alignment == Alignment::Causal;
        if causal {
            // Evaluated once per sample, at the newest states; the derivatives measured now belong to the prediction of
            // the last step.
            streaming.present(self.states);
            core::mem::swap(&mut self.awaited, &mut self.predicted);
        }
        self.scale_derivatives();
        self.evaluate();
        let comparable = !causal || self.awaiting;
        self.awaiting = true;
        if causal {
            self.next_sample = self.predict_sample(sample);
        }
        Some(self.result(if causal { Compare::Awaited } else { Compare::Predicted }, comparable))
    }

    /// One step with given states and measured derivatives, both in physical units. Missing values
    /// are 0.
    pub fn step_with(&mut self, states: &[f32], derivatives: &[f32]) -> Step<'_> {
        let fill = |to: &mut [f32], from: &[f32]| {
            to.iter_mut().enumerate().for_each(|(i, to)| *to = from.get(i).copied().unwrap_or(0.0));
        };
        fill(self.states, states);
        fill(self.derivatives, derivatives);
        self.scale_derivatives();
        self.evaluate();
        self.result(Compare::Predicted, true)
    }

    fn result(&self, compare: Compare, comparable: bool) -> Step<'_> {
        Step {
            states: self.states,
            latent: self.latent.get(..self.model.latent()).unwrap_or(&[]),
            latent_rate: self.latent_rate,
            predicted: self.predicted,
            measured: self.derivatives,
            expected: match compare {
                Compare::Predicted => self.predicted,
                Compare::Awaited => self.awaited,
            },
            comparable,
            next_sample: self.next_sample,
            spread_reciprocals: self.reciprocals.residual_spread,
        }
    }

    fn scale_derivatives(&mut self) {
        let mean = self.model.derivatives.mean;
        for ((d, mean), reciprocal) in self.derivatives.iter_mut().zip(mean.iter()).zip(self.reciprocals.derivatives) {
            *d = (*d - mean) * reciprocal;
        }
    }

    /// Evaluates `states` → `latent`, `latent_rate`, `predicted`.
    fn evaluate(&mut self) {
        let parameters = self.model.states.mean.iter().zip(self.reciprocals.states);
        for ((to, from), (mean, reciprocal)) in self.scaled.iter_mut().zip(&*self.states).zip(parameters) {
            *to = (from - mean) * reciprocal;
        }
        let count = self.model.latent();
        self.model.encoder.forward(self.scaled, self.latent.get_mut(..count).unwrap_or(&mut []), self.hidden);
        self.model.dynamics.rate(self.latent, self.latent_rate);
        let latent = self.latent.get(..count).unwrap_or(&[]);
        self.model.decoder.tangent(latent, self.latent_rate, self.predicted, self.hidden);
    }

    /// Predicted sample a\[t+1\] = a\[t\] + ∇a\[t+1\], theory (23); ∇a is the first derivative of a causal model.
    fn predict_sample(&self, sample: f32) -> Option<f32> {
        let scaling = &self.model.derivatives;
        let increment = self.predicted.first()? * scaling.scale.get(0)? + scaling.mean.get(0)?;
        Some(sample + increment)
    }
}

enum Compare {
    Predicted,
    Awaited,
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::states::{Estimator, Orders, StateSpec};
    use crate::testing::{Parts, samples};
    use std::vec::Vec;

    #[test]
    fn given_states_evaluate_to_the_bits_of_streamed_ones() {
        let spec = StateSpec {
            dimension: 3,
            orders: Orders::Even,
            alignment: Alignment::Half,
            estimator: Estimator::Differences,
        };
        let (streamed, mut given) = (Parts::new(spec), Parts::new(spec));
        given.direct = true;
        let (streamed, given) = (streamed.model(), given.model());
        let (mut a, mut b) = (std::vec![0.0; scratch_len(&streamed)], std::vec![0.0; scratch_len(&given)]);
        assert!(b.len() < a.len(), "no memory of virtual states");
        let mut stream = Evaluator::new(&streamed, &mut a).unwrap();
        let mut direct = Evaluator::new(&given, &mut b).unwrap();
        assert!(direct.step(1.0).is_none(), "samples mean nothing to it");
        let mut compared = 0;
        for sample in samples(40) {
            let Some(step) = stream.step(sample) else { continue };
            let scaling = streamed.derivatives;
            let physical: Vec<f32> = step
                .measured
                .iter()
                .zip(scaling.mean.iter().zip(scaling.scale.iter()))
                .map(|(m, (mean, scale))| m * scale + mean)
                .collect();
            let again = direct.step_with(step.states, &physical);
            assert_eq!(
                (step.latent, step.latent_rate, step.predicted),
                (again.latent, again.latent_rate, again.predicted)
            );
            assert!(step.residuals().zip(again.residuals()).all(|(r, s)| (r - s).abs() < 1e-4));
            compared += 1;
        }
        assert!(compared > 30);
    }
}
