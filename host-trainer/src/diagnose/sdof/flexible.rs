//! Flexible columns without a name: if they explain more than the best named causes, there is a lack of fit.
//!
//! Powers and products of position and speed, memory (play operators of M. A. Krasnosel'skii and A. V. Pokrovskii,
//! "Systems with Hysteresis", 1989; leaky integrals of the speed, as in viscoelastic supports), and parameters that
//! drift or swing with time.

use std::f64::consts::TAU;

use super::terms::{Library, where_under_test};
use crate::identify::force_balance::states::{States, Track};

/// Widths of the play operators, as shares of the largest position.
const WIDTHS: [f64; 4] = [0.02, 0.08, 0.25, 0.6];
/// Time constants of the leaky integrals, in periods of the band's upper edge.
const MEMORIES: [f64; 3] = [1.0, 4.0, 16.0];
/// Half periods of the swings with time.
const SWINGS: usize = 8;

/// Adds the flexible columns to a library.
pub fn add(states: &States, healthy: &[bool], library: &mut Library) {
    let (largest_q, largest_v) = states.amplitudes();
    let (per_q, per_v) = (1.0 / largest_q.max(f64::MIN_POSITIVE), 1.0 / largest_v.max(f64::MIN_POSITIVE));
    let mut push = |signal: &dyn Fn(&Track) -> Vec<f64>| {
        library.flexible.push(library.columns.len());
        library.columns.push(where_under_test(states, healthy, states.column(signal)));
    };
    let surface: [fn(f64, f64) -> f64; 14] = [
        |_, v| v * v * v,
        |q, v| q * v,
        |q, v| q * q * v,
        |q, v| q * v * v,
        |q, _| q * q * q * q,
        |q, _| q.powi(5),
        |q, _| q.abs(),
        |q, _| q * q.abs(),
        |_, v| v.abs(),
        |_, v| v * v,
        |q, v| q.abs() * (30.0 * v).tanh(),
        |_, v| (30.0 * v).tanh() * (-20.0 * v.abs()).exp(),
        |q, _| (3.0 * q).sin(),
        |q, _| (6.0 * q).sin(),
    ];
    for of in surface {
        push(&|t: &Track| t.position.iter().zip(&t.velocity).map(|(q, v)| of(q * per_q, v * per_v)).collect());
    }
    for width in WIDTHS {
        push(&|t: &Track| play(&t.position, width * largest_q));
    }
    for periods in MEMORIES {
        let share = (-states.band.high_hz / (periods * states.sample_rate_hz)).exp();
        push(&|t: &Track| leak(&t.velocity, share));
    }
    for swing in 1..=SWINGS {
        let wave = move |t: &Track, k: usize| (0.5 * TAU * swing as f64 * k as f64 / t.len() as f64).cos();
        let other = move |t: &Track, k: usize| (0.5 * TAU * swing as f64 * k as f64 / t.len() as f64).sin();
        push(&|t: &Track| (0..t.len()).map(|k| t.position[k] * wave(t, k)).collect());
        push(&|t: &Track| (0..t.len()).map(|k| t.velocity[k] * wave(t, k)).collect());
        push(&|t: &Track| (0..t.len()).map(|k| t.position[k] * other(t, k)).collect());
    }
}

/// What a play of this half-width passes on.
fn play(signal: &[f64], half: f64) -> Vec<f64> {
    let mut last = 0.0;
    let one = |x: &f64| {
        last = f64::clamp(last, x - half, x + half);
        last
    };
    signal.iter().map(one).collect()
}

fn leak(signal: &[f64], share: f64) -> Vec<f64> {
    let mut last = 0.0;
    let one = |x: &f64| {
        last = share * last + (1.0 - share) * x;
        last
    };
    signal.iter().map(one).collect()
}
