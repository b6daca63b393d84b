//! Combs of modulation lines, and their significance among decoys.
//!
//! The same comb at random orders that are none of this bearing's has, in this very recording, the distribution that the
//! choice of band and slip gives it without a defect, other machines' lines included.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::modulation::Modulation;
use super::pattern::Pattern;
use super::settings::CombSettings;
use crate::signal::kinematics::Geometry;

const SETTINGS: CombSettings = CombSettings::DEFAULT;

/// A comb in its band.
#[derive(Clone, Debug, PartialEq)]
pub struct Comb {
    /// Pattern of lines.
    pub pattern: Pattern,
    /// Index of the band.
    pub band: usize,
    /// Modulation depth: root of the lines' summed squared amplitudes, geometric mean over recordings.
    pub depth: f64,
    /// Sum over lines of ln of power over noise, mean over recordings.
    pub level: f64,
    /// Median level of the decoys.
    pub decoy_level: f64,
    /// p-value of the level among the decoys.
    pub p_value: f64,
    /// Slip of the cage in each recording.
    pub slip: Vec<f64>,
}

/// Depth and level of a comb in each band, with the slip of each recording.
struct Levels {
    depth: Vec<f64>,
    level: Vec<f64>,
    slip: Vec<Vec<f64>>,
}

impl Comb {
    /// Comb of a pattern in the band of its highest level; `recordings` hold one channel. `None` without recordings.
    pub fn find(recordings: &[Modulation], pattern: Pattern, geometry: &Geometry, seed: u64) -> Option<Self> {
        let own = levels(recordings, pattern, geometry, None)?;
        let band = (0..own.level.len()).max_by(|a, b| own.level[*a].total_cmp(&own.level[*b]))?;
        let highest = |decoy: &f64| {
            let found = levels(recordings, pattern, geometry, Some(*decoy));
            found.map_or(0.0, |found| found.level.iter().copied().fold(0.0, f64::max))
        };
        let mut of_decoys: Vec<f64> = decoys(pattern, geometry, seed).par_iter().map(highest).collect();
        of_decoys.sort_by(f64::total_cmp);
        let (decoy_level, p_value) = tail(&of_decoys, own.level[band]);
        Some(Self {
            pattern,
            band,
            depth: own.depth[band],
            level: own.level[band],
            decoy_level,
            p_value,
            slip: own.slip.iter().map(|of| of[band]).collect(),
        })
    }

    /// Depth of the pattern in a band.
    pub fn depth_in(recordings: &[Modulation], pattern: Pattern, geometry: &Geometry, band: usize) -> f64 {
        levels(recordings, pattern, geometry, None).and_then(|found| found.depth.get(band).copied()).unwrap_or_default()
    }
}

/// Median of sorted values, and the probability that one of them exceeds `level`, their upper half being exponential.
fn tail(sorted: &[f64], level: f64) -> (f64, f64) {
    let Some(median) = sorted.get(sorted.len() / 2).copied() else { return (0.0, 1.0) };
    let upper = &sorted[sorted.len() / 2..];
    let scale = upper.iter().map(|v| v - median).sum::<f64>() / upper.len() as f64;
    let p_value = if level > median { 0.5 * (-(level - median) / scale.max(0.25)).exp() } else { 1.0 };
    (median, p_value)
}

/// Orders of no part of the bearing.
fn decoys(pattern: Pattern, geometry: &Geometry, seed: u64) -> Vec<f64> {
    let (mut random, mut found) = (ChaCha8Rng::seed_from_u64(seed), Vec::new());
    let ([low, high], real) = (pattern.decoys(geometry), pattern.clear_of(geometry));
    // A bearing with many lines may leave little room.
    for _ in 0..100 * SETTINGS.decoys {
        let order: f64 = random.random_range(low..high);
        let clear = real.iter().all(|r| (order / r - 1.0).abs() > SETTINGS.decoy_guard);
        if clear && (order - order.round()).abs() > 0.05 && found.len() < SETTINGS.decoys {
            found.push(order);
        }
    }
    found
}

/// Slips to be tried for a resolution of `order_step`.
fn slips(order_step: f64, geometry: &Geometry) -> Vec<f64> {
    let [least, most] = SETTINGS.slip;
    let step = SETTINGS.slip_step * order_step / (2.0 * geometry.balls as f64).max(8.0);
    let count = ((most - least) / step).ceil().max(1.0) as usize;
    (0..=count).map(|k| least + (most - least) * k as f64 / count as f64).collect()
}

fn levels(recordings: &[Modulation], pattern: Pattern, geometry: &Geometry, decoy: Option<f64>) -> Option<Levels> {
    let bands = recordings.first()?.bands.len();
    let mut sum = Levels { depth: vec![0.0; bands], level: vec![0.0; bands], slip: Vec::new() };
    for recording in recordings {
        let all: Vec<(f64, Vec<Option<usize>>)> = slips(recording.order_step, geometry)
            .into_iter()
            .map(|slip| (slip, places(recording.order_step, pattern, geometry, slip, decoy)))
            .collect();
        let mut chosen = Vec::with_capacity(bands);
        for (band, modulated) in recording.bands.iter().enumerate() {
            let mut best = (-1.0, 0.0, 0.0);
            for (slip, places) in &all {
                let (mut level, mut excess) = (0.0, 0.0);
                for at in places.iter().flatten().filter(|at| **at + 1 < modulated.shown) {
                    let (power, floor) = (modulated.power[*at], modulated.floor[*at]);
                    let ratio = power / floor;
                    level += ratio.max(1.0).ln().min(SETTINGS.most_log_ratio);
                    if ratio > SETTINGS.line_ratio {
                        excess += power - floor;
                    }
                }
                if level > best.0 {
                    best = (level, excess, *slip);
                }
            }
            sum.level[band] += best.0 / recordings.len() as f64;
            sum.depth[band] += (best.1 + SETTINGS.least_power).ln() / recordings.len() as f64;
            chosen.push(best.2);
        }
        sum.slip.push(chosen);
    }
    sum.depth.iter_mut().for_each(|d| *d = (0.5 * *d).exp());
    Some(sum)
}

/// Spectral values of a pattern's lines; `None` where the shaft or another family has a line.
fn places(order_step: f64, pattern: Pattern, geometry: &Geometry, slip: f64, decoy: Option<f64>) -> Vec<Option<usize>> {
    let rivals = pattern.rivals(geometry, slip);
    let place = |order: f64| {
        let at = (order / order_step).round();
        let of_shaft = (order - order.round()).abs() < SETTINGS.shaft_guard_bins * order_step;
        let of_rival = rivals.iter().any(|r| (order - r).abs() < SETTINGS.rival_guard_bins * order_step);
        (at >= SETTINGS.first_bin as f64 && !of_shaft && !of_rival).then_some(at as usize)
    };
    pattern.lines(geometry, slip, decoy).into_iter().map(place).collect()
}
