//! Faults of the acquisition of a machine of unknown structure: in the samples themselves, or against the healthy machine.

use super::change::floor;
use super::observation::Observation;
use super::settings::FaultSettings;
use crate::diagnose::acquisition::{Fault, clipped, whole_part};
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::signal::spectrum::amplitudes;
use crate::signal::transform::median;
use crate::stats::significance::two_sided;

const SETTINGS: FaultSettings = FaultSettings::DEFAULT;

/// Faults in the samples of recordings, which are cut to where nothing is missing.
pub fn in_samples(recordings: &mut [Recording], baseline: &[Recording]) -> Vec<Fault> {
    let mut faults = clipped(recordings);
    // A sensor that is too small for the healthy machine has not failed since.
    let known = clipped(baseline);
    let channel = |fault: &Fault| fault.effect.text(ParameterKey::Channel).map(str::to_owned);
    faults.retain(|fault| known.iter().all(|k| channel(k) != channel(fault)));
    faults.extend(whole_part(recordings));
    faults.extend(CHANNELS.into_iter().enumerate().filter_map(|(n, name)| offset(recordings, baseline, n, name)));
    faults
}

/// Offset of a channel against the healthy machine, where gravity and the sensor's own are the same.
fn offset(recordings: &[Recording], baseline: &[Recording], channel: usize, name: &str) -> Option<Fault> {
    let levels = |of: &[Recording]| -> Vec<(f64, f64)> {
        let samples = of.iter().filter_map(|r| accelerations(r)[channel]);
        let level = |samples: &[f64]| {
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            (mean, (samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt())
        };
        samples.map(|c| level(&c.samples)).collect()
    };
    let (now, then) = (levels(recordings), levels(baseline));
    let middle = |of: &[(f64, f64)], part: fn(&(f64, f64)) -> f64| median(&mut of.iter().map(part).collect::<Vec<_>>());
    let change = middle(&now, |l| l.0)? - middle(&then, |l| l.0)?;
    let rms = middle(&now, |l| l.1)?;
    let healthy = middle(&then, |l| l.0)?;
    let scatter = then.iter().map(|l| (l.0 - healthy).abs()).fold(0.0, f64::max);
    let alike = now.iter().all(|l| ((l.0 - healthy) / change - 1.0).abs() < SETTINGS.offset_alike);
    let [of_rms, of_scatter] = SETTINGS.offset;
    (alike && change.abs() > of_rms * rms && change.abs() > of_scatter * scatter).then(|| Fault {
        effect: EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, change)])
            .with_text(ParameterKey::Channel, name),
        evidence: format!(
            "{name} has a mean {change:.3} m/s² from that of the healthy machine in every recording, {:.1} times the vibration's RMS; \
             the healthy machine's means differ by {scatter:.3} m/s².",
            change.abs() / rms
        ),
        p_value: two_sided(change / scatter.max(f64::MIN_POSITIVE)),
        probability: SETTINGS.probability,
    })
}

/// Line of the mains that the healthy machine has not: fixed in Hz, and no order of the shaft.
pub fn mains(recordings: &[Observation], baseline: &[Observation]) -> Option<Fault> {
    let of = |channel: usize, hz: f64| {
        let lines: Vec<Line> = recordings
            .iter()
            .filter(|r| !meets_an_order(r.shaft_hz, hz))
            .filter_map(|r| {
                let now = line(r, channel, hz)?;
                let healthy = r.matches(baseline).into_iter().filter_map(|m| Some(line(m, channel, hz)?.amplitude));
                let then = healthy.reduce(f64::max)?;
                Some(Line { change_db: 20.0 * (now.amplitude / then).log10(), ..now })
            })
            .collect();
        let least = |part: fn(&Line) -> f64| lines.iter().map(part).reduce(f64::min);
        let weakest = Line {
            prominence_db: least(|l| l.prominence_db)?,
            change_db: least(|l| l.change_db)?,
            amplitude: least(|l| l.amplitude)?,
        };
        let [prominence_db, change_db] = SETTINGS.mains;
        let stands = weakest.prominence_db > prominence_db && weakest.change_db > change_db;
        stands.then_some((channel, hz, weakest, lines.len()))
    };
    let all = (0..CHANNELS.len()).flat_map(|channel| [50.0, 60.0].map(|hz| (channel, hz)));
    let found = all.filter_map(|(channel, hz)| of(channel, hz));
    let (channel, hz, line, count) = found.max_by(|a, b| a.2.change_db.total_cmp(&b.2.change_db))?;
    Some(Fault {
        effect: EffectEntry::new(
            EffectKind::MainsInterference,
            &[(ParameterKey::FrequencyHz, hz), (ParameterKey::Amplitude, line.amplitude)],
        ),
        evidence: format!(
            "{}: a line at {hz:.0} Hz, which is no order of the shaft, is at least {:.0} dB over what is around it and \
             {:.0} dB over the healthy machine's in {count} of {} recordings.",
            CHANNELS[channel],
            line.prominence_db,
            line.change_db,
            recordings.len()
        ),
        // Powers of noise are exponential, and this is over their median.
        p_value: 0.5f64.powf(10f64.powf(0.1 * line.prominence_db)),
        probability: SETTINGS.probability,
    })
}

/// A line of fixed frequency in a channel.
struct Line {
    /// Power over the median of what is around it, dB.
    prominence_db: f64,
    /// Amplitude over the greatest of the healthy machine, dB; 0 where it is not compared.
    change_db: f64,
    /// Amplitude, m/s².
    amplitude: f64,
}

fn meets_an_order(shaft_hz: f64, hz: f64) -> bool {
    let order = 2.0 * hz / shaft_hz;
    (order - order.round()).abs() < SETTINGS.order_guard * order
}

/// Strongest line of a channel near a frequency.
fn line(recording: &Observation, channel: usize, hz: f64) -> Option<Line> {
    let spectrum = amplitudes(&[recording.channels[channel].as_deref()?], recording.sample_rate_hz)?;
    let centre = (hz / spectrum.step_hz).round() as usize;
    let reach = 1 + (SETTINGS.mains_reach * hz / spectrum.step_hz) as usize;
    let near = spectrum.values.get(centre.saturating_sub(reach)..centre + reach + 1)?;
    let most = near.iter().copied().fold(0.0, f64::max);
    let floor = floor(&spectrum, hz, SETTINGS.mains_around_hz)?;
    let prominence_db = 10.0 * (most * most / floor).log10();
    Some(Line { prominence_db, change_db: 0.0, amplitude: most.max(1e-15) })
}
