//! Recordings of the healthy machine: calibration of the nominal rig, and what is no change since.

use super::candidate::Candidate;
use super::data::{Data, Point};
use super::fit::Model;
use super::observation::{Observation, duration_s};
use super::selection::refit_nuisances;
use super::settings::{FitSettings, GateSettings};
use super::unevenness::UnevenMachines;
use crate::diagnose::DiagnoseError;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::Observed;
use crate::recording::Recording;
use crate::rig::config::ModelKey;
use crate::rig::{Rig, RigError};

const GATE: GateSettings = GateSettings::DEFAULT;
const FIT: FitSettings = FitSettings::DEFAULT;

/// Rig whose numbers at `keys` are fitted to recordings of the healthy machine, by the likelihood with which these are compared
/// with others; `rig` is where the search starts.
///
/// # Errors
/// Recordings without acceleration or speed; a rig that cannot run.
pub fn calibrated(rig: &Rig, keys: &[ModelKey], recordings: &[Recording]) -> Result<Rig, DiagnoseError> {
    let machine = rig.bearing().ok_or(DiagnoseError::NotBearing { found: rig.model.kind().name() })?;
    let orders = machine.bearing.geometry().orders();
    let observations: Vec<Observation> = Observed::from_recordings(recordings)?.iter().map(Observation::new).collect();
    let data = Data::new(&observations, orders, UnevenMachines::new(rig, &observations, &orders)?);
    let coordinates: Vec<Coordinate> = keys.iter().filter_map(|key| Coordinate::for_key(rig, *key)).collect();
    let model = Model::of_unknown(&data, rig, coordinates);
    let point = model.search(model.start()?, FIT.nominal_steps)?;
    // What the baseline leaves uncertain must not follow the recordings to diagnose: a change is against the baseline.
    let mut rig = model.rig_at(&point.values)?;
    rig.unknown.clear();
    Ok(rig)
}

/// Recordings of the healthy machine, to which the nominal rig is calibrated.
pub struct Baseline<'d, 'a> {
    data: &'d Data<'a>,
    /// −ln of likelihood and prior of the nominal rig.
    null: f64,
}

impl<'d, 'a> Baseline<'d, 'a> {
    /// Baseline with the nominal rig, of which only the nuisances are fitted.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn new(data: &'d Data<'a>, nominal: &Model, null: &Point) -> Result<Self, RigError> {
        Ok(Self { data, null: refit_nuisances(data, nominal, null)?.objective() })
    }

    /// Whether a candidate fits the baseline nearly as well as no effect does, so that it corrects the calibration and is no
    /// change since: an effect that is new would cost there what it gains now.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn shows(&mut self, candidate: &Candidate) -> Result<bool, RigError> {
        let now = refit_nuisances(self.data, &candidate.model, &candidate.point)?.objective();
        let share = duration_s(self.data.observations) / duration_s(candidate.model.data.observations);
        let shows = now - self.null < GATE.baseline_nats + GATE.baseline_share * share * candidate.gain;
        if shows {
            self.null = now;
        }
        Ok(shows)
    }
}
