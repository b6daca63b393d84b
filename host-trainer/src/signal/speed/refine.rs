//! From a comb a step of the spectrum wide to a speed with its standard error.

use super::evidence::Evidence;
use super::search::BestComb;
use super::{SpeedEstimate, SpeedLine, SpeedSearch};
use crate::signal::characteristic::Characteristic;
use crate::signal::spectrum::Spectrum;

/// Power over noise from which a value is a line: 12 is one exponential value of 160,000; averages are narrower.
const LINE: f64 = 12.0;
/// Rounds of choosing lines and solving.
const ROUNDS: usize = 6;
/// Steps around where the comb puts a tooth in which its line is looked for, in the first and in later rounds.
const REACH: (f64, f64) = (1.6, 1.2);
/// Share of a step that a line is placed to at the best: real ones are not pure.
const PLACED: f64 = 0.05;
/// Lines nearer than so many steps are one.
const SAME: f64 = 1.5;
/// Speeds to begin at, to either side, and what they are apart by in steps of the spectrum.
const STARTS: i32 = 4;
const START_STEP: f64 = 0.05;
/// Deviations at which a line's weight is a quarter: one that belongs to something else must not pull.
const FAR: f64 = 3.0;

/// A line at a tooth.
struct Observed {
    line: SpeedLine,
    shaft: f64,
    cage: f64,
    deviation_hz: f64,
}

/// Speed and slip by least squares over the lines at the comb's teeth; `None` where there are none.
///
/// Lines of other machines near a tooth draw a solution to themselves that begins near them: so it begins at several
/// speeds around the comb's, and the solution that most lines agree on counts.
pub(super) fn refine(evidence: &Evidence, search: &SpeedSearch, found: &BestComb) -> Option<SpeedEstimate> {
    let starts = (-STARTS..=STARTS).map(|k| found.shaft_hz + f64::from(k) * evidence.step_hz * START_STEP);
    let solutions = starts.filter_map(|shaft_hz| from(shaft_hz, evidence, search, found));
    let (observed, solved) = solutions.max_by(|a, b| a.1.agreement.total_cmp(&b.1.agreement))?;
    let sees_cage = observed.iter().any(|o| o.cage != 0.0);
    let lines = observed.into_iter().map(|o| {
        let fitted_hz = (o.shaft + o.cage * (1.0 - solved.slip)) * solved.shaft_hz;
        SpeedLine { fitted_hz, ..o.line }
    });
    Some(SpeedEstimate {
        shaft_hz: solved.shaft_hz,
        standard_error_hz: solved.shaft_error_hz,
        p_value: found.p_value,
        slip: sees_cage.then_some((solved.slip, solved.slip_error)),
        family: found.comb.family.filter(|_| sees_cage),
        lines: lines.collect(),
    })
}

/// Lines near the teeth and the solution for them, in turns.
fn from(start_hz: f64, evidence: &Evidence, search: &SpeedSearch, found: &BestComb) -> Option<(Vec<Observed>, Solved)> {
    let (mut shaft_hz, mut slip) = (start_hz, found.slip);
    let mut solution = None;
    for round in 0..ROUNDS {
        let reach = if round == 0 { REACH.0 } else { REACH.1 };
        let observed = observe(shaft_hz, slip, reach, evidence, found);
        let solved = solve(&observed, search, shaft_hz, slip)?;
        (shaft_hz, slip) = (solved.shaft_hz, solved.slip);
        solution = Some((observed, solved));
    }
    solution
}

/// The lines near the teeth of a comb.
fn observe(shaft_hz: f64, slip: f64, reach: f64, evidence: &Evidence, found: &BestComb) -> Vec<Observed> {
    let at = |tooth: &Characteristic| {
        let expected_hz = tooth.law.frequency_hz(shaft_hz, slip);
        let peaks = evidence.ratios.iter().filter_map(|s| peak(s, expected_hz, reach));
        let (frequency_hz, ratio) = peaks.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (ratio > LINE / evidence.averaged.sqrt()).then(|| Observed {
            line: SpeedLine { name: tooth.name.clone(), frequency_hz, fitted_hz: expected_hz, ratio },
            shaft: tooth.law.shaft,
            cage: tooth.law.cage,
            // A tone in noise (Rife & Boorstyn 1974): √3/(2π)·step/√ratio.
            deviation_hz: evidence.step_hz * (0.276 / (ratio * evidence.averaged).sqrt()).hypot(PLACED),
        })
    };
    let mut observed: Vec<Observed> = found.comb.teeth.iter().filter_map(at).collect();
    // A line that two teeth would have goes to the nearer.
    observed.sort_by(|a, b| a.line.frequency_hz.total_cmp(&b.line.frequency_hz));
    let miss = |o: &Observed| (o.line.frequency_hz - o.line.fitted_hz).abs();
    observed.dedup_by(|b, a| {
        let same = b.line.frequency_hz - a.line.frequency_hz < SAME * evidence.step_hz;
        if same && miss(b) < miss(a) {
            std::mem::swap(a, b);
        }
        same
    });
    observed
}

struct Solved {
    shaft_hz: f64,
    shaft_error_hz: f64,
    slip: f64,
    slip_error: f64,
    /// Lines, each as far as it fits.
    agreement: f64,
}

/// Weighted least squares for the shaft's and the cage's share, c = (1 − slip)·shaft, whose ratio is 1 within the
/// slip's deviation; errors grow with the scatter where it is more than expected.
fn solve(observed: &[Observed], search: &SpeedSearch, shaft_hz: f64, slip: f64) -> Option<Solved> {
    if observed.len() < 2 {
        return None;
    }
    // Normal equations of a·s + b·c = f, with the prior s − c = 0.
    let prior = (search.slip_std * search.nominal_hz).powi(-2);
    let (mut aa, mut ab, mut bb, mut af, mut bf) = (prior, -prior, prior, 0.0, 0.0);
    let (mut scatter, mut count) = (0.0, 0.0);
    for o in observed {
        let miss = (o.line.frequency_hz - (o.shaft + o.cage * (1.0 - slip)) * shaft_hz) / o.deviation_hz;
        let trust = (1.0 + (miss / FAR).powi(2)).powi(-2);
        let weight = trust / (o.deviation_hz * o.deviation_hz);
        aa += weight * o.shaft * o.shaft;
        ab += weight * o.shaft * o.cage;
        bb += weight * o.cage * o.cage;
        af += weight * o.shaft * o.line.frequency_hz;
        bf += weight * o.cage * o.line.frequency_hz;
        scatter += trust * miss * miss;
        count += trust;
    }
    let determinant = aa * bb - ab * ab;
    let (shaft, cage) = ((af * bb - bf * ab) / determinant, (bf * aa - af * ab) / determinant);
    // Scatter beyond what the deviations say is in the lines, not in the slip's prior; so it scales all but that, and
    // the prior's part is small where there are lines to scatter.
    let inflation = (scatter / f64::max(count - 2.0, 1.0)).max(1.0);
    let (var_s, var_c, cov) = (bb / determinant, aa / determinant, -ab / determinant);
    let slip = 1.0 - cage / shaft;
    let var_slip = (var_c + (1.0 - slip).powi(2) * var_s - 2.0 * (1.0 - slip) * cov) / (shaft * shaft);
    let solved = Solved {
        shaft_hz: shaft,
        shaft_error_hz: (inflation * var_s).sqrt(),
        slip,
        agreement: count,
        slip_error: (inflation * var_slip.max(0.0)).sqrt(),
    };
    (determinant > 0.0 && solved.shaft_hz.is_finite() && solved.shaft_error_hz.is_finite()).then_some(solved)
}

/// Greatest value within some steps of a frequency, placed between steps by a parabola through the logarithms of its
/// neighbours, with its height.
fn peak(spectrum: &Spectrum, expected_hz: f64, reach: f64) -> Option<(f64, f64)> {
    let values = &spectrum.values;
    let at = expected_hz / spectrum.step_hz;
    let from = (at - reach).ceil().max(2.0) as usize;
    let to = ((at + reach).floor() as usize).min(values.len().checked_sub(2)?);
    let top = (from..=to).max_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    let [a, b, c] = [top - 1, top, top + 1].map(|k| values[k].max(f64::MIN_POSITIVE).ln());
    let bend = a - 2.0 * b + c;
    // On the flank of another line there is no top.
    (bend < 0.0 && b >= a && b >= c).then(|| ((top as f64 + 0.5 * (a - c) / bend) * spectrum.step_hz, values[top]))
}
