//! Gradient and expected information of likelihood and prior around a point.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::colour::{COLOURS, KNOTS, PROCESS};
use super::data::Point;
use super::fit::Model;
use super::likelihood::Channel;
use super::observation::Power;
use super::prediction::{Deterministic, Known, Part, is_inner, lines_of, noises_of};
use super::settings::FitSettings;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::rig::config::RigKey;
use crate::rig::random_part::depends_on_velocity_noise;
use crate::rig::{Rig, RigError};

const SETTINGS: FitSettings = FitSettings::DEFAULT;
/// Share of a line with its skirts from which its power in a bin determines their derivative.
const LEAST_SHARE: f64 = 0.05;

/// Derivatives of the noise and the lines of a recording by a coordinate; empty where it moves nothing.
struct Derivative {
    noise: Power,
    outer: Power,
    inner: Power,
}

/// Gradient and information of likelihood and prior: coordinates first, then the colours of all recordings, then what each
/// recording's have of their own.
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
    /// Expansion of a fit at a point.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn new(model: &Model, point: &Point) -> Result<Self, RigError> {
        let columns = columns(model, point)?;
        let of = |piece: usize| {
            let (recording, channel) = (piece / 2, piece % 2);
            let columns: Vec<&Derivative> = columns.iter().map(|column| &column[recording]).collect();
            Self::of_channel(&model.data.channel(point, recording, channel), &columns)
        };
        let pieces: Vec<Self> = (0..2 * model.data.observations.len()).into_par_iter().map(of).collect();
        let shared = model.coordinates.len() + COLOURS * KNOTS;
        let mut out = Self::zeros(shared + pieces.len() * KNOTS);
        for (n, piece) in pieces.into_iter().enumerate() {
            // What a recording's colour has of its own moves its channel as the colour of all does.
            let colour = model.coordinates.len() + n % 2 * KNOTS;
            let of_own = (0..KNOTS).map(|knot| (colour + knot, shared + n * KNOTS + knot));
            let places: Vec<(usize, usize)> = (0..shared).map(|a| (a, a)).chain(of_own).collect();
            let mut gradient = vec![0.0; out.gradient.len()];
            for (from, to) in &places {
                gradient[*to] = piece.gradient[*from];
                out.gradient[*to] += piece.gradient[*from];
                for (other_from, other_to) in places.iter().take_while(|(_, other)| other <= to) {
                    let [a, b] = [*from.max(other_from), *from.min(other_from)];
                    out.information[(*to, *other_to)] += piece.information[(a, b)];
                }
            }
            out.pieces.push(gradient);
        }
        out.complete();
        out.add_prior(model, point);
        Ok(out)
    }

    fn zeros(count: usize) -> Self {
        Self { gradient: vec![0.0; count], information: Mat::zeros(count, count), pieces: Vec::new() }
    }

    /// Likelihood of a channel of a recording, without its own colour; of the information only the lower triangle.
    fn of_channel(at: &Channel, columns: &[&Derivative]) -> Self {
        let count = columns.len();
        let mut out = Self::zeros(count + COLOURS * KNOTS);
        let mut slopes = vec![0.0; count];
        for expected in at.bins() {
            let (k, noise, mean) = (expected.k, expected.noise, expected.mean());
            let density = at.bin(&expected);
            for (slope, column) in slopes.iter_mut().zip(columns) {
                *slope = column.moves(at, k, noise) / mean;
            }
            let (knot, share) = at.hats[k];
            let of_colour = |colour: usize, slope: f64| {
                let knot = count + colour * KNOTS + knot;
                [(knot, slope * (1.0 - share)), (knot + 1, slope * share)]
            };
            let slope = noise / mean;
            let [own, process] = [of_colour(at.channel, slope), of_colour(PROCESS, slope * at.process_share(k))];
            let hats = [own[0], own[1], process[0], process[1]];
            for (a, slope) in slopes.iter().copied().enumerate().chain(hats) {
                out.gradient[a] += density.slope * slope;
                for (b, other) in slopes.iter().copied().enumerate().chain(hats).take_while(|(b, _)| *b <= a) {
                    out.information[(a, b)] += density.information * slope * other;
                }
            }
        }
        out
    }

    /// Copies the lower triangle to the upper one.
    fn complete(&mut self) {
        for a in 0..self.gradient.len() {
            for b in 0..a {
                self.information[(b, a)] = self.information[(a, b)];
            }
        }
    }

    fn add_prior(&mut self, model: &Model, point: &Point) {
        let all = point.colour.iter().zip(&model.data.colour_precision);
        let own = point.own_colour.iter().flatten().map(|colour| (colour, &model.data.own_colour_precision));
        for (n, (colour, precision)) in all.chain(own).enumerate() {
            let from = model.coordinates.len() + n * KNOTS;
            for a in 0..KNOTS {
                for (b, knot) in colour.iter().enumerate() {
                    let precision = precision[(a, b)];
                    self.information[(from + a, from + b)] += precision;
                    self.gradient[from + a] += precision * knot;
                }
            }
        }
        for (a, guess) in model.guesses.iter().enumerate() {
            let precision = SETTINGS.unknown_std.powi(-2);
            self.information[(a, a)] += precision;
            self.gradient[a] += precision * (point.values[a] - guess);
        }
    }

    /// Step at a damping; `None` if the system cannot be solved.
    pub fn step(&self, damping: f64) -> Option<Vec<f64>> {
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

impl Derivative {
    /// Derivative of a bin's mean, of which `noise` is coloured noise.
    fn moves(&self, at: &Channel, k: usize, noise: f64) -> f64 {
        let (predicted, channel) = (at.prediction, at.channel);
        let by_noise = self.noise[channel].get(k).map_or(0.0, |d| d * noise / predicted.noise[channel][k]);
        // The derivative of a line's skirts is the same share of them; far from a line its own share is rounding.
        let by_lines = |slopes: &[f64], lines: &[f64], stretch: f64, line: &dyn Fn() -> f64| {
            let unstretched = ((k as f64 / (1.0 + stretch)).round() as usize).min(lines.len() - 1);
            match slopes.get(unstretched) {
                Some(slope) if *slope != 0.0 => {
                    let line = line();
                    slope * line / lines[unstretched].max(LEAST_SHARE * line).max(f64::MIN_POSITIVE)
                }
                _ => 0.0,
            }
        };
        let outer = &predicted.outer.power[channel];
        let by_outer = by_lines(&self.outer[channel], outer, at.stretch.outer, &|| at.rig_line(k));
        let by_inner = predicted.inner.as_ref().map_or(0.0, |inner| {
            by_lines(&self.inner[channel], &inner.power[channel], at.stretch.inner, &|| at.inner_line(k))
        });
        by_noise + by_outer + by_inner
    }
}

/// Derivatives by each coordinate, of each recording; all moved rigs are simulated side by side.
fn columns(model: &Model, point: &Point) -> Result<Vec<Vec<Derivative>>, RigError> {
    let observations = model.data.observations;
    let step = SETTINGS.difference;
    let moved_rig = |a: usize| {
        let mut values = point.values.clone();
        values[a] += step;
        model.rig_at(&values)
    };
    let rigs = (0..model.coordinates.len()).map(moved_rig).collect::<Result<Vec<Rig>, RigError>>()?;
    let scatter: Vec<_> = point.predictions.iter().map(|p| p.scatter).collect();
    let known = Known::Scatter(scatter.clone());
    let outer: Vec<Power> = point.predictions.iter().map(|p| p.outer.power.clone()).collect();

    let moves_noise = |c: &Coordinate| c.moves_variance && model.known.noise().is_none();
    let each = || model.coordinates.iter().zip(&rigs);
    // Where the noise depends on the velocity covariance, moved and unmoved rig must have the same one.
    let own = each().any(|(c, rig)| c.moves_variance && depends_on_velocity_noise(rig));
    let own = own.then(|| model.rig_at(&point.values)).transpose()?;
    let noisy = own.iter().chain(each().filter(|(c, _)| moves_noise(c)).map(|(_, rig)| rig));
    let mut noises = noises_of(&noisy.map(|rig| (&known, rig)).collect::<Vec<_>>(), observations).into_iter();
    let base = own.and_then(|_| noises.next()).transpose()?;

    // A number of an effect of the inner race moves that part alone.
    let moves_inner =
        |c: &Coordinate, rig: &Rig| matches!(c.key, RigKey::Effect { index, .. } if is_inner(&rig.effects[index]));
    let runs = each().filter(|(c, _)| c.moves_mean).map(|(c, rig)| Deterministic {
        rig,
        scatter: scatter.clone(),
        part: moves_inner(c, rig).then(|| Part::Outer(outer.clone())),
    });
    let mut lines = lines_of(&runs.collect::<Vec<_>>(), observations).into_iter();

    let quotient = |moved: Option<&Power>, still: Option<&Power>| -> Power {
        let both = moved.zip(still);
        [0, 1]
            .map(|c| both.map_or_else(Vec::new, |(m, s)| m[c].iter().zip(&s[c]).map(|(m, s)| (m - s) / step).collect()))
    };
    let mut columns = Vec::with_capacity(rigs.len());
    for (coordinate, rig) in each() {
        let moved_noise = if moves_noise(coordinate) { noises.next().transpose()? } else { None };
        let moved_lines = if coordinate.moves_mean { lines.next().transpose()? } else { None };
        let base = base.as_ref().filter(|_| coordinate.moves_variance && depends_on_velocity_noise(rig));
        let of = |n: usize| {
            let now = &point.predictions[n];
            let still = base.map_or(&now.noise, |base| &base[n].variance);
            let moved = moved_lines.as_ref().map(|all| &all[n]);
            let inner = moved.and_then(|parts| parts.inner.as_ref());
            Derivative {
                noise: quotient(moved_noise.as_ref().map(|all| all[n].variance.as_ref()), Some(still)),
                outer: quotient(moved.map(|parts| &parts.outer), Some(&now.outer.power)),
                inner: quotient(inner, now.inner.as_ref().map(|lines| &lines.power)),
            }
        };
        columns.push((0..observations.len()).map(of).collect());
    }
    Ok(columns)
}
