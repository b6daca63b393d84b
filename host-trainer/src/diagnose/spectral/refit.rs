//! A fitted model on other recordings.

use super::data::{Data, Point};
use super::fit::Model;
use super::settings::FitSettings;
use crate::rig::RigError;

const FIT: FitSettings = FitSettings::DEFAULT;

/// Fitted model on other recordings, to which all of it is fitted again.
///
/// # Errors
/// What the simulation refuses.
pub fn refit(data: &Data, model: &Model, point: &Point) -> Result<Point, RigError> {
    let other = Model::new(data, model.rig_at(&point.values)?, &model.coordinates, &model.guesses);
    other.search(other.start_from(&nuisances_from(data, point))?, FIT.held_out_steps)
}

/// Fitted model on other recordings, of which only the nuisances are fitted.
///
/// # Errors
/// What the simulation refuses.
pub fn refit_nuisances(data: &Data, model: &Model, point: &Point) -> Result<Point, RigError> {
    let other = Model::fixed(data, model.rig_at(&point.values)?);
    other.search(other.start_from(&nuisances_from(data, point))?, FIT.held_out_steps)
}

/// −ln of likelihood and prior of a fitted model on other recordings, of which only the nuisances are fitted; infinite if the rig
/// cannot run under their conditions, as it does not explain them.
pub fn objective_of(data: &Data, model: &Model, point: &Point) -> f64 {
    refit_nuisances(data, model, point).map_or(f64::INFINITY, |point| point.objective())
}

/// Nuisances of a machine as a start for other recordings of it.
fn nuisances_from(data: &Data, point: &Point) -> Point {
    let jitter = point.jitter.iter().copied().max().unwrap_or(0);
    Point { values: Vec::new(), ..point.clone() }.in_recordings(data.observations.len(), jitter)
}
