//! The comb of lines that fits the evidence best, and what that is worth.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::SpeedSearch;
use super::evidence::Evidence;
use crate::signal::characteristic::{Characteristic, Family, Speeds, list};

/// Harmonics of the shaft.
const SHAFT: u32 = 10;
/// Harmonics and sidebands of the bearing's families.
const HARMONICS: u32 = 5;
const SIDEBANDS: i32 = 2;
/// Teeth nearer than so many steps of the evidence are one: it is three wide.
const TOGETHER: f64 = 3.0;
/// Trials that do as well, after which no more are made, and how many are made at once.
const ENOUGH: usize = 5;
const AT_ONCE: usize = 8;
/// Slip is looked for so many standard deviations to either side.
const SLIPS: f64 = 2.5;

/// The shaft's lines, with a family's where there is one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comb {
    pub(super) family: Option<Family>,
    pub(super) teeth: Vec<Characteristic>,
}

/// The combs that are tried: the shaft's harmonics alone, and with each of the bearing's families.
pub(super) fn families(search: &SpeedSearch) -> Vec<Comb> {
    let speeds = Speeds { shaft_hz: search.nominal_hz, geometry: search.geometry, slip: 0.0 };
    let all = list(&speeds, f64::INFINITY, SHAFT, SIDEBANDS);
    let of = |family: Family, most: u32| {
        all.iter().filter(move |c| c.family == family && c.harmonic <= most).cloned().collect::<Vec<_>>()
    };
    let shaft = of(Family::Shaft, SHAFT);
    let mut combs = vec![Comb { family: None, teeth: shaft.clone() }];
    if search.geometry.is_some() {
        let with = |family| Comb { family: Some(family), teeth: [shaft.clone(), of(family, HARMONICS)].concat() };
        combs.extend([Family::Outer, Family::Inner, Family::Ball].map(with));
    }
    combs
}

/// The highest frequency that a comb reaches, Hz.
pub(super) fn highest_hz(search: &SpeedSearch, combs: &[Comb]) -> f64 {
    let teeth = combs.iter().flat_map(|comb| &comb.teeth);
    teeth.map(|tooth| tooth.frequency_hz).fold(0.0, f64::max) * (1.0 + search.range) + search.nominal_hz
}

/// The comb that fits best.
pub(super) struct BestComb {
    pub(super) comb: Comb,
    pub(super) shaft_hz: f64,
    pub(super) slip: f64,
    /// Share of combs that fit as well though every tooth is moved by chance but the family's own harmonics: what
    /// the shaft's harmonics and the sidebands are worth, which alone tell speed from slip.
    pub(super) p_value: f64,
}

struct Best {
    score: f64,
    comb: usize,
    shaft_hz: f64,
    slip: f64,
}

/// Which teeth chance moves.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Moved {
    None,
    /// All but the harmonics of a bearing's family.
    Shafts,
    All,
}

/// Over all combs, speeds and slips; and the same for combs moved by chance.
pub(super) fn best(evidence: &Evidence, search: &SpeedSearch, combs: &[Comb]) -> BestComb {
    let found = over_all(evidence, search, combs, Moved::None, 0);
    let p_value = share_as_good(found.score, evidence, search, combs, Moved::Shafts);
    BestComb { comb: combs[found.comb].clone(), shaft_hz: found.shaft_hz, slip: found.slip, p_value }
}

/// The share of combs with every tooth moved that fit as well as the best.
pub(super) fn p_value_of_all(evidence: &Evidence, search: &SpeedSearch, combs: &[Comb]) -> f64 {
    let found = over_all(evidence, search, combs, Moved::None, 0);
    share_as_good(found.score, evidence, search, combs, Moved::All)
}

/// One by one until [`ENOUGH`] do as well: by then the share is plain (J. Besag, P. Clifford, "Sequential Monte Carlo
/// p-values", Biometrika 78 (1991) 301–304).
fn share_as_good(score: f64, evidence: &Evidence, search: &SpeedSearch, combs: &[Comb], moved: Moved) -> f64 {
    let (mut beaten, mut tried) = (0, 0);
    let trials: Vec<u64> = (1..=search.trials as u64).collect();
    for some in trials.chunks(AT_ONCE) {
        let as_good = |trial: &&u64| over_all(evidence, search, combs, moved, **trial).score >= score;
        beaten += some.par_iter().filter(as_good).count();
        tried += some.len();
        if beaten >= ENOUGH {
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
    // The shaft's teeth are moved alike in all combs that hold them: by less than half of what they are apart.
    let most = combs.iter().map(|comb| comb.teeth.len()).max().unwrap_or(0);
    let chance: Vec<f64> = (0..most).map(|_| rng.random_range(-0.5..0.5) * nominal).collect();
    let shift = |tooth: &Characteristic, by: f64| match moved {
        Moved::None => 0.0,
        Moved::Shafts if tooth.family != Family::Shaft && tooth.sideband == 0 => 0.0,
        Moved::Shafts | Moved::All => by,
    };
    for (index, comb) in combs.iter().enumerate() {
        let highest = comb.teeth.iter().map(|t| t.frequency_hz).fold(0.0, f64::max);
        // Steps that move the highest tooth by one of the evidence's.
        let speeds = (search.range * highest / evidence.step_hz).ceil().max(1.0) as i32;
        let slips = if comb.family.is_some() { SLIPS * search.slip_std } else { 0.0 };
        let slip_steps = (slips * highest / evidence.step_hz).ceil() as i32;
        for slip in (-slip_steps..=slip_steps).map(|k| slips * f64::from(k) / f64::from(slip_steps.max(1))) {
            let mut teeth: Vec<(f64, f64)> =
                comb.teeth.iter().zip(&chance).map(|(t, by)| (t.law.frequency_hz(1.0, slip), shift(t, *by))).collect();
            let place = |(order, shift): &(f64, f64), shaft_hz: f64| order * shaft_hz + shift;
            teeth.sort_by(|a, b| place(a, nominal).total_cmp(&place(b, nominal)));
            let doubt = if slips > 0.0 { 0.5 * (slip / search.slip_std).powi(2) } else { 0.0 };
            for k in -speeds..=speeds {
                let shaft_hz = nominal * (1.0 + search.range * f64::from(k) / f64::from(speeds));
                // A line counts once: of teeth that fall together, as 7×shaft and 2×BPFO may, the first.
                let (mut sum, mut n, mut last) = (0.0, 0.0, f64::NEG_INFINITY);
                for tooth in &teeth {
                    let at = place(tooth, shaft_hz);
                    if at - last >= TOGETHER * evidence.step_hz {
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
