//! Checks of recordings before they are compared with a rig: what contradicts itself is refused, what is of no use is said.

use crate::recording::{Channel, Recording};
use crate::rig::plausible::check_stated;
use crate::rig::{Machine, Rig, RigError};
use crate::signal::order::ShaftAngle;
use crate::stats::format::significant;

use super::likelihood::observed::accelerations;
use super::likelihood::settings::TachometerSettings;
use super::settings::InputCheckSettings;

const SETTINGS: InputCheckSettings = InputCheckSettings::DEFAULT;
const TACHOMETER: TachometerSettings = TachometerSettings::DEFAULT;

/// Checks recordings of a rig; the result are sentences on what is not used.
///
/// # Errors
/// What [`check_stated`] refuses, a channel that never varies, a stated speed that the tachometer contradicts.
pub fn check(rig: &Rig, recordings: &[Recording]) -> Result<Vec<String>, RigError> {
    check_stated(rig, recordings)?;
    for recording in recordings {
        for channel in &recording.channels {
            check_varies(rig, recording, channel)?;
        }
    }
    let mut notes = Vec::new();
    if matches!(rig.model, Machine::Bearing(_)) {
        for recording in recordings {
            notes.extend(check_tachometer(recording)?);
        }
        notes.extend(missing_channels(recordings));
        notes.extend(very_fast(recordings));
    }
    Ok(notes)
}

/// Checks that no recording of a baseline is also one to diagnose.
///
/// # Errors
/// The first file that is both.
pub fn check_apart(baseline: &[Recording], recordings: &[Recording]) -> Result<(), RigError> {
    let files: Vec<_> = recordings.iter().filter_map(|recording| recording.source.path.canonicalize().ok()).collect();
    let both = baseline.iter().find(|one| one.source.path.canonicalize().is_ok_and(|path| files.contains(&path)));
    both.map_or(Ok(()), |one| {
        Err(RigError::BadRecording {
            place: "baseline".into(),
            found: format!("{}, which is also to be diagnosed", one.source),
            expected: "other recordings, of the healthy machine".into(),
        })
    })
}

/// Reason why a baseline is not of the same machine in about the same condition as the recordings, if there is one.
pub fn other_machine(baseline: &[Recording], recordings: &[Recording]) -> Option<String> {
    let measured = |all: &[Recording]| {
        let there = |k: usize| all.iter().any(|recording| accelerations(recording)[k].is_some());
        [there(0), there(1)]
    };
    let (then, now) = (measured(baseline), measured(recordings));
    if then != [false; 2] && now != [false; 2] && (0..2).all(|k| !(then[k] && now[k])) {
        return Some("its sensors are at none of the recordings' places".into());
    }
    let apart = |what: &str, unit: &str, of: &dyn Fn(&Recording) -> Option<f64>| {
        let (then, now) = (range(baseline, of)?, range(recordings, of)?);
        let apart = then[0] > SETTINGS.condition_ratio * now[1] || now[0] > SETTINGS.condition_ratio * then[1];
        let text = |[low, high]: [f64; 2]| format!("{} to {} {unit}", significant(low, 3), significant(high, 3));
        apart.then(|| format!("its {what} is {}, that of the recordings {}", text(then), text(now)))
    };
    apart("speed", "Hz", &|recording| recording.shaft_hz).or_else(|| apart("load", "N", &|recording| recording.load_n))
}

/// Least and greatest of what all recordings state.
fn range(recordings: &[Recording], of: &dyn Fn(&Recording) -> Option<f64>) -> Option<[f64; 2]> {
    let stated = recordings.iter().map(of).collect::<Option<Vec<f64>>>()?;
    let low = stated.iter().copied().reduce(f64::min)?;
    Some([low, stated.iter().copied().fold(low, f64::max)])
}

fn check_varies(rig: &Rig, recording: &Recording, channel: &Channel) -> Result<(), RigError> {
    let judged = match rig.model {
        Machine::Bearing(_) => channel.is_acceleration(),
        Machine::Sdof(_) => ["q", "qd", "qdd"].contains(&channel.name.as_str()),
    };
    let Some(value) = channel.constant().filter(|_| judged && channel.samples.len() > 1) else { return Ok(()) };
    Err(RigError::BadRecording {
        place: format!("{}, channel `{}`", recording.source, channel.name),
        found: format!("{value} in all {} samples", channel.samples.len()),
        expected:
            "a signal that varies: a flat one is of a dead sensor or an open cable; without this column the others \
                   can be used"
                .into(),
    })
}

/// Sentence on a tachometer that is none or that differs from the stated speed by more than this is known to.
fn check_tachometer(recording: &Recording) -> Result<Option<String>, RigError> {
    let Some(tacho) = recording.channel("tacho") else { return Ok(None) };
    let name = recording.name();
    let angle = match ShaftAngle::from_tacho(&tacho.samples, recording.sample_rate_hz) {
        Ok(angle) => angle,
        Err(error) => return Ok(Some(format!("{name}: the channel tacho is not used, the stated speed is: {error}"))),
    };
    let Some(stated) = recording.shaft_hz.filter(|stated| *stated > 0.0) else { return Ok(None) };
    let ratio = angle.mean_hz() / stated;
    if !(1.0 / TACHOMETER.max_speed_ratio..TACHOMETER.max_speed_ratio).contains(&ratio) {
        let minutes = (ratio * 60.0 - 1.0).abs() < SETTINGS.minute_tolerance;
        let hint = if minutes { ": shaft_hz is in turns a second, not a minute" } else { "" };
        return Err(RigError::BadRecording {
            place: format!("{}, shaft_hz", recording.source),
            found: format!("{stated} Hz"),
            expected: format!("about {} Hz, as the channel tacho says{hint}", significant(angle.mean_hz(), 4)),
        });
    }
    let known = recording.speed_std_hz().unwrap_or_default().max(SETTINGS.least_speed_std * stated);
    let apart = (angle.mean_hz() - stated).abs() > SETTINGS.speed_deviations * known;
    Ok(apart.then(|| {
        let [measured, stated] = [angle.mean_hz(), stated].map(|hz| significant(hz, 4));
        format!("{name}: the channel tacho says {measured} Hz, the manifest {stated} Hz")
    }))
}

/// Sentence on a speed that is more likely one a minute, where no tachometer tells.
fn very_fast(recordings: &[Recording]) -> Option<String> {
    let fast = |recording: &&Recording| {
        recording.channel("tacho").is_none() && recording.shaft_hz.is_some_and(|hz| hz >= SETTINGS.very_fast_hz)
    };
    let recording = recordings.iter().find(fast)?;
    let hz = recording.shaft_hz?;
    let (name, minutes) = (recording.name(), hz / 60.0);
    Some(format!("{name}: shaft_hz is {hz}, turns a second; if that is turns a minute, state {minutes:.3}"))
}

/// Sentences on recordings without a channel that others have.
fn missing_channels(recordings: &[Recording]) -> Vec<String> {
    let lacking = |(k, name): (usize, &str)| {
        let without: Vec<_> =
            recordings.iter().filter(|r| accelerations(r)[k].is_none()).map(Recording::name).collect();
        let some = !without.is_empty() && without.len() < recordings.len();
        some.then(|| format!("without the channel {name}, which others have: {}", without.join(", ")))
    };
    ["ax", "ay"].into_iter().enumerate().filter_map(lacking).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig() -> Rig {
        Rig::parse(include_str!("../../benches/rig.toml"), "rig.toml".as_ref()).unwrap()
    }

    /// A second at 1 kHz, 25 turns a second.
    fn recording(tacho: impl Fn(usize) -> f64) -> Recording {
        let channel = |name: &str, samples| Channel { name: name.into(), location: None, samples };
        let wave = |k: usize| (k as f64).sin();
        Recording {
            channels: vec![
                channel("ax", (0..1000).map(wave).collect()),
                channel("ay", (1..1001).map(wave).collect()),
                channel("tacho", (0..1000).map(tacho).collect()),
            ],
            sample_rate_hz: 1000.0,
            shaft_hz: Some(25.0),
            load_n: Some(500.0),
            ..Recording::default()
        }
    }

    fn pulses(k: usize) -> f64 {
        f64::from(u8::from(k % 40 == 7))
    }

    #[test]
    fn a_tachometer_that_is_none_is_said_and_a_good_one_is_not() {
        assert_eq!(check(&rig(), &[recording(pulses)]).unwrap(), Vec::<String>::new());
        let none: [fn(usize) -> f64; 5] =
            [|_| 0.0, |_| 1.0, |_| 0.5, |k| f64::from(u8::from(k == 100)), |k| (k % 2) as f64];
        for tacho in none {
            let notes = check(&rig(), &[recording(tacho)]).unwrap();
            assert!(notes.len() == 1 && notes[0].contains("tacho is not used"), "{notes:?}");
        }
    }

    #[test]
    fn a_stated_speed_that_the_tachometer_contradicts_is_refused() {
        let stated = |hz| Recording { shaft_hz: Some(hz), ..recording(pulses) };
        let notes = check(&rig(), &[stated(25.5)]).unwrap();
        assert!(notes[0].contains("says 25.00 Hz, the manifest 25.50 Hz"), "{notes:?}");
        let error = check(&rig(), &[stated(400.0)]).unwrap_err().to_string();
        assert!(error.contains("found 400 Hz, expected about 25.00 Hz, as the channel tacho says"), "{error}");
        let error = check(&rig(), &[stated(800.0)]).unwrap_err().to_string();
        assert!(error.contains("less than half the sample rate"), "{error}");
        let fast = Recording { sample_rate_hz: 25_600.0, ..stated(38_400.0) };
        let error = check(&rig(), &[fast]).unwrap_err().to_string();
        assert!(error.contains("38400 turns a minute are 640.000"), "{error}");
    }

    #[test]
    fn a_speed_that_looks_like_one_a_minute_is_said_where_no_tachometer_tells() {
        let mut fast = Recording { shaft_hz: Some(450.0), ..recording(pulses) };
        fast.channels.truncate(2);
        let notes = check(&rig(), &[fast]).unwrap();
        assert!(notes.len() == 1 && notes[0].contains("if that is turns a minute, state 7.500"), "{notes:?}");
    }

    #[test]
    fn a_flat_channel_is_refused_with_its_name() {
        let mut flat = recording(pulses);
        flat.channels[0].samples.fill(0.3);
        let error = check(&rig(), &[flat]).unwrap_err().to_string();
        assert!(error.contains("channel `ax`: found 0.3 in all 1000 samples"), "{error}");
    }

    #[test]
    fn places_are_those_of_the_rigs_sensors() {
        let at = |x: &str, y: &str| {
            let mut moved = recording(pulses);
            moved.channels[0].location = Some(x.into());
            moved.channels[1].location = Some(y.into());
            check(&rig(), &[moved]).map_err(|error| error.to_string())
        };
        assert!(at("outer-x", "resonator-y").is_ok());
        for (x, y, expected) in [
            ("outer-z", "resonator-y", "channels.ax: found `outer-z`, expected `outer-x`"),
            ("outer-x", "outer-y", "channels.ay: found `outer-y`, expected `resonator-y`"),
            ("outer-x", "outer-x", "channels.ay: found `outer-x`, where `ax` is"),
        ] {
            let error = at(x, y).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_baseline_in_another_condition_is_another_machines() {
        let with =
            |shaft_hz, load_n| vec![Recording { shaft_hz: Some(shaft_hz), load_n: Some(load_n), ..recording(pulses) }];
        assert_eq!(other_machine(&with(30.0, 800.0), &with(25.0, 500.0)), None);
        let why = other_machine(&with(25.0, 4000.0), &with(25.0, 500.0)).unwrap();
        assert!(why.contains("load is 4000 to 4000 N"), "{why}");
        assert!(other_machine(&with(100.0, 500.0), &with(25.0, 500.0)).unwrap().contains("speed"));
    }
}
