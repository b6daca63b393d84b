//! Parameters by simulation: the rig's own run against the sensor's signal, window by window, theory (67).
//!
//! Multiple shooting (H. G. Bock, "Recent advances in parameter identification techniques for O.D.E.", 1983): a recording
//! is cut into windows, each with a start of its own, which is fitted with the parameters. Under white sensor noise this
//! is the maximum-likelihood estimate, while the force balance, whose columns hold the noise too, is a little biased.
//! Under disturbing forces it is the worse estimate, because the simulation leaves them out for a whole window.

use crate::rig::config::{Machine, Restoring, RigKey};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::stats::optimise::{Damped, Decrease, GeometricDamping, damped_search};
use rayon::prelude::*;

use super::{
    regression::{self, Fit},
    settings::BalanceSettings,
    states::Sensed,
};
use crate::rig::{
    Rig,
    sdof::{Drive, Interpolation, simulate},
};

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// A rig fitted by simulation.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The rig with the fitted values.
    pub rig: Rig,
    /// Estimates in the order of the keys, their covariance, and the residual of each sample, in the sensor's unit.
    pub fit: Fit,
    /// Root mean square of the residual.
    pub rms: f64,
    /// Start q and q̇ of each window.
    pub starts: Vec<[f64; 2]>,
}

/// A recording as the shooting sees it.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// Input u.
    pub input: &'a [f64],
    /// Position q or acceleration q̈, as recorded.
    pub sensed: &'a [f64],
    /// Whether each sample is invalid.
    pub bad: &'a [bool],
    /// Positions from which windows start, on a grid of `fine` points a sample.
    pub position: &'a [f64],
    /// Velocities from which windows start, on that grid.
    pub velocity: &'a [f64],
    /// Grid points a sample.
    pub fine: usize,
    /// Samples per second.
    pub sample_rate_hz: f64,
}

/// Recordings for the shooting.
#[derive(Clone, Debug)]
pub struct Observed<'a> {
    /// Recordings.
    pub tracks: Vec<Measured<'a>>,
    /// Measured quantity.
    pub sensed: Sensed,
    /// Input between its samples.
    pub interpolation: Interpolation,
}

impl Observed<'_> {
    /// Windows of about `length` samples that cover all recordings; `None` takes recordings whole.
    pub fn spans(&self, length: Option<usize>) -> Vec<Span> {
        let mut spans = Vec::new();
        for (track, measured) in self.tracks.iter().enumerate() {
            let samples = measured.sensed.len();
            let count = length.map_or(1, |length| (samples / length.max(1)).max(1));
            let cut = |k: usize| k * samples / count;
            spans.extend((0..count).map(|k| Span { track, first: cut(k), last: cut(k + 1) }));
        }
        spans
    }

    fn amplitudes(&self) -> [f64; 2] {
        let largest = |of: for<'b> fn(&Measured<'b>) -> &'b [f64]| {
            self.tracks.iter().flat_map(of).fold(0.0f64, |largest, x| largest.max(x.abs()))
        };
        [largest(|t| t.position), largest(|t| t.velocity)]
    }
}

/// A window of a recording: from `first` to before `last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// Index of the recording.
    pub track: usize,
    /// First sample.
    pub first: usize,
    /// Sample after the last.
    pub last: usize,
}

#[derive(Clone, Copy)]
struct ShootingWindow<'a> {
    track: &'a Measured<'a>,
    first: usize,
    last: usize,
    /// Start q and q̇ at the first sample.
    start: [f64; 2],
}

/// Fits the numbers named by `keys`, as [`Rig::set`] takes them, and the start of each window, from the rig's values on.
/// Returns `None` if the simulation diverges or the keys are not determined.
pub fn refine(rig: &Rig, keys: &[RigKey], observed: &Observed, spans: &[Span]) -> Option<Refined> {
    let mut windows = cut(observed, spans);
    if is_nonlinear(rig) {
        lead_in(rig, observed, &mut windows);
    }
    search(rig, keys, observed, windows)
}

/// Whether the motion of a rig is not linear in its start.
fn is_nonlinear(rig: &Rig) -> bool {
    let pendulum = matches!(&rig.model, Machine::Sdof(machine) if machine.restoring == Restoring::Pendulum);
    pendulum || !rig.effects.is_empty()
}

/// Moves the start of each window to where its first samples are followed best, then more and more of them. A search over all of
/// a long window at once ends beside the motion where a small error of the start grows to half a turn of its phase.
fn lead_in(rig: &Rig, observed: &Observed, windows: &mut [ShootingWindow]) {
    let longest = windows.iter().map(|w| w.last - w.first).max().unwrap_or_default();
    let mut led = windows.to_vec();
    let mut reach = SETTINGS.start_reach;
    while reach < longest {
        let parts = led.iter().map(|w| ShootingWindow { last: w.last.min(w.first + reach), ..*w }).collect();
        let Some(found) = search(rig, &[], observed, parts) else { return };
        led.iter_mut().zip(found.starts).for_each(|(window, start)| window.start = start);
        reach *= SETTINGS.start_growth;
    }
    let run = Run { observed, keys: &[] };
    let error = |w: &ShootingWindow| run.error(rig, w, w.start).map_or(f64::INFINITY, |e| dot(&e, &e));
    windows.par_iter_mut().zip(led).for_each(|(window, led)| {
        if error(&led) < error(window) {
            *window = led;
        }
    });
}

/// Fits the numbers named by `keys` and the starts of windows, from where they are.
fn search(rig: &Rig, keys: &[RigKey], observed: &Observed, windows: Vec<ShootingWindow>) -> Option<Refined> {
    let run = Run { observed, keys };
    let values: Vec<f64> = keys.iter().map(|key| rig.get(*key)).collect::<Option<_>>()?;
    let pieces = run.linearise(rig, &values, &windows)?;
    let mut shooting = Shooting { run, rig: rig.clone(), values, windows, cost: cost_of(&pieces), pieces };
    let mut damping = GeometricDamping {
        value: SETTINGS.shooting_initial_damping,
        fall: SETTINGS.damping_fall,
        growth: SETTINGS.shooting_damping_growth,
        floor: SETTINGS.damping_floor,
        singular_growth: 10.0,
        singular_floor: 1e-9,
    };
    // Starts alone are all but linear.
    let (steps, most) = if keys.is_empty() {
        (SETTINGS.start_steps, SETTINGS.start_max_damping)
    } else {
        (SETTINGS.shooting_steps, SETTINGS.shooting_max_damping)
    };
    damped_search(&mut shooting, &mut damping, steps, most).ok()?;
    let Shooting { rig, values, windows, pieces, .. } = shooting;
    let fit = covariance(&pieces, &values)?;
    let count = fit.residual.len().max(1) as f64;
    let rms = (fit.residual.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
    Some(Refined { rig, fit, rms, starts: windows.iter().map(|w| w.start).collect() })
}

/// State of a search over parameters and the start of each window.
struct Shooting<'a> {
    run: Run<'a>,
    rig: Rig,
    values: Vec<f64>,
    windows: Vec<ShootingWindow<'a>>,
    pieces: Vec<Piece>,
    cost: f64,
}

/// A simulation that diverges.
struct Diverged;

impl Damped for Shooting<'_> {
    /// Values of the keys, and starts of the windows.
    type Trial = (Vec<f64>, Vec<[f64; 2]>);
    type Error = Diverged;

    fn trial(&self, damping: f64) -> Result<Option<Self::Trial>, Diverged> {
        let Some((step, starts)) = solve(&self.pieces, self.run.keys.len(), damping) else { return Ok(None) };
        let values = self.values.iter().zip(&step).map(|(v, s)| v + s).collect();
        let starts = self.windows.iter().zip(&starts).map(|(w, s)| [w.start[0] + s[0], w.start[1] + s[1]]).collect();
        Ok(Some((values, starts)))
    }

    fn decrease(&self, (values, starts): &Self::Trial) -> Option<Decrease> {
        let mut keys = self.run.keys.iter().zip(values);
        let inside = keys.all(|(k, v)| self.rig.domain(*k).is_none_or(|d| d.holds(*v)));
        let found = inside.then(|| self.run.sum_of_squares(&self.rig, values, &self.windows, starts)).flatten();
        let better = found.filter(|c| *c < self.cost)?;
        Some(Decrease { actual: 1.0 - better / self.cost, expected: f64::NAN })
    }

    fn accept(&mut self, (values, starts): Self::Trial, decrease: Decrease) -> Result<bool, Diverged> {
        self.values = values;
        self.windows.iter_mut().zip(starts).for_each(|(w, s)| w.start = s);
        for (key, value) in self.run.keys.iter().zip(&self.values) {
            self.rig.set(*key, *value).map_err(|_| Diverged)?;
        }
        self.pieces = self.run.linearise(&self.rig, &self.values, &self.windows).ok_or(Diverged)?;
        self.cost = cost_of(&self.pieces);
        let least = if self.run.keys.is_empty() { SETTINGS.start_min_fall } else { SETTINGS.shooting_min_fall };
        Ok(decrease.actual < least)
    }
}

/// Root mean square residual of a rig's simulation, over windows whose starts are fitted, in the sensor's unit. `None` if
/// the simulation diverges.
pub fn error(rig: &Rig, observed: &Observed, spans: &[Span]) -> Option<f64> {
    refine(rig, &[], observed, spans).map(|refined| refined.rms)
}

/// Simulation of each window from the start of least residual. `None` if a simulation diverges.
pub fn follow(rig: &Rig, observed: &Observed, spans: &[Span]) -> Option<Vec<Vec<f64>>> {
    let starts = refine(rig, &[], observed, spans)?.starts;
    let run = Run { observed, keys: &[] };
    cut(observed, spans).par_iter().zip(&starts).map(|(window, start)| run.signal(rig, window, *start)).collect()
}

fn cut<'a>(observed: &'a Observed, spans: &[Span]) -> Vec<ShootingWindow<'a>> {
    let one = |span: &Span| {
        let track = &observed.tracks[span.track];
        let at = span.first * track.fine;
        ShootingWindow { track, first: span.first, last: span.last, start: [track.position[at], track.velocity[at]] }
    };
    spans.iter().map(one).collect()
}

/// A window's error and its derivatives.
struct Piece {
    error: Vec<f64>,
    /// Derivatives by the keys, then by the start.
    slopes: Vec<Vec<f64>>,
}

struct Run<'a> {
    observed: &'a Observed<'a>,
    keys: &'a [RigKey],
}

impl Run<'_> {
    fn signal(&self, rig: &Rig, window: &ShootingWindow, start: [f64; 2]) -> Option<Vec<f64>> {
        let track = window.track;
        let drive = Drive {
            input: track.input,
            sample_rate_hz: track.sample_rate_hz,
            position: start[0],
            velocity: start[1],
            interpolation: self.observed.interpolation,
            first: window.first,
            samples: window.last - window.first,
        };
        let later = later(rig, window.first as f64 / track.sample_rate_hz);
        let mut recording = simulate(later.as_ref().unwrap_or(rig), &drive).ok()?;
        let channel = recording.channels.iter_mut().find(|c| c.name == self.observed.sensed.channel())?;
        Some(std::mem::take(&mut channel.samples))
    }

    fn error(&self, rig: &Rig, window: &ShootingWindow, start: [f64; 2]) -> Option<Vec<f64>> {
        let simulated = self.signal(rig, window, start)?;
        let track = window.track;
        let left = (window.first..window.last).zip(simulated).map(
            |(k, s)| {
                if track.bad[k] { 0.0 } else { track.sensed[k] - s }
            },
        );
        Some(left.collect())
    }

    fn sum_of_squares(
        &self,
        rig: &Rig,
        values: &[f64],
        windows: &[ShootingWindow],
        starts: &[[f64; 2]],
    ) -> Option<f64> {
        let mut rig = rig.clone();
        for (key, value) in self.keys.iter().zip(values) {
            rig.set(*key, *value).ok()?;
        }
        let each: Option<Vec<f64>> = windows
            .par_iter()
            .zip(starts)
            .map(|(w, s)| self.error(&rig, w, *s).map(|e| e.iter().map(|e| e * e).sum()))
            .collect();
        each.map(|each| each.iter().sum()).filter(|c: &f64| c.is_finite())
    }

    fn linearise(&self, rig: &Rig, values: &[f64], windows: &[ShootingWindow]) -> Option<Vec<Piece>> {
        let amplitudes = self.observed.amplitudes();
        windows
            .par_iter()
            .map(|window| {
                let error = self.error(rig, window, window.start)?;
                let mut slopes = Vec::with_capacity(self.keys.len() + 2);
                for (key, value) in self.keys.iter().zip(values) {
                    let step = if *value == 0.0 { 1e-6 } else { SETTINGS.shooting_difference * value.abs() };
                    let mut moved = rig.clone();
                    // Backwards where forwards is outside what the number may be.
                    let step = if moved.set(*key, value + step).is_ok() { step } else { -step };
                    moved.set(*key, value + step).ok()?;
                    slopes.push(slope(&error, &self.error(&moved, window, window.start)?, step));
                }
                let steps = amplitudes.map(|x| SETTINGS.shooting_difference * x.max(1e-12));
                for (axis, step) in steps.into_iter().enumerate() {
                    let mut start = window.start;
                    start[axis] += step;
                    let moved = self.error(rig, window, start)?;
                    slopes.push(slope(&error, &moved, step));
                }
                // Accelerations do not determine the position of a rig without a spring.
                if self.observed.sensed == Sensed::Acceleration
                    && slopes.iter().any(|s| s.iter().any(|x| !x.is_finite()))
                {
                    return None;
                }
                Some(Piece { error, slopes })
            })
            .collect()
    }
}

/// Derivative ∂(simulated)/∂(parameter).
fn slope(base: &[f64], moved: &[f64], step: f64) -> Vec<f64> {
    base.iter().zip(moved).map(|(b, m)| (b - m) / step).collect()
}

/// Rig of a window that begins later than its recording: times and phases of effects are moved.
fn later(rig: &Rig, offset_s: f64) -> Option<Rig> {
    if offset_s == 0.0 || rig.effects.is_empty() {
        return None;
    }
    let mut moved = rig.clone();
    for effect in &mut moved.effects {
        let number = |key: ParameterKey| effect.number(key).unwrap_or_default();
        if effect.kind == EffectKind::MainsInterference {
            let phase =
                number(ParameterKey::PhaseRad) + std::f64::consts::TAU * number(ParameterKey::FrequencyHz) * offset_s;
            effect.set_number(ParameterKey::PhaseRad, phase);
        } else if effect.parameters.contains_key(&ParameterKey::TimeS) {
            let time = number(ParameterKey::TimeS) - offset_s;
            effect.set_number(ParameterKey::TimeS, time);
        }
    }
    Some(moved)
}

fn cost_of(pieces: &[Piece]) -> f64 {
    pieces.iter().flat_map(|p| &p.error).map(|e| e * e).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Slopes by the keys and error of a piece, without the part that its start explains.
fn without_start(piece: &Piece, count: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(2);
    for slope in &piece.slopes[count..] {
        let mut vector = slope.clone();
        let before = dot(&vector, &vector);
        project(&mut vector, &basis);
        project(&mut vector, &basis);
        let size = dot(&vector, &vector);
        if size > 1e-16 * before && size > 0.0 {
            let root = size.sqrt();
            vector.iter_mut().for_each(|x| *x /= root);
            basis.push(vector);
        }
    }
    let clean = |signal: &Vec<f64>| {
        let mut signal = signal.clone();
        project(&mut signal, &basis);
        signal
    };
    (piece.slopes[..count].iter().map(clean).collect(), clean(&piece.error))
}

fn project(signal: &mut [f64], basis: &[Vec<f64>]) {
    for vector in basis {
        let share = dot(signal, vector);
        signal.iter_mut().zip(vector).for_each(|(x, b)| *x -= share * b);
    }
}

/// A step of parameters and starts.
fn solve(pieces: &[Piece], count: usize, damping: f64) -> Option<(Vec<f64>, Vec<[f64; 2]>)> {
    let mut normal = vec![vec![0.0; count]; count];
    let mut right = vec![0.0; count];
    for piece in pieces {
        let (slopes, error) = without_start(piece, count);
        for i in 0..count {
            right[i] += dot(&slopes[i], &error);
            for j in 0..=i {
                normal[i][j] += dot(&slopes[i], &slopes[j]);
            }
        }
    }
    let step = super::gram::cholesky_solve(&mut normal, &right, damping)?;
    let starts = pieces.iter().map(|piece| {
        let mut left = piece.error.clone();
        for (slope, step) in piece.slopes.iter().zip(&step) {
            left.iter_mut().zip(slope).for_each(|(e, s)| *e -= s * step);
        }
        let (a, b) = (&piece.slopes[count], &piece.slopes[count + 1]);
        let (aa, ab, bb) = (dot(a, a) * (1.0 + damping), dot(a, b), dot(b, b) * (1.0 + damping));
        let determinant = aa * bb - ab * ab;
        let (ra, rb) = (dot(a, &left), dot(b, &left));
        if determinant > 1e-12 * aa * bb {
            [(bb * ra - ab * rb) / determinant, (aa * rb - ab * ra) / determinant]
        } else if aa > 0.0 {
            [ra / aa, 0.0]
        } else {
            [0.0, if bb > 0.0 { rb / bb } else { 0.0 }]
        }
    });
    let starts = starts.collect();
    Some((step, starts))
}

fn covariance(pieces: &[Piece], values: &[f64]) -> Option<Fit> {
    let count = values.len();
    let mut columns = vec![Vec::new(); count];
    let mut target = Vec::new();
    let mut residual = Vec::new();
    for piece in pieces {
        let (slopes, error) = without_start(piece, count);
        columns.iter_mut().zip(slopes).for_each(|(column, slope)| column.extend(slope));
        target.extend(error);
        residual.extend_from_slice(&piece.error);
    }
    if count == 0 {
        return Some(Fit { values: Vec::new(), covariance: Vec::new(), residual });
    }
    let groups: Vec<usize> = pieces.iter().map(|p| p.error.len()).collect();
    let lags = regression::correlation_length(&target, &groups);
    let fit = regression::least_squares(&columns, &target, &groups, lags)?;
    Some(Fit { values: values.to_vec(), covariance: fit.covariance, residual })
}
