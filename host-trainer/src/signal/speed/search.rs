//! Comb of lines that fits the evidence best and its p-value, theory (79).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::SpeedSearch;
use super::evidence::Evidence;
use super::settings::CombSettings;
use crate::signal::characteristic::{Characteristic, Family, Speeds, list};

const SETTINGS: CombSettings = CombSettings::DEFAULT;

/// Comb of the shaft's lines and, except for one, a family's.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comb {
    pub(super) family: Option<Family>,
    pub(super) teeth: Vec<Characteristic>,
}

/// Candidate combs: the shaft's harmonics alone, and with each of the bearing's families.
pub(super) fn families(search: &SpeedSearch) -> Vec<Comb> {
    let speeds = Speeds { shaft_hz: search.nominal_hz, geometry: search.geometry, slip: 0.0 };
    let all = list(&speeds, f64::INFINITY, SETTINGS.shaft_harmonics, SETTINGS.sidebands);
    let of = |family: Family, most: u32| {
        all.iter().filter(move |c| c.family == family && c.harmonic <= most).cloned().collect::<Vec<_>>()
    };
    let shaft = of(Family::Shaft, SETTINGS.shaft_harmonics);
    let mut combs = vec![Comb { family: None, teeth: shaft.clone() }];
    if search.geometry.is_some() {
        let with = |family| Comb {
            family: Some(family),
            teeth: [shaft.clone(), of(family, SETTINGS.bearing_harmonics)].concat(),
        };
        combs.extend([Family::Outer, Family::Inner, Family::Ball].map(with));
    }
    combs
}

/// Highest frequency that a comb reaches, Hz.
pub(super) fn highest_hz(search: &SpeedSearch, combs: &[Comb]) -> f64 {
    let teeth = combs.iter().flat_map(|comb| &comb.teeth);
    teeth.map(|tooth| tooth.frequency_hz).fold(0.0, f64::max) * (1.0 + search.range) + search.nominal_hz
}

/// Best comb with its speed, slip and p-value.
pub(super) struct BestComb {
    pub(super) comb: Comb,
    pub(super) shaft_hz: f64,
    pub(super) slip: f64,
    /// Share of as good combs with every tooth moved at random but the family's own harmonics: the significance of the
    /// shaft's harmonics and the sidebands, which alone separate speed from slip.
    pub(super) p_value: f64,
}

struct Best {
    score: f64,
    comb: usize,
    shaft_hz: f64,
    slip: f64,
}

/// Teeth that a trial moves at random.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Moved {
    None,
    /// All but the harmonics of a bearing's family.
    Shafts,
    All,
}

/// Best comb over all families, speeds and slips, with its p-value.
pub(super) fn best(evidence: &Evidence, search: &SpeedSearch, combs: &[Comb]) -> BestComb {
    let found = over_all(evidence, search, combs, Moved::None, 0);
    let p_value = share_as_good(found.score, evidence, search, combs, Moved::Shafts);
    BestComb { comb: combs[found.comb].clone(), shaft_hz: found.shaft_hz, slip: found.slip, p_value }
}

/// p-value of the best comb against combs with every tooth moved.
pub(super) fn p_value_of_all(evidence: &Evidence, search: &SpeedSearch, combs: &[Comb]) -> f64 {
    let found = over_all(evidence, search, combs, Moved::None, 0);
    share_as_good(found.score, evidence, search, combs, Moved::All)
}

/// Sequential Monte Carlo p-value, which ends early once enough trials are as good (J. Besag, P. Clifford, "Sequential
/// Monte Carlo p-values", Biometrika 78 (1991) 301–304).
fn share_as_good(score: f64, evidence: &Evidence, search: &SpeedSearch, combs: &[Comb], moved: Moved) -> f64 {
    let (mut beaten, mut tried) = (0, 0);
    let trials: Vec<u64> = (1..=search.trials as u64).collect();
    for some in trials.chunks(SETTINGS.trials_at_once) {
        let as_good = |trial: &&u64| over_all(evidence, search, combs, moved, **trial).score >= score;
        beaten += some.par_iter().filter(as_good).count();
        tried += some.len();
        if beaten >= SETTINGS.max_exceedances {
            return beaten as f64 / tried as f64;
        }
    }
    (1 + beaten) as f64 / (1 + tried) as f64
}

fn over_all(evidence: &Evidence, search: &SpeedSearch, combs: &[Comb], moved: Moved, trial: u64) -> Best {
    let mut rng = ChaCha8Rng::seed_from_u64(search.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(trial));
    let (mean, deviation) = evidence.spread();
    let nominal = search.nominal_hz;
    let mut best = Best { score: f64::NEG_INFINITY, comb: 0, shaft_hz: nominal, slip: 0.0 };
    // The shaft's teeth are moved alike in all combs, by at most half their spacing.
    let most = combs.iter().map(|comb| comb.teeth.len()).max().unwrap_or(0);
    let chance: Vec<f64> = (0..most).map(|_| rng.random_range(-0.5..0.5) * nominal).collect();
    let shift = |tooth: &Characteristic, by: f64| match moved {
        Moved::None => 0.0,
        Moved::Shafts if tooth.family != Family::Shaft && tooth.sideband == 0 => 0.0,
        Moved::Shafts | Moved::All => by,
    };
    for (index, comb) in combs.iter().enumerate() {
        let highest = comb.teeth.iter().map(|t| t.frequency_hz).fold(0.0, f64::max);
        // Speed steps that move the highest tooth by one step of the evidence.
        let speeds = (search.range * highest / evidence.step_hz).ceil().max(1.0) as i32;
        let slips = if comb.family.is_some() { SETTINGS.slip_range * search.slip_std } else { 0.0 };
        let slip_steps = (slips * highest / evidence.step_hz).ceil() as i32;
        for slip in (-slip_steps..=slip_steps).map(|k| slips * f64::from(k) / f64::from(slip_steps.max(1))) {
            let mut teeth: Vec<(f64, f64)> =
                comb.teeth.iter().zip(&chance).map(|(t, by)| (t.law.frequency_hz(1.0, slip), shift(t, *by))).collect();
            let place = |(order, shift): &(f64, f64), shaft_hz: f64| order * shaft_hz + shift;
            teeth.sort_by(|a, b| place(a, nominal).total_cmp(&place(b, nominal)));
            let doubt = if slips > 0.0 { 0.5 * (slip / search.slip_std).powi(2) } else { 0.0 };
            for k in -speeds..=speeds {
                let shaft_hz = nominal * (1.0 + search.range * f64::from(k) / f64::from(speeds));
                // Of teeth that fall together, as 7×shaft and 2×BPFO may, only the first counts.
                let (mut sum, mut n, mut last) = (0.0, 0.0, f64::NEG_INFINITY);
                for tooth in &teeth {
                    let at = place(tooth, shaft_hz);
                    if at - last >= SETTINGS.merge_steps * evidence.step_hz {
                        sum += evidence.at(at);
                        n += 1.0;
                        last = at;
                    }
                }
                let score = (sum - n * mean) / (deviation * f64::max(n, 1.0).sqrt()).max(f64::MIN_POSITIVE) - doubt;
                if score > best.score {
                    best = Best { score, comb: index, shaft_hz, slip };
                }
            }
        }
    }
    best
}
