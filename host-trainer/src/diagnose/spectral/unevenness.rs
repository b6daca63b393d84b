//! Lines of a machine whose balls are unevenly spaced, by simulation of some draws.

use std::sync::OnceLock;

use super::likelihood::spacing_shares;
use super::observation::{Observation, Power, power};
use super::prediction::{Known, noise_free, noises_of};
use super::settings::LikelihoodSettings;
use crate::identify::likelihood::observed::CHANNELS;
use crate::recording::Recording;
use crate::rig::effect::EffectKind;
use crate::rig::simulate::simulate_all;
use crate::rig::{Rig, RigError, Run, Start};
use crate::signal::kinematics::Orders;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Lines of a recording of a rig with evenly and with unevenly spaced balls.
#[derive(Clone, Debug)]
pub struct Unevenness {
    /// Power of the lines with even balls.
    pub even: Power,
    /// Power that uneven balls add, over the share of a line's power that they take.
    pub added: Power,
}

/// Unevenness of the recordings of a rig, and of the rig with another rotation.
#[derive(Debug, Default)]
pub struct UnevenMachines {
    nominal: Vec<Unevenness>,
    turned: OnceLock<Vec<Unevenness>>,
}

impl UnevenMachines {
    /// Unevenness of recordings of a rig.
    ///
    /// # Errors
    /// As [`unevenness`].
    pub fn new(rig: &Rig, observations: &[Observation], orders: &Orders) -> Result<Self, RigError> {
        let made = unevenness(rig, observations, orders)?;
        Ok(match turns_otherwise(rig) {
            true => Self { nominal: Vec::new(), turned: OnceLock::from(made) },
            false => Self { nominal: made, turned: OnceLock::new() },
        })
    }

    /// Adds the unevenness of the rig with the first effect that changes its rotation; later ones are left out.
    ///
    /// # Errors
    /// As [`unevenness`].
    pub fn turn(&self, rig: &Rig, observations: &[Observation], orders: &Orders) -> Result<(), RigError> {
        if self.turned.get().is_none() {
            let made = unevenness(rig, observations, orders)?;
            self.turned.get_or_init(|| made);
        }
        Ok(())
    }

    /// Unevenness of a recording of a rig, by whether an effect changes its rotation; `None` if it is not known.
    pub fn of(&self, rig: &Rig, recording: usize) -> Option<&Unevenness> {
        let all = if turns_otherwise(rig) { self.turned.get()? } else { &self.nominal };
        all.get(recording)
    }
}

/// Whether an effect changes the rotation of shaft or cage.
pub fn turns_otherwise(rig: &Rig) -> bool {
    rig.effects.iter().any(|effect| matches!(effect.kind, EffectKind::SpeedDrift | EffectKind::CageSlip))
}

/// Unevenness of each recording of a rig.
///
/// # Errors
/// What the simulation refuses, or a run that diverges.
fn unevenness(rig: &Rig, observations: &[Observation], orders: &Orders) -> Result<Vec<Unevenness>, RigError> {
    // One rig in, one result out.
    let noises = noises_of(&[(&Known::Nothing, rig)], observations).swap_remove(0)?;
    let mut runs = Vec::new();
    for (o, noise) in observations.iter().zip(noises) {
        let even = noise_free(rig, o, noise.scatter);
        let draw = |seed: u64| Start { seed, ball_std_rad: SETTINGS.drawn_spacing_rad, ..even };
        let starts = std::iter::once(even).chain((0..SETTINGS.drawn_machines).map(draw));
        runs.extend(starts.map(|start| Run { rig, condition: o.condition, start }));
    }
    let made = simulate_all(&runs)?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let each = made.chunks(1 + SETTINGS.drawn_machines as usize).zip(observations);
    let of = |(made, o): (&[Recording], &Observation)| {
        let shares = spacing_shares(o, SETTINGS.drawn_spacing_rad, orders.ftf);
        Unevenness::new(&made[0], &made[1..], &shares)
    };
    Ok(each.map(of).collect())
}

impl Unevenness {
    /// Unevenness by a run with even balls and runs with uneven ones, which take `shares` of a line's power at each bin.
    fn new(even: &Recording, uneven: &[Recording], shares: &[f64]) -> Self {
        let samples = |recording: &Recording, channel: usize| {
            recording.channel(CHANNELS[channel]).map_or_else(Vec::new, |c| c.samples.clone())
        };
        let added = |channel: usize| {
            let still = samples(even, channel);
            let mut sum = vec![0.0; still.len() / 2 + 1];
            for moved in uneven {
                let moved = samples(moved, channel);
                let difference: Vec<f64> = moved.iter().zip(&still).map(|(m, s)| m - s).collect();
                sum.iter_mut().zip(power(&difference)).for_each(|(sum, p)| *sum += p / uneven.len() as f64);
            }
            let per_share =
                |(k, (power, share)): (usize, (f64, &f64))| if k < SETTINGS.first_bin { 0.0 } else { power / share };
            sum.into_iter().zip(shares).enumerate().map(per_share).collect()
        };
        Self { even: [0, 1].map(|c| power(&samples(even, c))), added: [0, 1].map(added) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::simulate;
    use crate::rig::test_support::{condition, nominal};

    /// A machine with twice the drawn spread has about four times the drawn power.
    #[test]
    fn invariant_what_uneven_balls_add_grows_with_the_square_of_their_spread() {
        let rig = nominal();
        let run = |ball_std_rad: f64| {
            let start = Start { ball_std_rad, seed: 77, ..Start::noise_free(0.4, 1.1) };
            simulate(&rig, &condition(30.0, 500.0, 12_800), &start).unwrap()
        };
        let even = run(0.0);
        let observation = Observation::new(&Observed::from_recording(&even).unwrap());
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let shares = spacing_shares(&observation, SETTINGS.drawn_spacing_rad, orders.ftf);
        let drawn = unevenness(&rig, std::slice::from_ref(&observation), &orders).unwrap().remove(0);
        let other = Unevenness::new(&even, &[run(2.0 * SETTINGS.drawn_spacing_rad)], &shares);
        for channel in 0..2 {
            let sum = |of: &Unevenness| of.added[channel].iter().zip(&shares).map(|(a, share)| a * share).sum::<f64>();
            let ratio = sum(&other) / sum(&drawn);
            assert!((1.5..10.0).contains(&ratio), "{channel}: {ratio}");
        }
    }
}
