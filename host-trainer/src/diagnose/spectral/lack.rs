//! Lack of fit: what a prediction leaves in each channel, band by band and line by line, and levels that are others in some
//! recordings.

use super::colour::Colour;
use super::data::{Data, Point};
use super::density::shape_of;
use super::settings::{LackSettings, LikelihoodSettings};
use crate::diagnose::result::{Aspect, Test};
use crate::identify::likelihood::observed::CHANNELS;
use crate::signal::transform::median;
use crate::stats::significance::two_sided;

const SETTINGS: LackSettings = LackSettings::DEFAULT;
const LIKELIHOOD: LikelihoodSettings = LikelihoodSettings::DEFAULT;

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

/// Lack of fit of the fitted and the held-out recordings of a machine, each with its data and point: also how far the level of each
/// recording is from the middle of all. The colours of the noise take up a level that is another one in some recordings.
pub fn lack_of_both(parts: [(&Data, &Point); 2]) -> [Lack; 2] {
    let colours = parts.map(|(data, at)| (0..data.observations.len()).map(|n| at.colour_in(n)).collect::<Vec<_>>());
    let middle = |channel: usize, knot: usize| {
        let mut values: Vec<f64> = colours.iter().flatten().map(|colour| colour[channel][knot]).collect();
        median(&mut values).unwrap_or_default()
    };
    let middle: Colour = std::array::from_fn(|channel| std::array::from_fn(|knot| middle(channel, knot)));
    std::array::from_fn(|part| {
        let (data, at) = parts[part];
        let mut lack = lack(data, at);
        for (nats, colour) in lack.nats.iter_mut().zip(&colours[part]) {
            *nats += (level_nats(colour, &middle) - SETTINGS.level_nats).max(0.0);
        }
        lack
    })
}

/// −ln of the prior of how far the levels of the channels are from those of another colour: a level is what all knots share.
pub fn level_nats(colour: &Colour, other: &Colour) -> f64 {
    let level = |channel: usize| {
        let apart = colour[channel].iter().zip(&other[channel]).map(|(a, b)| a - b);
        let (least, greatest) =
            apart.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), d| (least.min(d), greatest.max(d)));
        least.max(0.0) - greatest.min(0.0)
    };
    (0..CHANNELS.len()).map(|channel| 0.5 * (level(channel) / LIKELIHOOD.level_np).powi(2)).sum()
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
                let entry = own.entry(band_of(hz)).or_default();
                // The bins of a spread line are off alike: together they would count as many times.
                let weight = 1.0 - expected.skirt_share();
                let power = (expected.power / expected.mean()).min(SETTINGS.most_power);
                entry.0 += weight * (power - SETTINGS.mean_power);
                entry.1 += weight.powi(2);
                if excess > SETTINGS.line_nats {
                    lack.nats[recording] += excess - SETTINGS.line_nats;
                    lines.push((hz, hz / spectrum.observation.condition.shaft_hz, excess));
                }
            }
            for (band, (sum, count)) in own {
                let z = sum / count.max(1.0).sqrt();
                lack.nats[recording] += (0.5 * z * z - SETTINGS.band_nats).max(0.0);
                let all = bands.entry(band).or_default();
                all.0 += sum;
                all.1 += count;
            }
        }
        for (band, (sum, count)) in bands {
            let z = sum / count.max(1.0).sqrt();
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

/// Gain of −ln L, beyond chance, by one factor of the noise and one of the lines in each band, the same in all recordings. It also
/// shows what is below chance in each of them, and lines that are weaker than predicted.
pub fn shared_lack(data: &Data, at: &Point) -> f64 {
    let mut nats = 0.0;
    for channel in 0..CHANNELS.len() {
        let mut bands = std::collections::BTreeMap::<(i64, bool), Factor>::new();
        for recording in 0..data.observations.len() {
            let spectrum = data.channel(at, recording, channel);
            for expected in spectrum.bins() {
                let (hz, share) = (spectrum.observation.hz(expected.k as f64), expected.line_share());
                let (power, shape) = ((expected.power / expected.mean()).min(SETTINGS.most_power), shape_of(share));
                let factor = bands.entry((band_of(hz), share > SETTINGS.line_share)).or_default();
                factor.shape += shape;
                factor.sum += shape * power / SETTINGS.mean_power;
            }
        }
        nats += bands.values().map(|factor| (factor.gain() - SETTINGS.factor_nats).max(0.0)).sum::<f64>();
    }
    nats
}

/// Factor of bins' means, whose powers over them are gamma-distributed.
#[derive(Clone, Copy, Default)]
struct Factor {
    /// Sum of the shapes.
    shape: f64,
    /// Sum of powers over means, each times its shape.
    sum: f64,
}

impl Factor {
    /// Gain of −ln L by the best factor.
    fn gain(self) -> f64 {
        let ratio = (self.sum / self.shape.max(1e-9)).max(1e-9);
        self.shape * (ratio - 1.0 - ratio.ln())
    }
}

/// Number of the band of a frequency.
fn band_of(hz: f64) -> i64 {
    (SETTINGS.bands_per_octave * (hz / 1000.0).log2()).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::colour::KNOTS;
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::diagnose::spectral::settings::GateSettings;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::rig::EffectEntry;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::nominal;

    #[test]
    fn a_level_is_what_all_knots_share() {
        let of = |ax: [f64; 2], ay: f64| -> Colour {
            [std::array::from_fn(|knot| ax[usize::from(2 * knot > KNOTS)]), [ay; KNOTS], [0.0; KNOTS]]
        };
        let nats = |ax, ay| level_nats(&of(ax, ay), &of([0.1; 2], 0.0));
        let of_level = |level: f64| 0.5 * (level / LIKELIHOOD.level_np).powi(2);
        assert!((nats([0.4, 0.6], 0.0) - of_level(0.3)).abs() < 1e-9);
        assert!((nats([0.0, -0.2], -0.3) - of_level(0.1) - of_level(0.3)).abs() < 1e-9);
        assert_eq!(nats([0.0, 0.6], 0.0), 0.0);
    }

    /// Of a healthy machine, and of one of a somewhat greater damping, whose noise in each recording is within chance.
    #[test]
    fn invariant_what_all_recordings_lack_together_adds_up() {
        let of = |damping: f64| {
            let mut rig = nominal();
            let machine = rig.bearing().unwrap().resonator.damping_n_s_per_m;
            rig = rig.with_effect(
                EffectEntry::new(EffectKind::DampingChange, &[(ParameterKey::Value, damping * machine)])
                    .with_text(ParameterKey::Component, "resonator"),
            );
            let observations = [400.0, 520.0, 640.0, 760.0, 880.0, 1000.0]
                .map(|load_n| observed(&rig, load_n, &Point::default().in_recordings(1, 0)));
            let orders = rig.bearing().unwrap().bearing.geometry().orders();
            let data = Data::new(&observations, orders, UnevenMachines::default());
            let model = Model::fixed(&data, nominal());
            let point = model.search(model.start().unwrap(), 4).unwrap();
            (lack(&data, &point).total(), shared_lack(&data, &point))
        };
        let [(_, healthy), (own, shared)] = [of(1.0), of(1.3)];
        assert!(
            healthy < 5.0 && shared > 2.0 * own && shared > GateSettings::DEFAULT.second_shared_lack,
            "{healthy} {own} {shared}"
        );
    }
}
