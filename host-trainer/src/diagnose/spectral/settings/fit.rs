//! Settings of a fit.

use serde::Serialize;

use crate::stats::optimise::GeometricDamping;

/// Settings of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FitSettings {
    /// Decrease of −ln L below which a step is the last.
    pub converged: f64,
    /// The same over the decrease so far.
    pub converged_share: f64,
    /// Standard deviation of an unknown parameter's coordinate around its guess.
    pub unknown_std: f64,
    /// Greatest step of a coordinate.
    pub max_step: f64,
    /// Step of a coordinate by which derivatives are taken.
    pub difference: f64,
    /// Damping at the start of a search, and how it changes.
    pub damping: GeometricDamping,
    /// Damping at which a search ends.
    pub most_damping: f64,
    /// Gain that moves jitter or spacing by a step.
    pub least_gain: f64,
    /// Steps of the weights of the orders of the cage beside a line, each time the machine is refined. By hand: for the computing time.
    pub sideband_steps: usize,
    /// Steps of the stretch within which it is refined.
    pub near_steps: f64,
    /// Range of the stretch of a speed that drifts over the usual range.
    pub drift_reach: f64,
    /// Steps of the nominal rig's fit.
    pub nominal_steps: usize,
    /// Steps of a fit to held-out recordings.
    pub held_out_steps: usize,
    /// Most further steps of a candidate that is a cause: another one is searched for beside its best fit.
    pub cause_steps: usize,
}

impl FitSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        converged: 0.3,
        converged_share: 1e-3,
        unknown_std: 2.0,
        max_step: 0.7,
        difference: 1e-3,
        damping: GeometricDamping {
            value: 1e-3,
            fall: 0.2,
            growth: 8.0,
            floor: 1.25e-3,
            singular_growth: 10.0,
            singular_floor: 0.0,
        },
        most_damping: 1e6,
        least_gain: 0.5,
        sideband_steps: 2,
        near_steps: 4.0,
        drift_reach: 4.0,
        nominal_steps: 10,
        held_out_steps: 4,
        cause_steps: 16,
    };
}
