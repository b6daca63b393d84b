//! Expected gain of a start: one run with the effect, compared with the null model's prediction.

use rayon::prelude::*;

use super::hypothesis::Start;
use crate::identify::likelihood::align;
use crate::identify::likelihood::observed::{Coefficients, Observed};
use crate::identify::likelihood::whittle::{Noise, NoiseFreeRun, Prediction, judged_bins, means, noises};
use crate::rig::random_part::{Asked, depends_on_velocity_noise};
use crate::rig::{Rig, RigError};

/// Runs that are held in memory at a time.
const BATCH: usize = 128;

/// Expected gain of a start.
#[derive(Clone, Debug)]
pub struct StartScore {
    /// Index of the hypothesis.
    pub hypothesis: usize,
    /// Start, its strength scaled if that scores more.
    pub start: Start,
    /// Initial angles of each recording, rad.
    pub angles: Vec<[f64; 2]>,
    /// Expected gain in ln L.
    pub log_likelihood_gain: f64,
}

/// Recordings with the predictions of the null model.
pub struct NullPrediction<'o> {
    /// Recordings.
    pub observed: &'o [Observed],
    /// Initial angles of each recording, rad.
    pub angles: Vec<[f64; 2]>,
    /// Predictions of the null model.
    pub expected: Vec<Prediction>,
    /// Variance of their random parts by the rig's mean slopes, where it has force laws that are others in noise.
    by_mean_slopes: Option<Vec<[Vec<f64>; 2]>>,
}

impl<'o> NullPrediction<'o> {
    /// Predictions of a rig at these initial angles.
    ///
    /// # Errors
    /// Errors of the simulation.
    pub fn new(
        rig: &Rig,
        observed: &'o [Observed],
        angles: Vec<[f64; 2]>,
        expected: Vec<Prediction>,
    ) -> Result<Self, RigError> {
        let mut null = Self { observed, angles, expected, by_mean_slopes: None };
        if depends_on_velocity_noise(rig) {
            let noises = noises(&null.asked(rig, true).collect::<Vec<_>>()).into_iter();
            null.by_mean_slopes = Some(noises.map(|noise| Ok(noise?.variance)).collect::<Result<_, RigError>>()?);
        }
        Ok(null)
    }

    /// A rig under each recording's condition, by mean slopes in the noise that is expected without the effect or by its own.
    fn asked<'a>(&'a self, rig: &'a Rig, by_mean_slopes: bool) -> impl Iterator<Item = Asked<'a>> {
        let each = self.observed.iter().zip(&self.expected);
        each.map(move |(o, e)| Asked {
            rig,
            condition: o.condition,
            known: by_mean_slopes.then_some(e.noise.velocity_covariance),
        })
    }

    /// Random parts of rigs that differ by one effect; nothing of one that cannot be run. Where mean slopes are not enough for
    /// this rig, they are enough for the ratio of the two.
    fn noises_of(&self, rigs: &[&Rig]) -> Vec<Option<Vec<Noise>>> {
        let asked = rigs.iter().flat_map(|rig| self.asked(rig, self.by_mean_slopes.is_some()));
        let mut noises = noises(&asked.collect::<Vec<_>>()).into_iter();
        let mut of_next = || -> Option<Vec<Noise>> {
            // All of a rig's are taken, whichever was refused.
            let found: Vec<_> = noises.by_ref().take(self.observed.len()).collect();
            let mut found: Vec<Noise> = found.into_iter().collect::<Result<_, _>>().ok()?;
            for ((after, before), e) in found.iter_mut().zip(self.by_mean_slopes.iter().flatten()).zip(&self.expected) {
                after.velocity_covariance = e.noise.velocity_covariance;
                for ((after, before), own) in after.variance.iter_mut().zip(before).zip(&e.noise.variance) {
                    after.iter_mut().zip(before.iter().zip(own)).for_each(|(s, (before, own))| *s *= own / before);
                }
            }
            Some(found)
        };
        rigs.iter().map(|_| of_next()).collect()
    }

    /// Predicted random parts of the recordings.
    pub fn noise(&self) -> Vec<Noise> {
        self.expected.iter().map(|e| e.noise.clone()).collect()
    }
}

/// Start with its choice of initial angles.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Index of the hypothesis.
    pub hypothesis: usize,
    /// Start values of the effect.
    pub start: Start,
    /// Choice of the initial angles.
    pub angles: Angles,
}

/// Choice of a trial's initial angles.
#[derive(Clone, Debug)]
pub enum Angles {
    /// Angles of the null model.
    Bare,
    /// Angles fitted with the effect: a defect's pulses outweigh the ball passes, and the shaft's angle shows only in
    /// effects that rotate with it.
    Aligned,
    /// Angles of the null model, each recording's moved by so many samples.
    Moved(Vec<i64>),
    /// Given angles.
    Given(Vec<[f64; 2]>),
    /// Given angles, moved in time to fit the rig with the effect.
    Near(Vec<[f64; 2]>),
}

/// Strength at which a trial is scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// Given strength.
    Given,
    /// Strength of the greatest expected gain, for a change in proportion to it.
    Scaled,
}

/// Expected gains of all trials that can be simulated, the greatest first.
///
/// # Errors
/// Errors of the simulation before it runs.
pub fn evaluate(
    null: &NullPrediction,
    rig: &Rig,
    trials: &[Trial],
    strength: Strength,
) -> Result<Vec<StartScore>, RigError> {
    let trials: Vec<(&Trial, Rig)> = trials
        .iter()
        .map(|t| (t, rig.clone().with_effect(t.start.effect.clone())))
        .filter(|(_, r)| r.check().is_ok())
        .collect();
    let noise = null.noise();
    let mut scores: Vec<StartScore> = Vec::new();
    for batch in trials.chunks((BATCH / null.observed.len()).max(1)) {
        let turned: Vec<&Rig> =
            batch.iter().filter(|(t, _)| matches!(t.angles, Angles::Aligned)).map(|(_, rig)| rig).collect();
        let mut found = align::angles_of_many(&turned, null.observed, &noise, &null.angles)?.into_iter();
        let angles: Vec<Vec<[f64; 2]>> = batch
            .iter()
            .map(|(t, _)| match &t.angles {
                Angles::Bare => null.angles.clone(),
                Angles::Aligned => found.next().flatten().unwrap_or_else(|| null.angles.clone()),
                Angles::Moved(leads) => {
                    let each = null.observed.iter().zip(leads).zip(&null.angles);
                    each.map(|((o, lead), a)| align::moved_angles(rig, o, *lead, *a)).collect()
                }
                Angles::Given(angles) | Angles::Near(angles) => angles.clone(),
            })
            .collect();
        let with_own: Vec<&Rig> = batch.iter().filter(|(t, _)| moves_variance(t)).map(|(_, rig)| rig).collect();
        let mut found = null.noises_of(&with_own).into_iter();
        let own: Vec<Option<Vec<Noise>>> = batch
            .iter()
            .map(|(t, _)| if moves_variance(t) { found.next().flatten() } else { Some(noise.clone()) })
            .collect();
        let mut runs: Vec<NoiseFreeRun> = Vec::new();
        for (((_, rig), angles), own) in batch.iter().zip(&angles).zip(&own) {
            runs.extend(align::noise_free_runs(rig, null.observed, own.as_ref().unwrap_or(&noise), angles));
        }
        let means = means(&runs)?;
        let judged: Vec<Option<StartScore>> = batch
            .par_iter()
            .zip(&angles)
            .zip(&own)
            .zip(means.par_chunks(null.observed.len()))
            .map(|((((t, rig), angles), own), means)| {
                let noise = own.as_ref()?;
                let means: Vec<&[Coefficients; 2]> = means.iter().map(|m| m.as_ref().ok()).collect::<Option<_>>()?;
                let runs = Runs { angles, means: &means, base: None, noise };
                let as_it_is = score(null, t, &runs, strength);
                // What happens at a time of its own stays there, and what is on a shaft whose angle is known.
                let held = t.start.is_timed()
                    || t.start.effect.is_on_shaft() && null.observed.iter().any(|o| o.tachometer.is_some());
                if held || !matches!(t.angles, Angles::Bare | Angles::Near(_)) {
                    return as_it_is;
                }
                let moved = moved(null, t, rig, &runs, strength);
                as_it_is.into_iter().chain(moved).max_by(|a, b| a.log_likelihood_gain.total_cmp(&b.log_likelihood_gain))
            })
            .collect();
        scores.extend(judged.into_iter().flatten());
    }
    scores.sort_by(|a, b| b.log_likelihood_gain.total_cmp(&a.log_likelihood_gain));
    Ok(scores)
}

/// The same, moved in time to where it suits the recordings better; nothing where it need not be.
fn moved(null: &NullPrediction, of: &Trial, rig: &Rig, runs: &Runs, strength: Strength) -> Option<StartScore> {
    let Runs { angles, means, noise, .. } = *runs;
    let lag =
        |((o, e), mean): ((&Observed, &Prediction), &&[Coefficients; 2])| align::lag(rig, o, &e.noise.variance, mean);
    let lags: Vec<i64> = null.observed.iter().zip(&null.expected).zip(means).map(lag).collect();
    if lags.iter().all(|lag| *lag == 0) {
        return None;
    }
    let each = || null.observed.iter().zip(&lags);
    let angles: Vec<_> = each().zip(angles).map(|((o, lag), a)| align::moved_angles(rig, o, *lag, *a)).collect();
    let with: Vec<_> = each().zip(means).map(|((o, lag), mean)| align::moved_mean(o, *lag, mean)).collect();
    let base: Vec<_> = each().zip(&null.expected).map(|((o, lag), e)| align::moved_mean(o, *lag, &e.mean)).collect();
    let with: Vec<_> = with.iter().collect();
    score(null, of, &Runs { angles: &angles, means: &with, base: Some(&base), noise }, strength)
}

/// A try's runs.
struct Runs<'a> {
    angles: &'a [[f64; 2]],
    /// What is expected with the effect.
    means: &'a [&'a [Coefficients; 2]],
    /// What is expected without it where both have been moved in time; otherwise that is the null's.
    base: Option<&'a [[Coefficients; 2]]>,
    /// Random part with the effect.
    noise: &'a [Noise],
}

fn moves_variance(of: &Trial) -> bool {
    !of.start.effect.definition().is_deterministic
}

/// The gain of one run. Where it is scaled, what it changes is taken to grow with its strength.
fn score(null: &NullPrediction, of: &Trial, runs: &Runs, strength: Strength) -> Option<StartScore> {
    let (mut gain, mut along, mut square, mut lost) = (0.0, 0.0, 0.0, 0.0);
    for (n, (o, without)) in null.observed.iter().zip(&null.expected).enumerate() {
        let base = runs.base.map_or(&without.mean, |base| &base[n]);
        for (channel, x) in o.spectra.iter().enumerate() {
            let Some(x) = x else { continue };
            let (with, without_it, base) = (&runs.means[n][channel], &without.mean[channel], &base[channel]);
            let (s, t) = (&without.noise.variance[channel], &runs.noise[n].variance[channel]);
            for k in judged_bins(x, 1.0) {
                let before = (x[k] - without_it[k]).norm_sqr() / s[k];
                gain += s[k].ln() + before - t[k].ln() - (x[k] - with[k]).norm_sqr() / t[k];
                let (residual, change) = (x[k] - base[k], with[k] - base[k]);
                lost += residual.norm_sqr() / s[k] - before;
                along += (residual.conj() * change).re / s[k];
                square += change.norm_sqr() / s[k];
            }
        }
    }
    if !gain.is_finite() {
        return None;
    }
    let mut start = of.start.clone();
    let scale = if square > 0.0 { along / square } else { 1.0 };
    let scaled = if square > 0.0 { along * along / square - lost } else { 0.0 };
    if strength == Strength::Scaled
        && scaled > gain
        && let Some(stronger) = start.scaled(scale)
    {
        start = stronger;
        gain = scaled;
    }
    Some(StartScore { hypothesis: of.hypothesis, start, angles: runs.angles.to_vec(), log_likelihood_gain: gain })
}
