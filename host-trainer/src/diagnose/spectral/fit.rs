//! Fit of a rig to power spectra: Fisher scoring of its numbers and of the noise's colour, theory (57); in turn with it the
//! stretch and the jitter of each recording, and the unevenness of the balls.

use std::cell::OnceCell;
use std::sync::Arc;

use rayon::prelude::*;

use super::data::{Data, Point};
use super::expansion::Expansion;
use super::prediction::{Known, Prediction, predictions};
use super::settings::{FitSettings, LikelihoodSettings};
use super::sidebands::Sidebands;
use super::stretch::Stretch;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::rig::effect::EffectKind;
use crate::rig::{Rig, RigError};
use crate::stats::optimise::{Damped, Decrease, damped_search};

const SETTINGS: FitSettings = FitSettings::DEFAULT;
const LIKELIHOOD: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Rig whose coordinates are fitted.
#[derive(Clone)]
pub struct Model<'d, 'a> {
    /// Recordings.
    pub data: &'d Data<'a>,
    /// Rig; its values at the coordinates are replaced.
    pub rig: Rig,
    /// Coordinates.
    pub coordinates: Vec<Coordinate>,
    /// Mean of the first coordinates, the unknown ones, before any recording.
    pub guesses: Vec<f64>,
    /// Predictions that are partly those of a nearby rig.
    pub known: Known,
}

impl<'d, 'a> Model<'d, 'a> {
    /// Model of a rig with coordinates and their guesses.
    pub fn new(data: &'d Data<'a>, rig: Rig, coordinates: &[Coordinate], guesses: &[f64]) -> Self {
        Self { data, rig, coordinates: coordinates.to_vec(), guesses: guesses.to_vec(), known: Known::Nothing }
    }

    /// Model of a rig without anything to fit but what each recording has of its own.
    pub fn fixed(data: &'d Data<'a>, rig: Rig) -> Self {
        Self::new(data, rig, &[], &[])
    }

    /// Model of a rig with unknown numbers, whose own values are guesses.
    pub fn of_unknown(data: &'d Data<'a>, rig: &Rig, coordinates: Vec<Coordinate>) -> Self {
        let mut model = Self { coordinates, ..Self::fixed(data, rig.clone()) };
        model.guesses = model.own_values();
        model
    }

    /// Rig at given values.
    ///
    /// # Errors
    /// A value out of the range of its key.
    pub fn rig_at(&self, values: &[f64]) -> Result<Rig, RigError> {
        let mut rig = self.rig.clone();
        self.coordinates.iter().zip(values).try_for_each(|(c, u)| c.put(&mut rig, *u))?;
        rig.check()?;
        Ok(rig)
    }

    /// Point of the rig's own values without any colour, stretch and jitter.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn start(&self) -> Result<Point, RigError> {
        let count = self.data.observations.len();
        let predictions = Arc::new(self.predictions(&self.own_rig()?)?);
        let nuisances = Point::default().in_recordings(count, 0);
        let mut point = Point { values: self.own_values(), predictions, ..nuisances };
        self.weigh(&mut point);
        self.fit_stretch(&mut point);
        Ok(point)
    }

    /// Point of the rig's own values with the better nuisances of those of `from` and of usual machines.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn start_from(&self, from: &Point) -> Result<Point, RigError> {
        Ok(self.started(from, self.predictions(&self.own_rig()?)?))
    }

    /// Points as by [`Model::start_from`] of models of the same recordings, all simulated side by side; `None` for a rig that
    /// cannot run.
    pub fn start_all(models: &[(Self, Point)]) -> Vec<Option<Point>> {
        let Some((first, _)) = models.first() else { return Vec::new() };
        let rigs: Vec<Option<Rig>> = models.iter().map(|(model, _)| model.own_rig().ok()).collect();
        let runs = models.iter().zip(&rigs).filter_map(|((model, _), rig)| Some((&model.known, rig.as_ref()?)));
        let made =
            predictions(&runs.collect::<Vec<_>>(), first.data.observations, &first.data.orders, &first.data.unevenness);
        let mut made = made.into_iter();
        let all: Vec<_> = models.iter().zip(rigs).map(|(model, rig)| (model, rig.and_then(|_| made.next()))).collect();
        all.into_par_iter().map(|((model, from), made)| Some(model.started(from, made?.ok()?))).collect()
    }

    /// Point of the rig's own values, with their predictions. What a fit without the effect counts as an imperfect machine may
    /// be the effect, so that the nuisances of usual machines compete with those of `from`.
    pub fn started(&self, from: &Point, predictions: Vec<Prediction>) -> Point {
        let mut point = Point { values: self.own_values(), predictions: Arc::new(predictions), ..from.clone() };
        self.weigh(&mut point);
        self.fit_stretch(&mut point);
        let mut is_usual = false;
        for [jitter, spacing] in LIKELIHOOD.usual {
            let of_each = point.clone().in_recordings(point.jitter.len(), jitter);
            let mut usual = Point {
                colour: Default::default(),
                stretch: point.stretch.clone(),
                spacing,
                sidebands: Sidebands::default(),
                ..of_each
            };
            self.weigh(&mut usual);
            if usual.objective() < point.objective() {
                (point, is_usual) = (usual, true);
            }
        }
        if is_usual {
            self.fit_stretch(&mut point);
        }
        point
    }

    /// Point with other predictions and the nuisances of `from`.
    pub fn with_predictions(&self, from: &Point, predictions: Vec<Prediction>) -> Point {
        let mut point = Point { predictions: Arc::new(predictions), ..from.clone() };
        self.weigh(&mut point);
        point
    }

    /// Point of the same rig with the nuisances of another fit.
    pub fn with_nuisances(&self, own: &Point, of: &Point) -> Point {
        let mut point = Point { values: own.values.clone(), predictions: Arc::clone(&own.predictions), ..of.clone() };
        self.weigh(&mut point);
        point
    }

    /// Point searched from another one for at most `steps` steps.
    ///
    /// # Errors
    /// What the simulation refuses at the start.
    pub fn search(&self, from: Point, steps: usize) -> Result<Point, RigError> {
        let first = from.objective();
        let mut scoring = Scoring { model: self, first, point: from, expansion: OnceCell::new() };
        let mut damping = SETTINGS.damping;
        damped_search(&mut scoring, &mut damping, steps, SETTINGS.most_damping)?;
        Ok(scoring.point)
    }

    fn own_values(&self) -> Vec<f64> {
        self.coordinates.iter().map(|c| c.to_coordinate(self.rig.get(c.key).unwrap_or_default())).collect()
    }

    fn own_rig(&self) -> Result<Rig, RigError> {
        self.rig_at(&self.own_values())
    }

    fn predictions(&self, rig: &Rig) -> Result<Vec<Prediction>, RigError> {
        // One rig in, one result out.
        let Data { observations, orders, unevenness, .. } = self.data;
        predictions(&[(&self.known, rig)], observations, orders, unevenness).swap_remove(0)
    }

    /// Sets coloured noise, likelihood and prior of a point by its predictions and nuisances.
    fn weigh(&self, point: &mut Point) {
        point.coloured = self.data.coloured(point);
        point.neg_logs = self.data.neg_log_likelihoods(point);
        let jitter = |j: &usize| {
            let [usual, scatter] = LIKELIHOOD.usual_jitter;
            0.5 * ((LIKELIHOOD.jitter_s[*j].max(LIKELIHOOD.jitter_s[1] / 2.0) / usual).ln() / scatter).powi(2)
        };
        let unknown =
            self.guesses.iter().zip(&point.values).map(|(g, u)| 0.5 * ((u - g) / SETTINGS.unknown_std).powi(2));
        point.prior = self.data.colours_prior(point)
            + self.data.stretch_prior(point)
            + point.sidebands.prior()
            + point.jitter.iter().map(jitter).sum::<f64>()
            + unknown.sum::<f64>();
    }

    /// Moves the stretch of each recording to the best within its range.
    fn fit_stretch(&self, point: &mut Point) {
        // A stated speed that drifts may be that of the start or the mean.
        let drifts = self.rig.effects.iter().any(|e| e.kind == EffectKind::SpeedDrift);
        let reach = if drifts { SETTINGS.drift_reach } else { 1.0 } * LIKELIHOOD.stretch[0];
        let stretch = self.data.stretches(point, &vec![Stretch::default(); point.stretch.len()], reach);
        self.move_stretch(point, stretch);
    }

    /// Moves the stretch of each recording to the best nearby.
    fn refine_stretch(&self, point: &mut Point) {
        let stretch = self.data.stretches(point, &point.stretch, SETTINGS.near_steps * LIKELIHOOD.stretch[1]);
        self.move_stretch(point, stretch);
    }

    /// Moves a point to another stretch of each recording if it fits better.
    fn move_stretch(&self, point: &mut Point, stretch: Vec<Stretch>) {
        if stretch != point.stretch {
            let mut moved = Point { stretch, ..point.clone() };
            self.weigh(&mut moved);
            if moved.objective() < point.objective() {
                *point = moved;
            }
        }
    }

    /// Point searched from another one with the best jitter of all in each recording: small ones differ so little that a search from none
    /// does not come to the large ones.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn search_wandering(&self, from: &Point, steps: usize) -> Result<Point, RigError> {
        let all = (0..LIKELIHOOD.jitter_s.len()).map(|jitter| vec![jitter; from.jitter.len()]).collect();
        let mut point = from.clone();
        self.move_jitter(&mut point, all);
        self.search(point, steps)
    }

    /// Moves the jitter of each recording to that of some which fits better.
    fn move_jitter(&self, point: &mut Point, tried: Vec<Vec<usize>>) {
        let of = |jitter: Vec<usize>| {
            let neg_logs = self.data.neg_log_likelihoods(&Point { jitter: jitter.clone(), ..point.clone() });
            (jitter, neg_logs)
        };
        let tried: Vec<(Vec<usize>, Vec<f64>)> = tried.into_iter().map(of).collect();
        let mut jitter = point.jitter.clone();
        for (n, own) in jitter.iter_mut().enumerate() {
            let best = tried.iter().min_by(|a, b| a.1[n].total_cmp(&b.1[n]));
            if let Some((best, _)) = best.filter(|(_, best)| best[n] < point.neg_logs[n] - SETTINGS.least_gain) {
                *own = best[n];
            }
        }
        if jitter != point.jitter {
            point.jitter = jitter;
            self.weigh(point);
        }
    }

    /// Moves the jitter of each recording to where it fits better, a step up or down, and the unevenness of balls and races.
    fn refine_jitter(&self, point: &mut Point) {
        let last = LIKELIHOOD.jitter_s.len() - 1;
        let all = |by: i64| point.jitter.iter().map(|j| (*j as i64 + by).clamp(0, last as i64) as usize).collect();
        self.move_jitter(point, [-1, 1].map(all).into());
        for by in [-1i64, 1] {
            let stepped = |index: usize, count: usize| (index as i64 + by).clamp(0, count as i64 - 1) as usize;
            let spacing = stepped(point.spacing, LIKELIHOOD.spacing_rad.len());
            self.move_machine(point, |to| to.spacing = spacing);
            // With as much beside the lines as before.
            let [from, to] = [point.spacing, spacing].map(|index| LIKELIHOOD.spacing_rad[index]);
            let sidebands = point.sidebands.scaled((from / to).powi(2));
            self.move_machine(point, |to| (to.spacing, to.sidebands) = (spacing, sidebands));
            for (form, values) in LIKELIHOOD.form_m.iter().enumerate() {
                let index = stepped(point.form[form], values.len());
                self.move_machine(point, |to| to.form[form] = index);
            }
        }
        for _ in 0..SETTINGS.sideband_steps {
            let sidebands = self.data.sidebands_towards(point);
            self.move_machine(point, |to| to.sidebands = sidebands);
        }
    }

    /// Moves a point to another unevenness if it fits better.
    fn move_machine(&self, point: &mut Point, change: impl FnOnce(&mut Point)) {
        let mut moved = point.clone();
        change(&mut moved);
        let is_same_form = (moved.spacing, moved.form) == (point.spacing, point.form);
        if is_same_form && moved.sidebands == point.sidebands {
            return;
        }
        self.weigh(&mut moved);
        if moved.objective() < point.objective() - SETTINGS.least_gain {
            *point = moved;
        }
    }

    /// Point a step further; `None` if the rig cannot run there.
    fn stepped(&self, point: &Point, step: &[f64]) -> Option<Point> {
        let (own, of_colour) = step.split_at(self.coordinates.len());
        let greatest = own.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        let scale = if greatest > SETTINGS.max_step { SETTINGS.max_step / greatest } else { 1.0 };
        let mut next = point.clone();
        let colours = next.colour.iter_mut().chain(next.own_colour.iter_mut().flatten()).flatten();
        colours.zip(of_colour).for_each(|(c, s)| *c += scale * s);
        if !own.is_empty() {
            let values: Vec<f64> = point.values.iter().zip(own).map(|(u, s)| u + scale * s).collect();
            next.predictions = Arc::new(self.predictions(&self.rig_at(&values).ok()?).ok()?);
            next.values = values;
        }
        self.weigh(&mut next);
        Some(next)
    }
}

/// Fisher scoring at a point.
struct Scoring<'m, 'd, 'a> {
    model: &'m Model<'d, 'a>,
    /// Objective at the first point.
    first: f64,
    point: Point,
    /// Expansion at the point, once it is asked for.
    expansion: OnceCell<Expansion>,
}

impl Damped for Scoring<'_, '_, '_> {
    /// Point; `None` if the rig cannot run there.
    type Trial = Option<Point>;
    type Error = RigError;

    fn trial(&self, damping: f64) -> Result<Option<Option<Point>>, RigError> {
        let expansion = match self.expansion.get() {
            Some(expansion) => expansion,
            None => {
                let made = Expansion::new(self.model, &self.point)?;
                self.expansion.get_or_init(|| made)
            }
        };
        Ok(expansion.step(damping).map(|step| self.model.stepped(&self.point, &step)))
    }

    fn decrease(&self, trial: &Option<Point>) -> Option<Decrease> {
        let actual = self.point.objective() - trial.as_ref()?.objective();
        (actual > 0.0).then_some(Decrease { actual, expected: f64::NAN })
    }

    fn accept(&mut self, trial: Option<Point>, _: Decrease) -> Result<bool, RigError> {
        let Some(mut next) = trial else { return Ok(true) };
        self.model.refine_stretch(&mut next);
        self.model.refine_jitter(&mut next);
        let gain = self.point.objective() - next.objective();
        let so_far = self.first - next.objective();
        self.point = next;
        self.expansion = OnceCell::new();
        Ok(gain < SETTINGS.converged + SETTINGS.converged_share * so_far)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::imperfect::testing::{observed, pitted};
    use crate::diagnose::spectral::observation::Observation;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::effect::ParameterKey;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Start, simulate};

    /// A rotation that wanders by 0.5 ms: a search from an even one stays there.
    #[test]
    fn invariant_a_rotation_that_wanders_widely_is_found() {
        let rig = pitted();
        let wide = LIKELIHOOD.jitter_s.iter().position(|jitter| *jitter == 5e-4).unwrap();
        let observations = [observed(&rig, 500.0, &Point::default().in_recordings(1, wide))];
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, rig);
        let even = Point { jitter: vec![0], ..model.start().unwrap() };
        let found = model.search_wandering(&even, 10).unwrap();
        assert!(found.jitter[0].abs_diff(wide) <= 1, "{:?}", found.jitter);
        assert!(found.objective() < model.search(even, 0).unwrap().objective() - 100.0);
    }

    /// A slipping cage slows the passes over the outer race and quickens those over the inner one.
    #[test]
    fn invariant_a_slipping_cage_moves_the_lines_of_the_races_apart() {
        let defect = [(ParameterKey::DepthM, 5e-7), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 0.0)];
        let rig = nominal().with_effect(EffectEntry::new(EffectKind::InnerRaceDefect, &defect));
        let slip = 0.004;
        let slipping = EffectEntry::new(EffectKind::CageSlip, &[(ParameterKey::Fraction, slip)]);
        let recording =
            simulate(&rig.clone().with_effect(slipping), &condition(30.0, 800.0, 25_600), &Start::seeded(5)).unwrap();
        let observations = [Observation::new(&Observed::from_recording(&recording).unwrap())];
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let point = Model::fixed(&data, rig).start().unwrap();
        let found = point.stretch[0];
        let inner = slip * orders.ftf / (1.0 - orders.ftf);
        assert!((found.outer + slip).abs() < 8e-4 && (found.inner - inner).abs() < 8e-4, "{found:?}");
    }
}
