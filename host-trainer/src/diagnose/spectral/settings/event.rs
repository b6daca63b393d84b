//! Settings of the search for events.

use serde::Serialize;

use crate::rig::effect::course::Course;

/// Settings of the search for events.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EventSettings {
    /// Rise times of a step of the load with corners, s.
    pub straight_rises_s: [f64; 5],
    /// Rise times of one without, s. By hand: a factor of two apart, up to what a response holds.
    pub smooth_rises_s: [f64; 5],
    /// Time constants of one with a lag, s. By hand: of second order, whose size at its corner is as their square, a half octave apart.
    pub lags_s: [f64; 9],
    /// Durations of a shock, s.
    pub durations_s: [f64; 4],
    /// Where a shock acts.
    pub places: [&'static str; 3],
    /// Change of a template's load over the load: small, so that the response is linear.
    pub change_share: f64,
    /// Impulse of a template's shock, N s.
    pub impulse_n_s: f64,
    /// Time of a template's event, s.
    pub template_s: f64,
    /// Length of a response, s.
    pub response_s: f64,
    /// Length of the stretches of a recording that are compared, s: longer than the ring of a shock's strongest part.
    pub guard_s: f64,
    /// Time over which a recording fades in and out, s. By hand: a few periods of the slowest lines' distance.
    pub flank_s: f64,
    /// Parts of a recording whose median is its usual power. By hand: an event is in few of them.
    pub parts: usize,
    /// Bins on either side whose median is the floor that a line stands on. By hand: fewer than a mode's width.
    pub line_reach: usize,
    /// Power over the floor from which a bin has a line. By hand: noise has it in one of half a million.
    pub line_ratio: f64,
    /// Gain above which a response is no chance.
    pub gain: f64,
    /// Gain over the greatest elsewhere: a train of defect impulses has many as great.
    pub isolation: f64,
    /// Gain over that of the best from which a template of its kind is a rival for the size. By hand.
    pub alike_gain: f64,
    /// Greatest over the least size of these, below which it is known. By hand.
    pub alike_size: f64,
    /// Time before an event from which its recording is left out, s.
    pub before_s: f64,
    /// Time after an event up to which its recording is left out, s.
    pub after_s: f64,
}

impl EventSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        straight_rises_s: [1e-4, 1e-3, 4e-3, 1.5e-2, 4e-2],
        smooth_rises_s: [2e-3, 4e-3, 8e-3, 1.6e-2, 3.2e-2],
        lags_s: [1e-3, 1.4e-3, 2e-3, 2.8e-3, 4e-3, 5.6e-3, 8e-3, 1.1e-2, 1.6e-2],
        durations_s: [2e-4, 7e-4, 2e-3, 5e-3],
        places: ["outer-y", "outer-x", "inner-y"],
        change_share: 0.02,
        impulse_n_s: 1e-3,
        template_s: 0.02,
        response_s: 0.12,
        guard_s: 0.01,
        flank_s: 0.03,
        parts: 10,
        line_reach: 20,
        line_ratio: 8.0,
        gain: 30.0,
        isolation: 2.5,
        alike_gain: 0.7,
        alike_size: 3.0,
        before_s: 0.005,
        after_s: 0.08,
    };
}

impl EventSettings {
    /// Rise times or time constants of a course of the load, s.
    pub const fn rises_s(&self, course: Course) -> &[f64] {
        match course {
            Course::Straight => &self.straight_rises_s,
            Course::Smooth => &self.smooth_rises_s,
            Course::FirstOrder | Course::SecondOrder => &self.lags_s,
        }
    }

    /// Number of templates.
    pub const fn templates(&self) -> usize {
        let steps = self.straight_rises_s.len() + self.smooth_rises_s.len() + 2 * self.lags_s.len();
        steps + self.places.len() * self.durations_s.len()
    }
}
