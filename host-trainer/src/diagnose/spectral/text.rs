//! Sentences of the diagnosis by power spectra.

use std::f64::consts::LN_10;

use super::candidate::Candidate;
use super::causes::{Accepted, Beside};
use super::data::GreatestColour;
use super::gate::is_overdamped;
use super::settings::GateSettings;
use super::tolerance::is_tolerance;
use crate::diagnose::acquisition::Converter;
use crate::diagnose::result::Fit;
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::EffectEntry;
use crate::rig::config::RigKind;
use crate::rig::effect::EffectKind;

const GATE: GateSettings = GateSettings::DEFAULT;

/// Name of an effect with its place.
pub fn named(kind: &str, place: &str) -> String {
    if place.is_empty() { kind.to_owned() } else { format!("{kind} ({place})") }
}

/// Evidence of a cause.
pub fn evidence(accepted: &Accepted) -> String {
    let next = |name: &str, gain: f64| format!("; the next best, {name}, gains {:.0}", gain.max(0.0));
    let (of_pair, next) = match &accepted.beside {
        Some(Beside { gain, next: other }) => {
            let next = other.as_ref().map_or(String::new(), |(name, gain)| next(name, *gain));
            (format!(", {gain:.0} with the other cause"), next)
        }
        None => {
            let next = |r: &Candidate| {
                let within = if is_tolerance(r) { ", and would be within the tolerances of every machine" } else { "" };
                next(&named(r.kind.name(), &r.place), r.gain) + within
            };
            (String::new(), accepted.rivals.first().map_or(String::new(), next))
        }
    };
    let held =
        if accepted.holds { "; it holds the component, as a damper would, so that its force is not known" } else { "" };
    format!(
        "Gain of {:.0} in ln L of the power spectra on the fitted recordings and {:.0} on the held-out ones{of_pair}{next}{held}.",
        accepted.candidate.gain, accepted.held_out
    )
}

/// Evidence of an event.
pub fn event(times_s: &[(String, f64)], gain: f64) -> String {
    let times: Vec<String> = times_s.iter().map(|(name, time)| format!("{name} at {time:.4} s")).collect();
    format!("The rig's response to it is in {}: gain of {gain:.0} in ln L.", times.join(", "))
}

/// Reason why a candidate is no cause.
pub fn rejected(candidate: &Candidate, kept: Option<(&str, f64)>) -> String {
    let place = if candidate.place.is_empty() { String::new() } else { format!("({}) ", candidate.place) };
    match kept {
        Some((by, kept)) => format!("{place}gains {:.0} in ln L, {by} {kept:.0}", candidate.gain.max(0.0)),
        None if candidate.is_contradicted() => format!(
            "{place}gains {:.0} in ln L, but the phase between the channels is not that of it ({:.0})",
            candidate.gain, candidate.phase
        ),
        None if is_overdamped(candidate) => {
            format!(
                "{place}gains {:.0} in ln L, but with more damping than structures and dampers have",
                candidate.gain.max(0.0)
            )
        }
        None if candidate.gain > GATE.gain => {
            format!(
                "{place}gains {:.0} in ln L, too little of what is left or of it on the held-out recordings",
                candidate.gain
            )
        }
        None => format!(
            "{place}gains {:.1} in ln L, no more than chance and an imperfect machine do",
            candidate.gain.max(0.0)
        ),
    }
}

/// Caveat of an unexplained mismatch.
pub fn unexplained(lack: f64, recordings: &str) -> String {
    format!(
        "The spectra differ from the rig's by {lack:.0} nats beyond chance, most of all {recordings}; no effect of the vocabulary explains that."
    )
}

/// Caveat of an effect that did not pass the gate in spite of its gain.
pub fn doubtful(candidate: &Candidate) -> String {
    format!(
        "{} gains {:.0} in ln L on the fitted recordings, but the held-out ones do not bear it out or too much is left beside it.",
        named(candidate.kind.name(), &candidate.place),
        candidate.gain
    )
}

/// That the noise of a recording is not the rig's.
pub fn tilted(colour: &GreatestColour, recording: &str) -> String {
    let decibels = 10.0 * colour.power_np / LN_10;
    let side = if decibels > 0.0 { "above" } else { "below" };
    format!(
        "The noise of {} in {recording} is {:.1} dB {side} the rig's at {:.0} Hz and follows a smooth curve, as behind another filter or \
         mounting of the sensor; no effect of the vocabulary explains that.",
        CHANNELS[colour.channel],
        decibels.abs(),
        colour.frequency_hz
    )
}

/// Caveat of a rig whose simulations are far from the recordings.
pub fn unlike(fit: &Fit) -> String {
    format!(
        "Simulations of the rig are {:.2} dB from the held-out recordings, where noise alone leaves {:.2} dB, and no effect explains it.",
        fit.before, fit.noise_floor
    )
}

/// Caveat of an effect that passed the gate, but that simulations do not bear out.
pub fn unshown(candidate: &Candidate) -> String {
    format!(
        "{} gains {:.0} in ln L, but simulations with it are no nearer to the held-out recordings than without.",
        named(candidate.kind.name(), &candidate.place),
        candidate.gain
    )
}

/// Caveat of an effect that the vocabulary has no name for.
pub fn nameless(effect: &EffectEntry) -> String {
    format!(
        "The recordings are as with {} ({}), which is no name of the vocabulary; the corrected rig has it.",
        effect.kind,
        effect.equation(RigKind::Bearing5Dof)
    )
}

/// Caveat of samples that differ from those around them as noise does not, by the kurtosis of these differences.
pub fn unsteady(kurtosis: f64) -> String {
    format!(
        "What a sample differs by from those around it has a kurtosis of {kurtosis:.1}, where the noise of a rig has 3: there are spikes or \
         impacts, as of a loose part or contact, or the level rises and falls. Power spectra show little of that."
    )
}

/// Caveat of a coarse converter.
pub fn coarse(converter: &Converter) -> String {
    format!(
        "The samples are whole steps of {:.4} m/s² apart: a converter so coarse adds {:.0} % of the sensor's noise in power, \
         and distorts what is smaller than a step.",
        converter.step,
        100.0 * converter.of_noise
    )
}

/// Equation of a step of the load whose size its course hides.
pub const OF_UNKNOWN_SIZE: &str = "F_load becomes F_load + ΔF";

/// Caveat of recordings without a stated load.
pub const NO_LOAD: &str = "No load is stated (load_n in recordings.toml); the rig was simulated with 0 N, so that what \
                           depends on the load is a guess.";

/// Caveat of effects that the baseline has as well.
pub fn in_baseline(effects: &[EffectKind]) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
    format!(
        "The calibrated rig differs from the baseline too; the corrected rig has {} for that, which is no change since.",
        names.join(" and ")
    )
}

/// Caveat of an effect that every machine has.
pub fn tolerated(effect: &EffectEntry) -> String {
    let what = match effect.kind {
        EffectKind::ConstantForce => "The loads are not quite those that are stated, or not quite in their direction",
        EffectKind::SpeedDrift => "The speed of the shaft wanders",
        EffectKind::OuterRaceWaviness | EffectKind::InnerRaceWaviness => {
            "A race is as round and smooth as races are made"
        }
        EffectKind::MassChange | EffectKind::StiffnessChange | EffectKind::DampingChange => {
            "A mass, stiffness or damping is not quite that which is stated"
        }
        _ => "A race or ball is no rougher than its finish",
    };
    format!(
        "{what}; the corrected rig has {} for that ({}), which is no cause.",
        effect.kind,
        effect.equation(RigKind::Bearing5Dof)
    )
}

/// Caveat of causes that were found in some recordings alone.
pub fn in_some(recordings: &[&str]) -> String {
    format!("What is found is in {} alone: the other recordings are as the rig, within chance.", recordings.join(", "))
}

/// Caveat of causes that are those of some recordings, and that the others, with their effects and numbers in words, have as well but
/// for a share of their lack of fit that is left.
pub fn in_all(recordings: &[&str], others: &[String], left: f64) -> String {
    format!(
        "What is stated is that of {}, which differs most from the rig: no cause of one strength explains all recordings. With \
         numbers of their own the others have it as well ({}), which explains {:.0} % of what they differ by.",
        recordings.join(", "),
        others.join("; "),
        100.0 * (1.0 - left)
    )
}
