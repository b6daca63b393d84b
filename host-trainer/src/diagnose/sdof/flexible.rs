//! Flexible columns without a name: if they explain more than the best named causes, there is a lack of fit.
//!
//! Splines of position and of velocity, products of both, memory (play operators of M. A. Krasnosel'skii and A. V.
//! Pokrovskii, "Systems with Hysteresis", 1989; leaky integrals of the velocity, as in viscoelastic supports), delays of
//! input and position, and parameters that swing with time.

use std::f64::consts::TAU;

use super::acquire::{Acquired, Track};
use super::library::{Signal, Source};

/// Knots of a spline.
const KNOTS: usize = 7;
/// Widths of the play operators, as shares of the largest position.
const WIDTHS: [f64; 4] = [0.02, 0.08, 0.25, 0.6];
/// Time constants of the leaky integrals and delays, in periods of the motion.
const MEMORIES: [f64; 3] = [0.1, 0.5, 2.0];
/// Half periods of the swings with time.
const SWINGS: i32 = 8;

/// Function of position and velocity, both as shares of their largest values.
type OfState = fn(f64, f64) -> f64;

/// Knots of a piecewise linear curve of a state: quantiles, so that each piece has samples.
fn knots(mut values: Vec<f64>, count: usize) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    let mut knots: Vec<f64> = (0..count).map(|k| values[(last * k as f64 / (count - 1) as f64) as usize]).collect();
    knots.dedup_by(|a, b| *a <= *b);
    knots
}

/// Hat function number `index` of some knots.
fn hat(knots: &[f64], index: usize, x: f64) -> f64 {
    let here = knots[index];
    let side = if x < here { index.checked_sub(1).map(|i| knots[i]) } else { knots.get(index + 1).copied() };
    match side {
        Some(next) => (1.0 - (x - here) / (next - here)).clamp(0.0, 1.0),
        None => 1.0,
    }
}

/// A flexible column.
pub struct Flexible<'a> {
    /// What it depends on, in words.
    pub about: &'static str,
    /// Spline (0 of position, 1 of velocity) and knot that it belongs to.
    pub knot: Option<(usize, f64)>,
    /// What drives it.
    pub source: Source<'a>,
}

/// Flexible columns.
pub fn sources(acquired: &Acquired) -> Vec<Flexible<'_>> {
    let [largest_q, largest_v] = acquired.amplitudes();
    let (per_q, per_v) = (1.0 / largest_q, 1.0 / largest_v);
    let of_q = knots(acquired.under_test().flat_map(|t| t.states.position.clone()).collect(), KNOTS);
    let of_v = knots(acquired.under_test().flat_map(|t| t.states.velocity.clone()).collect(), KNOTS);
    let mut out = Vec::new();
    for index in 0..of_q.len() {
        let (knot, knots) = (Some((0, of_q[index])), of_q.clone());
        let source = Source::Force(Box::new(move |t: &Track| t.signal(|q, _, _| hat(&knots, index, q))));
        out.push(Flexible { about: "position", knot, source });
    }
    for index in 0..of_v.len() {
        let (knot, knots) = (Some((1, of_v[index])), of_v.clone());
        let source = Source::Force(Box::new(move |t: &Track| t.signal(|_, v, _| hat(&knots, index, v))));
        out.push(Flexible { about: "velocity", knot, source });
    }
    let mut force = |about, signal: Signal<'static>| {
        out.push(Flexible { about, knot: None, source: Source::Force(signal) });
    };
    let surface: [(&'static str, OfState); 14] = [
        ("position", |q, _| q * q * q),
        ("position", |q, _| q.powi(5)),
        ("position", |q, _| (30.0 * q).tanh()),
        ("position", |q, _| q.abs()),
        ("velocity", |_, v| v * v * v),
        ("velocity", |_, v| v * v.abs()),
        ("velocity", |_, v| (30.0 * v).tanh()),
        ("velocity", |_, v| (30.0 * v).tanh() * (-20.0 * v.abs()).exp()),
        ("velocity", |_, v| v),
        ("position", |q, _| q),
        ("position and velocity", |q, v| q * v),
        ("position and velocity", |q, v| q * q * v),
        ("position and velocity", |q, v| q * v * v),
        ("position and velocity", |q, v| q.abs() * (30.0 * v).tanh()),
    ];
    for (about, of) in surface {
        force(about, Box::new(move |t| t.signal(|q, v, _| of(q * per_q, v * per_v))));
    }
    for width in WIDTHS {
        force("what the position was before", Box::new(move |t| play(&t.states.position, width * largest_q)));
    }
    let hz = acquired.under_test().map(|t| super::acquire::frequency_hz(&t.states)).fold(0.0, f64::max);
    for periods in MEMORIES {
        let lag = move |t: &Track| hz * t.step_s() / t.fine as f64 / periods;
        force("what the velocity was before", Box::new(move |t| leak(&t.states.velocity, (-lag(t)).exp())));
        if acquired.driven {
            let interpolation = acquired.interpolation;
            force("the input before", Box::new(move |t| leak(&t.grid_input(interpolation), (-lag(t)).exp())));
        }
    }
    for swing in 1..=SWINGS {
        let wave =
            move |t: &Track, k: usize| (0.5 * TAU * f64::from(swing) * k as f64 / t.states.position.len() as f64).cos();
        let times = move |t: &Track, of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..t.states.position.len()).map(|k| wave(t, k) * of(k)).collect()
        };
        force("time", Box::new(move |t| times(t, &|_| 1.0)));
        force("time and position", Box::new(move |t| times(t, &|k| t.states.position[k])));
        force("time and velocity", Box::new(move |t| times(t, &|k| t.states.velocity[k])));
    }
    out
}

/// A few nonlinear terms.
pub fn rough(largest_q: f64, largest_v: f64) -> Vec<Source<'static>> {
    let terms: [fn(f64, f64) -> f64; 9] = [
        |_, _| 1.0,
        |q, _| q,
        |_, v| v,
        |q, _| q * q,
        |q, _| q * q * q,
        |_, v| v * v.abs(),
        |_, v| (30.0 * v).tanh(),
        |_, v| (300.0 * v).tanh(),
        |q, v| q * q * v,
    ];
    let source = |of: fn(f64, f64) -> f64| {
        Source::Force(Box::new(move |t: &Track| t.signal(|q, v, _| of(q / largest_q, v / largest_v))))
    };
    terms.into_iter().map(source).collect()
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
    let mut last = signal.first().copied().unwrap_or_default();
    let one = |x: &f64| {
        last = share * last + (1.0 - share) * x;
        last
    };
    signal.iter().map(one).collect()
}

/// η (or η̈, for an accelerometer) of a mode that the mass's acceleration drives, as the effect `structural-resonance` adds it
/// to the sensor's signal: η̈ + 2ζω η̇ + ω² η = q̈.
pub fn mode(track: &Track, hz: f64, ratio: f64, accelerometer: bool) -> Vec<f64> {
    let omega = TAU * hz;
    let fine = track.fine;
    let h = track.step_s() / fine as f64;
    let drive = &track.states.acceleration;
    let damped = omega * (1.0 - ratio * ratio).sqrt();
    let decay = (-ratio * omega * h).exp();
    let (s, c) = (damped * h).sin_cos();
    let along = ratio * omega / damped;
    let turn =
        [[decay * (c + along * s), decay * s / damped], [-decay * omega * omega * s / damped, decay * (c - along * s)]];
    let first = drive.first().copied().unwrap_or_default();
    // About the equilibrium under the drive of each step, which is taken as constant in it.
    let (mut y, mut z) = (first / (omega * omega), 0.0);
    let mut out = Vec::with_capacity(track.len());
    for k in 0..drive.len() {
        if k % fine == 0 {
            out.push(if accelerometer { drive[k] - 2.0 * ratio * omega * z - omega * omega * y } else { y });
        }
        let force = 0.5 * (drive[k] + drive[(k + 1).min(drive.len() - 1)]) / (omega * omega);
        let (a, b) = (y - force, z);
        (y, z) = (force + turn[0][0] * a + turn[0][1] * b, turn[1][0] * a + turn[1][1] * b);
    }
    out
}
