//! Selection of causes by what they gain on fitted and on held-out recordings: the best candidate, one after the other, or two at once.

use super::baseline::Baseline;
use super::candidate::{Candidate, NullFit};
use super::causes::{self, Accepted, Beside, Trust};
use super::data::{Data, Point};
use super::fit::Model;
use super::gate::{is_gain_of_lines_alone, is_in, is_no_tone, is_overdamped};
use super::lack::{lack, shared_lack};
use super::pairs::{Pair, pairs};
use super::refit::{objective_of, refit_nuisances};
use super::screening::Brief;
use super::search::{Sought, candidates};
use super::settings::{FitSettings, GateSettings};
use super::text;
use super::tolerance::{first_to_judge, is_tolerance};
use super::unevenness::turns_otherwise;
use crate::diagnose::DiagnoseError;
use crate::diagnose::result::{Cause, Fit, Rejected};
use crate::identify::likelihood::coordinate::Coordinate;
use crate::rig::config::RigKey;
use crate::rig::effect::EffectKind;
use crate::rig::{EffectEntry, Rig, RigError};

const GATE: GateSettings = GateSettings::DEFAULT;
const FIT: FitSettings = FitSettings::DEFAULT;

/// Selection of causes.
pub struct Selection<'d, 'a> {
    /// Nominal rig with the effects so far.
    pub model: Model<'d, 'a>,
    /// Fit of the model.
    pub point: Point,
    /// Both before the first cause.
    uncaused: (Model<'d, 'a>, Point),
    /// Causes.
    pub accepted: Vec<Accepted<'d, 'a>>,
    /// Candidates that did not pass the gate.
    pub rejected: Vec<Candidate<'d, 'a>>,
    /// Whether an event has changed the load: what is left of it is a constant force.
    is_stepped: bool,
    /// Effects that every machine has within its tolerances: no causes.
    pub tolerated: Vec<EffectEntry>,
    /// Effects that the baseline has as well.
    pub in_baseline: Vec<EffectKind>,
    /// Effects in the model that the vocabulary has no name for.
    pub nameless: Vec<EffectEntry>,
    /// Candidate that explains most beside the first cause, whether it is a cause or not.
    beside_first: Option<Candidate<'d, 'a>>,
    /// Fit of a dry friction that holds its component, while a damper stands for it.
    friction: Option<(Model<'d, 'a>, Point)>,
}

impl<'d, 'a> Selection<'d, 'a> {
    /// Nominal rig without causes, beside an event of a kind.
    pub fn new(nominal: &Model<'d, 'a>, null: &Point, event: Option<EffectKind>) -> Self {
        let (model, point) = (nominal.clone(), null.clone());
        Self {
            uncaused: (model.clone(), point.clone()),
            model,
            point,
            accepted: Vec::new(),
            rejected: Vec::new(),
            is_stepped: event == Some(EffectKind::LoadStep),
            tolerated: Vec::new(),
            in_baseline: Vec::new(),
            nameless: Vec::new(),
            beside_first: None,
            friction: None,
        }
    }

    /// Adds at most two causes, each judged by the held-out recordings; `held_null` is −ln there without any.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn with_causes(
        mut self,
        held_data: &Data,
        held_null: f64,
        mut baseline: Option<Baseline>,
        progress: &dyn Fn(&str),
    ) -> Result<Self, DiagnoseError> {
        let observations = self.model.data.observations;
        let brief = Brief::new(observations);
        let mut held_now = held_null;
        while self.accepted.len() < 2 && self.in_baseline.len().max(self.tolerated.len()) < GATE.most_corrections {
            // Beside what was found before, with a name or without.
            let is_second = !(self.accepted.is_empty() && self.nameless.is_empty());
            progress(if is_second { "searching for a second cause" } else { "searching for a cause" });
            let (asked, only) = self.asked(is_second);
            let null = NullFit::new(&self.model, &self.point);
            // A larger effect may be beside a tolerated one; an error of the load is not beside another.
            let tolerated = self.tolerated.iter().map(|e| e.kind).filter(|kind| *kind != EffectKind::ConstantForce);
            let corrections: Vec<EffectKind> = self.in_baseline.iter().copied().chain(tolerated).collect();
            let sought = Sought { asked, by_phase: is_second, corrections: &corrections, only };
            let is_refused = |c: &Candidate| {
                c.is_contradicted() || is_overdamped(c) || is_second && is_gain_of_lines_alone(c, &self.point)
            };
            // The damper in its place does not say that there is a friction already.
            let is_another = |c: &Candidate| self.friction.is_some() && c.kind == EffectKind::CoulombFriction;
            let found = candidates(&null, &brief, sought).into_iter().filter(|c| !is_another(c));
            let (refused, mut found): (Vec<_>, Vec<_>) = found.partition(is_refused);
            let first = (!found.is_empty()).then(|| found.remove(first_to_judge(&found, asked)));
            let damper = first.as_ref().and_then(|friction| causes::holding(friction, &refused)).cloned();
            self.rejected.extend(refused);
            let Some(mut best) = first else { break };
            let of_machine = self.refit_without(&best, asked)?;
            if of_machine > 0.0 {
                found.iter_mut().chain([&mut best]).for_each(|candidate| candidate.gain -= of_machine);
                held_now = held_now.min(objective_of(held_data, &self.model, &self.point));
            }
            if !self.accepted.is_empty() {
                self.beside_first = Some(best.clone());
            }
            let held_out = held_now - objective_of(held_data, &best.model, &best.point);
            let is_too_little = self.is_within_tolerances(&best) || best.gain < asked;
            if is_too_little || !is_no_tone(&best) || !is_in(held_data, held_now, held_out, &best) {
                self.rejected.push(best);
                self.rejected.extend(found);
                break;
            }
            if self.accepted.is_empty() {
                self.uncaused = (self.model, self.point);
            }
            best = best.searched(FIT.cause_steps);
            let judged = objective_of(held_data, &best.model, &best.point);
            let held_out = held_now - judged;
            (self.model, self.point, held_now) = (best.model.clone(), best.point.clone(), judged);
            let is_of_step = self.is_stepped && best.kind == EffectKind::ConstantForce;
            if let Some(effect) = best.effect().filter(|_| is_of_step || is_tolerance(&best)) {
                self.tolerated.push(effect);
                continue;
            }
            if baseline.as_mut().is_some_and(|baseline| baseline.shows(&best)) {
                self.in_baseline.push(best.kind);
                continue;
            }
            if let Some(effect) = best.effect().filter(|effect| !effect.kind.in_vocabulary()) {
                self.nameless.push(effect);
                continue;
            }
            let probability = causes::probability(&best, &found, is_second);
            let effect = self.model.rig.effects.len() - 1;
            self.accepted.push(Accepted {
                candidate: best,
                held_out,
                probability,
                rivals: found,
                effect,
                beside: None,
                holds: damper.is_some(),
            });
            if let Some(damper) = damper {
                held_now = objective_of(held_data, &damper.model, &damper.point);
                self.friction = Some((self.model, self.point));
                (self.model, self.point) = (damper.model, damper.point);
            }
            if turns_otherwise(&self.model.rig) {
                held_now = self.turn(held_data)?;
            }
        }
        self.with_friction()?.with_pair(held_data, held_now, baseline)
    }

    /// Rig with all that was found, as it was fitted.
    ///
    /// # Errors
    /// A value out of the range of its key.
    pub fn rig(&self) -> Result<Rig, RigError> {
        self.model.rig_at(&self.point.values)
    }

    /// Gain that the next cause must have, and the one kind that is sought, if not all are.
    fn asked(&self, is_second: bool) -> (f64, Option<EffectKind>) {
        let data = self.model.data;
        let left = lack(data, &self.point).total();
        let is_left_little = is_second && left < GATE.little_lack;
        // The colours of the noise take up most of what a sensor's gain leaves.
        let is_of_gain = is_left_little && shared_lack(data, &self.point) < GATE.second_shared_lack;
        let least = if is_of_gain {
            GATE.second_sensor_gain
        } else if is_left_little {
            GATE.little_lack
        } else {
            GATE.gain
        };
        let share = if is_second { GATE.second_share } else { GATE.first_share };
        let asked = least.max(share * left).max(GATE.form_share * data.form_gain(&self.point));
        (asked, is_of_gain.then_some(EffectKind::SensorGain))
    }

    /// Whether a candidate gains no more than what a clearance, stiffnesses and masses that are right within their tolerances leave
    /// together, where so little is left: a force and another exponent of the contact take that up.
    fn is_within_tolerances(&self, candidate: &Candidate) -> bool {
        matches!(candidate.kind, EffectKind::ConstantForce | EffectKind::ContactExponent)
            && candidate.gain < GATE.little_lack
            && lack(self.model.data, &self.point).total() < GATE.little_lack
    }

    /// Puts a dry friction into the place of the damper that stood for it: the same motion, of which a damper's is simulated in a
    /// fraction of the time.
    fn with_friction(mut self) -> Result<Self, RigError> {
        let Some((friction, at)) = self.friction.take() else { return Ok(self) };
        let count = friction.rig.effects.len();
        let later = self.rig()?.effects.split_off(count);
        if later.is_empty() {
            (self.model, self.point) = (friction, at);
            return Ok(self);
        }
        let mut rig = friction.rig_at(&at.values)?;
        rig.effects.extend(later);
        let is_of_later = |c: &&Coordinate| matches!(c.key, RigKey::Effect { index, .. } if index >= count);
        let of_later = self.model.coordinates.iter().filter(is_of_later);
        let coordinates: Vec<Coordinate> = friction.coordinates.iter().chain(of_later).cloned().collect();
        self.model = Model::new(friction.data, rig, &coordinates, &friction.guesses);
        self.point = self.model.search(self.model.start_from(&self.point)?, FIT.held_out_steps)?;
        Ok(self)
    }

    /// Takes two effects at once in the place of the causes, if they explain more than those, one after the other.
    fn with_pair(
        mut self,
        held_data: &Data,
        held_now: f64,
        mut baseline: Option<Baseline>,
    ) -> Result<Self, DiagnoseError> {
        let Some(first) = self.accepted.first() else { return Ok(self) };
        let (uncaused, at) = &self.uncaused;
        let is_corrected_since = self.model.rig.effects.len() > uncaused.rig.effects.len() + self.accepted.len();
        if is_corrected_since || lack(self.model.data, &first.candidate.point).total() < GATE.little_lack {
            return Ok(self);
        }
        let null = NullFit::new(uncaused, at);
        let singles: Vec<Candidate> = std::iter::once(&first.candidate).chain(&first.rivals).cloned().collect();
        let found = pairs(&null, &singles, self.beside_first.as_ref());
        let Some(best) = found.first().filter(|best| best.merit() > self.merit() + GATE.gain) else { return Ok(self) };
        let asked = GATE.gain.max(GATE.second_share * lack(self.model.data, &best.first.point).total());
        let held_null = objective_of(held_data, uncaused, at);
        let held_out = best.each().map(|c| held_null - objective_of(held_data, &c.model, &c.point));
        let both = Candidate { gain: best.gain(), ..best.second.clone() };
        let is_pair = best.second.gain > asked
            && held_out[1] > held_null - held_now + GATE.held_out
            && !best.is_contradicted(asked)
            && is_in(held_data, held_null, held_out[1], &both)
            && best.each().into_iter().all(|c| is_no_tone(c) && !is_overdamped(c))
            && best.each().into_iter().all(|c| !is_tolerance(c))
            && best.each().into_iter().all(|c| baseline.as_mut().is_none_or(|baseline| !baseline.shows(c)));
        if is_pair {
            self.accepted = self.pair_of_causes(best, held_out, &found, &singles);
            (self.model, self.point) = (best.second.model.clone(), best.second.point.clone());
            if turns_otherwise(&self.model.rig) {
                self.turn(held_data)?;
            }
        }
        Ok(self)
    }

    /// Best pair among all `found` as causes, which gain some nats, the first and both, on held-out recordings.
    fn pair_of_causes(
        &self,
        best: &Pair<'d, 'a>,
        held_out: [f64; 2],
        found: &[Pair],
        singles: &[Candidate<'d, 'a>],
    ) -> Vec<Accepted<'d, 'a>> {
        let next = found.iter().find(|other| other.kinds() != best.kinds());
        let one_by_one = self.accepted.iter().map(|a| a.candidate.kind).collect();
        let mut others: Vec<(Vec<EffectKind>, f64)> = found.iter().map(|p| (p.kinds().into(), p.merit())).collect();
        others.push((one_by_one, self.merit()));
        let [held_first, held_both] = held_out;
        let each = best.each().into_iter().zip([held_first, held_both - held_first]).enumerate();
        let accepted = each.map(|(n, (candidate, held_out))| Accepted {
            candidate: candidate.clone(),
            held_out,
            probability: best.probability(n, &others),
            rivals: singles.iter().filter(|c| !best.kinds().contains(&c.kind)).cloned().collect(),
            effect: self.uncaused.0.rig.effects.len() + n,
            beside: Some(Beside { gain: best.gain(), next: next.map(|other| (other.to_string(), other.gain())) }),
            holds: false,
        });
        accepted.collect()
    }

    /// Gain of the causes less the price of their numbers.
    fn merit(&self) -> f64 {
        let Some((last, before)) = self.accepted.split_last() else { return 0.0 };
        before.iter().map(|a| a.candidate.gain).sum::<f64>() + last.candidate.merit()
    }

    /// Moves the fit to what a candidate's fit found of the machine and of earlier effects beside the effect, if that is better
    /// without the effect too: a search may have ended before it. The gain of that. Where nothing else takes the candidate below
    /// the gain that is `asked`, the numbers of the rig are moved too.
    fn refit_without(&mut self, candidate: &Candidate, asked: f64) -> Result<f64, RigError> {
        let before = self.point.objective();
        let moved = self.model.with_nuisances(&self.point, &candidate.point);
        self.keep_better(self.model.search(moved, FIT.held_out_steps)?);
        let gain = before - self.point.objective();
        let numbers = self.model.coordinates.len();
        if numbers > 0 && candidate.gain - gain >= asked {
            // A rig of these numbers may not run without the effect.
            let rig = self.model.rig_at(&candidate.point.values[..numbers]);
            let moved = rig.and_then(|rig| Model { rig, ..self.model.clone() }.start_from(&candidate.point));
            if let Ok(moved) = moved {
                self.keep_better(self.model.search(moved, FIT.held_out_steps)?);
            }
        }
        Ok(before - self.point.objective())
    }

    fn keep_better(&mut self, point: Point) {
        if point.objective() < self.point.objective() {
            self.point = point;
        }
    }

    /// Lowers the probability of the causes by what they leave. One that is not trusted at all is none, nor is what was found beside
    /// it; none is one if the most probable leaves too much. Whether the model is another one then.
    pub fn judge(&mut self, trust: Trust) -> bool {
        let found = self.accepted.len();
        let of = |a: &Accepted| a.candidate.effect().map_or(0.0, |effect| trust.of(&effect));
        let trusted = self.accepted.iter().take_while(|a| of(a) > 0.0).count();
        let states = |a: &Accepted| a.candidate.effect().is_some_and(|effect| trust.states(a.probability, &effect));
        let is_stated = self.accepted[..trusted].iter().any(states);
        self.take_back(if is_stated { trusted } else { 0 });
        self.accepted.iter_mut().for_each(|a| a.probability *= of(a));
        self.accepted.len() < found
    }

    /// Takes the causes back if simulations with them are farther from the held-out recordings than without, and than noise alone,
    /// whatever the likelihood says; the first of them. Another rotation moves lines, which shows in no distance: it must be no farther
    /// than simulations are from each other.
    pub fn take_back_unshown(&mut self, fit: &Fit) -> Option<Candidate<'d, 'a>> {
        let apart = if turns_otherwise(&self.model.rig) { GATE.unshown * fit.noise_floor } else { 0.0 };
        let farthest = fit.before.max(fit.noise_floor) + apart;
        let first = self.accepted.first().filter(|_| fit.after > farthest)?.candidate.clone();
        self.take_back(0);
        Some(first)
    }

    /// Takes the causes but the first `kept` back: the model is that without them again.
    fn take_back(&mut self, kept: usize) {
        let taken = self.accepted.drain(kept..).map(|a| a.candidate);
        if taken.len() == 0 {
            return;
        }
        self.rejected.splice(0..0, taken);
        let last = self.accepted.last().map(|a| (a.candidate.model.clone(), a.candidate.point.clone()));
        (self.model, self.point) = last.unwrap_or_else(|| self.uncaused.clone());
    }

    /// Fits the unevenness of the balls in the rotation that a cause has changed; −ln of the held-out recordings.
    fn turn(&mut self, held_data: &Data) -> Result<f64, DiagnoseError> {
        self.model.rig = self.rig()?;
        for data in [self.model.data, held_data] {
            data.unevenness.turn(&self.model.rig, data.observations, &data.orders)?;
        }
        self.point = self.model.search(self.model.start_from(&self.point)?, FIT.held_out_steps)?;
        Ok(refit_nuisances(held_data, &self.model, &self.point)?.objective())
    }
}

/// Effects that were considered and are no causes, each once, with the reason.
pub fn rejected_names(accepted: &[Accepted], rejected: &[Candidate], causes: &[Cause]) -> Vec<Rejected> {
    let kept = accepted.first().map(|a| match &a.beside {
        Some(both) => ("both causes", both.gain),
        None => ("the cause", a.candidate.gain),
    });
    let rivals = accepted.iter().flat_map(|a| a.rivals.iter().map(|rival| (rival, kept)));
    let mut out: Vec<Rejected> = Vec::new();
    let all = rivals.chain(rejected.iter().map(|c| (c, None)));
    for (candidate, kept) in all.filter(|(candidate, _)| candidate.kind.in_vocabulary()) {
        let name = candidate.kind.to_string();
        if !out.iter().any(|r| r.name == name) && !causes.iter().any(|c| c.name == name) {
            out.push(Rejected { name, why: text::rejected(candidate, kept) });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::diagnose::spectral::imperfect::testing::{observed, pitted};
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::identify::likelihood::coordinate::Coordinate;
    use crate::rig::config::{ModelKey, RigKey};
    use crate::rig::effect::ParameterKey;
    use crate::rig::test_support::nominal;

    /// A machine of a wandering speed, whose fit has not found that, and a candidate whose fit has.
    #[test]
    fn null_what_a_fit_found_of_the_machine_beside_an_effect_is_no_gain_of_the_effect() {
        let rig = pitted();
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let observations = [observed(&rig, 500.0, &Point::default().in_recordings(1, 5))];
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, rig);
        let early = model.start().unwrap();
        let late = model.search(early.clone(), 10).unwrap();
        let gained = early.objective() - late.objective();
        let (kind, place) = (EffectKind::ViscousFriction, String::new());
        let candidate = Candidate { kind, place, model: model.clone(), point: late, gain: gained, phase: 0.0 };
        let mut selection = Selection::new(&model, &early, None);
        let of_machine = selection.refit_without(&candidate, 25.0).unwrap();
        assert!(gained > 25.0 && of_machine > gained - 1.0, "{gained} {of_machine}");
        assert!(selection.refit_without(&candidate, 25.0).unwrap() < 1.0);
    }

    /// A bearing of unknown clearance, whose fit is in another valley of the likelihood, and a candidate whose fit is not.
    #[test]
    fn null_what_a_fit_found_of_the_rigs_numbers_beside_an_effect_is_no_gain_of_the_effect() {
        let rig = nominal();
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let observations = [observed(&rig, 500.0, &Point::default().in_recordings(1, 0))];
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let key = RigKey::Model(ModelKey::RadialClearance);
        let coordinates = vec![Coordinate::for_key(&rig, key).unwrap()];
        let of_clearance = |clearance_m: f64| {
            let mut rig = rig.clone();
            rig.set(key, clearance_m).unwrap();
            Model { coordinates: coordinates.clone(), ..Model::fixed(&data, rig) }
        };
        let own = rig.get(key).unwrap();
        let [early_model, late_model] = [own + 2e-5, own].map(of_clearance);
        let [early, late] = [&early_model, &late_model].map(|model| model.start().unwrap());
        let gained = early.objective() - late.objective();
        let (kind, place) = (EffectKind::ViscousFriction, String::new());
        let candidate = Candidate { kind, place, model: late_model, point: late, gain: gained, phase: 0.0 };
        let of = |asked: f64| Selection::new(&early_model, &early, None).refit_without(&candidate, asked).unwrap();
        let [of_machine, of_numbers] = [f64::INFINITY, 25.0].map(of);
        assert!(of_machine < gained - 25.0 && of_numbers > gained - 1.0, "{of_machine} {of_numbers} of {gained}");
    }

    /// Causes whose simulations are farther from the held-out recordings are taken back, with the machine before them; nearer ones stay.
    #[test]
    fn null_a_cause_that_simulations_do_not_show_is_none() {
        let rig = nominal();
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let observations = [observed(&rig, 500.0, &Point::default().in_recordings(1, 0))];
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, rig);
        let point = model.start().unwrap();
        let mut selection = Selection::new(&model, &point, None);
        selection.accept(damper(), 60.0);
        let fit = |after: f64| Fit { before: 1.4, after, noise_floor: 1.29, ..Fit::default() };
        assert!(selection.take_back_unshown(&fit(1.39)).is_none());
        let of_noise = Fit { before: 1.27, ..fit(1.28) };
        assert!(selection.take_back_unshown(&of_noise).is_none());
        assert_eq!(selection.accepted.len(), 1);
        let unshown = selection.take_back_unshown(&fit(1.41)).unwrap();
        assert!(text::unshown(&unshown).starts_with("viscous-friction (bearing) gains 60 in ln L"));
        assert!(selection.accepted.is_empty() && selection.model.rig.effects.is_empty());
        assert_eq!(selection.rejected.len(), 1);
    }

    /// Where a converter changes the level, a sensor's gain is no cause: what was found before it stays, what was found beside it does not.
    #[test]
    fn null_a_cause_that_is_not_trusted_is_none_nor_what_stands_beside_it() {
        let observations = [observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0))];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, nominal());
        let point = model.start().unwrap();
        let gain = EffectEntry::new(EffectKind::SensorGain, &[(ParameterKey::Value, 1.5)]);
        let gain = gain.with_text(ParameterKey::Channel, "ay");
        let judged = |effects: [EffectEntry; 2], [is_steady, keeps_level]: [bool; 2]| {
            let mut selection = Selection::new(&model, &point, None);
            effects.into_iter().for_each(|effect| selection.accept(effect, 900.0));
            let is_changed = selection.judge(Trust { is_steady, keeps_level, is_filtered: false, share: 0.1 });
            assert_eq!(selection.model.rig.effects.len(), selection.accepted.len());
            (is_changed, selection.accepted.len(), selection.rejected.len())
        };
        assert_eq!(judged([gain.clone(), damper()], [true, true]), (false, 2, 0));
        assert_eq!(judged([gain.clone(), damper()], [true, false]), (true, 0, 2));
        assert_eq!(judged([damper(), gain.clone()], [true, false]), (true, 1, 1));
        // Beside spikes a damper is none either.
        assert_eq!(judged([damper(), gain], [false, true]), (true, 0, 2));
    }

    fn damper() -> EffectEntry {
        EffectEntry::new(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, 3e4)])
    }

    impl Selection<'_, '_> {
        /// Adds an effect as a cause of some gain.
        fn accept(&mut self, effect: EffectEntry, gain: f64) {
            let kind = effect.kind;
            let model = Model::fixed(self.model.data, self.model.rig.clone().with_effect(effect));
            let point = model.start().unwrap();
            (self.model, self.point) = (model.clone(), point.clone());
            self.accepted.push(Accepted {
                candidate: Candidate { kind, place: "bearing".into(), model, point, gain, phase: 0.0 },
                held_out: gain / 3.0,
                probability: 0.8,
                rivals: Vec::new(),
                effect: self.model.rig.effects.len() - 1,
                beside: None,
                holds: false,
            });
        }
    }
}
