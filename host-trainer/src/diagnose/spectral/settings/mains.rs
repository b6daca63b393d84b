//! Settings of the electrical line.

use serde::Serialize;

/// Settings of the search for the electrical line. All by hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MainsSettings {
    /// Range and step of the frequency, Hz: 50 and 60 Hz, and generators of their own.
    pub range_hz: [f64; 3],
    /// Step at which the search for the frequency ends, Hz: a hundredth of a bin of a second.
    pub resolution_hz: f64,
    /// Gain of a recording that has it: one in 10^7 by chance.
    pub gain: f64,
    /// Gain of a harmonic.
    pub harmonic_gain: f64,
    /// Gain above which a line's size says no more.
    pub most_gain: f64,
    /// Greatest multiple.
    pub most_multiples: u32,
    /// Bins to either side whose median is the level that a line stands out of.
    pub around_bins: usize,
    /// Bins next to the line that belong to it.
    pub apart_bins: usize,
    /// Bins by which an order of the shaft must move from recording to recording.
    pub moved_bins: f64,
    /// Bins within which a line is a harmonic of the shaft.
    pub harmonic_bins: f64,
    /// Gain of the lines at the same order of the shaft, over that of the lines at one frequency, from which they are the shaft's.
    pub locked_share: f64,
    /// Frequencies of supplies, Hz.
    pub supplies_hz: [f64; 2],
    /// Distance from one of these of a line that is in one recording only or in recordings of one speed, Hz.
    pub supply_reach_hz: f64,
    /// Size in a channel, over that in the other, from which the channel has it too.
    pub weak_share: f64,
}

impl MainsSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        range_hz: [45.0, 65.0, 0.25],
        resolution_hz: 0.005,
        gain: 16.0,
        harmonic_gain: 8.0,
        most_gain: 60.0,
        most_multiples: 9,
        around_bins: 20,
        apart_bins: 3,
        moved_bins: 3.0,
        harmonic_bins: 1.5,
        locked_share: 0.3,
        supplies_hz: [50.0, 60.0],
        supply_reach_hz: 0.6,
        weak_share: 0.1,
    };
}
