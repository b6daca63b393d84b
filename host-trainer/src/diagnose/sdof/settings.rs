//! Settings of the diagnosis of a rig of one degree of freedom.

use serde::Serialize;

/// Acquisition, selection, validation and report, theory (66) to (69).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SdofSettings {
    /// Least samples of all recordings together, by the contract.
    pub min_samples: usize,
    /// Least samples of a recording: one more than a spline of order five is fixed by.
    pub min_recording: usize,
    /// Least samples of each recording in which a step of the load is sought. Not tuned: chosen by hand.
    pub least_for_events: usize,
    /// Most samples; of longer recordings the first parts are used. Chosen for 10 s a case.
    pub most_samples: usize,
    /// Grid points a period of the fastest motion, at which a cubic force is right to 1 %.
    pub points_per_period: f64,
    /// Most grid points a sample. Not tuned: chosen by hand.
    pub max_fine: usize,
    /// Parts of a recording of which at most one is left out at either end, where an integrated acceleration is unreliable. Not tuned:
    /// chosen by hand.
    pub least_part_of_ends: usize,
    /// Decimal logarithms of the force noise tried, as shares of the mean square force, and their count. Chosen by hand: from
    /// none to all of it.
    pub force_noise: (f64, f64, usize),
    /// Longest delay of the sensor against the input that a filter before it makes, step of the search, both in samples, and least gain
    /// of twice the logarithm of the likelihood. Not tuned: chosen by hand.
    pub delay: [f64; 3],
    /// Blocks of all recordings under test together. Not tuned: chosen by hand.
    pub blocks: usize,
    /// Least rows of a block. Chosen on falls of 45 samples.
    pub min_block: usize,
    /// Folds of the cross-validation.
    pub folds: usize,
    /// Greatest relative error of a mass, a stiffness or a gain that is stated as known. Chosen by hand: that of a scale and of a force
    /// sensor, and of their ratio.
    pub tolerance: f64,
    /// Greatest relative error of a damping that is stated as known: nobody weighs it. Chosen by hand.
    pub tolerance_of_damping: f64,
    /// Most rounds in which known parameters are adjusted. Not tuned: chosen by hand.
    pub adjustments: usize,
    /// p-value at which a cause is beyond chance, before division by the number of terms tried. Not tuned: chosen by hand.
    pub significance: f64,
    /// Share of the held-out error from which a gain is no chance even where one block has nearly all of it. Not tuned: chosen by hand.
    pub most_of_error: f64,
    /// Independent pieces that a block then counts for. Not tuned: chosen by hand.
    pub pieces: f64,
    /// Share of the held-out error that a first cause must take away. Chosen on synthetic cases (seeds 1 to 3).
    pub worth: f64,
    /// Share of what is explained that a further cause must add. Chosen on synthetic cases (seeds 1 to 3).
    pub worth_further: f64,
    /// Share of the mean square error of held-out simulations that each cause must take away. Chosen on synthetic cases (seeds
    /// 1 to 3).
    pub worth_simulated: f64,
    /// Share of what all causes leave of that error that a cause must take away where it does not take that share: the rig alone
    /// may err by all of the motion. Chosen by hand on a pendulum with two kinds of friction.
    pub worth_left: f64,
    /// Share of the mean square error of held-out simulations that all causes together must take away, and that a mode between
    /// mass and sensor must, which can shape itself to the spectrum of any disturbance. Chosen on synthetic cases without a
    /// mismatch (seeds 1 and 2).
    pub takes_away: (f64, f64),
    /// Most causes. Not tuned: chosen by hand.
    pub max_causes: usize,
    /// Best models of some causes to each of which another is tried: drag and dry friction together are nearly viscous friction, so that
    /// the best pair may be two of three right causes or none. Not tuned: chosen by hand.
    pub widened: usize,
    /// Most columns of the flexible model. Not tuned: chosen by hand.
    pub flexible_columns: usize,
    /// Share of the held-out error that a flexible column must take away. Not tuned: chosen by hand.
    pub flexible_worth: f64,
    /// Share of the explainable error that named causes must explain. Between 0.47 and 0.67, dampers whose two directions differ and that
    /// have no name, and 0.78, a magneto-rheological one that is named by its dry friction.
    pub explains: f64,
    /// Share of the held-out error that a flexible model must take away for a mismatch without a name. Chosen on synthetic
    /// cases (seeds 1 to 3).
    pub unexplained: f64,
    /// Periods in the longest recording, or over the travel, from which something repeats: up to there it is a flexible column.
    pub repeats_at_least: usize,
    /// Cells of the travel in which a force that repeats along it is sought. Not tuned: chosen by hand.
    pub cells: usize,
    /// Bins beside a line of the input that are the line's, by a Hann window over half of the transform. By hand.
    pub near_bins: usize,
    /// Bins to either side over whose median a line stands. Not tuned: chosen by hand.
    pub floor_bins: usize,
    /// Error of a simulation over the motion's spread from which the rig explains nothing of it, and share of the spread below
    /// which what an autoregression leaves says that there is a motion to explain. By hand.
    pub explains_nothing: [f64; 2],
    /// Ratio of a simulation's error to the sensor's noise up to which it leaves nothing that would be unexplained. Chosen on a
    /// linear circuit whose input is known between its samples to 0.1 % only.
    pub at_noise: f64,
    /// Error of a simulation as a share of the motion's spread that is numerical: of the interpolation of the input and of
    /// the states between samples.
    pub numerical: f64,
    /// Least samples of a simulated window. Not tuned: chosen by hand.
    pub min_window: usize,
    /// Periods of the motion in the shortest simulated window. Not tuned: chosen by hand.
    pub window_periods: f64,
    /// Factor from one length of window to the next. Not tuned: chosen by hand.
    pub window_growth: usize,
    /// Growth of the error up to which a longer window is preferred, and its ratio to the sensor's noise. Not tuned: chosen
    /// by hand.
    pub window_error: (f64, f64),
    /// Ratio of a simulation's error to the sensor's noise from which forces disturb the machine, and the regression's
    /// parameters stand. Not tuned: chosen by hand.
    pub disturbed: f64,
    /// Most samples that the noise is estimated from. Chosen for 10 s a case.
    pub noise_samples: usize,
    /// Most samples that are simulated in a fit. Chosen for 10 s a case.
    pub simulated_samples: usize,
    /// Most probability that is given to a cause.
    pub most_probability: f64,
    /// Points of a term's curve. Not tuned: chosen by hand.
    pub curve_points: usize,
    /// Most held-out recordings that are written. Not tuned: chosen by hand.
    pub traces: usize,
}

impl SdofSettings {
    /// Settings of all diagnoses.
    pub const DEFAULT: Self = Self {
        min_samples: 12,
        min_recording: 6,
        least_for_events: 200,
        most_samples: 50_000,
        points_per_period: 24.0,
        max_fine: 6,
        least_part_of_ends: 8,
        force_noise: (-9.0, 0.0, 10),
        delay: [2.0, 0.5, 40.0],
        blocks: 32,
        min_block: 4,
        folds: 4,
        tolerance: 0.01,
        tolerance_of_damping: 0.05,
        adjustments: 4,
        significance: 0.02,
        most_of_error: 0.8,
        pieces: 8.0,
        worth: 0.004,
        worth_further: 0.01,
        worth_simulated: 0.005,
        worth_left: 0.3,
        takes_away: (0.05, 0.5),
        max_causes: 3,
        widened: 6,
        flexible_columns: 8,
        flexible_worth: 0.004,
        explains: 0.72,
        repeats_at_least: 4,
        cells: 4096,
        near_bins: 4,
        floor_bins: 128,
        explains_nothing: [0.5, 0.3],
        unexplained: 0.05,
        at_noise: 1.1,
        numerical: 3e-4,
        min_window: 16,
        window_periods: 1.5,
        window_growth: 4,
        window_error: (1.3, 2.0),
        disturbed: 5.0,
        noise_samples: 12_000,
        simulated_samples: 5000,
        most_probability: 0.98,
        curve_points: 25,
        traces: 12,
    };
}

/// All settings, stage by stage.
pub fn document() -> serde_json::Value {
    serde_json::json!({
        "sdof": SdofSettings::DEFAULT,
    })
}
