//! Held-out recordings, and simulations of them before and after the correction.

use super::data::Point;
use super::events::Event;
use super::likelihood::{Colour, KNOTS, colour_at, hats};
use super::observation::Observation;
use super::prediction::START_ANGLES_RAD;
use crate::diagnose::result::HeldOut;
use crate::identify::likelihood::observed::CHANNELS;
use crate::recording::Recording;
use crate::rig::{Rig, RigError, Run, Start, simulate_many};
use crate::signal::transform::{forward, inverse_plan};

/// Rig with the colour of the noise that was fitted with it.
pub struct Synthesis<'s> {
    /// Rig.
    pub rig: Rig,
    /// Colour of the noise.
    pub colour: &'s Colour,
}

impl Synthesis<'_> {
    /// Rig of a fit at a point.
    ///
    /// # Errors
    /// Values that the rig refuses.
    pub fn new<'s>(model: &super::fit::Model, point: &'s Point) -> Result<Synthesis<'s>, RigError> {
        Ok(Synthesis { rig: model.rig_at(&point.values)?, colour: &point.colour })
    }

    /// Samples of a channel of a run, with the colour of its noise.
    fn samples(&self, run: &Recording, channel: usize, observation: &Observation) -> Vec<f64> {
        let samples = run.channel(CHANNELS[channel]).map_or_else(Vec::new, |c| c.samples.clone());
        coloured(samples, &hats(observation), &self.colour[channel])
    }
}

/// Held-out recordings with simulations before and after the correction; `events` are the event in all recordings and the
/// index of the first held-out one among them.
///
/// # Errors
/// What the simulation refuses.
pub fn held_out(
    held: &[Observation],
    before: &Synthesis,
    after: &Synthesis,
    (event, first): (Option<&Event>, usize),
    seed: u64,
) -> Result<Vec<HeldOut>, RigError> {
    let [cage_angle0_rad, shaft_angle0_rad] = START_ANGLES_RAD;
    let mut out = Vec::new();
    for (n, o) in held.iter().enumerate() {
        let corrected = match event.and_then(|e| e.effect_in(first + n)) {
            Some(effect) => after.rig.clone().with_effect(effect),
            None => after.rig.clone(),
        };
        let start = Start { cage_angle0_rad, shaft_angle0_rad, ..Start::of_series(seed, n) };
        let run = |rig| Run { rig, condition: o.condition, start };
        let runs = simulate_many(&[run(&before.rig), run(&corrected)])?;
        for (channel, measured) in o.samples.iter().enumerate() {
            let Some(measured) = measured else { continue };
            out.push(HeldOut {
                name: format!("{}-{}", o.name, CHANNELS[channel]),
                sample_rate_hz: o.condition.sample_rate_hz,
                measured: measured.clone(),
                before: before.samples(&runs[0], channel, o),
                after: after.samples(&runs[1], channel, o),
            });
        }
    }
    Ok(out)
}

/// Samples with the colour of a channel's noise.
fn coloured(mut samples: Vec<f64>, hats: &[(usize, f64)], colour: &[f64; KNOTS]) -> Vec<f64> {
    let n = samples.len();
    if n == 0 {
        return samples;
    }
    let mut bins = forward(&mut samples);
    for (bin, hat) in bins.iter_mut().zip(hats) {
        *bin *= (0.5 * colour_at(colour, *hat)).exp() / n as f64;
    }
    let inverse = inverse_plan(n);
    let mut out = inverse.make_output_vec();
    bins[0].im = 0.0;
    if let Some(last) = bins.last_mut().filter(|_| n.is_multiple_of(2)) {
        last.im = 0.0;
    }
    inverse.process(&mut bins, &mut out).unwrap_or_default();
    out
}
