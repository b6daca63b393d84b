//! The electrical line in what a model leaves: a tone at the sensor that is not in the input, with its harmonics. It is taken
//! off, and the search for forces goes on.

use std::f64::consts::TAU;

use super::acquire::{Acquired, Track};
use super::faults::Fault;
use super::library::Builder;
use super::repeating::{self, Repeats};
use super::table::{Table, TermModel};
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

/// Nominal frequencies of the mains, Hz, and the greatest distance from them.
const NOMINAL: ([f64; 2], f64) = ([50.0, 60.0], 0.5);
/// Harmonics of the mains that are sought.
const HARMONICS: u32 = 7;
/// Steps to either side of a bin in which the frequency is sought, and parts of a bin a step.
const STEPS: (i32, f64) = (16, 16.0);
/// Power of a line over the mean of white noise's from which it is taken off: 1e-6 by chance.
const LINE: f64 = 14.0;

/// The line as a fault, and what it adds to each recording.
pub struct Hum {
    /// Fault.
    pub fault: Fault,
    /// Signal at the sensor of each recording.
    pub signals: Vec<Vec<f64>>,
}

/// Fit of a tone to what a model leaves of a recording.
#[derive(Clone, Copy, Default)]
struct Tone {
    /// Weights of cosine and sine, in the sensor's unit.
    weights: [f64; 2],
    /// What it takes of the squares, over the mean square.
    power: f64,
}

impl Hum {
    /// The line, if it is what repeats most in what a model leaves.
    pub fn find(builder: &Builder, table: &Table, model: &TermModel) -> Option<Self> {
        let acquired = builder.acquired;
        let found = repeating::find(table, acquired, model).filter(|found| found.what == Repeats::Force)?;
        let (nominal, near) = NOMINAL;
        let harmonic = |mains: f64| (found.often / mains).round();
        let is_of = |mains: &f64| {
            let n = harmonic(*mains);
            (1.0..=f64::from(HARMONICS)).contains(&n) && (found.often / n - mains).abs() < near
        };
        let mains = nominal.into_iter().filter(is_of).min_by(|a, b| harmonic(*a).total_cmp(&harmonic(*b)))?;
        let left = table.residual(model);
        let power = |hz: f64| tones(builder, table, &left, hz).iter().map(|tone| tone.power).sum::<f64>();
        let longest = acquired.under_test().map(|t| t.len() as f64 * t.step_s()).fold(0.0, f64::max);
        let (steps, parts) = STEPS;
        let around = (-steps..=steps).map(|step| found.often + f64::from(step) / parts / longest);
        let hz = around.map(|hz| (hz, power(hz))).max_by(|a, b| a.1.total_cmp(&b.1))?.0 / harmonic(mains);
        let mut signals: Vec<Vec<f64>> = acquired.tracks.iter().map(|t| vec![0.0; t.len()]).collect();
        let rate = acquired.under_test().map(|t| t.sample_rate_hz).fold(f64::INFINITY, f64::min);
        let count = acquired.under_test().count() as f64;
        // Of the lowest harmonic that stands out, in the first recording.
        let mut lowest: Option<[f64; 2]> = None;
        for harmonic in (1..=HARMONICS).map(f64::from).filter(|n| n * hz < 0.45 * rate) {
            let tones = tones(builder, table, &left, harmonic * hz);
            if tones.iter().map(|tone| tone.power).sum::<f64>() < LINE * count {
                continue;
            }
            for ((signal, track), tone) in signals.iter_mut().zip(&acquired.tracks).zip(&tones) {
                let [cosine, sine] = tone.weights;
                let phase = |k: usize| TAU * harmonic * hz * k as f64 * track.step_s();
                signal.iter_mut().enumerate().for_each(|(k, x)| {
                    let (s, c) = phase(k).sin_cos();
                    *x += cosine * c + sine * s;
                });
            }
            lowest = lowest.or_else(|| Some(tones.first()?.weights));
        }
        let [cosine, sine] = lowest?;
        let (amplitude, phase) = (cosine.hypot(sine), cosine.atan2(sine));
        let numbers =
            [(ParameterKey::FrequencyHz, hz), (ParameterKey::Amplitude, amplitude), (ParameterKey::PhaseRad, phase)];
        let evidence = format!(
            "a line at {:.2} Hz that is not in the input holds {:.0} % of the squares of what the rig leaves, one step ahead",
            found.often,
            100.0 * found.share
        );
        Some(Self {
            fault: Fault { entry: EffectEntry::new(EffectKind::MainsInterference, &numbers), evidence },
            signals,
        })
    }

    /// Takes the line off the recordings.
    pub fn take_off(&self, acquired: &mut Acquired) {
        for (track, signal) in acquired.tracks.iter_mut().zip(&self.signals) {
            track.sensed.iter_mut().zip(signal).for_each(|(x, line)| *x -= line);
        }
    }
}

/// Fit of a tone to what a model leaves of each recording under test, nothing for healthy ones.
fn tones(builder: &Builder, table: &Table, left: &[f64], hz: f64) -> Vec<Tone> {
    let mut rest = left;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut one = |((track, rows), [cosine, sine]): ((&Track, &usize), &[Vec<f64>; 2])| {
        let (own, others) = rest.split_at(*rows);
        rest = others;
        let [cc, cs, ss] = [dot(cosine, cosine), dot(cosine, sine), dot(sine, sine)];
        let determinant = cc * ss - cs * cs;
        if track.healthy || determinant <= 0.0 {
            return Tone::default();
        }
        let [c, s] = [dot(cosine, own), dot(sine, own)];
        let weights = [(ss * c - cs * s) / determinant, (cc * s - cs * c) / determinant];
        let mean = dot(own, own) / own.len().max(1) as f64;
        Tone { weights, power: 0.5 * (weights[0] * c + weights[1] * s) / mean.max(f64::MIN_POSITIVE) }
    };
    builder.acquired.tracks.iter().zip(&table.library.rows).zip(&builder.tone(hz)).map(&mut one).collect()
}
