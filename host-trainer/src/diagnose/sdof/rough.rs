//! A rough fit beside a few nonlinear terms: the rig's unknown parameters, the noise, the input between its samples, and the
//! time by which the sensor is late against it.

use super::acquire::Acquired;
use super::library::Builder;
use super::nominal::Nominal;
use super::settings::SdofSettings;
use super::table;
use crate::identify::force_balance::equation::Parameter;
use crate::identify::force_balance::gram::{Gram, Rows};
use crate::rig::Rig;
use crate::rig::sdof::Interpolation;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;
/// Least step in the search of a delay, samples.
const FINEST: f64 = 0.02;

/// A fit at a ratio of force noise to sensor noise.
struct Rough {
    /// Twice the logarithm of the likelihood, but for a constant.
    likelihood: f64,
    /// The ratio.
    ratio: f64,
    /// Input between its samples.
    interpolation: Interpolation,
    /// Mean square of what is left, in the sensor's unit.
    left: f64,
    /// Changes of the rig's unknown parameters, fitted alone.
    own: Vec<(Parameter, f64)>,
}

impl Rough {
    fn new(rig: &Rig, nominal: &Nominal, part: &Acquired, ratio: f64) -> Option<Self> {
        let library = Builder::new(rig, nominal, part, ratio).rough();
        let rows = library.columns[0].len();
        let gram = Gram::new(&library.columns, &[rows], &[0], 0);
        let columns: Vec<usize> = (1..library.columns.len()).collect();
        let values = gram.solve(&columns, &[], Rows::All, table::RIDGE)?;
        let left = gram.left_in(&columns, &values, Rows::All).max(f64::MIN_POSITIVE);
        let own: Vec<usize> = library.own.iter().map(|(_, column, _)| *column).collect();
        let alone = gram.solve(&own, &[], Rows::All, 0.0).unwrap_or_default();
        Some(Self {
            likelihood: -(rows as f64 * left.ln() + library.log_variance),
            ratio,
            interpolation: part.interpolation,
            left: left / rows as f64,
            own: library.own.iter().zip(alone).map(|((parameter, ..), value)| (*parameter, value)).collect(),
        })
    }
}

/// Fits the unknown parameters, learns noise, course and delay of the input; the ratio of force noise to sensor noise.
pub fn fit(rig: &Rig, nominal: &mut Nominal, acquired: &mut Acquired) -> f64 {
    let (low, high, count) = SETTINGS.force_noise;
    let mut noise = acquired.noise_std.powi(2);
    let mut part = acquired.beginning(SETTINGS.noise_samples);
    let mut best: Option<Rough> = None;
    for round in 0..2 {
        let force = mean_square_force(nominal, acquired);
        let rate = acquired.tracks[0].sample_rate_hz;
        let ratio = |log: f64| (10f64.powf(log) * force / rate / noise.max(f64::MIN_POSITIVE)).max(1e-300);
        best = None;
        let courses: &[Interpolation] = if acquired.driven {
            &[Interpolation::Hold, Interpolation::Linear, Interpolation::Smooth]
        } else {
            &[Interpolation::Hold]
        };
        for interpolation in courses {
            part.interpolation = *interpolation;
            for cell in 0..count {
                let log = low + (high - low) * cell as f64 / (count - 1) as f64;
                let Some(fit) = Rough::new(rig, nominal, &part, ratio(log)) else { continue };
                if best.as_ref().is_none_or(|most| fit.likelihood > most.likelihood) {
                    best = Some(fit);
                }
            }
        }
        // The rig's dynamics tell noise from motion where a spline takes fast motion for either.
        noise = best.as_ref().map_or(noise, |best| best.left);
        if let Some(best) = best.as_ref().filter(|_| round == 0) {
            best.own.iter().for_each(|(parameter, value)| nominal.add(*parameter, *value));
        }
    }
    acquired.noise_std = noise.sqrt();
    let Some(best) = best else { return 1.0 };
    acquired.interpolation = best.interpolation;
    part.interpolation = best.interpolation;
    if acquired.driven && acquired.delay == 0.0 {
        let delay = delay(&best, |delay| Rough::new(rig, nominal, &part.delayed(delay), best.ratio));
        if delay != 0.0 {
            *acquired = acquired.delayed(delay);
        }
    }
    best.ratio
}

/// Time by which the sensor is late against the input, in samples; 0 if that makes the recordings more likely by too little.
fn delay(without: &Rough, fit: impl Fn(f64) -> Option<Rough>) -> f64 {
    let [longest, step, gain] = SETTINGS.delay;
    let likelihood = |delay: f64| fit(delay).map_or(f64::NEG_INFINITY, |fit| fit.likelihood);
    let steps = (longest / step) as i32;
    let apart = (-steps..=steps).filter(|n| *n != 0).map(|n| f64::from(n) * step);
    let Some((mut best, mut most)) = apart.map(|d| (d, likelihood(d))).max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return 0.0;
    };
    let mut finer = 0.5 * step;
    while finer > FINEST {
        for near in [best - finer, best + finer] {
            let value = likelihood(near);
            if value > most {
                (best, most) = (near, value);
            }
        }
        finer *= 0.5;
    }
    if most > without.likelihood + gain { best } else { 0.0 }
}

/// Mean square of the largest force of the balance, N².
fn mean_square_force(nominal: &Nominal, acquired: &Acquired) -> f64 {
    let (mut sums, mut count) = ([0.0f64; 4], 0.0f64);
    let machine = &nominal.machine;
    for track in &acquired.tracks {
        let states = &track.states;
        for ((q, v), a) in states.position.iter().zip(&states.velocity).zip(&states.acceleration) {
            let forces = [machine.mass_kg * a, machine.damping_n_s_per_m * v, machine.stiffness_n_per_m * q];
            (0..3).for_each(|i| sums[i] += forces[i] * forces[i]);
        }
        count += states.position.len() as f64;
        let scale = machine.input_gain_n_per_unit.powi(2) * track.fine as f64;
        sums[3] += scale * track.input.iter().map(|u| u * u).sum::<f64>();
    }
    sums.iter().fold(0.0f64, |most, s| most.max(*s)) / count.max(1.0)
}
