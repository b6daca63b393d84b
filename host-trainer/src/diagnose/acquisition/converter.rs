//! Converter: samples on a grid of one step.

use statrs::statistics::Statistics;

use crate::identify::likelihood::observed::accelerations;
use crate::recording::{Channel, Recording};
use crate::rig::Rig;
use crate::rig::config::ModelKey;

/// Samples of a channel on a grid over its values, at least.
const REPEATED: usize = 10;
/// Deviation of two values from a whole number of steps, in steps: files round.
const OFF_GRID: f64 = 0.02;
/// Share of the sensor's noise from which what a converter adds is a mismatch: by hand.
const COARSE: f64 = 0.2;
/// Step over another one from which the two are of one converter.
const EQUAL: f64 = 0.9;
/// Step over the standard deviation of what a converter gives, up to which it keeps the level of a normal signal: √3, which is a
/// step of twice the standard deviation before it (B. Widrow, I. Kollár, "Quantization Noise", 2008).
const RESOLVED: f64 = 1.732;

/// Step of a converter in every recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converter {
    /// Step, m/s².
    pub step: f64,
    /// Power that it adds over that of the sensor's noise: step²/12 (W. R. Bennett, Bell Syst. Tech. J. 27 (1948) 446–472).
    pub of_noise: f64,
    /// Step over the standard deviation of the quietest channel.
    pub of_quietest: f64,
}

impl Converter {
    /// Converter of recordings of a bearing rig; `None` if a channel is on no grid, or if the noise of the rig's sensors is not
    /// known and is fitted, that of the converter with it.
    pub fn of(rig: &Rig, recordings: &[Recording]) -> Option<Self> {
        let is_known = !rig.unknown_keys().contains(&ModelKey::SensorNoise);
        let noise = rig.bearing().filter(|_| is_known)?.sensor.noise_std_m_per_s2;
        let step = common_step(recordings)?;
        let quietest = channels(recordings).map(|c| c.samples.iter().population_std_dev()).reduce(f64::min)?;
        Some(Self { step, of_noise: step * step / (12.0 * noise * noise), of_quietest: step / quietest })
    }

    /// Whether it changes what the sensor shows, and has no equal in recordings of the healthy machine.
    pub fn is_mismatch(&self, baseline: Option<&[Recording]>) -> bool {
        let healthy = baseline.and_then(common_step);
        self.of_noise > COARSE && healthy.is_none_or(|step| step < EQUAL * self.step)
    }

    /// Whether it keeps the level of every channel, so that a gain can be told.
    pub fn keeps_level(&self) -> bool {
        self.of_quietest < RESOLVED
    }

    /// Rig with what the converter adds to the noise of its sensors.
    pub fn noisy(&self, rig: &Rig) -> Rig {
        let mut noisy = rig.clone();
        let noise = rig.get(ModelKey::SensorNoise).unwrap_or_default();
        // A greater noise is a noise.
        noisy.set(ModelKey::SensorNoise, noise.hypot(self.step / 12f64.sqrt())).unwrap_or_default();
        noisy
    }
}

/// Least step of the channels of recordings; `None` if one is on no grid.
fn common_step(recordings: &[Recording]) -> Option<f64> {
    channels(recordings).map(|channel| step(&channel.samples)).reduce(|a, b| Some(a?.min(b?)))?
}

/// Accelerations of recordings.
fn channels(recordings: &[Recording]) -> impl Iterator<Item = &Channel> {
    recordings.iter().flat_map(|r| accelerations(r).into_iter().flatten())
}

/// Step between the values of a channel; `None` if they are on no grid.
fn step(samples: &[f64]) -> Option<f64> {
    let mut values = samples.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let apart = || values.windows(2).map(|pair| pair[1] - pair[0]);
    let step = apart().reduce(f64::min)?;
    let is_whole = |apart: f64| (apart / step - (apart / step).round()).abs() < OFF_GRID;
    (values.len() * REPEATED < samples.len() && apart().all(is_whole)).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::nominal;

    #[test]
    fn a_grid_is_found_and_noise_is_on_none() {
        let noise: Vec<f64> = (0..4000).map(|n| (f64::from(n) * f64::from(n)).sin()).collect();
        assert_eq!(step(&noise), None);
        let coarse: Vec<f64> = noise.iter().map(|v| (v / 0.05).floor() * 0.05 + 0.0125).collect();
        assert!((step(&coarse).unwrap() - 0.05).abs() < 1e-9);
        assert_eq!(step(&[1.0; 100]), None, "one value is no grid");
        let mut stray = coarse;
        stray[7] += 0.017;
        assert_eq!(step(&stray), None);
    }

    /// Of normal noise, with its steps: the variance is that of the noise and q²/12 while the level is kept.
    #[test]
    fn literature_steps_up_to_twice_the_deviation_keep_the_level() {
        let noise = crate::rig::noise::white(3, 0, 1.0, 20_000);
        for (step, is_kept) in [(0.5, true), (1.5, true), (2.5, false), (4.0, false)] {
            let rounded = |v: &f64| ((v / step).floor() + 0.5) * step;
            let channel = Channel { name: "ax".into(), location: None, samples: noise.iter().map(rounded).collect() };
            let level = channel.samples.iter().population_std_dev();
            let expected = 1.0f64.hypot(step / 12f64.sqrt());
            assert_eq!((level / expected - 1.0).abs() < 0.02, is_kept, "{step}: {level}, {expected}");
            let recording = Recording { channels: vec![channel], ..Recording::default() };
            let converter = Converter::of(&nominal(), &[recording]).unwrap();
            assert_eq!(converter.keeps_level(), is_kept, "{step}");
        }
    }
}
