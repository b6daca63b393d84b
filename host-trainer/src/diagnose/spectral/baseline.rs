//! Recordings of the healthy machine: calibration of the nominal rig, and what is no change since.

use super::candidate::Candidate;
use super::data::{Data, Point};
use super::fit::Model;
use super::observation::{Observation, duration_s};
use super::refit::{objective_of, refit_nuisances};
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
    pub fn shows(&mut self, candidate: &Candidate) -> bool {
        let now = objective_of(self.data, &candidate.model, &candidate.point);
        let share = duration_s(self.data.observations) / duration_s(candidate.model.data.observations);
        let shows = now - self.null < GATE.baseline_nats + GATE.baseline_share * share * candidate.gain;
        if shows {
            self.null = now;
        }
        shows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::candidate::NullFit;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    /// A spring that softens beyond its range under the baseline's load is no error that ends the diagnosis.
    #[test]
    fn null_a_rig_that_cannot_run_under_the_load_of_the_baseline_is_not_in_it() {
        let rig = nominal();
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let observed = |load_n: f64| {
            let run = simulate(&rig, &condition(30.0, load_n, 8192), &Start::seeded(3)).unwrap();
            [Observation::new(&Observed::from_recording(&run).unwrap())]
        };
        let (light, heavy) = (observed(200.0), observed(2000.0));
        let [data, healthy] =
            [&light, &heavy].map(|observations| Data::new(observations, orders, UnevenMachines::default()));
        let model = Model::fixed(&data, rig.clone());
        let point = model.start().unwrap();
        let mut baseline = Baseline::new(&healthy, &model, &point).unwrap();
        let null = NullFit::new(&model, &point);
        let hypotheses = null.hypotheses();
        let softening = hypotheses.iter().find(|h| h.kind == EffectKind::SofteningStiffness).unwrap();
        let soft = softening.starts[0].clone().with_number(ParameterKey::CubicNPerM3, -1e15);
        let candidate = null.started(softening, &[soft]).swap_remove(0);
        assert!(!baseline.shows(&Candidate { gain: 1e6, ..candidate }));
    }
}
