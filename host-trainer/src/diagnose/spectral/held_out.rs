//! Held-out recordings, and simulations of them before and after the correction.

use super::colour::{Colour, hats};
use super::data::Point;
use super::events::Event;
use super::imperfect::Imperfections;
use super::mains::Mains;
use super::observation::{Observation, samples};
use super::prediction::{Known, START_ANGLES_RAD, predictions};
use super::unevenness::UnevenMachines;
use crate::diagnose::acquisition::Acquired;
use crate::diagnose::result::HeldOut;
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::{Rig, RigError, Run, Start, simulate_many};
use crate::signal::kinematics::Orders;
use crate::signal::transform::{forward, inverse_plan};

/// A recording that is simulated with what the last fit found there beside the rig.
struct Synthesis<'s> {
    observation: &'s Observation,
    orders: &'s Orders,
    colour: Colour,
    imperfections: Imperfections,
    start: Start,
}

impl Synthesis<'_> {
    /// Samples of both channels of a run of a rig, whose random part has the colours of the noise: as in the likelihood, its lines
    /// have none. Nor is the random part delayed as the lines are.
    ///
    /// # Errors
    /// What the simulation refuses.
    fn samples(&self, rig: &Rig) -> Result<[Vec<f64>; 2], RigError> {
        // One rig and one recording in, one result out.
        let prediction = predictions(
            &[(&Known::Nothing, rig)],
            std::slice::from_ref(self.observation),
            self.orders,
            &UnevenMachines::default(),
        )
        .swap_remove(0)?
        .swap_remove(0);
        let start = self.imperfections.start(self.start);
        let quiet = Start { noise: false, velocity_covariance: Some(prediction.scatter), ..start };
        let condition = self.imperfections.condition(rig, self.observation.condition);
        let rig = &self.imperfections.rig(rig);
        let runs = simulate_many(&[start, quiet].map(|start| Run { rig, condition, start }))?;
        let hats = hats(self.observation);
        Ok([0, 1].map(|channel| {
            let [noisy, lines] = [0, 1].map(|run| samples(&runs[run], channel));
            let random = noisy.iter().zip(lines).map(|(noisy, line)| noisy - line).collect();
            let each = hats.iter().enumerate();
            let gains = each.map(|(k, hat)| prediction.colouring(&self.colour, channel, *hat, k).sqrt());
            let mut out = filtered(random, &gains.collect::<Vec<_>>());
            let lines = self.imperfections.delayed(lines, &condition, self.orders);
            out.iter_mut().zip(lines).for_each(|(out, line)| *out += line);
            out
        }))
    }
}

/// What happened on the way from sensor to file, and what happened once.
pub struct Disturbed<'s> {
    /// Faults of sensors.
    pub acquired: &'s Acquired,
    /// Electrical line.
    pub mains: Option<&'s Mains>,
    /// Event.
    pub event: Option<&'s Event>,
    /// Index of the first held-out recording among all.
    pub first: usize,
}

/// Rigs before and after the correction, and the last fit to the held-out recordings: both are simulated with its colours and
/// imperfections, so that they differ by the causes alone.
pub struct Compared<'s> {
    /// Rig as it was given, calibrated.
    pub before: &'s Rig,
    /// Rig with the causes.
    pub after: &'s Rig,
    /// Fit of what the held-out recordings have of their own.
    pub machine: &'s Point,
}

/// Held-out recordings, which still have the electrical line, with simulations before and after the correction. Size and phase of
/// the line are those of the recording.
///
/// # Errors
/// What the simulation refuses.
pub fn held_out(
    held: &[Observation],
    compared: &Compared,
    disturbed: &Disturbed,
    orders: &Orders,
    seed: u64,
) -> Result<Vec<HeldOut>, RigError> {
    let [cage_angle0_rad, shaft_angle0_rad] = START_ANGLES_RAD;
    let mut out = Vec::new();
    for (n, o) in held.iter().enumerate() {
        let corrected = match disturbed.event.and_then(|e| e.effect_in(disturbed.first + n)) {
            Some(effect) => compared.after.clone().with_effect(effect),
            None => compared.after.clone(),
        };
        let synthesis = Synthesis {
            observation: o,
            orders,
            colour: compared.machine.colour_in(n),
            imperfections: Imperfections::of(compared.machine, n, seed),
            start: Start { cage_angle0_rad, shaft_angle0_rad, ..Start::of_series(seed, n) },
        };
        let [before, after] = [synthesis.samples(compared.before)?, synthesis.samples(&corrected)?];
        for (channel, measured) in o.samples.iter().enumerate() {
            let Some(measured) = measured else { continue };
            let mut after = after[channel].clone();
            if let Some(mains) = disturbed.mains.filter(|mains| mains.is_in[disturbed.first + n]) {
                after.iter_mut().zip(mains.series(measured, o)).for_each(|(v, line)| *v += line);
            }
            out.push(HeldOut {
                name: HeldOut::name_of(&o.name, CHANNELS[channel]),
                sample_rate_hz: o.condition.sample_rate_hz,
                measured: disturbed.acquired.as_recorded(&o.name, channel, measured),
                before: before[channel].clone(),
                after: disturbed.acquired.as_recorded(&o.name, channel, &after),
            });
        }
    }
    Ok(out)
}

/// Samples with a gain at each frequency.
fn filtered(mut samples: Vec<f64>, gains: &[f64]) -> Vec<f64> {
    let n = samples.len();
    if n == 0 {
        return samples;
    }
    let mut bins = forward(&mut samples);
    bins.iter_mut().zip(gains).for_each(|(bin, gain)| *bin *= gain / n as f64);
    let inverse = inverse_plan(n);
    let mut out = inverse.make_output_vec();
    bins[0].im = 0.0;
    if let Some(last) = bins.last_mut().filter(|_| n.is_multiple_of(2)) {
        last.im = 0.0;
    }
    inverse.process(&mut bins, &mut out).unwrap_or_default();
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::colour::KNOTS;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, simulate};

    /// Noise of twice the size stands on the lines of a pit as they were.
    #[test]
    fn invariant_a_colour_of_the_noise_is_none_of_the_lines() {
        let pit = [(ParameterKey::DepthM, 1e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.5)];
        let rig = nominal().with_effect(EffectEntry::new(EffectKind::OuterRaceDefect, &pit));
        let (condition, start) = (condition(30.0, 500.0, 4096), Start::seeded(7));
        let run = simulate(&rig, &condition, &start).unwrap();
        let observation = Observation::new(&Observed::from_recording(&run).unwrap());
        let twice = 4f64.ln();
        let synthesis = Synthesis {
            observation: &observation,
            orders: &rig.bearing().unwrap().bearing.geometry().orders(),
            colour: [[twice; KNOTS], [twice; KNOTS], [0.0; KNOTS]],
            imperfections: Imperfections::of(&Point::default().in_recordings(1, 0), 0, 3),
            start,
        };
        let loud = synthesis.samples(&rig).unwrap();
        let lines = simulate(&rig, &condition, &Start { noise: false, ..start }).unwrap();
        for (channel, loud) in loud.iter().enumerate() {
            let both = samples(&run, channel).iter().zip(samples(&lines, channel));
            for (loud, (noisy, line)) in loud.iter().zip(both) {
                assert!((loud - (line + 2.0 * (noisy - line))).abs() < 1e-9, "{loud} {noisy} {line}");
            }
        }
    }
}
