//! Position, velocity and acceleration of a sampled, noisy position, whatever the rig: a spline of order five as a Kalman
//! smoother.
//!
//! The prior is a third derivative that is white noise, so that the mean given the samples is the smoothing spline of order
//! five (G. Wahba, J. R. Stat. Soc. B 40 (1978) 364–372; W. F. Ansley, R. Kohn, Ann. Statist. 11 (1983) 1297–1316), and its
//! two variances are estimated by maximum likelihood from all recordings together. Unlike differences, it is right at
//! fifteen noisy samples a second as well as at a thousand quiet ones, at the ends of a recording too, and says how well it
//! knows each state.

use super::settings::SmootherSettings;
use crate::stats::optimise::golden_section;

const SETTINGS: SmootherSettings = SmootherSettings::DEFAULT;

type Vec3 = [f64; 3];
type Mat3 = [[f64; 3]; 3];

/// Sampled position for a smoother.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Positions.
    pub position: &'a [f64],
    /// Whether each sample is invalid.
    pub bad: &'a [bool],
    /// Time between samples, s.
    pub step_s: f64,
}

/// Variances of the smoothing spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineVariances {
    /// Variance of a sample's noise.
    pub noise: f64,
    /// Power spectral density of the third derivative, divided by `noise`.
    pub ratio: f64,
}

/// States on a grid that divides each step between samples.
#[derive(Clone, Debug, Default)]
pub struct Smoothed {
    /// Position at each point.
    pub position: Vec<f64>,
    /// Velocity at each point.
    pub velocity: Vec<f64>,
    /// Acceleration at each point.
    pub acceleration: Vec<f64>,
    /// Median standard deviation of the velocity.
    pub velocity_std: f64,
}

/// Variances of greatest likelihood; `None` without samples.
pub fn estimate(tracks: &[Samples]) -> Option<SplineVariances> {
    let step = tracks.first()?.step_s;
    let share = (SETTINGS.most_samples / tracks.len().max(1)).max(SETTINGS.least_samples);
    let parts: Vec<Samples> = tracks
        .iter()
        .map(|t| {
            let count = t.position.len().min(share);
            Samples { position: &t.position[..count], bad: &t.bad[..count], ..*t }
        })
        .collect();
    // The ratio at one step is free of units.
    let at = |log: f64| 10f64.powf(log) / step.powi(5);
    let value = |log: f64| likelihood(&parts, at(log)).map_or(f64::NEG_INFINITY, |(value, _)| value);
    // The likelihood may have a second maximum: a coarse grid first.
    let (low, high) = SETTINGS.log_ratios;
    let cells = SETTINGS.ratios;
    let width = (high - low) / cells as f64;
    let best = (0..=cells).map(|k| low + width * k as f64).max_by(|a, b| value(*a).total_cmp(&value(*b)))?;
    let log = golden_section(&value, (best - width).max(low), (best + width).min(high));
    let (_, noise) = likelihood(&parts, at(log))?;
    Some(SplineVariances { noise, ratio: at(log) })
}

/// Twice the logarithm of the likelihood at its best noise, and that noise.
fn likelihood(tracks: &[Samples], ratio: f64) -> Option<(f64, f64)> {
    let (mut squares, mut logs, mut count) = (0.0, 0.0, 0.0);
    for track in tracks {
        let mut filter = Filter::new(track, ratio);
        for (k, (q, bad)) in track.position.iter().zip(track.bad).enumerate() {
            if k > 0 {
                filter.predict();
            }
            if !bad {
                let (error, variance) = filter.update(*q);
                // The first three samples fix the start.
                if filter.seen > 3 {
                    squares += error * error / variance;
                    logs += variance.ln();
                    count += 1.0;
                }
            }
        }
    }
    let noise = squares / count;
    (count > 2.0 && noise > 0.0).then(|| (-(count * noise.ln() + logs), noise))
}

/// Smoothed states with `fine` grid points a step.
pub fn smooth(track: &Samples, variances: &SplineVariances, fine: usize) -> Smoothed {
    let mut filter = Filter::new(&Samples { step_s: track.step_s / fine as f64, ..*track }, variances.ratio);
    let points = (track.position.len().max(1) - 1) * fine + 1;
    let (mut means, mut spreads) = (Vec::with_capacity(points), Vec::with_capacity(points));
    let mut predicted: Vec<(Vec3, Mat3)> = Vec::with_capacity(points);
    for point in 0..points {
        if point > 0 {
            filter.predict();
        }
        predicted.push((filter.mean, filter.spread));
        if point % fine == 0 && !track.bad[point / fine] {
            filter.update(track.position[point / fine]);
        }
        means.push(filter.mean);
        spreads.push(filter.spread);
    }
    // Backwards (H. E. Rauch, F. Tung, C. T. Striebel, AIAA J. 3 (1965) 1445–1450).
    for point in (0..points.saturating_sub(1)).rev() {
        let (ahead, spread) = predicted[point + 1];
        let Some(inverse) = invert(&spread) else { continue };
        let gain = times(&times(&spreads[point], &transpose(&TRANSITION)), &inverse);
        let lift: Vec3 = std::array::from_fn(|i| means[point + 1][i] - ahead[i]);
        let step = apply(&gain, &lift);
        (0..3).for_each(|i| means[point][i] += step[i]);
        let change: Mat3 = std::array::from_fn(|i| std::array::from_fn(|j| spreads[point + 1][i][j] - spread[i][j]));
        let change = times(&times(&gain, &change), &transpose(&gain));
        (0..3).for_each(|i| (0..3).for_each(|j| spreads[point][i][j] += change[i][j]));
    }
    let h = track.step_s / fine as f64;
    let mut stds: Vec<f64> = spreads.iter().map(|p| (p[1][1].max(0.0) * variances.noise).sqrt() / h).collect();
    stds.sort_by(f64::total_cmp);
    let offset = filter.offset;
    Smoothed {
        position: means.iter().map(|x| x[0] + offset).collect(),
        velocity: means.iter().map(|x| x[1] / h).collect(),
        acceleration: means.iter().map(|x| 2.0 * x[2] / (h * h)).collect(),
        velocity_std: stds.get(stds.len() / 2).copied().unwrap_or_default(),
    }
}

/// Transition over one step of q, h q̇ and h² q̈/2.
const TRANSITION: Mat3 = [[1.0, 1.0, 1.0], [0.0, 1.0, 2.0], [0.0, 0.0, 1.0]];

struct Filter {
    mean: Vec3,
    /// In units of the noise's variance.
    spread: Mat3,
    process: Mat3,
    seen: usize,
    offset: f64,
}

impl Filter {
    fn new(track: &Samples, ratio: f64) -> Self {
        let s = ratio * track.step_s.powi(5);
        let process = [[s / 20.0, s / 8.0, s / 12.0], [s / 8.0, s / 3.0, s / 4.0], [s / 12.0, s / 4.0, s / 4.0]];
        let offset = track.position.first().copied().unwrap_or_default();
        let wide = SETTINGS.start_variance * (1.0 + s);
        let spread = [[wide, 0.0, 0.0], [0.0, wide, 0.0], [0.0, 0.0, wide]];
        Self { mean: [0.0; 3], spread, process, seen: 0, offset }
    }

    fn predict(&mut self) {
        self.mean = apply(&TRANSITION, &self.mean);
        self.spread = times(&times(&TRANSITION, &self.spread), &transpose(&TRANSITION));
        (0..3).for_each(|i| (0..3).for_each(|j| self.spread[i][j] += self.process[i][j]));
    }

    /// Error of the prediction, and its variance in units of the noise's.
    fn update(&mut self, value: f64) -> (f64, f64) {
        self.seen += 1;
        let variance = self.spread[0][0] + 1.0;
        let error = value - self.offset - self.mean[0];
        let gain: Vec3 = std::array::from_fn(|i| self.spread[i][0] / variance);
        (0..3).for_each(|i| self.mean[i] += gain[i] * error);
        // Joseph's form stays positive.
        let keep: Mat3 = std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from(u8::from(i == j)) - if j == 0 { gain[i] } else { 0.0 })
        });
        self.spread = times(&times(&keep, &self.spread), &transpose(&keep));
        (0..3).for_each(|i| (0..3).for_each(|j| self.spread[i][j] += gain[i] * gain[j]));
        (error, variance)
    }
}

fn times(a: &Mat3, b: &Mat3) -> Mat3 {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transpose(a: &Mat3) -> Mat3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

fn apply(a: &Mat3, x: &Vec3) -> Vec3 {
    std::array::from_fn(|i| (0..3).map(|j| a[i][j] * x[j]).sum())
}

/// Inverse of a symmetric matrix by its cofactors after scaling its diagonal to 1.
fn invert(a: &Mat3) -> Option<Mat3> {
    let scale: Vec3 = std::array::from_fn(|i| a[i][i].sqrt());
    if scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
        return None;
    }
    let n: Mat3 = std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] / (scale[i] * scale[j])));
    let minor = |i: usize, j: usize| {
        let (r, c) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
        n[r[0]][c[0]] * n[r[1]][c[1]] - n[r[0]][c[1]] * n[r[1]][c[0]]
    };
    let determinant: f64 = (0..3).map(|j| n[0][j] * minor(0, j)).sum();
    (determinant.abs() > 1e-14)
        .then(|| std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant / (scale[i] * scale[j]))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::force_balance::testing::white;

    /// A fall at fifteen samples a second with a centimetre of noise: velocity and acceleration are known to some percent.
    #[test]
    fn invariant_states_of_a_noisy_fall() {
        let (h, noise) = (1.0 / 15.0, white(1, 0.01, 45));
        let position: Vec<f64> = (0..45).map(|k| 4.905 * (k as f64 * h).powi(2) + noise[k]).collect();
        let samples = Samples { position: &position, bad: &[false; 45], step_s: h };
        let variances = estimate(&[samples]).unwrap();
        assert!((variances.noise.sqrt() / 0.01 - 1.0).abs() < 0.4, "{variances:?}");
        let smoothed = smooth(&samples, &variances, 2);
        for k in 10..80 {
            let t = 0.5 * h * k as f64;
            assert!((smoothed.velocity[k] - 9.81 * t).abs() < 0.1, "{k}: {}", smoothed.velocity[k]);
        }
        assert!((smoothed.acceleration[40] - 9.81).abs() < 0.5);
    }

    /// Nine samples a period without noise: between them the spline is right to a thousandth.
    #[test]
    fn invariant_a_fast_tone_is_interpolated() {
        let wave = |x: f64| (0.7 * x).sin();
        let position: Vec<f64> = (0..200).map(|k| wave(f64::from(k))).collect();
        let samples = Samples { position: &position, bad: &[false; 200], step_s: 1.0 };
        let variances = estimate(&[samples]).unwrap();
        let smoothed = smooth(&samples, &variances, 4);
        for point in 80..700 {
            let x = 0.25 * point as f64;
            assert!((smoothed.position[point] - wave(x)).abs() < 1e-3);
            assert!((smoothed.velocity[point] - 0.7 * (0.7 * x).cos()).abs() < 2e-3);
        }
    }
}
