//! Speed with its standard error from the best comb, by least squares over its lines, theory (80).

use super::evidence::Evidence;
use super::search::BestComb;
use super::settings::RefineSettings;
use super::{SpeedEstimate, SpeedLine, SpeedSearch};
use crate::signal::characteristic::Characteristic;
use crate::signal::spectrum::Spectrum;

const SETTINGS: RefineSettings = RefineSettings::DEFAULT;

/// A line at a tooth.
struct Observed {
    line: SpeedLine,
    shaft: f64,
    cage: f64,
    deviation_hz: f64,
}

/// Speed and slip by least squares over the lines at the comb's teeth, theory (80); `None` for fewer than two lines.
///
/// A foreign line near a tooth attracts solutions that start near it: the fit starts at several speeds around the
/// comb's, and the solution that most lines agree on counts.
pub(super) fn refine(evidence: &Evidence, search: &SpeedSearch, found: &BestComb) -> Option<SpeedEstimate> {
    let (each, spacing) = (SETTINGS.starts_per_side, SETTINGS.start_spacing_steps);
    let starts = (-each..=each).map(|k| found.shaft_hz + f64::from(k) * evidence.step_hz * spacing);
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

/// Alternates line assignment and least squares from a starting speed.
fn from(start_hz: f64, evidence: &Evidence, search: &SpeedSearch, found: &BestComb) -> Option<(Vec<Observed>, Solved)> {
    let (mut shaft_hz, mut slip) = (start_hz, found.slip);
    let mut solution = None;
    for round in 0..SETTINGS.rounds {
        let reach = if round == 0 { SETTINGS.first_reach_steps } else { SETTINGS.reach_steps };
        let observed = observe(shaft_hz, slip, reach, evidence, found);
        let solved = solve(&observed, search, shaft_hz, slip)?;
        (shaft_hz, slip) = (solved.shaft_hz, solved.slip);
        solution = Some((observed, solved));
    }
    solution
}

/// Lines near the teeth of a comb.
fn observe(shaft_hz: f64, slip: f64, reach: f64, evidence: &Evidence, found: &BestComb) -> Vec<Observed> {
    let at = |tooth: &Characteristic| {
        let expected_hz = tooth.law.frequency_hz(shaft_hz, slip);
        let peaks = evidence.ratios.iter().filter_map(|s| peak(s, expected_hz, reach));
        let (frequency_hz, ratio) = peaks.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (ratio > SETTINGS.line_ratio / evidence.averaged.sqrt()).then(|| Observed {
            line: SpeedLine { name: tooth.name.clone(), frequency_hz, fitted_hz: expected_hz, ratio },
            shaft: tooth.law.shaft,
            cage: tooth.law.cage,
            // A tone in noise (Rife & Boorstyn 1974): √3/(2π)·step/√ratio.
            deviation_hz: evidence.step_hz
                * (0.276 / (ratio * evidence.averaged).sqrt()).hypot(SETTINGS.frequency_floor_steps),
        })
    };
    let mut observed: Vec<Observed> = found.comb.teeth.iter().filter_map(at).collect();
    // A line at two teeth goes to the nearer.
    observed.sort_by(|a, b| a.line.frequency_hz.total_cmp(&b.line.frequency_hz));
    let miss = |o: &Observed| (o.line.frequency_hz - o.line.fitted_hz).abs();
    observed.dedup_by(|b, a| {
        let same = b.line.frequency_hz - a.line.frequency_hz < SETTINGS.merge_steps * evidence.step_hz;
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
    /// Sum of the lines' trust.
    agreement: f64,
}

/// One step of theory (80): weighted least squares for the speed s and c = (1 − slip)·s, with s − c = 0 within the
/// slip's deviation as prior; standard errors grow with scatter beyond the expected.
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
        let trust = (1.0 + (miss / SETTINGS.trust_deviations).powi(2)).powi(-2);
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
    // Excess scatter belongs to the lines, not to the slip's prior, whose part is small once there are lines.
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

/// Frequency and height of the greatest value within `reach` steps of a frequency, placed between steps by a parabola
/// through logarithms; `None` if it is no local maximum.
fn peak(spectrum: &Spectrum, expected_hz: f64, reach: f64) -> Option<(f64, f64)> {
    let values = &spectrum.values;
    let at = expected_hz / spectrum.step_hz;
    let from = (at - reach).ceil().max(2.0) as usize;
    let to = ((at + reach).floor() as usize).min(values.len().checked_sub(2)?);
    let top = (from..=to).max_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    let [a, b, c] = [top - 1, top, top + 1].map(|k| values[k].max(f64::MIN_POSITIVE).ln());
    let bend = a - 2.0 * b + c;
    // The flank of another line is no maximum.
    (bend < 0.0 && b >= a && b >= c).then(|| ((top as f64 + 0.5 * (a - c) / bend) * spectrum.step_hz, values[top]))
}
