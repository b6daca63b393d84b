//! Where a mismatch is: in time, frequency, order, angle, state and channel.

use super::outcome::Location;
use super::residual::{Whitened, bands, blocks};
use crate::rig::Rig;
use crate::whittle::observed::{CHANNELS, Observed};

/// Standard deviations from which a band or a block counts.
const STANDS_OUT: f64 = 5.0;
/// Power of a line over the residual's mean that counts, and how many orders are named.
const LINE: f64 = 25.0;
const ORDERS: usize = 6;

/// Where the residual of the rig as it was stands out.
pub fn locate(before: &Rig, corrected: &Rig, observed: &[Observed], residuals: &[Whitened]) -> Location {
    let of = |channel: usize| residuals.iter().filter(|w| w.channel == channel).collect::<Vec<_>>();
    let power = |channel: usize| {
        let of = of(channel);
        of.iter().flat_map(|w| &w.signal).map(|v| v * v - 1.0).sum::<f64>() / of.len().max(1) as f64
    };
    let channel = usize::from(power(1) > power(0));
    let worst = of(channel);
    let standing = |m: f64, n: f64| (m - 1.0) * n.sqrt() > STANDS_OUT;
    let frequency_hz = bands(&worst).into_iter().filter(|(_, m, n)| standing(*m, *n as f64)).map(|(hz, ..)| hz);
    let all = blocks(&worst);
    let usual = median(all.iter().map(|(_, m, _)| *m));
    // Where every block stands out there is no time to it.
    let time_s = all.into_iter().filter(|(_, m, n)| standing(m / usual.max(1.0), 0.5 * *n as f64)).map(|(s, ..)| s);
    let new = corrected.effects.iter().skip(before.effects.len());
    let mut angle_rad = Vec::new();
    let mut states = Vec::new();
    for effect in new {
        if let (Some(angle), Some(width)) = (effect.number("angle_rad"), effect.number("width_rad")) {
            angle_rad.push([angle - 0.5 * width, angle + 0.5 * width]);
        }
        if let Some(component) = effect.text("component") {
            states.push(format!("motion of {component}"));
        }
    }
    Location {
        time_s: joined(time_s.collect()),
        frequency_hz: joined(frequency_hz.collect()),
        order: orders(observed, &worst),
        angle_rad,
        state: states.join(", "),
        channel: CHANNELS[channel].into(),
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(1.0)
}

/// Neighbours as one.
fn joined(intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut out: Vec<[f64; 2]> = Vec::new();
    for [from, to] in intervals {
        match out.last_mut() {
            Some(last) if from <= last[1] * (1.0 + 1e-9) => last[1] = to,
            _ => out.push([from, to]),
        }
    }
    out
}

/// Orders of the shaft at which the residual has its highest lines in the first recording.
fn orders(observed: &[Observed], residuals: &[&Whitened]) -> Vec<f64> {
    let Some(w) = residuals.first() else { return Vec::new() };
    let shaft_hz = observed.get(w.recording).map_or(1.0, |o| o.condition.shaft_hz);
    let step = w.sample_rate_hz / w.signal.len() as f64;
    let mut lines: Vec<(f64, f64)> = Vec::new();
    for k in 2..w.spectrum.len().saturating_sub(2) {
        let here = w.spectrum[k].norm_sqr();
        let around = |j: usize| w.spectrum[j].norm_sqr();
        if here > LINE && here > around(k - 1) && here >= around(k + 1) {
            lines.push((here, k as f64 * step / shaft_hz));
        }
    }
    lines.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut orders: Vec<f64> = lines.into_iter().take(ORDERS).map(|(_, o)| (1e3 * o).round() / 1e3).collect();
    orders.sort_by(f64::total_cmp);
    orders
}
