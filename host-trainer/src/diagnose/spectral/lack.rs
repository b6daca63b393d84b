//! Lack of fit: what a prediction leaves in each channel, band by band and line by line.

use super::data::{Data, Point};
use super::settings::LackSettings;
use crate::diagnose::result::{Aspect, Test};
use crate::identify::likelihood::observed::CHANNELS;
use crate::stats::significance::two_sided;

const SETTINGS: LackSettings = LackSettings::DEFAULT;

/// What a prediction leaves.
#[derive(Clone, Debug, Default)]
pub struct Lack {
    /// −ln L beyond chance of each recording.
    pub nats: Vec<f64>,
    /// Test of each band and strong line.
    pub tests: Vec<Test>,
}

impl Lack {
    /// −ln L beyond chance of all recordings.
    pub fn total(&self) -> f64 {
        self.nats.iter().sum()
    }
}

/// Lack of fit at a point.
pub fn lack(data: &Data, at: &Point) -> Lack {
    let mut lack = Lack { nats: vec![0.0; data.observations.len()], tests: Vec::new() };
    let tried = data.observations.iter().map(|o| CHANNELS.len() * o.bins().len()).sum::<usize>() as f64;
    for (channel, name) in CHANNELS.into_iter().enumerate() {
        let mut bands = std::collections::BTreeMap::<i64, (f64, f64)>::new();
        let mut lines: Vec<(f64, f64, f64)> = Vec::new();
        for recording in 0..data.observations.len() {
            let spectrum = data.channel(at, recording, channel);
            let mut own = std::collections::BTreeMap::<i64, (f64, f64)>::new();
            for expected in spectrum.bins() {
                let hz = spectrum.observation.hz(expected.k as f64);
                let excess = spectrum.bin(&expected).neg_log - expected.mean().ln() - 1.0;
                let band = (SETTINGS.bands_per_octave * (hz / 1000.0).log2()).floor() as i64;
                let entry = own.entry(band).or_default();
                entry.0 += (expected.power / expected.mean()).min(SETTINGS.most_power) - SETTINGS.mean_power;
                entry.1 += 1.0;
                if excess > SETTINGS.line_nats {
                    lack.nats[recording] += excess - SETTINGS.line_nats;
                    lines.push((hz, hz / spectrum.observation.condition.shaft_hz, excess));
                }
            }
            for (band, (sum, count)) in own {
                let z = sum / count.sqrt();
                lack.nats[recording] += (0.5 * z * z - SETTINGS.band_nats).max(0.0);
                let all = bands.entry(band).or_default();
                all.0 += sum;
                all.1 += count;
            }
        }
        for (band, (sum, count)) in bands {
            let z = sum / count.sqrt();
            let edge = |band: i64| 1000.0 * (band as f64 / SETTINGS.bands_per_octave).exp2();
            let [from, to] = [edge(band), edge(band + 1)];
            lack.tests.push(Test {
                aspect: Aspect::Spectrum,
                channel: name,
                at: Some([from, to]),
                what: format!("{name}, power from {from:.0} to {to:.0} Hz"),
                z,
                p_value: two_sided(z),
                q_value: 1.0,
            });
        }
        lines.sort_by(|a, b| b.2.total_cmp(&a.2));
        lines.truncate(SETTINGS.most_lines);
        lack.tests.extend(lines.into_iter().map(|(hz, order, excess)| Test {
            aspect: Aspect::Order,
            channel: name,
            at: Some([order; 2]),
            what: format!("{name}, a line at {hz:.1} Hz, order {order:.3}"),
            z: (2.0 * excess).sqrt(),
            p_value: (tried * (-excess).exp()).min(1.0),
            q_value: 1.0,
        }));
    }
    lack
}
