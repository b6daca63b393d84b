//! Recordings, a rig and its sought numbers: likelihood, gradient and information at a point, theory (54) to (56).

use std::iter;
use std::ops::Range;

use faer::Mat;
use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::align;
use super::coordinate::{ANGLE_STEP, Coordinate};
use super::observed::{Coefficients, Observed};
use super::settings::SearchSettings;
use super::tachometer::Reading;
use super::whittle::{Noise, NoiseFreeRun, Prediction, judged_bins, means, neg_log_likelihood, noises_in};
use crate::rig::{Rig, RigError};

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Recordings, and the rig whose numbers are sought.
#[derive(Clone, Debug)]
pub struct Problem<'o> {
    /// The recordings.
    pub observed: &'o [Observed],
    /// The rig; its values at `coordinates` are replaced.
    pub rig: Rig,
    /// Sought numbers.
    pub coordinates: Vec<Coordinate>,
    /// Highest frequency that counts, as a share of half the sample rate. Below 1 for the first steps of a search: at low
    /// frequencies the likelihood has few local maxima.
    pub band: f64,
}

/// Values of all unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// One for each of the problem's coordinates.
    pub coordinates: Vec<f64>,
    /// Angle of cage and shaft at t = 0 of each recording, rad.
    pub angles: Vec<[f64; 2]>,
}

/// The likelihood around a point. Unknowns are the coordinates, then both angles of each recording.
#[derive(Clone, Debug)]
pub struct Expansion {
    /// Negative log-likelihood −ln L of each recording.
    pub neg_log_likelihoods: Vec<f64>,
    /// Lack of fit above chance, in the unit of −ln L: squared residuals over their variance, less one each.
    pub excess: f64,
    /// Gradient of −ln L, theory (55), one entry per unknown.
    pub gradient: Vec<f64>,
    /// Parts of the gradient by each recording's tachometer and each band of its channels.
    pub scores: Vec<Vec<f64>>,
    /// Expected information, theory (56), unknowns × unknowns.
    pub information: Mat<f64>,
}

impl Expansion {
    /// Negative log-likelihood −ln L of all recordings.
    pub fn neg_log_likelihood(&self) -> f64 {
        self.neg_log_likelihoods.iter().sum()
    }
}

impl<'o> Problem<'o> {
    /// Problem of `coordinates` and the angles, with all frequencies up to half the sample rate.
    pub fn new(observed: &'o [Observed], rig: Rig, coordinates: Vec<Coordinate>) -> Self {
        Self { observed, rig, coordinates, band: 1.0 }
    }

    /// Problem of the angles only.
    pub fn of_angles(observed: &'o [Observed], rig: Rig) -> Self {
        Self::new(observed, rig, Vec::new())
    }

    /// Point of the rig's own values, with the angles that suit the recordings best.
    ///
    /// # Errors
    /// A run that the simulation refuses.
    pub fn start(&self) -> Result<Point, RigError> {
        Ok(self.start_at(self.aligned(&self.rig)?))
    }

    /// Point of the rig's own values, with given angles.
    pub fn start_at(&self, angles: Vec<[f64; 2]>) -> Point {
        let value = |c: &Coordinate| c.to_coordinate(self.rig.get(c.key).unwrap_or_default());
        Point { coordinates: self.coordinates.iter().map(value).collect(), angles }
    }

    /// Angles with which a rig suits the recordings best, theory (58).
    ///
    /// # Errors
    /// A run that the simulation refuses.
    pub fn aligned(&self, rig: &Rig) -> Result<Vec<[f64; 2]>, RigError> {
        align::angles(rig, self.observed, &self.noise(rig)?)
    }

    /// Rig at the given coordinates.
    ///
    /// # Errors
    /// A value out of the range of its key.
    pub fn rig_at(&self, coordinates: &[f64]) -> Result<Rig, RigError> {
        let mut rig = self.rig.clone();
        self.coordinates.iter().zip(coordinates).try_for_each(|(c, u)| c.put(&mut rig, *u))?;
        rig.check()?;
        Ok(rig)
    }

    fn noise(&self, rig: &Rig) -> Result<Vec<Noise>, RigError> {
        noises_in(&[rig], self.observed)
    }

    /// Prediction of each recording at a point.
    ///
    /// # Errors
    /// A run that the simulation refuses, or that diverges.
    pub fn predict(&self, point: &Point) -> Result<Vec<Prediction>, RigError> {
        let rig = self.rig_at(&point.coordinates)?;
        let noise = self.noise(&rig)?;
        let means = means(&align::noise_free_runs(&rig, self.observed, &noise, &point.angles))?;
        means.into_iter().zip(noise).map(|(mean, noise)| Ok(Prediction { mean: mean?, noise })).collect()
    }

    /// Negative log-likelihood −ln L of each recording, theory (54).
    ///
    /// # Errors
    /// As [`Problem::predict`].
    pub fn neg_log_likelihoods(&self, point: &Point) -> Result<Vec<f64>, RigError> {
        let expected = self.predict(point)?;
        let each = self.observed.iter().zip(&expected).zip(&point.angles);
        Ok(each
            .map(|((o, e), [_, shaft])| {
                neg_log_likelihood(o, e, self.band) + self.of_tachometer(o, |t| t.neg_log_likelihood(*shaft))
            })
            .collect())
    }

    /// Term of a recording's tachometer.
    fn of_tachometer(&self, o: &Observed, adds: impl Fn(Reading) -> f64) -> f64 {
        align::reading(&self.rig, o).map_or(0.0, adds)
    }

    /// Likelihood, gradient and information, theory (54) to (56), by difference quotients of D and ln S.
    ///
    /// # Errors
    /// As [`Problem::predict`].
    pub fn expand(&self, point: &Point) -> Result<Expansion, RigError> {
        let base = self.rig_at(&point.coordinates)?;
        let moved: Vec<Rig> = (0..self.coordinates.len())
            .map(|a| {
                let mut coordinates = point.coordinates.clone();
                coordinates[a] += self.coordinates[a].step();
                self.rig_at(&coordinates)
            })
            .collect::<Result<_, _>>()?;
        // Of each recording: as it is, with each coordinate that moves D moved, with each angle moved.
        let mean_of: Vec<usize> = (0..moved.len()).filter(|a| self.coordinates[*a].moves_mean).collect();
        // The noise of each recording: as it is, with each coordinate that moves S moved.
        let variance_of: Vec<usize> = (0..moved.len()).filter(|a| self.coordinates[*a].moves_variance).collect();
        let rigs: Vec<&Rig> = iter::once(&base).chain(variance_of.iter().map(|a| &moved[*a])).collect();
        let noises = noises_in(&rigs, self.observed)?;
        let mut runs = Vec::new();
        for ((o, &[cage, shaft]), noises) in self.observed.iter().zip(&point.angles).zip(noises.chunks(rigs.len())) {
            let scatter = noises[0].velocity_covariance;
            let as_it_is = NoiseFreeRun { rig: &base, condition: o.condition, angles: [cage, shaft], scatter };
            runs.push(as_it_is);
            runs.extend(mean_of.iter().map(|a| {
                let own = variance_of
                    .iter()
                    .position(|b| a == b)
                    .map_or(scatter, |place| noises[1 + place].velocity_covariance);
                NoiseFreeRun { rig: &moved[*a], scatter: own, ..as_it_is }
            }));
            runs.push(NoiseFreeRun { angles: [cage + ANGLE_STEP, shaft], ..as_it_is });
            runs.push(NoiseFreeRun { angles: [cage, shaft + ANGLE_STEP], ..as_it_is });
        }
        let means = means(&runs)?.into_iter().collect::<Result<Vec<_>, _>>()?;
        let count = self.coordinates.len();
        let unknowns = count + 2 * self.observed.len();
        let pieces: Vec<_> = self
            .observed
            .par_iter()
            .enumerate()
            .zip(means.par_chunks(mean_of.len() + 3))
            .zip(noises.par_chunks(rigs.len()))
            .map(|(((index, o), means), noises)| {
                let at = &noises[0].variance;
                let mut local = Local::new(count + 2);
                let tachometer = self.of_tachometer(o, |t| t.gradient(point.angles[index][1]));
                local.scores.push(vec![0.0; count + 2]);
                local.scores[0][count + 1] = tachometer;
                for channel in 0..2 {
                    let Some(x) = &o.spectra[channel] else { continue };
                    let mut slopes: Vec<Slope> = vec![Slope::default(); count + 2];
                    for (place, a) in mean_of.iter().enumerate() {
                        slopes[*a].mean =
                            quotient(&means[0][channel], &means[1 + place][channel], self.coordinates[*a].step());
                    }
                    for angle in 0..2 {
                        let moved = &means[mean_of.len() + 1 + angle][channel];
                        slopes[count + angle].mean = quotient(&means[0][channel], moved, ANGLE_STEP);
                    }
                    for (a, there) in variance_of.iter().zip(&noises[1..]) {
                        let pairs = at[channel].iter().zip(&there.variance[channel]);
                        slopes[*a].log_variance =
                            pairs.map(|(s, t)| (t / s).ln() / self.coordinates[*a].step()).collect();
                    }
                    local.add(judged_bins(x, self.band), x, &means[0][channel], &at[channel], &slopes);
                }
                (index, local)
            })
            .collect();
        let mut out = Expansion {
            neg_log_likelihoods: vec![0.0; self.observed.len()],
            excess: 0.0,
            gradient: vec![0.0; unknowns],
            scores: Vec::new(),
            information: Mat::zeros(unknowns, unknowns),
        };
        for (index, local) in pieces {
            let global = |a: usize| if a < count { a } else { count + 2 * index + a - count };
            let (o, shaft) = (&self.observed[index], point.angles[index][1]);
            out.excess += local.excess;
            out.neg_log_likelihoods[index] =
                local.neg_log_likelihood + self.of_tachometer(o, |t| t.neg_log_likelihood(shaft));
            let place = global(count + 1);
            out.information[(place, place)] += self.of_tachometer(o, Reading::information);
            for of_band in &local.scores {
                let mut score = vec![0.0; unknowns];
                (0..count + 2).for_each(|a| score[global(a)] = of_band[a]);
                out.gradient.iter_mut().zip(&score).for_each(|(sum, part)| *sum += part);
                out.scores.push(score);
            }
            for a in 0..count + 2 {
                for b in 0..count + 2 {
                    out.information[(global(a), global(b))] += local.information[(a, b)];
                }
            }
        }
        Ok(out)
    }
}

/// Derivatives of D and ln S by one unknown; empty if they do not depend on it.
#[derive(Clone, Debug, Default)]
struct Slope {
    mean: Coefficients,
    log_variance: Vec<f64>,
}

fn quotient(from: &[Complex<f64>], to: &[Complex<f64>], step: f64) -> Coefficients {
    from.iter().zip(to).map(|(a, b)| (b - a) / step).collect()
}

/// One recording's part of an [`Expansion`].
struct Local {
    neg_log_likelihood: f64,
    excess: f64,
    /// Scores as in [`Expansion::scores`].
    scores: Vec<Vec<f64>>,
    information: Mat<f64>,
}

impl Local {
    fn new(unknowns: usize) -> Self {
        Self { neg_log_likelihood: 0.0, excess: 0.0, scores: Vec::new(), information: Mat::zeros(unknowns, unknowns) }
    }

    fn add(&mut self, bins: Range<usize>, x: &[Complex<f64>], d: &[Complex<f64>], s: &[f64], slopes: &[Slope]) {
        let left = bins.clone().map(|k| (x[k] - d[k]).norm_sqr() / s[k]).sum::<f64>();
        self.neg_log_likelihood += left + bins.clone().map(|k| s[k].ln()).sum::<f64>();
        self.excess += left - bins.len() as f64;
        let bands = SETTINGS.score_bands;
        let width = bins.len().div_ceil(bands).max(1);
        for band in (0..bands).map(|n| bins.start + n * width..(bins.start + (n + 1) * width).min(bins.end)) {
            let score = |slope: &Slope| -> f64 {
                let of = |k: usize| {
                    let residual = x[k] - d[k];
                    let of_mean = slope.mean.get(k).map_or(0.0, |mean| -2.0 * (residual.conj() * mean).re / s[k]);
                    let of_log = slope.log_variance.get(k).map_or(0.0, |log| (1.0 - residual.norm_sqr() / s[k]) * log);
                    of_mean + of_log
                };
                band.clone().map(of).sum()
            };
            self.scores.push(slopes.iter().map(score).collect());
        }
        for (a, slope) in slopes.iter().enumerate() {
            for (b, other) in slopes[..=a].iter().enumerate() {
                let mut sum = 0.0;
                if !slope.mean.is_empty() && !other.mean.is_empty() {
                    sum += bins.clone().map(|k| 2.0 * (slope.mean[k].conj() * other.mean[k]).re / s[k]).sum::<f64>();
                }
                if !slope.log_variance.is_empty() && !other.log_variance.is_empty() {
                    sum += bins.clone().map(|k| slope.log_variance[k] * other.log_variance[k]).sum::<f64>();
                }
                self.information[(a, b)] += sum;
                if a != b {
                    self.information[(b, a)] += sum;
                }
            }
        }
    }
}
