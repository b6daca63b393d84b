//! Spectral lines: found one after the other, the strongest first.

use std::f64::consts::TAU;

use crate::signal::settings::SurrogateSettings;
use crate::signal::transform::forward_plan;
use crate::stats::optimise::golden_section;

const SETTINGS: SurrogateSettings = SurrogateSettings::DEFAULT;

/// Spectral line c cos ωt + s sin ωt.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Frequency ω, rad/sample.
    pub step: f64,
    cosine: f64,
    sine: f64,
}

impl Line {
    /// Amplitude.
    pub fn amplitude(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    /// Value at sample `t`.
    pub fn at(&self, t: usize) -> f64 {
        let (s, c) = (self.step * t as f64).sin_cos();
        self.cosine * c + self.sine * s
    }
}

/// Subtracts spectral lines, the strongest first, each fitted by least squares.
pub fn take_lines(values: &mut [f64]) -> Vec<Line> {
    let n = values.len();
    let window: Vec<f64> = (0..n).map(|t| 0.5 - 0.5 * (TAU * (t as f64 + 0.5) / n as f64).cos()).collect();
    let forward = forward_plan(n);
    let mut spectrum = forward.make_output_vec();
    let mut lines = Vec::new();
    while lines.len() < SETTINGS.max_lines {
        let mut windowed: Vec<f64> = values.iter().zip(&window).map(|(v, w)| v * w).collect();
        forward.process(&mut windowed, &mut spectrum).expect("buffers are the plan's own");
        let power: Vec<f64> = spectrum.iter().map(|bin| bin.norm_sqr()).collect();
        let Some(bin) = strongest_line(&power) else { break };
        let at = |step: f64| -> f64 {
            let (mut re, mut im) = (0.0, 0.0);
            for (t, (v, w)) in values.iter().zip(&window).enumerate() {
                let (s, c) = (step * t as f64).sin_cos();
                re += v * w * c;
                im -= v * w * s;
            }
            re * re + im * im
        };
        let step = golden_section(&at, TAU * (bin as f64 - 1.0) / n as f64, TAU * (bin as f64 + 1.0) / n as f64);
        // Least squares for c cos + s sin.
        let (mut cc, mut cs, mut ss, mut vc, mut vs) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (t, v) in values.iter().enumerate() {
            let (s, c) = (step * t as f64).sin_cos();
            (cc, cs, ss, vc, vs) = (cc + c * c, cs + c * s, ss + s * s, vc + v * c, vs + v * s);
        }
        let determinant = cc * ss - cs * cs;
        let (c, s) = ((vc * ss - vs * cs) / determinant, (vs * cc - vc * cs) / determinant);
        let line = Line { step, cosine: c, sine: s };
        values.iter_mut().enumerate().for_each(|(t, v)| *v -= line.at(t));
        lines.push(line);
    }
    lines
}

/// Bin of the strongest line, if any.
fn strongest_line(power: &[f64]) -> Option<usize> {
    let (far, near) = (SETTINGS.neighbourhood_bins, SETTINGS.guard_bins);
    let ratio = |k: usize| {
        let around = (k.saturating_sub(far)..(k + far + 1).min(power.len())).filter(|j| j.abs_diff(k) > near);
        let mut around: Vec<f64> = around.map(|j| power[j]).collect();
        around.sort_by(f64::total_cmp);
        let median = around.get(around.len() / 2).copied().unwrap_or(f64::INFINITY);
        power[k] / median.max(f64::MIN_POSITIVE)
    };
    let peaks = (2..power.len().saturating_sub(2)).filter(|k| power[*k] >= power[k - 1] && power[*k] >= power[k + 1]);
    let outstanding = peaks.filter(|k| ratio(*k) > SETTINGS.line_ratio);
    outstanding.max_by(|a, b| power[*a].total_cmp(&power[*b]))
}
