//! Settings of the reports.

/// Segment lengths, windows and limits of lists in the reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportSettings {
    /// Error over the noise floor up to which it is within chance. By hand.
    pub near_noise: f64,
    /// Samples in a segment of Welch's method in pictures of a recording and its simulation. Not tuned: chosen by hand.
    pub segment: usize,
    /// Highest harmonic of the BPFO in the narrow spectrum of a calibration. Not tuned: chosen by hand.
    pub ball_pass_harmonics: f64,
    /// Shaft revolutions in the time picture of a calibration. Not tuned: chosen by hand.
    pub turns: f64,
    /// Samples in the enlarged stretch of a held-out acceleration. Not tuned: chosen by hand.
    pub zoom: usize,
    /// Ratio of the errors after and before a correction below which a stretch is shown for it. Not tuned: chosen by hand.
    pub gain: f64,
    /// Points beyond which a curve is thinned; a picture is 1000 pixels wide. Not tuned: chosen by hand.
    pub points: usize,
    /// Share of a spectrum below which the bands of a mismatch are drawn enlarged. Not tuned: chosen by hand.
    pub enlarged_share: f64,
    /// Averaged segments of an enlarged spectrum. Not tuned: chosen by hand.
    pub enlarged_segments: usize,
    /// Ratio of RMS residuals before and after from which the one after is drawn enlarged. Not tuned: chosen by hand.
    pub enlarged_ratio: f64,
    /// Tests listed in the report of a diagnosis. Not tuned: chosen by hand.
    pub tests: usize,
    /// Equations listed in the report of a fit; the model file has all. Not tuned: chosen by hand.
    pub equations: usize,
    /// Terms listed in each equation, those of most power. Not tuned: chosen by hand.
    pub terms: usize,
    /// Events listed in the report of the monitor; a broken sensor can cause thousands. Not tuned: chosen by hand.
    pub events: usize,
    /// Machines of a fleet with a picture, the worst. Not tuned: chosen by hand.
    pub fleet_pictures: usize,
    /// Recordings averaged in an early or late spectrum. Not tuned: chosen by hand.
    pub averaged: usize,
    /// Samples in a picture of the residual. Not tuned: chosen by hand.
    pub window: usize,
    /// Samples in a picture of derivatives, few enough to show single periods. Not tuned: chosen by hand.
    pub close_window: usize,
    /// Derivatives whose prediction is shown. Not tuned: chosen by hand.
    pub panels: usize,
    /// Recordings of the running median that is drawn of predicted lives. Not tuned: chosen by hand.
    pub running_median: usize,
}

impl ReportSettings {
    /// Settings of all reports.
    pub const DEFAULT: Self = Self {
        near_noise: 2.0,
        segment: 2048,
        ball_pass_harmonics: 6.0,
        turns: 3.0,
        zoom: 400,
        gain: 0.9,
        points: 1600,
        enlarged_share: 0.25,
        enlarged_segments: 4,
        enlarged_ratio: 5.0,
        tests: 12,
        equations: 16,
        terms: 6,
        fleet_pictures: 50,
        events: 40,
        averaged: 5,
        window: 512,
        close_window: 128,
        panels: 2,
        running_median: 9,
    };
}
