//! Location of the largest residual in time, frequency and state.

use super::{
    finding::Where,
    table::{Table, TermModel},
};
use crate::identify::force_balance::states::States;

/// Count of stretches of each recording.
const STRETCHES: usize = 20;
/// Ratio to the mean above which a stretch is named.
const LOUD: f64 = 2.0;

/// Location of a model's residual in the recordings under test.
pub fn locate(table: &Table, model: &TermModel, states: &States) -> Where {
    let left = table.residual(model);
    let rows: Vec<(f64, usize, usize)> = left
        .iter()
        .zip(&table.places)
        .filter(|(_, (track, _))| *track < states.tracks.len())
        .map(|(r, (track, row))| (r * r, *track, states.tracks[*track].rows[*row]))
        .collect();
    let mean = rows.iter().map(|(r, ..)| r).sum::<f64>() / rows.len().max(1) as f64;
    let mut time_s = Vec::new();
    for (index, track) in states.tracks.iter().enumerate() {
        let at = |stretch: usize| stretch as f64 * track.len() as f64 / STRETCHES as f64;
        for stretch in 0..STRETCHES {
            let inside = rows
                .iter()
                .filter(|(_, t, k)| *t == index && (*k as f64) >= at(stretch) && (*k as f64) < at(stretch + 1));
            let (sum, count) = inside.fold((0.0, 0.0), |(s, c), (r, ..)| (s + r, c + 1.0));
            if count > 3.0 && sum / count > LOUD * mean {
                let span = [at(stretch) * states.step_s(), at(stretch + 1) * states.step_s()];
                time_s.push((track.name.clone(), span));
            }
        }
    }
    Where { time_s, frequency_hz: band(table, &left, states), state: state(&rows, mean, states) }
}

/// Region of the states, by |q|, |q̇| or the sign of q, with the largest residual.
fn state(rows: &[(f64, usize, usize)], mean: f64, states: &States) -> String {
    let (largest_q, largest_v) = states.amplitudes();
    type Region = (&'static str, fn(f64, f64) -> bool);
    let regions: [Region; 6] = [
        ("|q| beyond half its range", |q, _| q.abs() > 0.5),
        ("|q| within a fifth of its range", |q, _| q.abs() < 0.2),
        ("|q̇| beyond half its range", |_, v| v.abs() > 0.5),
        ("|q̇| within a tenth of its range, where the motion turns", |_, v| v.abs() < 0.1),
        ("q > 0", |q, _| q > 0.0),
        ("q < 0", |q, _| q < 0.0),
    ];
    let ratio = |region: &Region| {
        let inside = rows.iter().filter(|(_, t, k)| {
            let track = &states.tracks[*t];
            region.1(track.position[*k] / largest_q, track.velocity[*k] / largest_v)
        });
        let (sum, count) = inside.fold((0.0, 0.0), |(s, c), (r, ..)| (s + r, c + 1.0));
        if count > 20.0 { sum / count / mean } else { 0.0 }
    };
    let best = regions.iter().map(|r| (ratio(r), r.0)).max_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((ratio, name)) if ratio > 1.2 => format!("{name}: {ratio:.1} times the mean square residual"),
        _ => "uniform over positions and velocities".into(),
    }
}

/// Band with the middle 80 % of the residual power, Hz.
fn band(table: &Table, left: &[f64], states: &States) -> [f64; 2] {
    let rate = states.sample_rate_hz / states.stride as f64;
    let segments: Vec<&[f64]> = {
        let mut out = Vec::new();
        let mut start = 0;
        for track in 0..states.tracks.len() {
            let length = table.places[start..].iter().take_while(|(t, _)| *t == track).count();
            out.push(&left[start..start + length]);
            start += length;
        }
        out
    };
    let shortest = segments.iter().map(|s| s.len()).min().unwrap_or(0);
    if shortest < 32 {
        return [0.0, 0.5 * rate];
    }
    let power = crate::identify::force_balance::noise::power(&segments, (shortest / 2 * 2).min(512));
    let total: f64 = power.iter().sum();
    let mut sum = 0.0;
    let mut edges = [0.0, 0.5 * rate];
    for (k, p) in power.iter().enumerate() {
        let hz = 0.5 * rate * k as f64 / (power.len() - 1) as f64;
        if sum < 0.1 * total && sum + p >= 0.1 * total {
            edges[0] = hz;
        }
        if sum < 0.9 * total && sum + p >= 0.9 * total {
            edges[1] = hz;
        }
        sum += p;
    }
    edges
}
