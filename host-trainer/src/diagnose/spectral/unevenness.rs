//! Lines of a machine whose balls are uneven in place or diameter, or whose races are out of round, by simulation of some draws.

use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

use super::likelihood::spacing_shares;
use super::observation::{Observation, Power, power, samples};
use super::prediction::{Known, Skirts, noise_free, noises_of, skirts};
use super::settings::{FORMS, LikelihoodSettings};
use crate::recording::Recording;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::simulate::simulate_all;
use crate::rig::{EffectEntry, Rig, RigError, Run, Start};
use crate::signal::kinematics::Orders;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Lines of a recording of a rig as it is drawn, and what uneven balls and races add.
#[derive(Clone, Debug)]
pub struct Unevenness {
    /// Power of the lines with even balls.
    pub even: Power,
    /// Power that unevenly spaced balls add, over the share of a line's power that they take.
    pub added: Power,
    /// Power that each error of form adds.
    pub formed: Formed,
}

/// Power that each error of form adds, and the same spread as a rotation wanders.
pub type Formed = Arc<[(Power, Skirts); FORMS]>;

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
    rig.effects.iter().any(|effect| turns(effect.kind))
}

/// Whether an effect is another rotation of shaft or cage.
pub fn turns(kind: EffectKind) -> bool {
    matches!(kind, EffectKind::SpeedDrift | EffectKind::CageSlip)
}

/// Unevenness of each recording of a rig.
///
/// # Errors
/// What the simulation refuses, or a run that diverges.
fn unevenness(rig: &Rig, observations: &[Observation], orders: &Orders) -> Result<Vec<Unevenness>, RigError> {
    // One rig in, one result out.
    let noises = noises_of(&[(&Known::Nothing, rig)], observations).swap_remove(0)?;
    let (seeds, [ball_std_m, roundness_m]) = (0..SETTINGS.drawn_machines, SETTINGS.drawn_form_m);
    let rounds: Vec<Rig> = seeds.clone().map(|seed| with_roundness(rig, roundness_m, seed)).collect();
    let mut runs = Vec::new();
    for (o, noise) in observations.iter().zip(noises) {
        let even = noise_free(rig, o, noise.scatter);
        let spaced = |seed| Start { seed, ball_std_rad: SETTINGS.drawn_spacing_rad, ..even };
        let sized = |seed| Start { seed, ball_std_m, ..even };
        let of_rig = [even].into_iter().chain(seeds.clone().map(spaced)).chain(seeds.clone().map(sized));
        runs.extend(of_rig.map(|start| Run { rig, condition: o.condition, start }));
        runs.extend(rounds.iter().map(|rig| Run { rig, condition: o.condition, start: even }));
    }
    let made = simulate_all(&runs)?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let machines = SETTINGS.drawn_machines as usize;
    let each = made.chunks(1 + (1 + FORMS) * machines).zip(observations);
    let of = |(made, o): (&[Recording], &Observation)| {
        let (even, drawn) = (Spectra::new(&made[0]), made[1..].chunks(machines).collect::<Vec<_>>());
        let shares = spacing_shares(o, SETTINGS.drawn_spacing_rad, orders.ftf);
        Unevenness {
            added: even.added_over(drawn[0], &shares),
            formed: Arc::new(std::array::from_fn(|form| {
                let added = even.added(drawn[1 + form]);
                let spread = skirts(&added, o);
                (added, spread)
            })),
            even: even.power,
        }
    };
    Ok(each.map(of).collect())
}

/// Rig whose races are out of round by an amplitude, of two or three lobes each.
pub fn with_roundness(rig: &Rig, amplitude_m: f64, seed: u64) -> Rig {
    let lobes = |race: u64| (2 + (seed + race) % 2) as f64;
    let phase = |race: u64| TAU * ((0.618 * (2 * seed + race) as f64) % 1.0);
    let race = |(kind, race): (EffectKind, u64)| {
        let values = [
            (ParameterKey::AmplitudeM, amplitude_m),
            (ParameterKey::Lobes, lobes(race)),
            (ParameterKey::PhaseRad, phase(race)),
        ];
        EffectEntry::new(kind, &values)
    };
    let races = [(EffectKind::OuterRaceWaviness, 0), (EffectKind::InnerRaceWaviness, 1)];
    races.map(race).into_iter().fold(rig.clone(), Rig::with_effect)
}

/// Signals of an even machine with their power.
struct Spectra {
    signals: [Vec<f64>; 2],
    power: Power,
}

impl Spectra {
    fn new(even: &Recording) -> Self {
        let signals = [0, 1].map(|channel| samples(even, channel).to_vec());
        Self { power: signals.each_ref().map(|signal| power(signal)), signals }
    }

    /// Mean power that machines have beyond the even one.
    fn added(&self, machines: &[Recording]) -> Power {
        [0, 1].map(|channel| {
            let still = &self.signals[channel];
            let mut sum = vec![0.0; still.len() / 2 + 1];
            for moved in machines {
                let moved = samples(moved, channel);
                let difference: Vec<f64> = moved.iter().zip(still).map(|(m, s)| m - s).collect();
                sum.iter_mut().zip(power(&difference)).for_each(|(sum, p)| *sum += p / machines.len() as f64);
            }
            sum.iter_mut().take(SETTINGS.first_bin).for_each(|power| *power = 0.0);
            sum
        })
    }

    /// The same over the `shares` of a line's power that they take at each bin.
    fn added_over(&self, machines: &[Recording], shares: &[f64]) -> Power {
        let mut added = self.added(machines);
        let counted = |power: &mut Vec<f64>| {
            let bins = power.iter_mut().zip(shares).skip(SETTINGS.first_bin);
            bins.for_each(|(power, share)| *power /= share);
        };
        added.iter_mut().for_each(counted);
        added
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
        let other = Spectra::new(&even).added_over(&[run(2.0 * SETTINGS.drawn_spacing_rad)], &shares);
        for channel in 0..2 {
            let sum = |of: &Power| of[channel].iter().zip(&shares).map(|(a, share)| a * share).sum::<f64>();
            let ratio = sum(&other) / sum(&drawn.added);
            assert!((1.5..10.0).contains(&ratio), "{channel}: {ratio}");
        }
    }

    /// What errors of form add grows with the square of their size, and has no share of a line.
    #[test]
    fn invariant_what_errors_of_form_add_grows_with_their_square() {
        let rig = nominal();
        let run = |rig: &Rig, ball_std_m: f64| {
            let start = Start { ball_std_m, seed: 3, ..Start::noise_free(0.4, 1.1) };
            simulate(rig, &condition(30.0, 500.0, 12_800), &start).unwrap()
        };
        let even = Spectra::new(&run(&rig, 0.0));
        let sum = |made: Recording| even.added(&[made]).iter().flatten().sum::<f64>();
        let [balls, races] = SETTINGS.drawn_form_m;
        let of_balls = |scale: f64| sum(run(&rig, scale * balls));
        let of_races = |scale: f64| sum(run(&with_roundness(&rig, scale * races, 3), 0.0));
        for ratio in [of_balls(1.0) / of_balls(0.5), of_races(1.0) / of_races(0.5)] {
            // Contacts that open take some of the 4.
            assert!((2.4..6.0).contains(&ratio), "{ratio}");
        }
    }
}
