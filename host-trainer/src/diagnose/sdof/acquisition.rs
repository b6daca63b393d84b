//! Acquisition faults of an sdof rig, found in the samples themselves: clipping, mains interference, lost samples.
//!
//! They are removed or marked before the force balance, as a clipped sample holds no information on forces.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use super::{events, finding::Fault};
use crate::identify::force_balance::{
    BalanceError,
    states::{States, Track},
};
use crate::rig::EffectEntry;

/// Minimum count of equal consecutive samples of a plateau.
const PLATEAU: usize = 3;
/// Minimum count of plateaus at the maximum of a clipped signal.
const PLATEAUS: usize = 2;
/// Share of equal neighbours elsewhere above which plateaus are no evidence (a coarse converter, a machine at rest).
const EQUAL: f64 = 0.02;
/// Minimum power of a significant line over the mean of its neighbourhood.
const LINE: f64 = 40.0;

/// Finds faults in the first `count` recordings, and removes them or marks the affected samples. A recording with lost
/// samples is cut in two, and `count` is raised.
///
/// # Errors
///
/// As [`States::learn_band`].
pub fn clean(states: &mut States, count: &mut usize) -> Result<Vec<Fault>, BalanceError> {
    let mut faults = Vec::new();
    faults.extend(clipping(&mut states.tracks[..*count]));
    faults.extend(mains(states, *count));
    if faults.is_empty() {
        faults.extend(events::lost_samples(states, count));
    }
    if !faults.is_empty() {
        states.learn_band()?;
    }
    Ok(faults)
}

/// Plateaus of equal samples at a recording's largest magnitude.
fn clipping(tracks: &mut [Track]) -> Option<Fault> {
    let (mut levels, mut plateaus, mut clipped) = (Vec::new(), 0, 0);
    for track in tracks.iter_mut() {
        let level = track.sensed.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
        let at = |x: f64| x.abs() >= level * (1.0 - 1e-9);
        let (mut here, mut run, mut equal) = (0, 0, 0);
        for pair in track.sensed.windows(2) {
            equal += usize::from(pair[0] == pair[1] && !at(pair[0]));
            run = if at(pair[0]) && at(pair[1]) && pair[0] == pair[1] { run + 1 } else { 0 };
            here += usize::from(run == PLATEAU - 1);
        }
        if level == 0.0 || here < PLATEAUS || equal as f64 > EQUAL * track.len() as f64 {
            continue;
        }
        for k in 0..track.len() {
            track.bad[k] |= at(track.sensed[k]);
            clipped += usize::from(at(track.sensed[k]));
        }
        plateaus += here;
        levels.push(level);
    }
    levels.sort_by(f64::total_cmp);
    let level = *levels.get(levels.len() / 2)?;
    Some(Fault {
        entry: EffectEntry::new(EffectKind::SensorClipping, &[(ParameterKey::Value, level)]),
        evidence: format!("{clipped} samples in {plateaus} plateaus are at exactly ±{level:.6e}, no sample is beyond"),
    })
}

/// Line near 50 or 60 Hz in the sensor's signal that is not in the input.
fn mains(states: &mut States, count: usize) -> Option<Fault> {
    let rate = states.sample_rate_hz;
    let nominal = [50.0, 60.0].into_iter().filter(|hz| *hz < 0.45 * rate);
    let longest = states.tracks[..count].iter().max_by_key(|t| t.len())?;
    let step = 0.25 * rate / longest.len() as f64;
    let steps = ((0.5 / step).ceil() as i32).clamp(1, 200);
    let mut best: Option<(f64, f64)> = None;
    for hz in nominal.flat_map(|n| (-steps..=steps).map(move |k| n + f64::from(k) * step)) {
        let stands = prominence(&longest.sensed, hz, rate);
        if best.is_none_or(|(_, most)| stands > most) {
            best = Some((hz, stands));
        }
    }
    let (hz, stands) = best.filter(|(_, stands)| *stands > LINE)?;
    // The machine may respond to a line of the input there, or to a subharmonic.
    if prominence(&longest.input, hz, rate) > 0.2 * stands || answers(longest, hz, rate) {
        return None;
    }
    let (size, phase) = line(&longest.sensed, hz, rate);
    let amplitude = 2.0 * size / longest.len() as f64;
    for track in &mut states.tracks[..count] {
        for harmonic in [1.0, 3.0, 5.0] {
            let f = hz * harmonic;
            if f < 0.45 * rate && (harmonic == 1.0 || prominence(&track.sensed, f, rate) > LINE) {
                subtract(&mut track.sensed, f, rate);
            }
        }
    }
    Some(Fault {
        entry: EffectEntry::new(
            EffectKind::MainsInterference,
            &[
                (ParameterKey::FrequencyHz, hz),
                (ParameterKey::Amplitude, amplitude),
                (ParameterKey::PhaseRad, phase + 0.25 * TAU),
            ],
        ),
        evidence: format!(
            "a line at {hz:.2} Hz has {stands:.0} times the power of its neighbourhood and is not in the input"
        ),
    })
}

/// Magnitude and phase of Σ x e^(−iωk) under a Hann window scaled to weigh like a plain sum; the mean is taken out.
fn line(signal: &[f64], hz: f64, rate: f64) -> (f64, f64) {
    let n = signal.len() as f64;
    let mean = signal.iter().sum::<f64>() / n;
    let (mut re, mut im) = (0.0, 0.0);
    for (k, x) in signal.iter().enumerate() {
        let weight = 1.0 - (TAU * (k as f64 + 0.5) / n).cos();
        let (s, c) = (TAU * hz * k as f64 / rate).sin_cos();
        re += weight * (x - mean) * c;
        im -= weight * (x - mean) * s;
    }
    (re.hypot(im), im.atan2(re))
}

/// Power of a line over the mean of its neighbourhood, 4 to 24 bins away on either side.
fn prominence(signal: &[f64], hz: f64, rate: f64) -> f64 {
    let resolution = rate / signal.len() as f64;
    let around: Vec<f64> = (2..=12)
        .flat_map(|k| [-2.0 * f64::from(k), 2.0 * f64::from(k)])
        .map(|offset| line(signal, hz + offset * resolution, rate).0.powi(2))
        .collect();
    let mean = around.iter().sum::<f64>() / around.len() as f64;
    line(signal, hz, rate).0.powi(2) / mean.max(f64::MIN_POSITIVE)
}

/// Whether the frequency is a small multiple of a strong line of the input.
fn answers(track: &Track, hz: f64, rate: f64) -> bool {
    (2..=7).any(|n| {
        let f = hz / f64::from(n);
        prominence(&track.input, f, rate) > LINE
    })
}

/// Subtracts a tone, fitted by least squares.
fn subtract(signal: &mut [f64], hz: f64, rate: f64) {
    let n = signal.len() as f64;
    // The window leaks a little; the next round corrects it.
    for _ in 0..3 {
        let (size, phase) = line(signal, hz, rate);
        let amplitude = 2.0 * size / n;
        for (k, x) in signal.iter_mut().enumerate() {
            *x -= amplitude * (TAU * hz * k as f64 / rate + phase).cos();
        }
    }
}
