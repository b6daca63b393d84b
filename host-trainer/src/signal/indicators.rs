//! Vibration indicators of a recording: RMS, peak, crest factor, kurtosis, and the vibration velocity of ISO 20816-3
//! with its evaluation zones.

use std::fmt;
use std::ops::Range;

use rayon::prelude::*;
use serde::Serialize;

use super::Sample;
use super::phases::life::Features;
use super::settings::IndicatorSettings;
use super::spectrum::{USABLE, welch};
use crate::recording::input::{Input, Series};
use crate::recording::is_acceleration;

const SETTINGS: IndicatorSettings = IndicatorSettings::DEFAULT;

/// Frequency range of the vibration velocity, Hz (ISO 20816-3:2022, for speeds from 600 rpm on).
pub const VELOCITY_BAND_HZ: Range<f64> = 10.0..1000.0;

/// Indicators of one recording's acceleration about its mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Indicators {
    /// Root mean square, m/s².
    pub rms: f64,
    /// Largest absolute value, m/s².
    pub peak: f64,
    /// Kurtosis, 3 for normal noise; NaN for a constant signal.
    pub kurtosis: f64,
    /// Vibration velocity over [`VELOCITY_BAND_HZ`], mm/s RMS, or why there is none.
    pub velocity: Result<f64, NoVelocity>,
}

impl Indicators {
    /// Indicators of samples in m/s²; after each sample that `gaps` lists, samples are missing. The velocity is that of
    /// the longest piece without a gap.
    pub fn new<S: Sample>(samples: &[S], sample_rate_hz: f64, gaps: &[usize]) -> Self {
        let values: Vec<f64> = samples.iter().map(|v| (*v).into()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let Features { kurtosis, rms } = Features::new(&values);
        Self {
            rms,
            peak: values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max),
            kurtosis,
            velocity: velocity_mm_per_s(&values[longest_piece(values.len(), gaps)], sample_rate_hz),
        }
    }

    /// Indicators of each recording of an input.
    pub fn of_each(input: &Input) -> Vec<Self> {
        let of = |(series, gaps): (&Series, &Vec<usize>)| {
            let mut found = Self::new(&series.samples, input.sample_rate_hz, gaps);
            if !is_acceleration(&input.channel) {
                found.velocity = Err(NoVelocity::NoAcceleration);
            }
            found
        };
        input.series.par_iter().zip(&input.gaps).map(of).collect()
    }

    /// Peak over RMS; NaN for a constant signal.
    pub fn crest_factor(&self) -> f64 {
        self.peak / self.rms
    }
}

/// Reason for a missing vibration velocity.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoVelocity {
    /// Too few periods of the lowest frequency.
    #[error("found {found_s:.3} s without a gap, expected at least {} s", SETTINGS.velocity_least_s)]
    TooShort {
        /// Length of the longest piece, s.
        found_s: f64,
    },
    /// Highest frequency beyond the passband of the converter's filter.
    #[error("found {found_hz} Hz, expected a sample rate of at least {:.0} Hz for a band up to {} Hz",
        2.0 * VELOCITY_BAND_HZ.end / USABLE, VELOCITY_BAND_HZ.end)]
    TooSlow {
        /// Sample rate, Hz.
        found_hz: f64,
    },
    /// Channel of another quantity.
    #[error("the channel is not an acceleration in m/s²")]
    NoAcceleration,
}

/// Velocity in mm/s RMS over [`VELOCITY_BAND_HZ`], from an acceleration in m/s² by division by 2πf in the frequency
/// domain: v² = Σ S(f) Δf / (2πf)², S the power spectral density (Welch, Hann window).
///
/// # Errors
/// A recording that is too short or sampled too slowly for the band.
pub fn velocity_mm_per_s<S: Sample>(samples: &[S], sample_rate_hz: f64) -> Result<f64, NoVelocity> {
    if 0.5 * USABLE * sample_rate_hz < VELOCITY_BAND_HZ.end {
        return Err(NoVelocity::TooSlow { found_hz: sample_rate_hz });
    }
    let found_s = samples.len() as f64 / sample_rate_hz;
    let segment = samples.len().min((SETTINGS.velocity_segment_s * sample_rate_hz) as usize);
    if found_s < SETTINGS.velocity_least_s {
        return Err(NoVelocity::TooShort { found_s });
    }
    let density = welch(&[samples], sample_rate_hz, segment).ok_or(NoVelocity::TooShort { found_s })?;
    let in_band = density.points().filter(|(f, _)| VELOCITY_BAND_HZ.contains(f));
    let squared = in_band.map(|(f, s)| s / (std::f64::consts::TAU * f).powi(2)).sum::<f64>() * density.step_hz;
    Ok(1e3 * squared.sqrt())
}

/// Longest range of `count` samples without one of the `gaps`, each the sample after which some are missing.
pub fn longest_piece(count: usize, gaps: &[usize]) -> Range<usize> {
    let starts = std::iter::once(0).chain(gaps.iter().map(|gap| gap + 1));
    let ends = gaps.iter().map(|gap| gap + 1).chain([count]);
    starts.zip(ends).map(|(a, b)| a..b.max(a)).max_by_key(|piece| piece.len()).unwrap_or(0..0)
}

/// Group and support of a machine, which fix its zones (ISO 20816-3:2022, tables A.1 and A.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum IsoClass {
    /// Group 1, over 300 kW, on a rigid support
    #[value(name = "1-rigid")]
    Group1Rigid,
    /// Group 1, over 300 kW, on a flexible support
    #[value(name = "1-flexible")]
    Group1Flexible,
    /// Group 2, 15 to 300 kW, on a rigid support
    #[value(name = "2-rigid")]
    Group2Rigid,
    /// Group 2, 15 to 300 kW, on a flexible support
    #[value(name = "2-flexible")]
    Group2Flexible,
}

impl IsoClass {
    /// Boundaries A/B, B/C and C/D, mm/s RMS.
    pub fn boundaries_mm_per_s(self) -> [f64; 3] {
        match self {
            Self::Group1Rigid | Self::Group2Flexible => [2.3, 4.5, 7.1],
            Self::Group1Flexible => [3.5, 7.1, 11.0],
            Self::Group2Rigid => [1.4, 2.8, 4.5],
        }
    }

    /// Zone of a velocity in mm/s RMS.
    pub fn zone(self, velocity_mm_per_s: f64) -> Zone {
        let passed = self.boundaries_mm_per_s().iter().filter(|boundary| velocity_mm_per_s > **boundary).count();
        [Zone::A, Zone::B, Zone::C, Zone::D][passed]
    }
}

impl fmt::Display for IsoClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Group1Rigid => "group 1, rigid support",
            Self::Group1Flexible => "group 1, flexible support",
            Self::Group2Rigid => "group 2, rigid support",
            Self::Group2Flexible => "group 2, flexible support",
        })
    }
}

/// Evaluation zone of ISO 20816-1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Zone {
    /// As of newly commissioned machines.
    A,
    /// Acceptable for unrestricted long-term operation.
    B,
    /// Unsatisfactory for long-term operation.
    C,
    /// Severe enough to damage the machine.
    D,
}

impl Zone {
    /// Meaning in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::A => "as of a newly commissioned machine",
            Self::B => "acceptable for unrestricted long-term operation",
            Self::C => "unsatisfactory for long-term operation",
            Self::D => "severe enough to damage the machine",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const RATE: f64 = 12_800.0;

    fn sine(amplitude: f64, hz: f64, seconds: f64, rate: f64) -> Vec<f64> {
        (0..(seconds * rate) as usize).map(|n| 3.0 + amplitude * (TAU * hz * n as f64 / rate).sin()).collect()
    }

    /// Velocity of a sine in mm/s RMS.
    fn of_sine(amplitude: f64, hz: f64) -> f64 {
        1e3 * amplitude / (TAU * hz) / 2f64.sqrt()
    }

    #[test]
    fn literature_indicators_of_a_sine() {
        let found = Indicators::new(&sine(2.0, 160.0, 1.0, RATE), RATE, &[]);
        assert!((found.rms - 2f64.sqrt()).abs() < 1e-9 && (found.peak - 2.0).abs() < 1e-9, "{found:?}");
        assert!((found.crest_factor() - 2f64.sqrt()).abs() < 1e-9 && (found.kurtosis - 1.5).abs() < 1e-9);
        // 10 m/s² at 159.155 Hz are 10 mm/s: ω is 1000 rad/s.
        let velocity = velocity_mm_per_s(&sine(10.0, 1000.0 / TAU, 4.0, RATE), RATE).unwrap();
        assert!((velocity * 2f64.sqrt() / 10.0 - 1.0).abs() < 1e-3, "{velocity}");
    }

    #[test]
    fn literature_velocity_counts_tones_of_the_band_and_no_others() {
        for (hz, seconds) in [(25.0, 0.5), (12.3, 2.0), (60.0, 30.0), (990.0, 1.0)] {
            let found = velocity_mm_per_s(&sine(1.0, hz, seconds, RATE), RATE).unwrap();
            assert!((found / of_sine(1.0, hz) - 1.0).abs() < 0.01, "{hz} Hz: {found}");
        }
        // The shortest recording that has a velocity.
        for hz in [12.0, 12.7, 14.0, 17.3, 29.0] {
            let found = velocity_mm_per_s(&sine(1.0, hz, 0.5, RATE), RATE).unwrap();
            assert!((found / of_sine(1.0, hz) - 1.0).abs() < 0.02, "{hz} Hz: {found}, {}", of_sine(1.0, hz));
        }
        for hz in [3.0, 1500.0] {
            let found = velocity_mm_per_s(&sine(1.0, hz, 4.0, RATE), RATE).unwrap();
            assert!(found < 1e-3 * of_sine(1.0, hz), "{hz} Hz: {found}");
        }
        let both: Vec<f64> =
            sine(1.0, 30.0, 2.0, RATE).iter().zip(sine(2.0, 90.0, 2.0, RATE)).map(|(a, b)| a + b).collect();
        let expected = of_sine(1.0, 30.0).hypot(of_sine(2.0, 90.0));
        assert!((velocity_mm_per_s(&both, RATE).unwrap() / expected - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_velocity_that_the_recording_cannot_show_is_not_stated() {
        let error = |seconds, rate| velocity_mm_per_s(&sine(1.0, 50.0, seconds, rate), rate).unwrap_err().to_string();
        assert_eq!(error(0.1, 25_600.0), "found 0.100 s without a gap, expected at least 0.5 s");
        assert_eq!(
            error(9.0, 2_000.0),
            "found 2000 Hz, expected a sample rate of at least 2500 Hz for a band up to 1000 Hz"
        );
        let samples = sine(1.0, 50.0, 1.0, RATE);
        let gaps: Vec<usize> = (1..10).map(|n| n * 1280).collect();
        let broken = Indicators::new(&samples, RATE, &gaps);
        assert!(matches!(broken.velocity, Err(NoVelocity::TooShort { found_s }) if found_s < 0.11), "{broken:?}");
        assert!(Indicators::new(&[0.0f32; 0], RATE, &[]).velocity.is_err());
    }

    #[test]
    fn literature_zones_of_iso_20816_3() {
        let zones = |class: IsoClass| [1.4, 1.5, 2.9, 4.6, 7.2, 11.1].map(|v| class.zone(v));
        use Zone::{A, B, C, D};
        assert_eq!(zones(IsoClass::Group1Rigid), [A, A, B, C, D, D]);
        assert_eq!(zones(IsoClass::Group1Flexible), [A, A, A, B, C, D]);
        assert_eq!(zones(IsoClass::Group2Rigid), [A, B, C, D, D, D]);
        assert_eq!(zones(IsoClass::Group2Flexible), zones(IsoClass::Group1Rigid));
    }
}
