//! Gain of the balls' deflection over the lobes of a race. No race has one number of lobes alone: those of one lobe more and less
//! have sizes and phases of their own.

use std::f64::consts::{PI, TAU};
use std::iter;

use super::{Parameter, ParameterDefault, ParameterKey, Scale, Values};
use crate::rig::{assembly::Assembly, config::Domain, state::Instant};

/// Parameters of the lobes on either race.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::number(ParameterKey::AmplitudeM, "m", Domain::NotNegative, (1e-9, 1e-5), Scale::Log),
    Parameter::number(ParameterKey::Lobes, "", Domain::Whole(1, 1000), (2.0, 60.0), Scale::Each),
    Parameter::number(ParameterKey::PhaseRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
        .usually(ParameterDefault::Number(0.0)),
    share(ParameterKey::BelowCos),
    share(ParameterKey::BelowSin),
    share(ParameterKey::AboveCos),
    share(ParameterKey::AboveSin),
];

/// Part of a neighbouring wave, as a share of the main one.
const fn share(key: ParameterKey) -> Parameter {
    Parameter::number(key, "", Domain::Any, (-1.0, 1.0), Scale::Linear).usually(ParameterDefault::Number(0.0))
}

/// Wave around a race: amplitude · cos(lobes · angle + phase).
struct Wave {
    lobes: f64,
    amplitude_m: f64,
    phase_rad: f64,
}

/// Wave of the lobes, and those of one less and one more that are there.
fn waves(v: &Values) -> impl Iterator<Item = Wave> {
    use ParameterKey::{AboveCos, AboveSin, AmplitudeM, BelowCos, BelowSin, Lobes, PhaseRad};
    let (lobes, size) = (v.number(Lobes), v.number(AmplitudeM));
    let beside = |lobes: f64, cosine: ParameterKey, sine: ParameterKey| {
        let (cosine, sine) = (v.number(cosine), v.number(sine));
        Wave { lobes, amplitude_m: size * cosine.hypot(sine), phase_rad: (-sine).atan2(cosine) }
    };
    let main = Wave { lobes, amplitude_m: size, phase_rad: v.number(PhaseRad) };
    let beside = [beside(lobes - 1.0, BelowCos, BelowSin), beside(lobes + 1.0, AboveCos, AboveSin)];
    iter::once(main).chain(beside.into_iter().filter(|wave| wave.amplitude_m != 0.0))
}

/// The term added to δ_j, `angle` being the ball's angle on the race in the rig's symbols.
pub(super) fn equation(v: &Values, angle: &str) -> String {
    let each = waves(v).map(|Wave { lobes, amplitude_m, phase_rad }| {
        format!("{amplitude_m:.3e} m · cos({lobes}·{angle} + {phase_rad:.3})")
    });
    format!("δ_j = … − c + {}", each.collect::<Vec<_>>().join(" + "))
}

/// Lobes that ball 0 meets at `angle` of the race, rad.
pub(super) fn apply(v: &Values, assembly: &mut Assembly, angle: fn(&Instant) -> f64) {
    let Some(rig) = assembly.bearing() else { return };
    let balls = rig.bearing.balls as f64;
    for Wave { lobes, amplitude_m, phase_rad } in waves(v).filter(|wave| wave.amplitude_m != 0.0) {
        // From ball to ball by rotation: one sine and cosine for all.
        let (s_step, c_step) = (lobes * TAU / balls).sin_cos();
        assembly.profile(move |at, losses| {
            let (mut s, mut c) = (lobes * angle(at) + phase_rad).sin_cos();
            for loss in losses {
                *loss -= amplitude_m * c;
                (s, c) = (s * c_step + c * s_step, c * c_step - s * s_step);
            }
        });
    }
}
