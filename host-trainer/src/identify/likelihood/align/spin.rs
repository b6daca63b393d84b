//! Angles of a rig with a ball defect, which include the ball's spin.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use rayon::prelude::*;

use super::SETTINGS;
use super::shift::correlation;
use crate::identify::likelihood::observed::{Coefficients, Observed};
use crate::identify::likelihood::whittle::{Noise, NoiseFreeRun, judged_bins, means};
use crate::rig::{EffectEntry, Rig, RigError};

/// Whether an effect depends on the balls' spin.
pub fn spins(effect: &EffectEntry) -> bool {
    effect.kind == EffectKind::BallDefect
}

/// Moves the shaft by half turns of the ball, which keep its spin, to the angle nearest to `known`. A ball defect determines
/// the spin much better than the shaft's angle, which only the unbalance needs.
pub fn respin(rig: &Rig, angles: &mut [[f64; 2]], known: &[[f64; 2]]) {
    let Some(machine) = rig.bearing().filter(|_| rig.effects.iter().any(spins)) else { return };
    // A ball defect strikes outer and inner race in turn, alike: half a turn of the ball is the period.
    let period = 0.5 * TAU / machine.bearing.geometry().orders().bsf;
    for ([_, shaft], [_, known]) in angles.iter_mut().zip(known) {
        let away = |turned: f64| {
            let off = (*shaft + turned - known).rem_euclid(TAU);
            off.min(TAU - off)
        };
        let candidates = (0..SETTINGS.ball_half_turns).map(|k| f64::from(k) * period);
        *shaft += candidates.min_by(|a, b| away(*a).total_cmp(&away(*b))).unwrap_or_default();
    }
}

/// Angles for a rig whose ball defect is too small to outweigh the balls' passing: those of the rig without it, with each
/// ball in turn as the defective one, and the spin at which the pulses suit that rig's residual best.
///
/// # Errors
/// A run that the simulation refuses, or that diverges.
pub fn spun(
    rig: &Rig,
    plain: &Rig,
    observed: &[Observed],
    noise: &[Noise],
    known: &[[f64; 2]],
) -> Result<Vec<[f64; 2]>, RigError> {
    let Some(machine) = rig.bearing() else { return Ok(known.to_vec()) };
    let (balls, per_shaft) = (machine.bearing.balls, machine.bearing.geometry().orders().bsf);
    // Half a turn of the ball is the period; between the spins the pulses are moved in time.
    let turned = |spin: usize| TAU / 2.0 * spin as f64 / SETTINGS.spins as f64;
    let respun = |spin: usize| {
        let mut rig = rig.clone();
        rig.effects.iter_mut().filter(|e| spins(e)).for_each(|effect| {
            let now = effect.number(ParameterKey::SpinRad).unwrap_or_default();
            effect.set_number(ParameterKey::SpinRad, now + turned(spin));
        });
        rig
    };
    let rigs: Vec<Rig> = (0..SETTINGS.spins).map(respun).collect();
    let mut out = Vec::new();
    for ((o, Noise { variance, velocity_covariance: scatter, .. }), [cage, shaft]) in
        observed.iter().zip(noise).zip(known)
    {
        let choices: Vec<(usize, usize)> =
            (0..balls).flat_map(|ball| (0..SETTINGS.spins).map(move |spin| (ball, spin))).collect();
        let at = |ball: usize| [cage + TAU * ball as f64 / balls as f64, *shaft];
        let run = |rig, angles| NoiseFreeRun { rig, condition: o.condition, angles, scatter: *scatter };
        let mut runs = vec![run(plain, [*cage, *shaft])];
        runs.extend(choices.iter().map(|(ball, spin)| run(&rigs[*spin], at(*ball))));
        let mut means = means(&runs)?.into_iter();
        let Some(without) = means.next().transpose()? else { return Ok(known.to_vec()) };
        let with: Vec<_> = means.collect::<Result<_, _>>()?;
        let per_sample = per_shaft * TAU * o.condition.shaft_hz / o.condition.sample_rate_hz;
        let reach = (0.5 * turned(1) / per_sample).ceil() as i64;
        let best_of = |((ball, spin), with): (&(usize, usize), &[Coefficients; 2])| {
            let change = |c: usize, k: usize| with[c][k] - without[c][k];
            let correlation = correlation(o, variance, |c, k, x| x - without[c][k], change);
            let at = |lag: i64| correlation[lag.rem_euclid(o.condition.samples as i64) as usize];
            let lag = (-reach..=reach).max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or_default();
            let energy = |c: usize| -> f64 {
                let bins = o.spectra[c].as_ref().map_or(0..0, |x| judged_bins(x, 1.0));
                bins.map(|k| change(c, k).norm_sqr() / variance[c][k]).sum()
            };
            (at(lag) - energy(0) - energy(1), *ball, turned(*spin) + lag as f64 * per_sample)
        };
        let found = choices.par_iter().zip(&with).map(best_of).max_by(|a, b| a.0.total_cmp(&b.0));
        let (_, ball, spin) = found.unwrap_or_default();
        let [cage, shaft] = at(ball);
        out.push([cage.rem_euclid(TAU), shaft + spin / per_shaft]);
    }
    respin(rig, &mut out, known);
    Ok(out)
}
