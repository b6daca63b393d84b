//! Gain of the balls' deflection over the lobes of a race. No race has one number of lobes alone: those of one lobe more and less
//! may be a share of it.

use std::f64::consts::{PI, TAU};

use super::{Parameter, ParameterDefault, ParameterKey, Scale, Values};
use crate::rig::{assembly::Assembly, config::Domain, state::Instant};

/// Parameters of the lobes on either race.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::number(ParameterKey::AmplitudeM, "m", Domain::NotNegative, (1e-9, 1e-5), Scale::Log),
    Parameter::number(ParameterKey::Lobes, "", Domain::Whole(1, 1000), (2.0, 60.0), Scale::Each),
    Parameter::number(ParameterKey::PhaseRad, "rad", Domain::Any, (-PI, PI), Scale::Linear)
        .usually(ParameterDefault::Number(0.0)),
    Parameter::number(ParameterKey::Neighbours, "", Domain::Any, (-1.0, 1.0), Scale::Linear)
        .usually(ParameterDefault::Number(0.0)),
];

/// The term added to δ_j, `angle` being the ball's angle on the race in the rig's symbols.
pub(super) fn equation(v: &Values, angle: &str) -> String {
    let (amplitude, lobes, phase) =
        (v.number(ParameterKey::AmplitudeM), v.number(ParameterKey::Lobes), v.number(ParameterKey::PhaseRad));
    let beside = match v.number(ParameterKey::Neighbours) * amplitude {
        0.0 => String::new(),
        beside => format!(", and {beside:.3e} m · cos of {} and {} lobes", lobes - 1.0, lobes + 1.0),
    };
    format!("δ_j = … − c + {amplitude:.3e} m · cos({lobes}·{angle} + {phase:.3}){beside}")
}

/// Lobes that ball 0 meets at `angle` of the race, rad.
pub(super) fn apply(v: &Values, assembly: &mut Assembly, angle: fn(&Instant) -> f64) {
    let (amplitude, lobes, phase) =
        (v.number(ParameterKey::AmplitudeM), v.number(ParameterKey::Lobes), v.number(ParameterKey::PhaseRad));
    if amplitude == 0.0 {
        return;
    }
    let Some(rig) = assembly.bearing() else { return };
    let balls = rig.bearing.balls as f64;
    let beside = v.number(ParameterKey::Neighbours) * amplitude;
    let waves = [(lobes, amplitude), (lobes - 1.0, beside), (lobes + 1.0, beside)];
    for (lobes, amplitude) in waves.into_iter().filter(|(_, amplitude)| *amplitude != 0.0) {
        // From ball to ball by rotation: one sine and cosine for all.
        let (s_step, c_step) = (lobes * TAU / balls).sin_cos();
        assembly.profile(move |at, losses| {
            let (mut s, mut c) = (lobes * angle(at) + phase).sin_cos();
            for loss in losses {
                *loss -= amplitude * c;
                (s, c) = (s * c_step + c * s_step, c * c_step - s * s_step);
            }
        });
    }
}
