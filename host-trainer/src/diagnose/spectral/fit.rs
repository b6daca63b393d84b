//! Fit of a rig to power spectra: Fisher scoring of its numbers and of the noise's colour, theory (57).

use std::sync::Arc;

use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, Side};
use rayon::prelude::*;

use super::likelihood::{Channel, Colour, KNOTS, Range, best_stretch, bin, colour_covariance, hats};
use super::observation::{Observation, Power};
use super::prediction::{Prediction, lines, noise, skirts, spaced};
use super::settings::{FitSettings, LikelihoodSettings};
use crate::identify::likelihood::coordinate::Coordinate;
use crate::rig::effect::EffectKind;
use crate::rig::random_part::depends_on_velocity_noise;
use crate::rig::state::VelocityCovariance;
use crate::rig::{Rig, RigError};
use crate::signal::kinematics::Orders;

const SETTINGS: FitSettings = FitSettings::DEFAULT;
const LIKELIHOOD: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Recordings with what a fit needs of them.
pub struct Data<'a> {
    /// Recordings.
    pub observations: &'a [Observation],
    /// Orders of the bearing.
    pub orders: Orders,
    hats: Vec<Vec<(usize, f64)>>,
    colour_precision: Mat<f64>,
}

impl<'a> Data<'a> {
    /// Data of recordings.
    pub fn new(observations: &'a [Observation], orders: Orders) -> Self {
        let covariance = Mat::from_fn(KNOTS, KNOTS, colour_covariance);
        let colour_precision = covariance.partial_piv_lu().inverse();
        Self { observations, orders, hats: observations.iter().map(hats).collect(), colour_precision }
    }

    /// Spectrum of a channel at a point.
    pub fn channel<'p>(&'p self, point: &'p Point, recording: usize, channel: usize) -> Channel<'p> {
        Channel {
            observation: &self.observations[recording],
            prediction: &point.predictions[recording],
            hats: &self.hats[recording],
            colour: &point.colour,
            stretch: point.stretch[recording],
            jitter_s: LIKELIHOOD.jitter_s[point.jitter[recording]],
            spacing_rad: LIKELIHOOD.spacing_rad[point.spacing],
            cage_per_shaft: self.orders.ftf,
            channel,
        }
    }

    /// −ln L of each recording.
    fn neg_log_likelihoods(&self, point: &Point) -> Vec<f64> {
        let of = |n: usize| (0..2).map(|c| self.channel(point, n, c).neg_log_likelihood()).sum();
        (0..self.observations.len()).into_par_iter().map(of).collect()
    }

    /// Stretch of each recording that suits a point, within the whole range or near the present one.
    fn stretches(&self, point: &Point, near: bool, reach: f64) -> Vec<f64> {
        let of = |n: usize| {
            let range = if near {
                Range { around: point.stretch[n], reach: 4.0 * LIKELIHOOD.stretch[1], healthy: true }
            } else {
                Range { around: 0.0, reach, healthy: true }
            };
            self.stretch(point, n, range).0
        };
        (0..self.observations.len()).into_par_iter().map(of).collect()
    }

    /// Stretch of a recording that suits a point best, and its gain over no lines at all.
    pub fn stretch(&self, point: &Point, recording: usize, range: Range) -> (f64, f64) {
        let (o, prediction) = (&self.observations[recording], &point.predictions[recording]);
        best_stretch(o, prediction, &self.hats[recording], &point.colour, range)
    }

    fn prior(&self, colour: &Colour) -> f64 {
        let of = |c: &[f64; KNOTS]| {
            let pairs = (0..KNOTS).flat_map(|a| (0..KNOTS).map(move |b| (a, b)));
            pairs.map(|(a, b)| 0.5 * c[a] * self.colour_precision[(a, b)] * c[b]).sum::<f64>()
        };
        colour.iter().map(of).sum()
    }
}

/// Values of all unknowns with the predictions there.
#[derive(Clone, Debug)]
pub struct Point {
    /// One for each coordinate.
    pub values: Vec<f64>,
    /// Colour of the noise.
    pub colour: Colour,
    /// Frequency of the lines over that predicted, less 1, of each recording.
    pub stretch: Vec<f64>,
    /// Index of the time jitter of each recording in the settings.
    pub jitter: Vec<usize>,
    /// Index of the unevenness of the balls in the settings.
    pub spacing: usize,
    /// Predictions of each recording.
    pub predictions: Vec<Prediction>,
    /// −ln L of each recording.
    pub neg_logs: Vec<f64>,
    /// −ln of the prior.
    pub prior: f64,
}

impl Point {
    /// −ln of likelihood and prior.
    pub fn objective(&self) -> f64 {
        self.neg_logs.iter().sum::<f64>() + self.prior
    }
}

/// What is fitted beside the coordinates.
struct Nuisance {
    colour: Colour,
    stretch: Vec<f64>,
    jitter: Vec<usize>,
    spacing: usize,
}

/// Rig whose coordinates are fitted.
#[derive(Clone)]
pub struct Model<'d, 'a> {
    /// Recordings.
    pub data: &'d Data<'a>,
    /// Rig; its values at the coordinates are replaced.
    pub rig: Rig,
    /// Coordinates.
    pub coordinates: Vec<Coordinate>,
    /// Mean of the first coordinates, the unknown ones, before any recording.
    pub guesses: Vec<f64>,
    /// Predictions that are partly those of a nearby rig.
    pub known: Known,
}

/// Part of the predictions that is known from a nearby rig.
#[derive(Clone, Debug, Default)]
pub enum Known {
    /// Nothing.
    #[default]
    Nothing,
    /// Noise, which effects of the deterministic motion leave as it is.
    Noise(Arc<Vec<Prediction>>),
    /// Velocity covariance, on which friction depends; for a first look.
    Scatter(Vec<VelocityCovariance>),
}

impl Model<'_, '_> {
    /// Rig at given values.
    ///
    /// # Errors
    /// A value out of the range of its key.
    pub fn rig_at(&self, values: &[f64]) -> Result<Rig, RigError> {
        let mut rig = self.rig.clone();
        self.coordinates.iter().zip(values).try_for_each(|(c, u)| c.put(&mut rig, *u))?;
        rig.check()?;
        Ok(rig)
    }

    /// Point of the rig's own values; colour and stretch are those of `from`, if there is one.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn start(&self, from: Option<&Point>) -> Result<Point, RigError> {
        let value = |c: &Coordinate| c.to_coordinate(self.rig.get(c.key).unwrap_or_default());
        let values: Vec<f64> = self.coordinates.iter().map(value).collect();
        let count = self.data.observations.len();
        let colour = from.map_or([[0.0; KNOTS]; 2], |p| p.colour);
        let stretch = from.map_or_else(|| vec![0.0; count], |p| p.stretch.clone());
        let jitter = from.map_or_else(|| vec![0; count], |p| p.jitter.clone());
        let spacing = from.map_or(0, |p| p.spacing);
        let mut point = self.at(&values, Nuisance { colour, stretch, jitter, spacing })?;
        self.settle_stretch(&mut point);
        // What the model before took for an imperfect machine may be the effect.
        let usual = if from.is_some() { LIKELIHOOD.usual.as_slice() } else { &[] };
        for [jitter, spacing] in usual {
            let (jitter, spacing) = (vec![*jitter; count], *spacing);
            let mut clean = Point { colour: [[0.0; KNOTS]; 2], jitter, spacing, ..point.clone() };
            self.judge(&mut clean);
            self.settle_stretch(&mut clean);
            if clean.objective() < point.objective() {
                point = clean;
            }
        }
        Ok(point)
    }

    /// Moves the stretch of each recording to where it suits best.
    fn settle_stretch(&self, point: &mut Point) {
        let stretch = self.data.stretches(point, false, self.stretch_reach());
        if stretch != point.stretch {
            point.stretch = stretch;
            self.judge(point);
        }
    }

    /// Range of the stretch: whether the stated speed is that of the start or the mean, nobody says of a speed that drifts.
    fn stretch_reach(&self) -> f64 {
        let drifts = self.rig.effects.iter().any(|e| e.kind == EffectKind::SpeedDrift);
        if drifts { 4.0 * LIKELIHOOD.stretch[0] } else { LIKELIHOOD.stretch[0] }
    }

    fn at(&self, values: &[f64], nuisance: Nuisance) -> Result<Point, RigError> {
        let rig = self.rig_at(values)?;
        let predictions = self.known.predicted(&rig, self.data.observations, &self.data.orders)?;
        let Nuisance { colour, stretch, jitter, spacing } = nuisance;
        let values = values.to_vec();
        let mut point =
            Point { values, colour, stretch, jitter, spacing, predictions, neg_logs: Vec::new(), prior: 0.0 };
        self.judge(&mut point);
        Ok(point)
    }

    fn judge(&self, point: &mut Point) {
        point.neg_logs = self.data.neg_log_likelihoods(point);
        let stretch = |s: &f64| 0.5 * ((s - LIKELIHOOD.stretch_mean) / LIKELIHOOD.stretch_std).powi(2);
        let jitter = |j: &usize| {
            let [usual, scatter] = LIKELIHOOD.usual_jitter;
            0.5 * ((LIKELIHOOD.jitter_s[*j].max(LIKELIHOOD.jitter_s[1] / 2.0) / usual).ln() / scatter).powi(2)
        };
        let unknown =
            self.guesses.iter().zip(&point.values).map(|(g, u)| 0.5 * ((u - g) / SETTINGS.unknown_std).powi(2));
        point.prior = self.data.prior(&point.colour)
            + point.stretch.iter().map(stretch).sum::<f64>()
            + point.jitter.iter().map(jitter).sum::<f64>()
            + unknown.sum::<f64>();
    }

    /// Searches from a point for at most `steps` steps.
    ///
    /// # Errors
    /// What the simulation refuses at the start.
    pub fn search(&self, from: Point, steps: usize) -> Result<Point, RigError> {
        let mut point = from;
        let (mut damping, first) = (1e-3, point.objective());
        for _ in 0..steps {
            let expansion = self.expand(&point)?;
            let mut gain = 0.0;
            while damping < 1e6 {
                let Some(step) = expansion.step(damping) else {
                    damping *= 10.0;
                    continue;
                };
                let next = self.stepped(&point, &step);
                match next.filter(|next| next.objective() < point.objective()) {
                    Some(mut next) => {
                        let stretch = self.data.stretches(&next, true, 0.0);
                        if stretch != next.stretch {
                            let mut moved = Point { stretch, ..next.clone() };
                            self.judge(&mut moved);
                            if moved.objective() < next.objective() {
                                next = moved;
                            }
                        }
                        self.settle_jitter(&mut next);
                        gain = point.objective() - next.objective();
                        point = next;
                        damping = (damping * 0.2).max(1e-6);
                        break;
                    }
                    None => damping = (damping * 8.0).max(1e-2),
                }
            }
            if gain < SETTINGS.converged + SETTINGS.converged_share * (first - point.objective()) {
                break;
            }
        }
        Ok(point)
    }

    /// Moves the jitter of each recording to where it suits better, a step up or down.
    fn settle_jitter(&self, point: &mut Point) {
        let last = LIKELIHOOD.jitter_s.len() - 1;
        let now = point.clone();
        let moved: Vec<Point> = [-1i64, 1]
            .into_iter()
            .map(|by| {
                let jitter = now.jitter.iter().map(|j| (*j as i64 + by).clamp(0, last as i64) as usize).collect();
                let mut moved = Point { jitter, ..now.clone() };
                moved.neg_logs = self.data.neg_log_likelihoods(&moved);
                moved
            })
            .collect();
        for n in 0..now.jitter.len() {
            let best = moved.iter().min_by(|a, b| a.neg_logs[n].total_cmp(&b.neg_logs[n]));
            if let Some(best) = best.filter(|best| best.neg_logs[n] < now.neg_logs[n] - 0.5) {
                point.jitter[n] = best.jitter[n];
            }
        }
        if point.jitter != now.jitter {
            self.judge(point);
        }
        for by in [-1i64, 1] {
            let spacing = (point.spacing as i64 + by).clamp(0, LIKELIHOOD.spacing_rad.len() as i64 - 1) as usize;
            let mut moved = Point { spacing, ..point.clone() };
            self.judge(&mut moved);
            if moved.objective() < point.objective() - 0.5 {
                *point = moved;
            }
        }
    }

    fn stepped(&self, point: &Point, step: &[f64]) -> Option<Point> {
        let count = self.coordinates.len();
        let greatest = step[..count].iter().fold(0.0f64, |m, s| m.max(s.abs()));
        let scale = if greatest > SETTINGS.max_step { SETTINGS.max_step / greatest } else { 1.0 };
        let values: Vec<f64> = point.values.iter().zip(step).map(|(u, s)| u + scale * s).collect();
        let mut colour = point.colour;
        colour.iter_mut().flatten().zip(&step[count..]).for_each(|(c, s)| *c += scale * s);
        if count == 0 {
            let mut next = Point { colour, ..point.clone() };
            self.judge(&mut next);
            return Some(next);
        }
        let (stretch, jitter) = (point.stretch.clone(), point.jitter.clone());
        self.at(&values, Nuisance { colour, stretch, jitter, spacing: point.spacing }).ok()
    }

    /// Gradient and information at a point: coordinates first, then the colour of both channels.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn expand(&self, point: &Point) -> Result<Expansion, RigError> {
        let columns = self.columns(point)?;
        let count = self.coordinates.len();
        let all = count + 2 * KNOTS;
        let pieces: Vec<Expansion> = (0..2 * self.data.observations.len())
            .into_par_iter()
            .map(|piece| {
                let (recording, c) = (piece / 2, piece % 2);
                let mut out = Expansion::new(all);
                let at = self.data.channel(point, recording, c);
                let mut slopes = vec![0.0; count];
                for (k, power, noise, line) in at.bins() {
                    let found = bin(power, noise, line);
                    let mean = noise + line;
                    let coloured = noise / at.prediction.noise[c][k];
                    let unstretched =
                        ((k as f64 / (1.0 + at.stretch)).round() as usize).min(at.prediction.lines[c].len() - 1);
                    for (slope, column) in slopes.iter_mut().zip(&columns) {
                        let [of_noise, of_line] = &column[recording];
                        let by_noise = of_noise[c].get(k).map_or(0.0, |d| d * coloured);
                        let by_line = of_line[c].get(unstretched).copied().unwrap_or_default();
                        // The line's slope; that of its skirts is the same share of them.
                        let by_line = if line > 0.0 && by_line != 0.0 {
                            by_line * line / at.prediction.lines[c][unstretched].max(1e-300)
                        } else {
                            0.0
                        };
                        *slope = (by_noise + by_line) / mean;
                    }
                    let (knot, share) = at.hats[k];
                    let of_colour = noise / mean;
                    let hats = [
                        (count + c * KNOTS + knot, of_colour * (1.0 - share)),
                        (count + c * KNOTS + knot + 1, of_colour * share),
                    ];
                    for (a, slope) in slopes.iter().enumerate() {
                        out.gradient[a] += found.slope * slope;
                        for (b, other) in slopes[..=a].iter().enumerate() {
                            out.information[(a, b)] += found.information * slope * other;
                        }
                        for (b, other) in hats {
                            out.information[(b, a)] += found.information * slope * other;
                        }
                    }
                    for (a, slope) in hats {
                        out.gradient[a] += found.slope * slope;
                        for (b, other) in hats {
                            if b <= a {
                                out.information[(a, b)] += found.information * slope * other;
                            }
                        }
                    }
                }
                out
            })
            .collect();
        let mut out = Expansion::new(all);
        for piece in &pieces {
            out.gradient.iter_mut().zip(&piece.gradient).for_each(|(sum, g)| *sum += g);
            out.information += &piece.information;
        }
        for a in 0..all {
            for b in 0..a {
                out.information[(b, a)] = out.information[(a, b)];
            }
        }
        for channel in 0..2 {
            let from = count + channel * KNOTS;
            for a in 0..KNOTS {
                for b in 0..KNOTS {
                    let precision = self.data.colour_precision[(a, b)];
                    out.information[(from + a, from + b)] += precision;
                    out.gradient[from + a] += precision * point.colour[channel][b];
                }
            }
        }
        for (a, guess) in self.guesses.iter().enumerate() {
            let precision = SETTINGS.unknown_std.powi(-2);
            out.information[(a, a)] += precision;
            out.gradient[a] += precision * (point.values[a] - guess);
        }
        out.pieces = pieces.into_iter().map(|piece| piece.gradient).collect();
        Ok(out)
    }

    /// Derivatives of noise and lines by each coordinate, of each recording.
    fn columns(&self, point: &Point) -> Result<Vec<Vec<[Power; 2]>>, RigError> {
        let observations = self.data.observations;
        let scatter: Vec<_> = point.predictions.iter().map(|p| p.scatter).collect();
        let column = |(a, coordinate): (usize, &Coordinate)| -> Result<Vec<[Power; 2]>, RigError> {
            let mut values = point.values.clone();
            let step = 1e-3;
            values[a] += step;
            let rig = self.rig_at(&values)?;
            let noise = if coordinate.moves_variance && !matches!(self.known, Known::Noise(_)) {
                Some(self::noise(&lasting(&rig), observations, Some(&scatter))?)
            } else {
                None
            };
            let base = if coordinate.moves_variance && depends_on_velocity_noise(&rig) {
                Some(self::noise(&lasting(&self.rig_at(&point.values)?), observations, Some(&scatter))?)
            } else {
                None
            };
            let lines = if coordinate.moves_mean { Some(lines(&rig, observations, &scatter)?) } else { None };
            let quotient = |moved: Option<&Power>, still: &Power| -> Power {
                [0, 1].map(|c| {
                    moved.map_or_else(Vec::new, |m| m[c].iter().zip(&still[c]).map(|(m, s)| (m - s) / step).collect())
                })
            };
            let of = |n: usize| {
                let now = &point.predictions[n];
                let still = base.as_ref().map_or(&now.noise, |base| &base[n].0);
                [
                    quotient(noise.as_ref().map(|all| &all[n].0), still),
                    quotient(lines.as_ref().map(|all| &all[n]), &now.lines),
                ]
            };
            Ok((0..observations.len()).map(of).collect())
        };
        self.coordinates.par_iter().enumerate().map(column).collect()
    }
}

impl Known {
    /// Predictions of a rig.
    fn predicted(&self, rig: &Rig, observations: &[Observation], orders: &Orders) -> Result<Vec<Prediction>, RigError> {
        let noise = match self {
            Self::Noise(known) => known.iter().map(|p| (p.noise.clone(), p.scatter)).collect(),
            Self::Scatter(known) => noise(&lasting(rig), observations, Some(known))?,
            Self::Nothing => noise(&lasting(rig), observations, None)?,
        };
        let scatter: Vec<_> = noise.iter().map(|(_, scatter)| *scatter).collect();
        let lines = lines(rig, observations, &scatter)?;
        let inner = [EffectKind::InnerRaceDefect, EffectKind::InnerRaceWaviness];
        let on_cage_orders = !rig.effects.iter().any(|effect| inner.contains(&effect.kind));
        let all = noise.into_iter().zip(lines).zip(observations);
        Ok(all
            .map(|(((noise, scatter), lines), o)| Prediction {
                skirts: skirts(&lines, o),
                spaced: spaced(&lines, o, orders, on_cage_orders),
                noise,
                lines,
                scatter,
            })
            .collect())
    }
}

/// Rig without the effects that leave its noise as it is.
fn lasting(rig: &Rig) -> Rig {
    let mut rig = rig.clone();
    rig.effects.retain(|effect| !effect.definition().is_deterministic);
    rig
}

/// Likelihood and prior around a point.
#[derive(Clone, Debug)]
pub struct Expansion {
    /// Gradient of −ln.
    pub gradient: Vec<f64>,
    /// Expected information.
    pub information: Mat<f64>,
    /// Gradient of each channel of each recording, without the prior.
    pub pieces: Vec<Vec<f64>>,
}

impl Expansion {
    fn new(count: usize) -> Self {
        Self { gradient: vec![0.0; count], information: Mat::zeros(count, count), pieces: Vec::new() }
    }

    fn step(&self, damping: f64) -> Option<Vec<f64>> {
        let count = self.gradient.len();
        let system = Mat::from_fn(count, count, |a, b| {
            let own = self.information[(a, b)];
            if a == b { own * (1.0 + damping) + 1e-9 } else { own }
        });
        let right = Mat::from_fn(count, 1, |a, _| -self.gradient[a]);
        let step = system.llt(Side::Lower).ok()?.solve(&right);
        let step: Vec<f64> = (0..count).map(|a| step[(a, 0)]).collect();
        step.iter().all(|s| s.is_finite()).then_some(step)
    }
}
