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
    let z = change.abs() / (rms / of_rms).max(scatter / of_scatter);
    (alike && change.abs() > of_rms * rms && change.abs() > of_scatter * scatter).then(|| Fault {
        effect: EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, change)])
            .with_text(ParameterKey::Channel, name),
        evidence: format!(
            "{name} has a mean {change:.3} m/s² from that of the healthy machine in every recording, {:.1} times the vibration's RMS; \
             the healthy machine's means differ by {scatter:.3} m/s².",
            change.abs() / rms
        ),
        p_value: two_sided(z),
        probability: SETTINGS.probability,
    })
}

/// Line of the mains that the healthy machine has not: fixed in Hz, and no order of the shaft.
pub fn mains(recordings: &[Observation], baseline: &[Observation]) -> Option<Fault> {
    let of = |channel: usize, hz: f64| {
        let lines: Vec<(f64, f64, f64)> = recordings
            .iter()
            .filter(|r| !meets_an_order(r.shaft_hz, hz))
            .filter_map(|r| {
                let [now, size] = line(r, channel, hz)?;
                let healthy: Vec<f64> =
                    r.matches(baseline).iter().filter_map(|m| Some(line(m, channel, hz)?[1])).collect();
                let then = healthy.iter().copied().reduce(f64::max)?;
                Some((now, 20.0 * (size / then).log10(), size))
            })
            .collect();
        let least = |part: fn(&(f64, f64, f64)) -> f64| lines.iter().map(part).fold(f64::INFINITY, f64::min);
        let (prominence, change) = (least(|l| l.0), least(|l| l.1));
        let stands = !lines.is_empty() && prominence > SETTINGS.mains[0] && change > SETTINGS.mains[1];
        stands.then_some((channel, hz, prominence, change, least(|l| l.2), lines.len()))
    };
    let all = (0..CHANNELS.len()).flat_map(|channel| [50.0, 60.0].map(|hz| (channel, hz)));
    let most = all.filter_map(|(channel, hz)| of(channel, hz)).max_by(|a, b| a.3.total_cmp(&b.3));
    most.map(|(channel, hz, prominence, change, amplitude, count)| Fault {
        effect: EffectEntry::new(
            EffectKind::MainsInterference,
            &[(ParameterKey::FrequencyHz, hz), (ParameterKey::Amplitude, amplitude)],
        ),
        evidence: format!(
            "{}: a line at {hz:.0} Hz, which is no order of the shaft, is at least {prominence:.0} dB over what is around it and \
             {change:.0} dB over the healthy machine's in {count} of {} recordings.",
            CHANNELS[channel],
            recordings.len()
        ),
        p_value: two_sided(prominence / SETTINGS.mains[0] * 4.0),
        probability: SETTINGS.probability,
    })
}

fn meets_an_order(shaft_hz: f64, hz: f64) -> bool {
    let order = 2.0 * hz / shaft_hz;
    (order - order.round()).abs() < SETTINGS.order_guard * order
}

/// Prominence of a line, dB, and its amplitude.
fn line(recording: &Observation, channel: usize, hz: f64) -> Option<[f64; 2]> {
    let spectrum = amplitudes(&[recording.channels[channel].as_deref()?], recording.sample_rate_hz)?;
    let centre = (hz / spectrum.step_hz).round() as usize;
    let reach = 1 + (SETTINGS.mains_reach * hz / spectrum.step_hz) as usize;
    let near = spectrum.values.get(centre.saturating_sub(reach)..centre + reach + 1)?;
    let most = near.iter().copied().fold(0.0, f64::max);
    let floor = floor(&spectrum, hz, SETTINGS.mains_around_hz)?;
    Some([10.0 * (most * most / floor).log10(), most.max(1e-15)])
}
