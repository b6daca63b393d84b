//! Missing term of a cause as a curve: force over state, angle or time, depth over angle, gain over frequency.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::diagnose::result::Term;
use crate::rig::EffectEntry;
use crate::rig::config::{BearingRig, RigKind};
use crate::rig::effect::local_defect::profile;
use crate::rig::effect::{EffectKind, ParameterKey};

/// Points of a curve.
const POINTS: usize = 41;
/// Speed over which a force of friction is shown, m/s.
const SPEED_M_PER_S: f64 = 5e-4;

/// Term of an effect under a load, N; `band` are the ends of its strength's 95 % interval over the strength.
pub fn term(effect: &EffectEntry, rig: &BearingRig, load_n: f64, band: [f64; 2]) -> Option<Term> {
    use ParameterKey::{
        AngleRad, Component, CubicNPerM3, DampingNSPerM, DampingRatio, DragNS2PerM2, DurationS, ForceN, FrequencyHz,
        Gain, GapM, ImpulseNS, PhaseRad, QuadraticNPerM2, StiffnessNPerM, UnbalanceKgM, WidthRad,
    };
    let number = |key| effect.number(key).unwrap_or_default();
    let place = effect.text(Component).unwrap_or("inner-y").to_owned();
    let still = load_n.abs() / (rig.inner.stiffness_n_per_m + rig.outer.stiffness_n_per_m).max(1.0);
    let reach = 1.5 * still.max(1e-7);
    type Law<'l> = Box<dyn Fn(f64) -> f64 + 'l>;
    let (force_on, depends_on, [from, to], unit, law): (String, String, [f64; 2], &str, Law) = match effect.kind {
        EffectKind::HardeningStiffness | EffectKind::SofteningStiffness => {
            let k = number(CubicNPerM3);
            (place.clone(), place, [-reach, reach], "N", Box::new(move |q| -k * q.powi(3)))
        }
        EffectKind::AsymmetricStiffness => {
            let k = number(QuadraticNPerM2);
            (place.clone(), place, [-reach, reach], "N", Box::new(move |q| -k * q * q))
        }
        EffectKind::EndStopContact => {
            let (gap, k) = (number(GapM), number(StiffnessNPerM));
            (place.clone(), place, [0.0, 1.5 * gap.max(reach)], "N", Box::new(move |q| -k * (q - gap).max(0.0)))
        }
        EffectKind::CoulombFriction => {
            let (force, speed) = (number(ForceN), number(ParameterKey::RegularisationMPerS).max(1e-9));
            let law: Law = Box::new(move |v| -force * (v / speed).tanh());
            (place.clone(), format!("speed of {place}"), [-SPEED_M_PER_S, SPEED_M_PER_S], "N", law)
        }
        EffectKind::ViscousFriction => {
            let c = number(DampingNSPerM);
            let law: Law = Box::new(move |v| -c * v);
            (place.clone(), format!("speed of {place}"), [-SPEED_M_PER_S, SPEED_M_PER_S], "N", law)
        }
        EffectKind::QuadraticDrag => {
            let d = number(DragNS2PerM2);
            let law: Law = Box::new(move |v| -d * v * v.abs());
            (place.clone(), format!("speed of {place}"), [-SPEED_M_PER_S, SPEED_M_PER_S], "N", law)
        }
        EffectKind::Unbalance => {
            let u = number(UnbalanceKgM) - rig.excitation.unbalance_kg_m;
            let law: Law = Box::new(move |angle| u * angle.sin());
            ("inner-y".into(), "shaft angle".into(), [0.0, TAU], "kg m (times the square of the speed)", law)
        }
        EffectKind::Misalignment => {
            let (force, phase) = (number(ForceN), number(PhaseRad));
            let law: Law = Box::new(move |angle| force * (2.0 * angle + phase).sin());
            ("inner-y".into(), "shaft angle".into(), [0.0, TAU], "N", law)
        }
        EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect => {
            let (loss, width, at) = (profile(effect)?, number(WidthRad), number(AngleRad));
            let law: Law = Box::new(move |angle| loss(angle - at));
            ("contact".into(), "angle on the part".into(), [at - width, at + width], "m", law)
        }
        EffectKind::StructuralResonance => {
            let (hz, ratio, gain) = (number(FrequencyHz), number(DampingRatio), number(Gain));
            let law: Law = Box::new(move |at: f64| {
                let r = at / hz;
                gain * r * r / ((1.0 - r * r).powi(2) + (2.0 * ratio * r).powi(2)).sqrt()
            });
            let channel = effect.text(ParameterKey::Channel).unwrap_or("ay").to_owned();
            (channel, "frequency, Hz".into(), [0.5 * hz, 1.5 * hz], "1", law)
        }
        EffectKind::Shock => {
            let (impulse, duration) = (number(ImpulseNS), number(DurationS).max(1e-9));
            let law: Law = Box::new(move |t: f64| {
                let inside = (0.0..duration).contains(&t);
                if inside { FRAC_PI_2 * impulse / duration * (PI * t / duration).sin() } else { 0.0 }
            });
            (place, "time after the event, s".into(), [-0.5 * duration, 1.5 * duration], "N", law)
        }
        EffectKind::LoadStep => {
            let (change, rise) = (number(ParameterKey::ChangeN), number(ParameterKey::RiseS).max(1e-9));
            let law: Law = Box::new(move |t: f64| change * (t / rise + 0.5).clamp(0.0, 1.0));
            ("inner-y".into(), "time after the event, s".into(), [-2.0 * rise, 2.0 * rise], "N", law)
        }
        _ => return None,
    };
    let point = |n: usize| {
        let x = from + (to - from) * n as f64 / (POINTS - 1) as f64;
        let value = law(x);
        let ends = band.map(|share| share * value);
        [x, value, ends[0].min(ends[1]), ends[0].max(ends[1])]
    };
    let curve = (0..POINTS).map(point).collect();
    Some(Term { force_on, depends_on, equation: effect.equation(RigKind::Bearing5Dof), curve, unit: unit.into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::nominal;

    #[test]
    fn a_trough_is_drawn_with_its_bottom() {
        use ParameterKey::{AngleRad, DepthM, Flank, WidthRad};
        let trough = [(DepthM, 2e-6), (WidthRad, 0.1), (AngleRad, 1.5), (Flank, 0.1)];
        let trough = EffectEntry::new(EffectKind::OuterRaceDefect, &trough);
        let drawn = term(&trough, nominal().bearing().unwrap(), 500.0, [1.0, 1.0]).unwrap();
        // Of twice its width, a part of 0.4 is bottom.
        let deepest = drawn.curve.iter().filter(|[_, depth, ..]| *depth == 2e-6).count();
        assert!((15..=17).contains(&deepest), "{deepest} of {POINTS}");
    }
}
