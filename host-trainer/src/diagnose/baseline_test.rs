//! Tests of real recordings against those of the healthy machine, which give the null distribution instead of a rig.
//!
//! All are cut into pieces of one length, which thus have the same null distribution. Pieces do not show the variation between
//! recordings: with few recordings of the healthy machine a difference shows a change, not necessarily of the machine's
//! condition.

use realfft::num_complex::Complex;

use super::DiagnoseError;
use super::evidence::{NullSpread, against, ranked, views};
use super::residual::{Whitened, whitened};
use super::result::{Aspect, Test};
use super::statistics::{Statistic, statistics};
use crate::identify::calibrate::split::part;
use crate::identify::likelihood::observed::Observed;
use crate::identify::likelihood::whittle::{Noise, Prediction};
use crate::recording::Recording;
use crate::rig::state::VelocityCovariance;
use crate::signal::kinematics::Geometry;

/// Minimum count of pieces that the healthy machine's recordings are cut into.
const PIECES: usize = 12;
/// Maximum count of pieces that are tested.
const MOST: usize = 48;
/// Minimum count of healthy pieces for a null distribution.
const LEAST: usize = 4;
/// Minimum samples of a piece.
const SHORTEST: usize = 1024;
/// Bins of the power density that are averaged.
const SMOOTH: usize = 9;

/// Tests of recordings against the scatter of pieces of healthy ones, the most significant first; none if these are too few or
/// of another sample rate.
///
/// # Errors
/// Recordings without acceleration, speed or load.
pub fn tests(
    geometry: &Geometry,
    baseline: &[Recording],
    recordings: &[Recording],
) -> Result<Vec<Test>, DiagnoseError> {
    let rate = |r: &Recording| r.sample_rate_hz;
    let even = baseline.iter().chain(recordings).all(|r| rate(r) == rate(&recordings[0]));
    let shortest = |of: &[Recording]| of.iter().map(Recording::len).min().unwrap_or_default();
    let each = PIECES.div_ceil(baseline.len().max(1));
    let length = (shortest(baseline) / each).min(shortest(recordings));
    let (usual, now) = (pieces(baseline, length)?, pieces(recordings, length)?);
    if !even || usual.len() < LEAST || now.is_empty() {
        return Ok(Vec::new());
    }
    let density = [0, 1].map(|channel| density(&usual, channel));
    let left = |piece: &Observed| {
        let mean = density.each_ref().map(|d| vec![Complex::default(); d.len()]);
        let noise = Noise { variance: density.clone(), velocity_covariance: VelocityCovariance(Default::default()) };
        whitened(std::slice::from_ref(piece), &[Prediction { mean, noise }])
    };
    let of = |piece: &Observed| -> Vec<Statistic> {
        let residuals: Vec<Whitened> = left(piece);
        let mut all = statistics(&views(std::slice::from_ref(piece), &residuals, None), geometry);
        // Of these aspects each piece has its own values.
        all.retain(|s| !matches!(s.aspect, Aspect::Time | Aspect::Displacement | Aspect::Velocity));
        all
    };
    let others: Vec<Vec<Statistic>> = usual.iter().map(of).collect();
    let own: Vec<Vec<Statistic>> = now.iter().map(of).collect();
    Ok(ranked(against(mean(&own), &others, NullSpread::OfTheOthers)))
}

fn pieces(of: &[Recording], length: usize) -> Result<Vec<Observed>, DiagnoseError> {
    if length < SHORTEST {
        return Ok(Vec::new());
    }
    let cut = |r: &Recording| (0..r.len() / length).map(|k| part(r, k * length..(k + 1) * length)).collect::<Vec<_>>();
    let all: Vec<Recording> = of.iter().flat_map(cut).collect();
    // Evenly over all of them.
    let step = all.len().div_ceil(MOST).max(1);
    Ok(all.iter().step_by(step).map(Observed::from_recording).collect::<Result<_, _>>()?)
}

/// Power of the Fourier coefficients of a channel, averaged over pieces and neighbouring bins; empty if no piece has the channel.
fn density(of: &[Observed], channel: usize) -> Vec<f64> {
    let spectra: Vec<_> = of.iter().filter_map(|o| o.spectra[channel].as_ref()).collect();
    let Some(first) = spectra.first() else { return Vec::new() };
    let mean = |k: usize| spectra.iter().map(|s| s[k].norm_sqr()).sum::<f64>() / spectra.len() as f64;
    let raw: Vec<f64> = (0..first.len()).map(mean).collect();
    let around = |k: usize| {
        let here = &raw[k.saturating_sub(SMOOTH / 2)..(k + SMOOTH / 2 + 1).min(raw.len())];
        (here.iter().sum::<f64>() / here.len() as f64).max(f64::MIN_POSITIVE)
    };
    (0..raw.len()).map(around).collect()
}

/// Mean statistics of pieces.
fn mean(pieces: &[Vec<Statistic>]) -> Vec<Statistic> {
    let of = |(index, s): (usize, &Statistic)| {
        let sum: f64 = pieces.iter().filter_map(|p| p.get(index)).map(|p| p.value).sum();
        Statistic { value: sum / pieces.len() as f64, ..s.clone() }
    };
    pieces.first().map_or_else(Vec::new, |first| first.iter().enumerate().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::force_balance::testing::white;
    use crate::recording::Channel;

    const RATE: f64 = 12_000.0;

    /// Recording of coloured noise, a tone of random phase, and white noise of standard deviation `more`.
    fn recording(seed: u64, seconds: f64, more: f64) -> Recording {
        let count = (seconds * RATE) as usize;
        let (noise, other) = (white(seed, 1.0, count), white(seed + 500, more, count));
        let mut state = 0.0;
        let samples = (0..count).map(|i| {
            state = 0.9 * state + noise[i];
            state + (0.3 * i as f64 + seed as f64).sin() + other[i]
        });
        let channels = vec![Channel { name: "ay".into(), location: None, samples: samples.collect() }];
        Recording { channels, sample_rate_hz: RATE, shaft_hz: Some(30.0), load_n: Some(300.0), ..Recording::default() }
    }

    fn geometry() -> Geometry {
        Geometry { balls: 9, ball_diameter_m: 0.00794, pitch_diameter_m: 0.03904, contact_angle_rad: 0.0 }
    }

    #[test]
    fn null_more_of_the_same_does_not_stand_out() {
        let of =
            |seed: u64| tests(&geometry(), &[recording(seed, 4.0, 0.0)], &[recording(seed + 50, 6.0, 0.0)]).unwrap();
        let wrong = (0..20).filter(|seed| of(*seed).iter().any(Test::is_significant)).count();
        assert!(wrong <= 2, "{wrong}");
    }

    #[test]
    fn what_is_louder_where_the_machine_is_quiet_stands_out_there() {
        let found = tests(&geometry(), &[recording(1, 4.0, 0.0)], &[recording(2, 4.0, 1.0)]).unwrap();
        let bands: Vec<[f64; 2]> = found
            .iter()
            .filter(|t| t.aspect == Aspect::Spectrum && t.is_significant() && t.z > 0.0)
            .filter_map(|t| t.at)
            .collect();
        // The coloured noise is 100 times as strong below 200 Hz as white noise, and a quarter of it at 6 kHz.
        assert!(bands.iter().any(|[from, _]| *from > 5000.0), "{bands:?}");
        assert!(found.iter().all(|t| !matches!(t.aspect, Aspect::Time | Aspect::Velocity)));
    }

    #[test]
    fn too_few_or_uneven_recordings_tell_nothing() {
        let short = recording(1, 0.5, 0.0);
        assert_eq!(tests(&geometry(), &[short], &[recording(2, 1.0, 0.0)]).unwrap(), []);
        let slower = Recording { sample_rate_hz: 6000.0, ..recording(3, 1.0, 0.0) };
        assert_eq!(tests(&geometry(), &[recording(1, 1.0, 0.0)], &[slower]).unwrap(), []);
    }
}
