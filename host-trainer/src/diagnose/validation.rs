//! Validation on held-out recordings.

use super::DiagnoseError;
use super::result::{Fit, HeldOut};
use crate::identify::calibrate::distance::log_spectral;
use crate::identify::likelihood::observed::{CHANNELS, Observed, accelerations};
use crate::identify::likelihood::problem::Problem;
use crate::identify::likelihood::search::{Limits, search, search_from_rig};
use crate::identify::likelihood::whittle::{Prediction, judged_bins};
use crate::rig::{Rig, RigError, Run, Start, simulate_many};
use crate::stats::significance::sign_flip_of;

/// Bins of a block whose gains are summed, as neighbouring bins correlate.
const BLOCK: usize = 32;

/// Fit of a correction to held-out recordings.
#[derive(Clone, Debug)]
pub struct Validation {
    /// −ln L of the rig before, above the expectation of the true rig.
    pub before: f64,
    /// −ln L of the corrected rig, above the expectation of the true rig.
    pub after: f64,
    /// `before` per bin.
    pub before_each: f64,
    /// `after` per bin.
    pub after_each: f64,
    /// Standard deviation of −ln L per bin under the true rig.
    pub floor_each: f64,
    /// Ratio of error powers, after over before, of the worse channel.
    pub error_ratio: f64,
    /// p-value of the gain.
    pub p_value: f64,
    /// Held-out recordings with both simulations.
    pub traces: Vec<HeldOut>,
}

/// Compares two rigs on held-out recordings; only the angles are fitted to them.
///
/// # Errors
/// What the simulation refuses.
pub fn validate(before: &Rig, after: &Rig, held_out: &[Observed], seed: u64) -> Result<Validation, DiagnoseError> {
    let (before, old_expected) = Side::aligned(before, held_out)?;
    let (after, new_expected) = Side::aligned_given(after, &before, held_out)?;
    let mut gains = Vec::new();
    let (mut old, mut new, mut bins) = (0.0, 0.0, 0usize);
    let mut errors = [[0.0; 2]; 2];
    for (index, o) in held_out.iter().enumerate() {
        for (channel, errors) in errors.iter_mut().enumerate() {
            let Some(x) = &o.spectra[channel] else { continue };
            let (was, is) = (&old_expected[index], &new_expected[index]);
            let each = |e: &Prediction, k: usize| {
                e.noise.variance[channel][k].ln()
                    + (x[k] - e.mean[channel][k]).norm_sqr() / e.noise.variance[channel][k]
            };
            let all: Vec<usize> = judged_bins(x, 1.0).collect();
            let error = |e: &Prediction| all.iter().map(|k| (x[*k] - e.mean[channel][*k]).norm_sqr()).sum::<f64>();
            errors[0] += error(was);
            errors[1] += error(is);
            for block in all.chunks(BLOCK) {
                let before: f64 = block.iter().map(|k| each(was, *k)).sum();
                let after: f64 = block.iter().map(|k| each(is, *k)).sum();
                gains.push(before - after);
                // ln S + 1 is the expectation of the true rig, for which the corrected one is taken.
                let right: f64 = block.iter().map(|k| is.noise.variance[channel][*k].ln() + 1.0).sum();
                old += before - right;
                new += after - right;
                bins += block.len();
            }
        }
    }
    let traces = traces(held_out, &before, &after, seed)?;
    let n = bins.max(1) as f64;
    Ok(Validation {
        before: old,
        after: new,
        before_each: old / n,
        after_each: new / n,
        floor_each: 1.0 / n.sqrt(),
        error_ratio: errors.iter().map(|[was, is]| is / was.max(f64::MIN_POSITIVE)).fold(0.0, f64::max),
        p_value: p_value(&gains, held_out.len(), seed),
        traces,
    })
}

/// Fit of an acquisition fault to held-out recordings: log-spectral distance before and after, dB, and that of two runs of
/// the corrected rig as the floor.
///
/// # Errors
/// What the simulation refuses.
pub fn shown(
    before: &Rig,
    after: &Rig,
    held_out: &[Observed],
    described: &str,
    p_value: f64,
    seed: u64,
) -> Result<(Fit, Vec<HeldOut>), DiagnoseError> {
    let (before, _) = Side::aligned(before, held_out)?;
    let after = Side { rig: after, angles: before.angles.clone() };
    let again = traces(held_out, &before, &after, seed.wrapping_add(1))?;
    let traces = traces(held_out, &before, &after, seed)?;
    let mean = |of: &dyn Fn(&HeldOut, &HeldOut) -> Option<f64>| {
        let all: Vec<f64> = traces.iter().zip(&again).filter_map(|(t, u)| of(t, u)).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    let fit = Fit {
        metric: "log-spectral distance, dB".into(),
        held_out: described.into(),
        before: mean(&|t, _| log_spectral(&t.measured, &t.before, t.sample_rate_hz)),
        after: mean(&|t, _| log_spectral(&t.measured, &t.after, t.sample_rate_hz)),
        noise_floor: mean(&|t, u| log_spectral(&u.after, &t.after, t.sample_rate_hz)),
        p_value,
    };
    Ok((fit, traces))
}

/// Mean gain in ln L by fitting the angles of a recording to it.
const ANGLES_GAIN: f64 = 1.0;

/// p-value of the gains: the smaller of two tests, times two (Bonferroni).
///
/// The first, theory (81), flips signs of the gains, clamped so that no single block decides; it assumes nothing of either
/// rig. The second detects gains in few frequencies: a rig fitted elsewhere is e^g times as likely as the true one with
/// probability e^−g at most (Ville's inequality; G. Shafer, "Testing by betting", J. R. Stat. Soc. A 184 (2021) 407–431).
fn p_value(gains: &[f64], recordings: usize, seed: u64) -> f64 {
    let gain: f64 = gains.iter().sum();
    let by_betting = (ANGLES_GAIN * recordings as f64 - gain).exp();
    (2.0 * by_signs(gains, seed).min(by_betting)).min(1.0)
}

fn by_signs(gains: &[f64], seed: u64) -> f64 {
    let mut sizes: Vec<f64> = gains.iter().map(|g| g.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = 5.0 * sizes.get(sizes.len() * 9 / 10).copied().unwrap_or_default();
    let gains: Vec<f64> = gains.iter().map(|g| g.clamp(-most, most)).collect();
    sign_flip_of(&gains, seed)
}

/// Rig with the initial angles of the held-out recordings.
struct Side<'r> {
    rig: &'r Rig,
    angles: Vec<[f64; 2]>,
}

impl<'r> Side<'r> {
    /// Rig with fitted angles, and its predictions of the recordings.
    fn aligned(rig: &'r Rig, held_out: &[Observed]) -> Result<(Self, Vec<Prediction>), RigError> {
        let problem = Problem::of_angles(held_out, rig.clone());
        let point = search_from_rig(&problem)?.point;
        let expected = problem.predict(&point)?;
        Ok((Self { rig, angles: point.angles }, expected))
    }

    /// Rig with angles fitted from those of the rig without the causes, and its predictions.
    fn aligned_given(rig: &'r Rig, without: &Side, held_out: &[Observed]) -> Result<(Self, Vec<Prediction>), RigError> {
        let problem = Problem::of_angles(held_out, rig.clone());
        let angles = problem.aligned_given(rig, without.rig, &without.angles, &[])?;
        let point = search(&problem, problem.start_at(angles), &Limits::default())?.point;
        let expected = problem.predict(&point)?;
        Ok((Self { rig, angles: point.angles }, expected))
    }
}

fn traces(held_out: &[Observed], before: &Side, after: &Side, seed: u64) -> Result<Vec<HeldOut>, RigError> {
    let run = |side: &Side| simulate_many(&runs(side.rig, held_out, &side.angles, seed));
    let (old, new) = (run(before)?, run(after)?);
    let mut out = Vec::new();
    for (index, o) in held_out.iter().enumerate() {
        for (channel, measured) in o.samples.iter().enumerate() {
            let Some(measured) = measured else { continue };
            let of = |r: &crate::recording::Recording| {
                accelerations(r)[channel].map_or_else(Vec::new, |c| c.samples.clone())
            };
            out.push(HeldOut {
                name: format!("{}-{}", o.name, CHANNELS[channel]),
                sample_rate_hz: o.condition.sample_rate_hz,
                measured: measured.clone(),
                before: of(&old[index]),
                after: of(&new[index]),
            });
        }
    }
    Ok(out)
}

fn runs<'r>(rig: &'r Rig, observed: &[Observed], angles: &[[f64; 2]], seed: u64) -> Vec<Run<'r>> {
    let of = |(index, (o, [cage, shaft])): (usize, (&Observed, &[f64; 2]))| Run {
        rig,
        condition: o.condition,
        start: Start { cage_angle0_rad: *cage, shaft_angle0_rad: *shaft, ..Start::of_series(seed, index) },
    };
    observed.iter().zip(angles).enumerate().map(of).collect()
}

/// Simulations of the recordings by the rig, with independent noise.
///
/// # Errors
/// What the simulation refuses.
pub fn replicate(
    rig: &Rig,
    observed: &[Observed],
    angles: &[[f64; 2]],
    seed: u64,
) -> Result<Vec<Observed>, DiagnoseError> {
    let made = simulate_many(&runs(rig, observed, angles, seed))?;
    let each = made.iter().zip(observed);
    each.map(|(m, o)| {
        let made = Observed::from_recording(m)?;
        Ok(Observed { name: o.name.clone(), tachometer: made.tachometer.filter(|_| o.tachometer.is_some()), ..made })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_gains_of_no_sign_prove_nothing_and_steady_ones_do() {
        let mixed: Vec<f64> = (0..200u32).map(|k| f64::from(k * 7919 % 101) - 50.0).collect();
        assert!(by_signs(&mixed, 1) > 0.05);
        let steady: Vec<f64> = mixed.iter().map(|g| g + 15.0).collect();
        assert!(by_signs(&steady, 1) < 0.001);
        let one = [vec![1e6], vec![-0.1; 200]].concat();
        assert!(by_signs(&one, 1) > 0.5, "one block does not decide");
    }

    #[test]
    fn a_gain_in_few_frequencies_is_proof_where_it_is_large() {
        let mixed: Vec<f64> = (0..200u32).map(|k| (f64::from(k * 7919 % 101) - 50.0) / 50.0).collect();
        let line = |gain: f64| [mixed.clone(), vec![gain - mixed.iter().sum::<f64>()]].concat();
        assert!(p_value(&line(0.0), 1, 1) > 0.1);
        // Two nats more than the angles give are no validation, fifteen are.
        assert!(p_value(&line(3.0), 1, 1) > 0.1);
        assert!(p_value(&line(16.0), 1, 1) < 1e-5);
    }
}
