//! Data of a fit, and points in the space of its unknowns.

use std::sync::Arc;

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use rayon::prelude::*;

use super::colour::{
    COLOURS, Colour, ColouredNoise, KNOTS, OwnColour, colour_covariance, colour_with, hats, own_colour_covariance,
};
use super::likelihood::{Channel, Expected, Jitter, jitters, spacing_shares};
use super::observation::Observation;
use super::prediction::Prediction;
use super::settings::{FORMS, LikelihoodSettings};
use super::sidebands::{Shares, Sidebands, numbers};
use super::stretch::{Range, Stretch, best_stretch};
use super::unevenness::UnevenMachines;
use crate::identify::likelihood::observed::CHANNELS;
use crate::signal::kinematics::Orders;

const LIKELIHOOD: LikelihoodSettings = LikelihoodSettings::DEFAULT;
/// Levels of a sensor's noise to either side that are tried, half a standard deviation apart.
const NOISE_LEVELS: i32 = 8;

/// Recordings with what a fit needs of them.
pub struct Data<'a> {
    /// Recordings.
    pub observations: &'a [Observation],
    /// Orders of the bearing.
    pub orders: Orders,
    /// Lines of uneven machines; empty where they are not known.
    pub unevenness: UnevenMachines,
    /// Inverse covariance of each colour before any recording.
    pub colour_precision: [Mat<f64>; COLOURS],
    /// Inverse covariance of what a recording's colour has of its own, before any recording.
    pub own_colour_precision: Mat<f64>,
    hats: Vec<Vec<(usize, f64)>>,
    /// What jitter takes from the lines, of each recording and jitter of the settings.
    jitter: Vec<Vec<Vec<Jitter>>>,
    /// Shares that uneven balls take.
    spacing: Vec<Vec<Vec<f64>>>,
    /// Number of the order of the cage from the nearest line, of each bin of each recording.
    cage_orders: Vec<Vec<usize>>,
}

impl<'a> Data<'a> {
    /// Data of recordings.
    pub fn new(observations: &'a [Observation], orders: Orders, unevenness: UnevenMachines) -> Self {
        let covariance = Mat::from_fn(KNOTS, KNOTS, colour_covariance);
        let precision = covariance.partial_piv_lu().inverse();
        let colour_precision =
            LIKELIHOOD.colour_std.map(|std| Mat::from_fn(KNOTS, KNOTS, |a, b| precision[(a, b)] / (std * std)));
        let jitter = |o: &Observation| LIKELIHOOD.jitter_s.iter().map(|s| jitters(o, *s)).collect();
        let spacing =
            |o: &Observation| LIKELIHOOD.spacing_rad.iter().map(|rad| spacing_shares(o, *rad, orders.ftf)).collect();
        Self {
            observations,
            orders,
            unevenness,
            colour_precision,
            own_colour_precision: Mat::from_fn(KNOTS, KNOTS, own_colour_covariance).partial_piv_lu().inverse(),
            hats: observations.iter().map(hats).collect(),
            jitter: observations.par_iter().map(jitter).collect(),
            spacing: observations.par_iter().map(spacing).collect(),
            cage_orders: observations.iter().map(|o| numbers(o, &orders)).collect(),
        }
    }

    /// Spectrum of a channel at a point.
    pub fn channel<'p>(&'p self, point: &'p Point, recording: usize, channel: usize) -> Channel<'p> {
        Channel {
            observation: &self.observations[recording],
            prediction: &point.predictions[recording],
            hats: &self.hats[recording],
            coloured: &point.coloured[recording],
            stretch: point.stretch[recording],
            jitter: &self.jitter[recording][point.jitter[recording]],
            spacing: &self.spacing[recording][point.spacing],
            cage_orders: &self.cage_orders[recording],
            sidebands: &point.sidebands,
            form: std::array::from_fn(|f| (LIKELIHOOD.form_m[f][point.form[f]] / LIKELIHOOD.drawn_form_m[f]).powi(2)),
            channel,
        }
    }

    /// Noise of each recording at a point in its colour; as the point has it already where that is the same.
    pub fn coloured(&self, point: &Point) -> Vec<ColouredNoise> {
        let each = point.predictions.par_iter().zip(&self.hats).enumerate();
        each.map(|(n, (p, hats))| ColouredNoise::new(point.coloured.get(n), p, &point.colour_in(n), hats)).collect()
    }

    /// −ln L of each recording.
    pub fn neg_log_likelihoods(&self, point: &Point) -> Vec<f64> {
        let of = |n: usize| (0..2).map(|c| self.channel(point, n, c).neg_log_likelihood()).sum();
        (0..self.observations.len()).into_par_iter().map(of).collect()
    }

    /// Weights of the orders of the cage nearer to those that the recordings show.
    pub fn sidebands_towards(&self, point: &Point) -> Sidebands {
        let mut shares: Shares = vec![[0.0; 2]; self.orders.balls() / 2];
        let of = |piece: usize| {
            let channel = self.channel(point, piece / 2, piece % 2);
            let of_bin = |expected: Expected| {
                let (order, part) = channel.sideband(expected.k)?;
                let (share, ratio) = (part / expected.mean(), expected.power / expected.mean());
                Some((order, [share * ratio.min(LIKELIHOOD.most_sideband_ratio), share]))
            };
            channel.bins().filter_map(of_bin).collect::<Vec<_>>()
        };
        let pieces: Vec<_> = (0..2 * self.observations.len()).into_par_iter().map(of).collect();
        for (order, share) in pieces.into_iter().flatten() {
            shares[order - 1].iter_mut().zip(share).for_each(|(sum, share)| *sum += share);
        }
        point.sidebands.towards(&shares)
    }

    /// Gain of a point's errors of form over none.
    pub fn form_gain(&self, point: &Point) -> f64 {
        let without = Point { form: [0; FORMS], ..point.clone() };
        let each = self.neg_log_likelihoods(&without).into_iter().zip(&point.neg_logs);
        each.map(|(without, with)| without - with).sum::<f64>().max(0.0)
    }

    /// Stretch of each recording that fits a point best, within `reach` of that of `around`.
    pub fn stretches(&self, point: &Point, around: &[Stretch], reach: f64) -> Vec<Stretch> {
        let of = |n: usize| {
            let o = &self.observations[n];
            let range = Range { around: around[n].outer, reach };
            let (outer, _) = self.outer_stretch(point, n, range, |outer| Stretch::outer_prior(o, outer));
            let Some(lines) = &point.predictions[n].inner else { return Stretch { outer, inner: outer } };
            let background = [0, 1].map(|c| {
                let mut channel = self.channel(point, n, c);
                channel.stretch.outer = outer;
                (0..o.bins().end).map(|k| channel.noise(k) + channel.outer_line(k)).collect()
            });
            let prior = |inner: f64| Stretch { outer, inner }.prior(o, self.orders.ftf);
            let range = Range { around: around[n].inner, reach };
            let (inner, _) = best_stretch(o, &lines.power, &background, range, prior);
            Stretch { outer, inner }
        };
        (0..self.observations.len()).into_par_iter().map(of).collect()
    }

    /// Stretch of the lines without effects of the inner race that fits a recording best, and its gain over no lines at all.
    pub fn outer_stretch(
        &self,
        point: &Point,
        recording: usize,
        range: Range,
        prior: impl Fn(f64) -> f64,
    ) -> (f64, f64) {
        let o = &self.observations[recording];
        let noise = |c: usize| {
            let channel = self.channel(point, recording, c);
            (0..o.bins().end).map(|k| channel.noise(k)).collect()
        };
        best_stretch(o, &point.predictions[recording].outer.power, &[0, 1].map(noise), range, prior)
    }

    /// Where the noise differs most from the rig's by its colours.
    pub fn greatest_colour(&self, point: &Point) -> Option<GreatestColour> {
        let of = |n: usize| {
            let (o, prediction) = (&self.observations[n], &point.predictions[n]);
            (0..CHANNELS.len()).filter(|c| o.power[*c].is_some()).flat_map(move |c| {
                let channel = self.channel(point, n, c);
                o.bins().map(move |k| GreatestColour {
                    recording: n,
                    channel: c,
                    frequency_hz: o.hz(k as f64),
                    power_np: (channel.noise(k) / prediction.noise[c][k]).ln(),
                })
            })
        };
        let all = (0..self.observations.len()).flat_map(of);
        all.max_by(|a, b| a.power_np.abs().total_cmp(&b.power_np.abs()))
    }

    /// Gain of each channel at a point by another level of its sensor's noise in place of the colour's level: what a wrong gain of a
    /// sensor must exceed.
    pub fn noise_level_gains(&self, point: &Point) -> [f64; 2] {
        let cost = |c: usize, level: f64| {
            let of = |n: usize| {
                let channel = self.channel(point, n, c);
                let bin = |expected: Expected| {
                    let share = channel.process_share(expected.k);
                    let noise = expected.noise * (share * (-level).exp() + 1.0 - share);
                    channel.bin(&Expected { noise, ..expected }).neg_log
                };
                channel.bins().map(bin).sum::<f64>()
            };
            let mut colour = point.colour;
            colour[c].iter_mut().for_each(|knot| *knot -= level);
            (0..self.observations.len()).into_par_iter().map(of).sum::<f64>()
                + self.colour_prior(&colour)
                + 0.5 * (level / LIKELIHOOD.noise_level_np).powi(2)
        };
        [0, 1].map(|c| {
            let levels = (-NOISE_LEVELS..=NOISE_LEVELS).map(|n| 0.5 * f64::from(n) * LIKELIHOOD.noise_level_np);
            cost(c, 0.0) - levels.map(|level| cost(c, level)).fold(f64::INFINITY, f64::min)
        })
    }

    /// −ln of the prior of a point's stretches.
    pub fn stretch_prior(&self, point: &Point) -> f64 {
        let each = self.observations.iter().zip(&point.stretch).zip(point.predictions.iter());
        each.map(|((o, stretch), prediction)| match prediction.inner {
            Some(_) => stretch.prior(o, self.orders.ftf),
            None => Stretch::outer_prior(o, stretch.outer),
        })
        .sum()
    }

    /// −ln of the colour's prior.
    fn colour_prior(&self, colour: &Colour) -> f64 {
        colour.iter().zip(&self.colour_precision).map(|(colour, precision)| neg_log_prior(colour, precision)).sum()
    }

    /// −ln of the prior of all of a point's colours.
    pub fn colours_prior(&self, point: &Point) -> f64 {
        self.colour_prior(&point.colour) + self.own_colour_prior(&point.own_colour)
    }

    /// −ln of the prior of what the recordings' colours have of their own.
    fn own_colour_prior(&self, own: &[OwnColour]) -> f64 {
        own.iter().flatten().map(|colour| neg_log_prior(colour, &self.own_colour_precision)).sum()
    }
}

/// −ln of a normal prior around 0.
fn neg_log_prior(colour: &[f64; KNOTS], precision: &Mat<f64>) -> f64 {
    let pairs = (0..KNOTS).flat_map(|a| (0..KNOTS).map(move |b| (a, b)));
    pairs.map(|(a, b)| 0.5 * colour[a] * precision[(a, b)] * colour[b]).sum()
}

/// Values of all unknowns with the predictions there.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// One for each coordinate.
    pub values: Vec<f64>,
    /// Colour of the noise.
    pub colour: Colour,
    /// What the colour of each recording has of its own.
    pub own_colour: Vec<OwnColour>,
    /// Stretch of the lines of each recording.
    pub stretch: Vec<Stretch>,
    /// Index of the time jitter of each recording in the settings.
    pub jitter: Vec<usize>,
    /// Index of the unevenness of the balls in the settings.
    pub spacing: usize,
    /// Weights of the orders of the cage beside a line.
    pub sidebands: Sidebands,
    /// Index of each error of form in the settings.
    pub form: [usize; FORMS],
    /// Predictions of each recording.
    pub predictions: Arc<Vec<Prediction>>,
    /// Noise of each recording in that colour.
    pub coloured: Vec<ColouredNoise>,
    /// −ln L of each recording.
    pub neg_logs: Vec<f64>,
    /// −ln of the prior.
    pub prior: f64,
}

/// Where the noise differs most from the rig's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreatestColour {
    /// Index of the recording.
    pub recording: usize,
    /// Index of the channel.
    pub channel: usize,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Power over the rig's, Np.
    pub power_np: f64,
}

impl Point {
    /// The same machine in so many other recordings, all with a jitter of that index, at stated speeds and without colours of their own.
    pub fn in_recordings(self, count: usize, jitter: usize) -> Self {
        Self {
            own_colour: vec![OwnColour::default(); count],
            stretch: vec![Stretch::default(); count],
            jitter: vec![jitter; count],
            ..self
        }
    }

    /// The same machine with the rotation of an even one.
    pub fn evenly(mut self) -> Self {
        self.jitter.fill(LIKELIHOOD.usual[0][0]);
        self
    }

    /// Colour of the noise of a recording: that of all, and what it has of its own.
    pub fn colour_in(&self, recording: usize) -> Colour {
        colour_with(&self.colour, &self.own_colour[recording])
    }

    /// −ln of likelihood and prior.
    pub fn objective(&self) -> f64 {
        self.neg_logs.iter().sum::<f64>() + self.prior
    }
}
