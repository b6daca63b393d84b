//! Location of a mismatch in time, frequency, order, angle, state and channel.

use super::result::{Aspect, Location, Test};
use crate::rig::Rig;
use crate::rig::effect::ParameterKey;

/// Share of the most telling test's standard deviations from which another of its aspect counts.
const TELLING: f64 = 0.1;
/// Share of an order by which two lines differ that are the same.
const SAME_LINE: f64 = 5e-3;
/// How many orders are named, of the signal and of its envelope each.
const ORDERS: usize = 4;

/// Location of the mismatch by the significant tests, in the channel of the most significant, and by the causes that the
/// corrected rig has in addition.
pub fn locate(before: &Rig, corrected: &Rig, tests: &[Test]) -> Location {
    let standing: Vec<&Test> = tests.iter().filter(|t| t.is_significant()).collect();
    let new = || corrected.effects.iter().skip(before.effects.len());
    let told = standing.iter().find(|t| !t.channel.is_empty()).map(|t| t.channel);
    // What a sensor does has been taken out before.
    let channel = told.or_else(|| new().find_map(|effect| effect.text(ParameterKey::Channel))).unwrap_or_default();
    let of = |aspect: Aspect| -> Vec<[f64; 2]> {
        // Of angles those with more power: there is less at all others.
        let counts = |t: &&&Test| aspect != Aspect::ShaftAngle || t.z > 0.0;
        let all = || standing.iter().filter(|t| t.aspect == aspect && t.channel == channel).filter(counts);
        let most = all().map(|t| t.z.abs()).fold(0.0, f64::max);
        let mut at: Vec<[f64; 2]> = all().filter(|t| t.z.abs() >= TELLING * most).filter_map(|t| t.at).collect();
        at.sort_by(|a, b| a[0].total_cmp(&b[0]));
        at
    };
    let orders = |aspect: Aspect| {
        let found = standing.iter().filter(move |t| t.aspect == aspect && t.channel == channel).filter_map(|t| t.at);
        found.map(|[order, _]| (1e3 * order).round() / 1e3).take(ORDERS)
    };
    let mut order: Vec<f64> = orders(Aspect::Order).chain(orders(Aspect::Envelope)).collect();
    order.sort_by(f64::total_cmp);
    order.dedup_by(|next, last| *next - *last < SAME_LINE * *next);
    let mut angle_rad = Vec::new();
    let mut states = Vec::new();
    for effect in new() {
        if let (Some(angle), Some(width)) =
            (effect.number(ParameterKey::AngleRad), effect.number(ParameterKey::WidthRad))
        {
            angle_rad.push([angle - 0.5 * width, angle + 0.5 * width]);
        }
        if let Some(component) = effect.text(ParameterKey::Component) {
            states.push(format!("motion of {component}"));
        }
    }
    if angle_rad.is_empty() {
        angle_rad = joined(of(Aspect::ShaftAngle));
    }
    states.extend(standing.iter().find(|t| is_state(t) && t.channel == channel).map(|t| t.what.clone()));
    Location {
        time_s: joined(of(Aspect::Time)),
        frequency_hz: joined(of(Aspect::Spectrum)),
        order,
        angle_rad,
        state: states.join("; "),
        channel: channel.into(),
    }
}

fn is_state(test: &Test) -> bool {
    matches!(test.aspect, Aspect::Displacement | Aspect::Velocity)
}

/// Neighbours as one.
fn joined(intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut out: Vec<[f64; 2]> = Vec::new();
    for [from, to] in intervals {
        match out.last_mut() {
            Some(last) if from <= last[1] * (1.0 + 1e-9) => last[1] = to,
            _ => out.push([from, to]),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::EffectEntry;
    use crate::rig::effect::EffectKind;
    use crate::rig::test_support::nominal;

    fn test(aspect: Aspect, channel: &'static str, at: [f64; 2], z: f64, q_value: f64) -> Test {
        let what = format!("{channel}, {}", aspect.text());
        Test { aspect, channel, at: Some(at), what, z, p_value: 0.1 * q_value, q_value }
    }

    #[test]
    fn a_mismatch_is_where_the_tests_of_one_channel_stand_out() {
        let tests = [
            test(Aspect::Spectrum, "ay", [400.0, 800.0], 90.0, 1e-30),
            test(Aspect::Spectrum, "ay", [800.0, 1200.0], -20.0, 1e-20),
            // Less than a tenth as telling; another channel; nothing.
            test(Aspect::Spectrum, "ay", [2000.0, 2400.0], 8.0, 1e-10),
            test(Aspect::Spectrum, "ax", [4000.0, 4400.0], 30.0, 1e-20),
            test(Aspect::Time, "ay", [0.5, 0.525], 2.0, 0.5),
            test(Aspect::Order, "ay", [3.585, 3.585], 12.0, 1e-12),
            test(Aspect::Envelope, "ay", [3.587, 3.587], 12.0, 1e-12),
            test(Aspect::Order, "ay", [1.0, 1.0], 9.0, 1e-9),
            test(Aspect::ShaftAngle, "ay", [0.5, 1.0], 9.0, 1e-9),
            test(Aspect::ShaftAngle, "ay", [1.0, 1.5], -9.0, 1e-9),
        ];
        let found = locate(&nominal(), &nominal(), &tests);
        assert_eq!(found.channel, "ay");
        assert_eq!(found.frequency_hz, [[400.0, 1200.0]]);
        assert_eq!((found.time_s, found.order, found.angle_rad), (vec![], vec![1.0, 3.585], vec![[0.5, 1.0]]));
    }

    #[test]
    fn what_a_cause_says_of_its_place_counts_though_no_test_stands_out() {
        let friction = EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 1.0)])
            .with_text(ParameterKey::Component, "outer");
        let bias = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, 0.1)])
            .with_text(ParameterKey::Channel, "ax");
        let found = locate(&nominal(), &nominal().with_effect(friction).with_effect(bias), &[]);
        assert_eq!((found.state.as_str(), found.channel.as_str()), ("motion of outer", "ax"));
        assert!(found.frequency_hz.is_empty() && found.order.is_empty());
    }
}
