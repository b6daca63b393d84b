//! Checks of what is stated about recordings against the rig that they are compared with.

use super::config::{BearingRig, Machine, Rig};
use super::error::RigError;
use super::settings::ConditionLimits;
use crate::recording::{Channel, Recording};

const LIMITS: ConditionLimits = ConditionLimits::DEFAULT;

/// Checks places of sensors, and speeds, of recordings of a bearing rig; an sdof rig has neither.
///
/// # Errors
/// A sensor that the rig has elsewhere or not at all, two in one place, a speed that no such bearing runs at or that is too
/// fast for the sample rate.
pub fn check_stated(rig: &Rig, recordings: &[Recording]) -> Result<(), RigError> {
    let Machine::Bearing(rig) = &rig.model else { return Ok(()) };
    for recording in recordings {
        check_places(rig, recording)?;
        if let Some(shaft_hz) = recording.shaft_hz {
            check_speed(rig, shaft_hz, recording.sample_rate_hz, &recording.source.to_string())?;
        }
    }
    Ok(())
}

/// Checks a stated speed; `place` is what states it.
///
/// # Errors
/// A speed that no such bearing runs at, or that is too fast for the sample rate.
pub fn check_speed(rig: &BearingRig, shaft_hz: f64, sample_rate_hz: f64, place: &str) -> Result<(), RigError> {
    let refuse = |expected: String| {
        Err(RigError::BadRecording { place: format!("{place}, shaft_hz"), found: shaft_hz.to_string(), expected })
    };
    let fastest = LIMITS.speed_factor_mm_per_min / (60.0 * 1e3 * rig.bearing.pitch_diameter_m);
    if shaft_hz > fastest {
        return refuse(format!(
            "turns a second, at most {fastest:.0} for a pitch diameter of {} m; {shaft_hz} turns a minute are {:.3}",
            rig.bearing.pitch_diameter_m,
            shaft_hz / 60.0
        ));
    }
    if shaft_hz >= 0.5 * sample_rate_hz {
        return refuse(format!("less than half the sample rate of {sample_rate_hz} Hz"));
    }
    Ok(())
}

fn check_places(rig: &BearingRig, recording: &Recording) -> Result<(), RigError> {
    let sensors = [("ax", "horizontal", rig.sensor.horizontal), ("ay", "vertical", rig.sensor.vertical)];
    let mut taken: Vec<&Channel> = Vec::new();
    for channel in recording.channels.iter().filter(|channel| channel.is_acceleration()) {
        let Some(place) = channel.location.as_deref() else { continue };
        let refuse = |found: String, expected: String| {
            let place = format!("{}, channels.{}", recording.source, channel.name);
            Err(RigError::BadRecording { place, found, expected })
        };
        if let Some(other) = taken.iter().find(|other| other.location.as_deref() == Some(place)) {
            return refuse(format!("`{place}`, where `{}` is", other.name), "one channel for each place".into());
        }
        taken.push(channel);
        if channel.is_at_default() {
            continue;
        }
        let own = sensors.iter().find(|(name, ..)| *name == channel.name);
        if let Some((_, key, sensor)) = own.filter(|(.., sensor)| sensor.name() != place) {
            return refuse(format!("`{place}`"), format!("`{}`, where the rig has sensor.{key}", sensor.name()));
        }
        if own.is_none() && !sensors.iter().any(|(.., sensor)| sensor.name() == place) {
            let places = sensors.map(|(.., sensor)| format!("`{}`", sensor.name())).join(" or ");
            return refuse(format!("`{place}`"), format!("a place where the rig has a sensor: {places}"));
        }
    }
    Ok(())
}
