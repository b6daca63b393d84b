//! Held-out recordings, simulated.

use serde::Serialize;

use super::{shooting, states::States};
use crate::rig::Rig;

/// A held-out recording, as measured and as simulated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOutTrace {
    /// The recording.
    pub recording: String,
    /// The channel, `q` or `qdd`.
    pub channel: &'static str,
    /// Time from the recording's first sample, s.
    pub time_s: Vec<f64>,
    /// Measured signal, in the sensor's unit.
    pub measured: Vec<f64>,
    /// Simulation by the rig with its unknown parameters fitted to the other recordings.
    pub before: Vec<f64>,
    /// Simulation with the causes, fitted to the other recordings.
    pub after: Vec<f64>,
}

/// Recordings as measured and as simulated by two rigs, each from the start of least residual; those that diverge are left
/// out.
pub fn simulated(before: &Rig, after: &Rig, test: &States) -> Vec<HeldOutTrace> {
    let one = |index: usize| {
        let alone = States { tracks: vec![test.tracks[index].clone()], ..test.clone() };
        let track = &alone.tracks[0];
        let observed = alone.observed();
        let whole = observed.spans(None);
        let follow = |rig: &Rig| Some(shooting::follow(rig, &observed, &whole)?.swap_remove(0));
        let (before, after) = (follow(before)?, follow(after)?);
        Some(HeldOutTrace {
            recording: track.name.clone(),
            channel: alone.sensed.channel(),
            time_s: (0..track.len()).map(|k| k as f64 * alone.step_s()).collect(),
            measured: track.sensed.clone(),
            before,
            after,
        })
    };
    (0..test.tracks.len()).filter_map(one).collect()
}
