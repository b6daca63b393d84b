//! What a power spectrum, which has no time, shows little of: spikes and impacts, a level that rises and falls, a tone that sweeps
//! through a band.

use realfft::num_complex::Complex;
use statrs::statistics::Statistics;

use super::observation::{Observation, samples};
use super::settings::UnsteadySettings;
use crate::identify::likelihood::observed::CHANNELS;
use crate::recording::Recording;
use crate::signal::coherence::short_time;
use crate::signal::phases::life::Features;
use crate::signal::surrogate::autoregression::Autoregression;
use crate::signal::transform::{hann, median};

const SETTINGS: UnsteadySettings = UnsteadySettings::DEFAULT;
/// Kurtosis of a normal distribution.
const NORMAL: f64 = 3.0;

/// Greatest kurtosis in a recording of what the samples differ by from those around them, where it is beyond that of the noise of a rig
/// and of a `run` of the rig with what was found.
pub fn unsteady_kurtosis(observations: &[&Observation], run: impl FnOnce() -> Option<Recording>) -> Option<f64> {
    let all = observations.iter().flat_map(|o| o.samples.iter().flatten());
    let of_each = all.map(|s| (interpolated_kurtosis(s), (24.0 / s.len() as f64).sqrt()));
    // A constant signal has none.
    let (found, chance) = of_each.filter(|(found, _)| found.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let excess = |found: f64| found - NORMAL;
    if excess(found) < SETTINGS.kurtosis.max(SETTINGS.standard_errors * chance) {
        return None;
    }
    let of_run = run().map_or(0.0, |run| {
        let of = |channel: usize| excess(interpolated_kurtosis(samples(&run, channel)));
        (0..CHANNELS.len()).map(of).fold(0.0, f64::max)
    });
    (excess(found) > SETTINGS.of_run * of_run).then_some(found)
}

/// Kurtosis of the error by which an autoregression interpolates each sample from those on both sides of it. A line or a mode is
/// interpolated, a spike is not.
fn interpolated_kurtosis(samples: &[f64]) -> f64 {
    let mean = samples.iter().mean();
    let signal: Vec<f64> = samples.iter().map(|v| v - mean).collect();
    let filter = Autoregression::new(&signal);
    let mut innovations = filter.innovations(&signal);
    innovations.reverse();
    Features::new(&filter.innovations(&innovations)).kurtosis
}

/// Whether the power of a band comes and goes in most recordings, as of a tone that sweeps through it: a mode rings all the time.
pub fn is_fleeting(observations: &[Observation], around_hz: f64, half_power_hz: f64) -> bool {
    let reach = SETTINGS.widths * half_power_hz;
    let of = |o: &Observation| {
        let fleeting =
            |samples: &Vec<f64>| fleeting(samples, [around_hz - reach, around_hz + reach], o.condition.sample_rate_hz);
        o.samples.iter().flatten().map(fleeting).fold(0.0, f64::max)
    };
    let mut all: Vec<f64> = observations.iter().map(of).collect();
    median(&mut all).is_some_and(|found| found > SETTINGS.fleeting)
}

/// Mean square of the short-time power of a band over the square of its mean at each frequency; 0 if the band is too narrow.
fn fleeting(samples: &[f64], [from_hz, to_hz]: [f64; 2], sample_rate_hz: f64) -> f64 {
    let window = samples.len() / SETTINGS.parts;
    if window < 2 {
        return 0.0;
    }
    let bin = |hz: f64| (hz.max(0.0) * window as f64 / sample_rate_hz).round() as usize;
    let rows = short_time(samples, &hann(window), (window / 2).max(1));
    let band = bin(from_hz).min(rows.len())..(bin(to_hz) + 1).min(rows.len());
    let ratio = |row: &Vec<Complex<f64>>| {
        let mean = row.iter().map(Complex::norm_sqr).mean();
        row.iter().map(|v| v.norm_sqr().powi(2)).mean() / (mean * mean).max(f64::MIN_POSITIVE)
    };
    if band.is_empty() { 0.0 } else { rows[band].iter().map(ratio).mean() }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Rig, Start, simulate};

    #[test]
    fn a_tone_that_sweeps_is_fleeting_and_noise_and_a_still_tone_are_not() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let noise: Vec<f64> = (0..25_600).map(|_| StandardNormal.sample(&mut random)).collect();
        let mut turn = 0.0;
        let mut tone = |hz: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let of = |(k, noise): (usize, &f64)| {
                turn += std::f64::consts::TAU * hz(k as f64 / 25_600.0) / 25_600.0;
                f64::sin(turn) + 0.01 * noise
            };
            noise.iter().enumerate().map(of).collect()
        };
        let of = |samples: &[f64]| fleeting(samples, [440.0, 560.0], 25_600.0);
        let sweeping = tone(&|time| 420.0 + 190.0 * time);
        assert!(of(&sweeping) > SETTINGS.fleeting, "{}", of(&sweeping));
        let still = tone(&|_| 500.0);
        for steady in [of(&noise), of(&still)] {
            assert!(steady < 2.2, "{steady}");
        }
    }

    /// A mode rings with what the balls strike: a run of the rig shows that only with the mode.
    #[test]
    fn invariant_what_rings_in_a_run_too_is_no_spike() {
        let mode = EffectEntry::new(
            EffectKind::StructuralResonance,
            &[(ParameterKey::Gain, 300.0), (ParameterKey::FrequencyHz, 8200.0), (ParameterKey::DampingRatio, 0.024)],
        )
        .with_text(ParameterKey::Channel, "ay")
        .with_text(ParameterKey::Source, "across");
        let ringing = nominal().with_effect(mode);
        let run = |rig: &Rig, seed: u64| simulate(rig, &condition(30.0, 500.0, 25_600), &Start::seeded(seed));
        let recorded = Observed::from_recording(&run(&ringing, 3).unwrap()).unwrap();
        let observation = Observation::new(&recorded);
        let kurtosis = |rig: &Rig| unsteady_kurtosis(&[&observation], || run(rig, 4).ok());
        assert!(kurtosis(&nominal()).is_some());
        assert_eq!(kurtosis(&ringing), None);
    }

    #[test]
    fn spikes_and_a_level_that_swings_are_not_normal_and_noise_lines_and_a_mode_are() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let noise: Vec<f64> = (0..25_600).map(|_| StandardNormal.sample(&mut random)).collect();
        let of = |change: &dyn Fn(usize, f64) -> f64| {
            interpolated_kurtosis(&noise.iter().enumerate().map(|(n, v)| change(n, *v)).collect::<Vec<_>>()) - NORMAL
        };
        let mode = Autoregression::new(
            &(0..4000).map(|n| (0.3 * f64::from(n)).sin() * (-0.01 * f64::from(n % 400)).exp()).collect::<Vec<_>>(),
        );
        assert!(of(&|_, v| v).abs() < 0.1);
        assert!(of(&|n, v| v + 30.0 * (0.11 * n as f64).sin()).abs() < 0.1);
        assert!((interpolated_kurtosis(&mode.coloured(&noise, 25_600)) - NORMAL).abs() < 0.1);
        assert!(of(&|n, v| if n % 1000 == 0 { 6.0 * v } else { v }) > SETTINGS.kurtosis);
        assert!(of(&|n, v| (1.0 + 0.4 * (2e-3 * n as f64).sin()) * v) > SETTINGS.kurtosis);
    }
}
