//! Effects of one recording in the others: a fault that grows has numbers of its own in each.

use rayon::prelude::*;

use super::data::Data;
use super::fit::Model;
use super::lack::{Lack, lack};
use super::observation::Observation;
use super::settings::{FitSettings, GateSettings};
use super::unevenness::UnevenMachines;
use crate::identify::likelihood::coordinate::{Coordinate, Scale};
use crate::rig::config::RigKey;
use crate::rig::{Rig, RigError};
use crate::signal::kinematics::Orders;
use crate::stats::units::in_words;

const GATE: GateSettings = GateSettings::DEFAULT;
const FIT: FitSettings = FitSettings::DEFAULT;

/// Lasting effects that were found, with the numbers that are fitted.
pub struct Lasting {
    /// Rig with the effects.
    rig: Rig,
    coordinates: Vec<Coordinate>,
    /// As in a [`Model`].
    guesses: Vec<f64>,
}

impl Lasting {
    /// Effects of a fitted model, whose rig they are in at the fit.
    pub fn of(model: &Model, rig: Rig) -> Self {
        Self { rig, coordinates: model.coordinates.clone(), guesses: model.guesses.clone() }
    }

    /// Lack of fit of other recordings, to which the numbers are fitted anew, and each effect with these in words.
    ///
    /// # Errors
    /// What the simulation refuses.
    fn refitted(&self, data: &Data) -> Result<(Lack, Vec<String>), RigError> {
        let mut model = Model::new(data, self.rig.clone(), &self.coordinates, &self.guesses);
        let mut point = model.start()?;
        // A search does not come down from lines that are far too strong.
        let is_size = |c: &&Coordinate| matches!((c.key, c.scale), (RigKey::Effect { .. }, Scale::Log { .. }));
        for c in self.coordinates.iter().filter(is_size) {
            let value = model.rig.get(c.key).unwrap_or_default();
            for share in GATE.refitted_sizes {
                let mut rig = model.rig.clone();
                let started = rig.set(c.key, share * value).and_then(|()| {
                    let smaller = Model::new(data, rig, &self.coordinates, &self.guesses);
                    Ok((smaller.start()?, smaller))
                });
                match started {
                    Ok((start, smaller)) if start.objective() < point.objective() => (point, model) = (start, smaller),
                    _ => {}
                }
            }
        }
        let point = model.search(point, FIT.nominal_steps)?;
        let rig = model.rig_at(&point.values)?;
        let words = |index: usize| {
            let own = |c: &Coordinate| match c.key {
                RigKey::Effect { index: of, key } if of == index => Some(in_words(key.name(), rig.get(c.key)?, None)),
                _ => None,
            };
            let numbers: Vec<String> = model.coordinates.iter().filter_map(own).collect();
            (!numbers.is_empty()).then(|| format!("{} ({})", rig.effects[index].kind, numbers.join(", ")))
        };
        Ok((lack(data, &point), (0..rig.effects.len()).filter_map(words).collect()))
    }
}

/// Effects of one recording, fitted to others.
pub struct Refitted {
    /// Share of the others' lack of fit that they leave.
    pub left: f64,
    /// Each recording with the effects and their numbers, in words.
    pub said: Vec<String>,
}

impl Refitted {
    /// Effects fitted to each of some recordings by itself, whose lack of fit without them is given. Those that cannot be there leave
    /// all of it.
    ///
    /// # Errors
    /// What the simulation of the rig refuses.
    pub fn of(lasting: &Lasting, rig: &Rig, others: &[(&Observation, f64)], orders: Orders) -> Result<Self, RigError> {
        let of = |(observation, before): &(&Observation, f64)| {
            let one = std::slice::from_ref(*observation);
            let data = Data::new(one, orders, UnevenMachines::new(rig, one, &orders)?);
            let (left, effects) = match lasting.refitted(&data) {
                Ok((lack, effects)) => (lack.total().min(*before), effects),
                Err(_) => (*before, Vec::new()),
            };
            Ok((left, format!("{} with {}", observation.name, effects.join(" and "))))
        };
        let each = others.par_iter().map(of).collect::<Result<Vec<_>, RigError>>()?;
        let before: f64 = others.iter().map(|(_, before)| before).sum();
        let left = each.iter().map(|(left, _)| left).sum::<f64>() / before.max(1.0);
        Ok(Self { left, said: each.into_iter().map(|(_, said)| said).collect() })
    }
}
