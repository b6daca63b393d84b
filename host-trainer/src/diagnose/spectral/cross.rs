//! Cross-spectrum of the channels under a prediction.
//!
//! Powers are the same for a defect on the one or the other side of the load: its force points to the other side, and only the
//! phase between the channels tells. A wandering speed or a slipping cage, which take a line's phase, do not change that one.

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::candidate::{Candidate, NullFit};
use super::data::Point;
use super::density::ORDINARY;
use super::fit::Model;
use super::likelihood::{Channel, Expected};
use super::observation::{cross_power, power};
use super::prediction::{noise_free, noise_free_runs};
use super::settings::LikelihoodSettings;
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::effect::EffectKind;
use crate::rig::{RigError, Run};

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Sets the gain by the phase of candidates that gain more than `least` by the powers; leaves all as they are if the phase is not as
/// the null fit predicts it. Between the parts of a misalignment's force along x and y any phase is possible, and none is fitted.
pub fn set_phases(null: &NullFit, candidates: &mut [Candidate], least: f64) {
    let has_phase = |c: &&mut Candidate| c.gain > least && c.kind != EffectKind::Misalignment;
    let mut asked: Vec<&mut Candidate> = candidates.iter_mut().filter(has_phase).collect();
    let mut fits = vec![(&null.model, &null.point)];
    fits.extend(asked.iter().map(|c| (&c.model, &c.point)));
    let mut gains = cross_gains(&fits).into_iter();
    let Some(Ok(now)) = gains.next().filter(|now| now.as_ref().is_ok_and(|now| *now > 0.0)) else { return };
    asked.iter_mut().zip(gains).for_each(|(c, gain)| c.phase = gain.map_or(f64::NEG_INFINITY, |gain| gain - now));
}

/// Gain of the predicted coherence of the channels over none, nats: the ratio of the density of both channels' complex Gaussian
/// coefficients (N. R. Goodman, Ann. Math. Stat. 34 (1963) 152–177) to that of each by itself. Only lines count as coherent.
/// Of each fit; one that cannot run has an error of its own.
pub fn cross_gains(fits: &[(&Model, &Point)]) -> Vec<Result<f64, RigError>> {
    fits.par_iter().map(|(model, point)| cross_gain(model, point)).collect()
}

fn cross_gain(model: &Model, point: &Point) -> Result<f64, RigError> {
    let rig = model.rig_at(&point.values)?;
    let observations = model.data.observations;
    let each = observations.iter().zip(point.predictions.iter());
    let runs = each.map(|(o, p)| Run { rig: &rig, condition: o.condition, start: noise_free(&rig, o, p.scatter) });
    let made = noise_free_runs(&runs.collect::<Vec<_>>())?;
    let mut gain = 0.0;
    for (n, (made, observation)) in made.into_iter().zip(observations).enumerate() {
        let made = made?;
        let [Some(ax), Some(ay)] = CHANNELS.map(|name| made.channel(name)) else { continue };
        let [Some(x), Some(y)] = observation.samples.each_ref() else { continue };
        let channels = [0, 1].map(|channel| model.data.channel(point, n, channel));
        gain += gain_of(&channels, &cross_power(x, y), &coherence(&ax.samples, &ay.samples));
    }
    Ok(gain)
}

/// Coherence of two noise-free signals within a line's lobe.
fn coherence(x: &[f64], y: &[f64]) -> Vec<Complex<f64>> {
    let (cross, x, y) = (cross_power(x, y), power(x), power(y));
    let of = |k: usize| {
        let lobe = k.saturating_sub(1)..(k + 2).min(cross.len());
        let [x, y] = [&x, &y].map(|power| power[lobe.clone()].iter().sum::<f64>());
        cross[lobe].iter().sum::<Complex<f64>>() / (x * y).sqrt().max(f64::MIN_POSITIVE)
    };
    (0..cross.len()).map(of).collect()
}

/// Gain of a recording, of whose lines the channels have a coherence.
fn gain_of(channels: &[Channel; 2], measured: &[Complex<f64>], coherence: &[Complex<f64>]) -> f64 {
    let [x, y] = channels;
    let gain = |(of_x, of_y): (Expected, Expected)| {
        let (x_mean, y_mean) = (of_x.mean(), of_y.mean());
        let unstretched = (of_x.k as f64 / (1.0 + x.stretch.outer)).round() as usize;
        let Some(of_line) = coherence.get(unstretched) else { return 0.0 };
        let expected = of_line * (of_x.line / x_mean * of_y.line / y_mean).sqrt() * SETTINGS.most_coherent;
        let square = expected.norm_sqr();
        // A line that is far stronger than predicted says no more than one a little stronger.
        let (x_mean, y_mean) = (x_mean.max(of_x.power / ORDINARY[1]), y_mean.max(of_y.power / ORDINARY[1]));
        let together = 2.0 * (expected.conj() * measured[of_x.k]).re / (x_mean * y_mean).sqrt();
        let gain =
            (together - square * (of_x.power / x_mean + of_y.power / y_mean)) / (1.0 - square) - (-square).ln_1p();
        // No more against it than an outlier.
        ((1.0 - SETTINGS.outliers) * gain.exp() + SETTINGS.outliers).ln()
    };
    x.bins().zip(y.bins()).map(gain).sum()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::diagnose::spectral::data::Data;
    use crate::diagnose::spectral::observation::Observation;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::identify::likelihood::observed::Observed;
    use crate::recording::Recording;
    use crate::rig::effect::ParameterKey;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Rig, Start, simulate};

    fn pitted(angle: f64) -> Rig {
        let pit = [(ParameterKey::DepthM, 5e-7), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, angle)];
        nominal().with_effect(EffectEntry::new(EffectKind::OuterRaceDefect, &pit))
    }

    /// −ln L of the powers of a recording and the gain by its phase, under each rig.
    fn under(recording: &Recording, rigs: &[Rig]) -> Vec<[f64; 2]> {
        let observations = [Observation::new(&Observed::from_recording(recording).unwrap())];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let of = |rig: &Rig| {
            let model = Model::fixed(&data, rig.clone());
            let point = model.start().unwrap();
            [point.objective(), cross_gain(&model, &point).unwrap()]
        };
        rigs.iter().map(of).collect()
    }

    #[test]
    fn invariant_the_side_of_the_load_is_in_the_phase_and_not_in_the_powers() {
        let angle = PI / 2.0 + 0.3;
        let recording = simulate(&pitted(angle), &condition(30.0, 800.0, 25_600), &Start::seeded(5)).unwrap();
        let found = under(&recording, &[pitted(angle), pitted(PI - angle)]);
        let [powers, phases] = [0, 1].map(|n| found[1][n] - found[0][n]);
        assert!(phases < -100.0 && powers.abs() < 0.2 * phases.abs(), "{found:?}");
        assert!(found[0][1] > 50.0, "{found:?}");
    }

    #[test]
    fn invariant_a_candidate_of_the_other_side_is_contradicted_where_the_phase_is_as_predicted() {
        let angle = PI / 2.0 + 0.3;
        let recording = simulate(&pitted(angle), &condition(30.0, 800.0, 25_600), &Start::seeded(5)).unwrap();
        let observations = [Observation::new(&Observed::from_recording(&recording).unwrap())];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let judged = |of_null: f64, of_candidate: f64| {
            let fitted = |angle: f64| {
                let model = Model::fixed(&data, pitted(angle));
                let point = model.start().unwrap();
                (model, point)
            };
            let ((null, at), (model, point)) = (fitted(of_null), fitted(of_candidate));
            let (kind, place) = (EffectKind::OuterRaceDefect, String::new());
            let mut candidates = [Candidate { kind, place, model, point, gain: 200.0, phase: 0.0 }];
            set_phases(&NullFit::new(&null, &at), &mut candidates, 100.0);
            (candidates[0].phase, candidates[0].is_contradicted())
        };
        let (phase, is_contradicted) = judged(angle, PI - angle);
        assert!(phase < -100.0 && is_contradicted, "{phase}");
        assert_eq!(judged(angle, angle), (0.0, false));
        assert_eq!(
            judged(PI - angle, PI - angle),
            (0.0, false),
            "nothing is asked of a phase that is not as predicted"
        );
    }

    /// Channels of two recordings at other angles of the cage are no more coherent than chance.
    #[test]
    fn null_channels_that_have_nothing_in_common_speak_against_lines_of_both() {
        let rig = pitted(PI / 2.0 + 0.3);
        let made = |seed: u64| simulate(&rig, &condition(30.0, 800.0, 25_600), &Start::seeded(seed)).unwrap();
        let (mut one, other) = (made(1), made(2));
        let across = other.channel("ax").unwrap().samples.clone();
        one.channels.iter_mut().filter(|c| c.name == "ax").for_each(|c| c.samples = across.clone());
        let [[_, gain]] = under(&one, &[rig])[..] else { panic!("one rig") };
        assert!(gain < -50.0, "{gain}");
    }
}
