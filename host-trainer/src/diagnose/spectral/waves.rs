//! Waviness with neighbours: no race has one number of lobes alone, and one lobe less and one more add to the same lines under a
//! load. Without them the amplitude is off, or the number of lobes by one.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use super::candidate::{Candidate, NullFit, best};
use super::hypotheses::{Hypothesis, ladder};
use super::screening::{best_starts, scores, searched_from_best};
use super::settings::SearchSettings;
use crate::rig::EffectEntry;
use crate::rig::effect::EffectKind;
use crate::rig::effect::ParameterKey::{self, AboveCos, AboveSin, AmplitudeM, BelowCos, BelowSin, Lobes, PhaseRad};

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;
const QUARTERS: [f64; 4] = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];
/// Cosine and sine of one lobe less, then of one more.
const NEIGHBOURS: [[ParameterKey; 2]; 2] = [[BelowCos, BelowSin], [AboveCos, AboveSin]];

/// A candidate of waviness with neighbours, then named by its greatest wave, each better than the one before; none if none is better.
/// The powers alone may take one number of lobes for another, which the phase between the channels tells apart.
pub fn with_neighbours<'d, 'a>(
    candidate: &Candidate<'d, 'a>,
    hypotheses: &[Hypothesis],
    null: &NullFit<'d, 'a>,
) -> Vec<Candidate<'d, 'a>> {
    let better = |of: &Candidate<'d, 'a>, starts: fn(&EffectEntry) -> Vec<EffectEntry>| {
        let found = searched(starts(&of.effect()?), hypotheses, null);
        found.filter(|found| found.merit() > of.merit())
    };
    let beside = better(candidate, alone);
    let centred = beside.as_ref().and_then(|beside| better(beside, centred));
    let again = centred.as_ref().and_then(|centred| better(centred, alone));
    let mut forms: Vec<Candidate> = [beside, centred, again].into_iter().flatten().collect();
    // So many numbers take more steps.
    let last = forms.pop().map(|last| last.searched(SETTINGS.steps[1]));
    forms.extend(last);
    forms
}

/// Candidates of other numbers of lobes than the few of a candidate at rest, and the best of them with its neighbours: they bend the
/// balls' mean path alike, and a screening of brief recordings may have lost the right ones. None of a candidate that gains little, as
/// one of so many numbers of lobes gains something by any strong lines, nor where the noise is not known, for the computing time.
pub fn other_lobes<'d, 'a>(
    of: &Candidate<'d, 'a>,
    hypotheses: &[Hypothesis],
    null: &NullFit<'d, 'a>,
) -> Vec<Candidate<'d, 'a>> {
    // Those of few lobes have a phase in their first fit.
    let is_few = hypotheses.iter().any(|h| of.is_of(h) && h.free.contains(&PhaseRad));
    if !is_few || of.gain < SETTINGS.other_lobes_nats || !null.model.coordinates.is_empty() {
        return Vec::new();
    }
    let others = hypotheses.iter().filter(|h| h.kind == of.kind && h.place != of.place);
    let starts = others.flat_map(|h| turned(&h.starts[0]).into_iter().map(move |start| (h, start))).collect();
    let kept = best_starts(scores(null, starts, &SETTINGS.scales), SETTINGS.other_lobes, 1);
    let searched = kept
        .into_par_iter()
        .filter_map(|score| Some(best(null.started(score.hypothesis, &[score.effect]))?.searched(SETTINGS.steps[1])));
    let mut all: Vec<Candidate> = searched.collect();
    let forms = best(all.clone()).map_or_else(Vec::new, |best| with_neighbours(&best, hypotheses, null));
    all.extend(forms);
    all
}

/// Lobes at any phase to the load, where the race does not turn.
fn turned(effect: &EffectEntry) -> Vec<EffectEntry> {
    let phase = effect.number(PhaseRad).unwrap_or_default();
    let turns: &[f64] = if effect.kind == EffectKind::OuterRaceWaviness { &QUARTERS } else { &QUARTERS[..1] };
    turns.iter().map(|turn| effect.clone().with_number(PhaseRad, phase + turn)).collect()
}

/// Best of the searches from starts of the same lobes, with all their numbers.
fn searched<'d, 'a>(
    starts: Vec<EffectEntry>,
    hypotheses: &[Hypothesis],
    null: &NullFit<'d, 'a>,
) -> Option<Candidate<'d, 'a>> {
    let first = starts.first()?;
    let is_of =
        |h: &&Hypothesis| h.kind == first.kind && h.starts.iter().any(|s| s.number(Lobes) == first.number(Lobes));
    let of = hypotheses.iter().find(is_of)?;
    let of = Hypothesis { free: of.extended, ..of.clone() };
    let starts = starts.into_iter().map(|start| (&of, start)).collect();
    searched_from_best(&of, scores(null, starts, &[]), SETTINGS.wave_searches, null)
}

/// Lobes of any size and, where the race does not turn, at any phase to the load, with neighbours of no size yet: the balls that
/// bear the load change with the size, so that the likelihood has many valleys.
fn alone(effect: &EffectEntry) -> Vec<EffectEntry> {
    let alone = NEIGHBOURS.into_iter().flatten().fold(effect.clone(), |effect, key| effect.with_number(key, 0.0));
    let size = effect.number(AmplitudeM).unwrap_or_default();
    let [least, greatest] = SETTINGS.wave_sizes;
    let sizes = ladder(least * size, greatest * size, SETTINGS.wave_steps);
    let resized = |effect: EffectEntry| sizes.iter().map(move |size| effect.clone().with_number(AmplitudeM, *size));
    turned(&alone).into_iter().flat_map(resized).collect()
}

/// The same waves, but for the least, as neighbours of the greatest; none if they are so already.
fn centred(effect: &EffectEntry) -> Vec<EffectEntry> {
    let number = |key: ParameterKey| effect.number(key).unwrap_or_default();
    let share = |[cosine, sine]: [ParameterKey; 2]| number(cosine).hypot(number(sine));
    let [below, above] = NEIGHBOURS.map(share);
    let (keys, other, by, share) = if below > above {
        (NEIGHBOURS[0], NEIGHBOURS[1], -1.0, below)
    } else {
        (NEIGHBOURS[1], NEIGHBOURS[0], 1.0, above)
    };
    if share <= 1.0 {
        return Vec::new();
    }
    let [cosine, sine] = keys.map(number);
    let (s, c) = number(PhaseRad).sin_cos();
    let numbers = [
        (Lobes, number(Lobes) + by),
        (AmplitudeM, share * number(AmplitudeM)),
        (PhaseRad, (-sine).atan2(cosine)),
        (keys[0], 0.0),
        (keys[1], 0.0),
        (other[0], c / share),
        (other[1], -s / share),
    ];
    vec![numbers.into_iter().fold(effect.clone(), |effect, (key, number)| effect.with_number(key, number))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::data::{Data, Point};
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    /// Lobes with neighbours are found with both, in number and, to a factor of 1.5, in size, where the search begins at a neighbour.
    #[test]
    fn invariant_lobes_are_found_from_a_neighbour() {
        let numbers =
            [(AmplitudeM, 4e-7), (Lobes, 10.0), (BelowCos, 0.1), (BelowSin, 0.2), (AboveCos, -0.3), (AboveSin, 0.1)];
        let rig = nominal().with_effect(EffectEntry::new(EffectKind::InnerRaceWaviness, &numbers));
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let observations = [400.0, 700.0].map(|load_n| observed(&rig, load_n, &Point::default().in_recordings(1, 0)));
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, nominal());
        let null = NullFit::new(&model, &model.search(model.start().unwrap(), 4).unwrap());
        let hypotheses = null.hypotheses();
        let of = hypotheses.iter().find(|h| h.kind == EffectKind::InnerRaceWaviness && h.place == "11 lobes").unwrap();
        let single = best(null.started(of, &of.starts)).unwrap().searched(SETTINGS.steps[1]);
        let forms = with_neighbours(&single, &hypotheses, &null);
        let found = forms.last().unwrap();
        let effect = found.effect().unwrap();
        let size = effect.number(AmplitudeM).unwrap();
        assert!(found.gain > single.gain + 100.0, "{} {}", found.gain, single.gain);
        assert_eq!(found.place, "10 lobes", "{effect:?}");
        assert!((size / 4e-7).ln().abs() < 1.5f64.ln(), "{effect:?}");
    }

    /// Lobes with a greater neighbour are that neighbour with smaller ones.
    #[test]
    fn invariant_waves_are_the_same_around_the_greatest() {
        let numbers = [(AmplitudeM, 1e-7), (Lobes, 12.0), (PhaseRad, 0.4), (BelowCos, 0.0), (BelowSin, 0.0)];
        let effect = EffectEntry::new(EffectKind::InnerRaceWaviness, &numbers);
        let effect = effect.with_number(AboveCos, 1.2).with_number(AboveSin, -0.9);
        let [around] = centred(&effect).try_into().unwrap();
        assert_eq!((around.number(Lobes), centred(&around).len()), (Some(13.0), 0));
        assert!((around.number(AmplitudeM).unwrap() - 1.5e-7).abs() < 1e-15);
        let run = |effect: EffectEntry| {
            let recording = simulate(&nominal().with_effect(effect), &condition(30.0, 800.0, 8192), &Start::seeded(5));
            recording.unwrap().channels[0].samples.clone()
        };
        let (before, after, without) = (run(effect.clone()), run(around), run(effect.with_number(AmplitudeM, 0.0)));
        let greatest = |other: &[f64]| before.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(greatest(&after) < 1e-6 * greatest(&without), "{} {}", greatest(&after), greatest(&without));
    }
}
