//! Settings of the pictures.

/// Layout of the pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotSettings {
    /// Height of the synchronous average, pixels. Not tuned: chosen by hand.
    pub cycle_height: u32,
    /// Height of the monitor's trend, pixels. Not tuned: chosen by hand.
    pub trend_height: u32,
    /// Height of the trend of one machine of a fleet, pixels. Not tuned: chosen by hand.
    pub fleet_height: u32,
    /// Height of a panel of indicators, pixels. Not tuned: chosen by hand.
    pub indicator_panel_height: u32,
    /// Most recordings of a trend that has dots beside its line. Not tuned: chosen by hand.
    pub dots: usize,
    /// Height of a panel of derivatives, pixels. Not tuned: chosen by hand.
    pub derivative_panel_height: u32,
    /// Height of a panel of residuals, pixels. Not tuned: chosen by hand.
    pub residual_panel_height: u32,
    /// Height of a row of ratings, pixels. Not tuned: chosen by hand.
    pub rating_height: u32,
    /// Height of legend and axis around the rows of ratings, pixels. Not tuned: chosen by hand.
    pub rating_margin: u32,
    /// Level at which residuals are clamped from below, dB re healthy. Not tuned: chosen by hand.
    pub lowest_db: f64,
    /// Steps of the kurtogram's colour scale, few so that the file stays small. Not tuned: chosen by hand.
    pub colour_steps: usize,
    /// Rows for the names of marks; names beyond them are left out. Not tuned: chosen by hand.
    pub name_rows: usize,
    /// Share of the plot's height that such a row takes. Not tuned: chosen by hand.
    pub name_row: f64,
    /// Share of the plot's width that a letter takes. Not tuned: chosen by hand.
    pub letter: f64,
    /// Share of an indicator panel's height that the name of a zone's boundary takes. Not tuned: chosen by hand.
    pub zone_name: f64,
}

impl PlotSettings {
    /// Settings of all pictures.
    pub const DEFAULT: Self = Self {
        cycle_height: 300,
        trend_height: 440,
        fleet_height: 260,
        indicator_panel_height: 230,
        dots: 60,
        derivative_panel_height: 230,
        residual_panel_height: 210,
        rating_height: 26,
        rating_margin: 90,
        lowest_db: -20.0,
        colour_steps: 40,
        name_rows: 4,
        name_row: 0.055,
        letter: 0.0086,
        zone_name: 0.1,
    };
}
