//! Change of a channel against the baseline: amplitudes of the shaft's orders, and power in bands.

use super::observation::Observation;
use super::settings::ChangeSettings;
use crate::signal::spectrum::{Spectrum, amplitudes, welch};
use crate::signal::transform::median;

const SETTINGS: ChangeSettings = ChangeSettings::DEFAULT;

/// A rise of the power beside a fall, as where a mode's frequency changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedMode {
    /// Frequency of the fall, Hz: where the mode was.
    pub from_hz: f64,
    /// Frequency of the rise, Hz.
    pub to_hz: f64,
    /// The smaller of the two changes, dB.
    pub by_db: f64,
}

impl MovedMode {
    /// Whether two moves are of one mode.
    pub fn is_like(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a / b).log2().abs() * SETTINGS.parts_per_octave < 1.5;
        near(self.from_hz, other.from_hz) && near(self.to_hz, other.to_hz)
    }
}

/// Change of one channel against the baseline, mean over recordings, dB.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// Change of the amplitude of each order of the shaft from 1, of each recording.
    pub orders: Vec<Vec<f64>>,
    /// Change of how far each half order, from 0.5, stands out of what is around it, of each recording.
    pub half_orders: Vec<Vec<f64>>,
    /// Bands with the change of their power, Hz and dB.
    pub bands: Vec<([f64; 2], f64)>,
    /// Median change over bands.
    pub gain_db: f64,
    /// Root mean square of the bands' changes around that.
    pub shape_db: f64,
    /// Spread of the change over bands and recordings.
    pub spread_db: f64,
    /// Greatest change around the median, up or down, in the mean over neighbouring bands.
    pub wide_db: f64,
    /// Ends of these bands, Hz.
    pub wide_hz: [f64; 2],
    /// Strongest rise beside a fall, of a mode that moved or of chance.
    pub moved: Option<MovedMode>,
    /// Greatest difference of the speeds that were compared, as a logarithm of their ratio.
    pub apart: f64,
}

impl Change {
    /// Change of a channel; `None` where nothing in the baseline can be compared.
    pub fn new(recordings: &[Observation], baseline: &[Observation], channel: usize) -> Option<Self> {
        let (mut orders, mut half_orders, mut apart) = (Vec::new(), Vec::new(), 0.0f64);
        let (mut of_bands, mut of_parts) = (Vec::new(), Vec::new());
        let rate = recordings.first()?.sample_rate_hz;
        let edges = edges(rate, SETTINGS.lowest_hz, SETTINGS.bands_per_octave);
        let parts = self::edges(rate, SETTINGS.lowest_mode_hz, SETTINGS.parts_per_octave);
        for recording in recordings {
            let Some(samples) = recording.channels[channel].as_deref() else { continue };
            let matches = recording.matches(baseline);
            let healthy: Vec<&[f64]> = matches.iter().filter_map(|m| m.channels[channel].as_deref()).collect();
            if healthy.is_empty() {
                continue;
            }
            let rate = recording.sample_rate_hz;
            apart = matches.iter().map(|m| (m.shaft_hz / recording.shaft_hz).ln().abs()).fold(apart, f64::max);
            if recording.turns() >= SETTINGS.fewest_turns && matches.iter().all(|m| m.turns() >= SETTINGS.fewest_turns)
            {
                let recorded = matches.iter().filter_map(|m| Some((m.channels[channel].as_deref()?, m.shaft_hz)));
                let then: Option<Vec<Orders>> =
                    recorded.map(|(samples, shaft_hz)| Orders::new(samples, rate, shaft_hz)).collect();
                if let (Some(now), Some(then)) = (Orders::new(samples, rate, recording.shaft_hz), then) {
                    orders.push(ratios(&now.powers, then.iter().map(|t| &t.powers)));
                    half_orders.push(ratios(&now.halves, then.iter().map(|t| &t.halves)));
                }
            }
            of_bands.push(band_change(samples, &healthy, rate, &edges)?);
            of_parts.push(band_change(samples, &healthy, rate, &parts)?);
        }
        let first = of_bands.first()?;
        let count = of_bands.len() as f64;
        let bands: Vec<_> = (0..first.len())
            .map(|k| ([edges[k], edges[k + 1]], of_bands.iter().map(|b| b[k]).sum::<f64>() / count))
            .collect();
        let gain_db = median(&mut bands.iter().map(|b| b.1).collect::<Vec<_>>())?;
        let around = |value: f64| (value - gain_db).clamp(-SETTINGS.most_db, SETTINGS.most_db).powi(2);
        let rms = |values: &[f64]| (values.iter().map(|v| around(*v)).sum::<f64>() / values.len() as f64).sqrt();
        let shape_db = rms(&bands.iter().map(|b| b.1).collect::<Vec<_>>());
        let wide = bands.windows(SETTINGS.wide_bands).map(|near| {
            let mean = near.iter().map(|b| b.1 - gain_db).sum::<f64>() / near.len() as f64;
            (mean.abs(), [near[0].0[0], near[near.len() - 1].0[1]])
        });
        let (wide_db, wide_hz) = wide.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        let spread_db = rms(&of_bands.concat());
        Some(Self {
            orders,
            half_orders,
            gain_db,
            shape_db,
            spread_db,
            wide_db,
            wide_hz,
            moved: moved(&of_parts, &parts),
            apart,
            bands,
        })
    }

    /// Mean change of an order over recordings, dB, with its standard error, which is at least that of the scatter between
    /// healthy machines; `None` without orders.
    pub fn order_db(&self, order: usize) -> Option<[f64; 2]> {
        self.with_error(self.orders.iter().filter_map(|o| o.get(order - 1).copied()).collect())
    }

    /// Mean change of the half orders over recordings, dB, that of the second strongest of them, with its standard error; `None`
    /// without orders.
    pub fn half_orders_db(&self) -> Option<[f64; 2]> {
        let second = |of: &Vec<f64>| {
            let mut sorted = of.clone();
            sorted.sort_by(|a, b| b.total_cmp(a));
            sorted.get(1).copied()
        };
        self.with_error(self.half_orders.iter().filter_map(second).collect())
    }

    /// Mean of a change of the shaft's lines over recordings, dB, with its standard error; `None` without recordings.
    fn with_error(&self, values: Vec<f64>) -> Option<[f64; 2]> {
        let count = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        // Two speeds have two responses of the structure.
        let usual = SETTINGS.order_scatter_db.hypot(SETTINGS.per_speed_db * self.apart);
        Some([mean, variance.sqrt().max(usual) / count.sqrt()])
    }
}

/// Edges of bands of a share of an octave.
fn edges(sample_rate_hz: f64, lowest_hz: f64, per_octave: f64) -> Vec<f64> {
    let octaves = (0.45 * sample_rate_hz / lowest_hz).log2().max(0.0);
    let count = (per_octave * octaves) as usize;
    (0..=count.max(1)).map(|k| lowest_hz * (k as f64 / per_octave).exp2()).collect()
}

/// The rise beside a fall, of the median change over recordings around its own median, whose smaller part is greatest.
fn moved(changes: &[Vec<f64>], edges: &[f64]) -> Option<MovedMode> {
    let count = changes.first()?.len();
    let typical = |k: usize| median(&mut changes.iter().map(|of| of[k]).collect::<Vec<_>>());
    let course: Vec<f64> = (0..count).map(typical).collect::<Option<_>>()?;
    let level = median(&mut course.clone())?;
    let near = (SETTINGS.most_move_octaves * SETTINGS.parts_per_octave) as usize;
    let middle = |k: usize| (edges[k] * edges[k + 1]).sqrt();
    let pair = |to: usize, from: usize| MovedMode {
        from_hz: middle(from),
        to_hz: middle(to),
        by_db: (course[to] - level).min(level - course[from]),
    };
    let pairs =
        (0..count).flat_map(|to| (to.saturating_sub(near)..(to + near + 1).min(count)).map(move |from| (to, from)));
    pairs.map(|(to, from)| pair(to, from)).max_by(|a, b| a.by_db.total_cmp(&b.by_db))
}

fn band_change(samples: &[f64], healthy: &[&[f64]], rate: f64, edges: &[f64]) -> Option<Vec<f64>> {
    let shortest = healthy.iter().map(|h| h.len()).min()?.min(samples.len());
    let segment = shortest.min(8192);
    let (now, then) = (welch(&[samples], rate, segment)?, welch(healthy, rate, segment)?);
    let mean = |of: &Spectrum, low: f64, high: f64| {
        let from = (low / of.step_hz).round() as usize;
        let to = ((high / of.step_hz).round() as usize).clamp(from + 1, of.values.len().max(from + 1));
        let inside = of.values.get(from..to).unwrap_or(&[]);
        inside.iter().sum::<f64>() / inside.len().max(1) as f64
    };
    let change = |pair: &[f64]| {
        let ratio = mean(&now, pair[0], pair[1]).max(1e-30) / mean(&then, pair[0], pair[1]).max(1e-30);
        10.0 * ratio.log10()
    };
    Some(edges.windows(2).map(change).collect())
}

/// Lines of the shaft in a recording.
struct Orders {
    /// Power of each order from 1.
    powers: Vec<f64>,
    /// Power of each half order from 0.5, over what is around it.
    halves: Vec<f64>,
}

impl Orders {
    fn new(samples: &[f64], rate: f64, shaft_hz: f64) -> Option<Self> {
        let spectrum = amplitudes(&[samples], rate)?;
        let power = |order: f64| {
            let hz = order * shaft_hz;
            let (centre, reach) = ((hz / spectrum.step_hz).round() as usize, reach(hz, spectrum.step_hz));
            let near = spectrum.values.get(centre.saturating_sub(reach)..centre + reach + 1)?;
            Some(near.iter().map(|v| v * v).sum::<f64>().max(1e-30))
        };
        let half = |k: usize| {
            let order = k as f64 - 0.5;
            let floor = floor(&spectrum, order * shaft_hz, 0.5 * shaft_hz)?;
            let count = (2 * reach(order * shaft_hz, spectrum.step_hz) + 1) as f64;
            Some((power(order)? / (count * floor)).max(1.0))
        };
        let each = |of: &dyn Fn(usize) -> Option<f64>| (1..=SETTINGS.orders).map(of).collect::<Option<Vec<_>>>();
        Some(Self { powers: each(&|k| power(k as f64))?, halves: each(&half)? })
    }
}

/// Values to either side of a line that are part of it.
fn reach(hz: f64, step_hz: f64) -> usize {
    2 + (SETTINGS.order_reach * hz / step_hz) as usize
}

/// Median power around a line, nearer than `within_hz`.
pub fn floor(spectrum: &Spectrum, hz: f64, within_hz: f64) -> Option<f64> {
    let centre = (hz / spectrum.step_hz).round() as usize;
    let (inner, outer) = (reach(hz, spectrum.step_hz) + 1, (within_hz / spectrum.step_hz) as usize);
    let below = centre.saturating_sub(outer)..centre.saturating_sub(inner);
    let above = centre + inner + 1..(centre + outer + 1).min(spectrum.values.len());
    let around = |range: std::ops::Range<usize>| spectrum.values.get(range).unwrap_or(&[]).iter().map(|v| v * v);
    median(&mut around(below).chain(around(above)).collect::<Vec<_>>()).map(|floor| floor.max(1e-30))
}

/// Ratios to the mean of the healthy ones, dB.
fn ratios<'v>(now: &[f64], then: impl Iterator<Item = &'v Vec<f64>> + Clone) -> Vec<f64> {
    let count = then.clone().count() as f64;
    let mean = |k: usize| then.clone().map(|t| t[k]).sum::<f64>() / count;
    now.iter().enumerate().map(|(k, now)| 10.0 * (now / mean(k)).log10()).collect()
}
