//! Settings of the search for events.

use serde::Serialize;

/// Settings of the search for events.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EventSettings {
    /// Rise times of a step of the load with corners, s.
    pub rises_s: [f64; 5],
    /// Rise times of one without, s. By hand: a factor of two apart, up to what a response holds.
    pub smooth_rises_s: [f64; 5],
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
    /// Gain above which a response is no chance.
    pub gain: f64,
    /// Gain over the greatest elsewhere: a train of defect impulses has many as great.
    pub isolation: f64,
    /// Time before an event from which its recording is left out, s.
    pub before_s: f64,
    /// Time after an event up to which its recording is left out, s.
    pub after_s: f64,
}

impl EventSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        rises_s: [1e-4, 1e-3, 4e-3, 1.5e-2, 4e-2],
        smooth_rises_s: [2e-3, 4e-3, 8e-3, 1.6e-2, 3.2e-2],
        durations_s: [2e-4, 7e-4, 2e-3, 5e-3],
        places: ["outer-y", "outer-x", "inner-y"],
        change_share: 0.02,
        impulse_n_s: 1e-3,
        template_s: 0.02,
        response_s: 0.12,
        guard_s: 0.01,
        gain: 30.0,
        isolation: 2.5,
        before_s: 0.005,
        after_s: 0.08,
    };
}

impl EventSettings {
    /// Number of templates.
    pub const fn templates(&self) -> usize {
        self.rises_s.len() + self.smooth_rises_s.len() + self.places.len() * self.durations_s.len()
    }
}
