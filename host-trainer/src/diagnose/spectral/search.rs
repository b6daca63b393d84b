//! Search for the effect that explains what a rig leaves.

use rayon::prelude::*;

use super::angle::turned;
use super::candidate::{Candidate, NullFit, best, rank};
use super::cross::set_phases;
use super::dissipation::as_friction_or_damper;
use super::forms::Forms;
use super::hypotheses::{Hypothesis, LOAD_COMPONENT};
use super::lack::lack;
use super::observation::duration_s;
use super::screening::{Brief, StartScore, brief_null, screened};
use super::settings::SearchSettings;
use super::unevenness::turns;
use super::waves::{other_lobes, with_neighbours};
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Effects that bend a spring's force.
const CURVATURES: [EffectKind; 3] =
    [EffectKind::HardeningStiffness, EffectKind::SofteningStiffness, EffectKind::AsymmetricStiffness];
/// Waviness, of which only the best on each race is fitted with its neighbours, for the computing time.
const RACES: [EffectKind; 2] = [EffectKind::OuterRaceWaviness, EffectKind::InnerRaceWaviness];
/// Effects that take a motion's energy.
const DISSIPATION: [EffectKind; 3] =
    [EffectKind::CoulombFriction, EffectKind::QuadraticDrag, EffectKind::DampingChange];
/// Effects that are always fitted to all recordings: a brief recording does not show a drift of the speed, a rotation that wanders may
/// have taken up a slip, and an error of the load is always a rival.
const ALWAYS_FITTED: [(EffectKind, &str); 3] =
    [(EffectKind::SpeedDrift, ""), (EffectKind::CageSlip, ""), (EffectKind::ConstantForce, LOAD_COMPONENT)];

/// What is sought.
#[derive(Clone, Copy, Debug)]
pub struct Sought<'s> {
    /// Gain that a cause must have; what is far from it is not followed up.
    pub asked: f64,
    /// Whether the phase between the channels is asked too.
    pub by_phase: bool,
    /// Corrections of the calibration, of whose kinds there may be another effect.
    pub corrections: &'s [EffectKind],
    /// The one kind that is asked for; `None` for all.
    pub only: Option<EffectKind>,
}

/// Candidates that gain most, at each place the best of a kind, the one of greatest merit first, those that the phase contradicts
/// last; of the kinds that the rig has already, only corrections. None beside a rig that cannot run with uneven balls.
pub fn candidates<'d, 'a>(null: &NullFit<'d, 'a>, brief: &Brief, sought: Sought) -> Vec<Candidate<'d, 'a>> {
    let Sought { asked, by_phase, corrections, only } = sought;
    let data = null.model.data;
    let mut hypotheses = null.hypotheses();
    let has = |kind: EffectKind| !corrections.contains(&kind) && null.rig.effects.iter().any(|e| e.kind == kind);
    hypotheses.retain(|h| !has(h.kind) && only.is_none_or(|only| h.kind == only));
    let Some([of_first, of_second]) = &brief.data(null) else { return Vec::new() };
    let (Some(first), Some(second)) = (brief_null(null, of_first), brief_null(null, of_second)) else {
        return Vec::new();
    };
    let forms = Forms { null, brief: &second };
    let mut kept = screened([&first, &second], &hypotheses);
    let most = kept.first().map_or(0.0, |score| score.gain);
    let followed_from = asked / SETTINGS.growth;
    let of_brief = followed_from * duration_s(of_second.observations) / duration_s(data.observations);
    kept.retain(|score| score.gain > (SETTINGS.rival_share * most).max(of_brief));
    let mut kept = without_twins(kept);
    kept.truncate(SETTINGS.full_fits);
    let mut sought: Vec<_> = kept.into_iter().map(|score| (score.hypothesis, sizes(&score.effect))).collect();
    for also in hypotheses.iter().filter(|h| ALWAYS_FITTED.contains(&(h.kind, h.place.as_str()))) {
        if sought.iter().all(|(hypothesis, _)| !hypothesis.is_same_as(also)) {
            sought.push((also, also.starts.clone()));
        }
    }
    let hopeless = SETTINGS.hopeless_nats + lack(data, &null.point).total();
    let fit = |(hypothesis, starts): (&Hypothesis, Vec<EffectEntry>)| {
        let started = best(null.started(hypothesis, &starts))?;
        // The colours of the noise have yet to make room for a random force.
        let is_hopeless = started.gain < -hopeless && hypothesis.kind != EffectKind::RandomForce;
        if is_hopeless {
            return Some(started);
        }
        let searched = started.searched(SETTINGS.steps[0]);
        // A stop without its damping can gain too little to be followed.
        let is_stop = hypothesis.kind == EffectKind::EndStopContact;
        let searched = if is_stop { forms.extended(searched, hypothesis) } else { searched };
        // A drift or a slip may be what the null fit took for a rotation that wanders.
        let even = || Some(best(null.started_evenly(hypothesis, &starts))?.searched(SETTINGS.steps[0]));
        best([searched].into_iter().chain(turns(hypothesis.kind).then(even).flatten()))
    };
    let mut fits: Vec<Candidate> = sought.into_par_iter().filter_map(fit).collect();
    let ask_phase = |fits: &mut [Candidate]| {
        if by_phase {
            set_phases(null, fits, followed_from);
        }
    };
    ask_phase(&mut fits);
    rank(&mut fits);
    let (contradicted, fits): (Vec<Candidate>, Vec<Candidate>) = fits.into_iter().partition(Candidate::is_contradicted);
    let most = fits.first().map_or(0.0, |c| c.gain);
    let least = (most - SETTINGS.close_nats - SETTINGS.close_share * most.abs()).max(followed_from);
    let close = |c: &Candidate| c.gain > least;
    let (near, far): (Vec<Candidate>, Vec<Candidate>) = fits.into_iter().partition(close);
    let followed = |candidate: Candidate<'d, 'a>| {
        let candidate = candidate.searched(SETTINGS.steps[1]);
        let Some(hypothesis) = hypotheses.iter().find(|h| candidate.is_of(h)) else { return candidate };
        // Its widths and depths are sought where the defect is, and move it a little.
        let candidate = forms.restarted(turned(candidate, null), hypothesis);
        turned(forms.extended(candidate, hypothesis), null)
    };
    let mut near: Vec<Candidate> = near.into_par_iter().map(followed).collect();
    rank(&mut near);
    // So many numbers gain something by any strong lines: the lobes alone are the reason to fit them.
    let of_races = RACES.into_par_iter().filter_map(|kind| near.iter().find(|c| c.kind == kind && c.gain > asked));
    let of_races: Vec<_> = of_races.map(|best| with_neighbours(best, &hypotheses, null)).collect();
    near.extend(of_races.into_iter().flatten());
    rank(&mut near);
    let siblings = near.first().map_or_else(Vec::new, |best| siblings(best, &near, &hypotheses, null));
    near.extend(siblings);
    ask_phase(&mut near);
    rank(&mut near);
    let (against, near): (Vec<Candidate>, Vec<Candidate>) = near.into_iter().partition(Candidate::is_contradicted);
    first_of_each(near.into_iter().chain(far).chain(against).chain(contradicted))
}

/// The first candidate of each kind at each place.
fn first_of_each<'d, 'a>(all: impl Iterator<Item = Candidate<'d, 'a>>) -> Vec<Candidate<'d, 'a>> {
    let mut first: Vec<Candidate> = Vec::new();
    for candidate in all {
        if !first.iter().any(|c| (c.kind, &c.place) == (candidate.kind, &candidate.place)) {
            first.push(candidate);
        }
    }
    first
}

/// Scores, best first, without an effect in one direction that differs from that in both by chance, and the reverse.
fn without_twins(scores: Vec<StartScore>) -> Vec<StartScore> {
    let is_twin = |of: &StartScore, score: &StartScore| {
        let (one, other) = (of.hypothesis, score.hypothesis);
        (one.is_direction_of(other) || other.is_direction_of(one)) && (of.gain - score.gain).abs() < SETTINGS.twin_nats
    };
    let mut kept: Vec<StartScore> = Vec::new();
    for score in scores {
        match kept.iter().position(|of| is_twin(of, &score)) {
            // In both directions is the simpler effect.
            Some(index) if kept[index].hypothesis.is_direction_of(score.hypothesis) => kept[index] = score,
            Some(_) => {}
            None => kept.push(score),
        }
    }
    kept
}

/// Fits of the other curvatures of the spring that the best candidate bends or stops, of other dissipation there, or of other lobes
/// of the race: they differ by little, and a screening may have lost the right one.
fn siblings<'d, 'a>(
    best_so_far: &Candidate<'d, 'a>,
    fits: &[Candidate],
    hypotheses: &[Hypothesis],
    null: &NullFit<'d, 'a>,
) -> Vec<Candidate<'d, 'a>> {
    let family = match best_so_far.kind {
        EffectKind::OuterRaceWaviness => return other_lobes(best_so_far, hypotheses, null),
        // A stop with its gap and stiffness bends in most of the ways that a curvature does.
        EffectKind::EndStopContact => CURVATURES,
        kind if CURVATURES.contains(&kind) => CURVATURES,
        kind if DISSIPATION.contains(&kind) => DISSIPATION,
        _ => return Vec::new(),
    };
    let is_fitted = |h: &Hypothesis| fits.iter().any(|c| c.is_of(h));
    let of = |h: &Hypothesis| {
        let whole = hypotheses.iter().find(|w| h.is_direction_of(w)).unwrap_or(h);
        let starts: Vec<EffectEntry> = whole.starts.iter().map(|start| h.placed(start)).collect();
        Some(best(null.started(h, &starts))?.searched(SETTINGS.steps[1]))
    };
    let others = hypotheses.iter().filter(|h| family.contains(&h.kind) && h.place == best_so_far.place);
    let others = others.filter(|h| !is_fitted(h)).filter_map(of);
    others.chain(as_friction_or_damper(best_so_far, hypotheses, null)).collect()
}

/// Effect at the sizes from which its fit to all recordings starts: as screened and, of friction, weaker, since it reduces the
/// motion on which the screening's noise rests.
fn sizes(effect: &EffectEntry) -> Vec<EffectEntry> {
    let key = match effect.kind {
        EffectKind::CoulombFriction => Some(ParameterKey::ForceN),
        EffectKind::QuadraticDrag => Some(ParameterKey::DragNS2PerM2),
        _ => None,
    };
    match key.and_then(|key| Some((key, effect.number(key)?))) {
        Some((key, size)) => SETTINGS.weaker.map(|share| effect.clone().with_number(key, share * size)).to_vec(),
        None => vec![effect.clone()],
    }
}
