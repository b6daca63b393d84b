//! Settings of the likelihood of a power spectrum.

use serde::Serialize;

/// Number of errors of form: the balls' diameters, the races' roundness.
pub const FORMS: usize = 2;
/// Count of the half widths to which lines are spread.
pub const WIDTHS: usize = 3;

/// Settings of the likelihood of a power spectrum. The priors of colour, jitter and stretch are by hand, with the healthy
/// machines of another hand in view (docs/results.md, power spectra).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LikelihoodSettings {
    /// Longest settling of a run over its recording: what is left of the start is below the noise of a short recording. By
    /// hand: for the computing time.
    pub settle_share: f64,
    /// Sine tapers of a spectrum. By hand: two keep a line within three bins and its leakage below the noise.
    pub tapers: usize,
    /// First bin that counts: below it are the taper's lobe around 0 Hz and what is left of an offset.
    pub first_bin: usize,
    /// Knots of a noise's colour, as shares of half the sample rate.
    pub knots: [f64; 9],
    /// Standard deviation of a noise's level, Np of power.
    pub level_np: f64,
    /// Standard deviation of the level of a sensor's own noise beside a gain, Np of power: stated to a tenth. By hand.
    pub noise_level_np: f64,
    /// Standard deviation of the colour's roll-off at half the sample rate, Np of power; it grows with the square of the
    /// frequency.
    pub roll_off_np: f64,
    /// Standard deviation of the first cosine of the colour over frequency, Np of power; the k-th has a k-th of it.
    pub cosine_np: f64,
    /// Cosines of the colour.
    pub cosines: usize,
    /// Standard deviation of the colour at each knot, Np of power.
    pub knot_np: f64,
    /// Standard deviation of the colours of `ax`, `ay` and the process force over the ones above. By hand: half for the process
    /// force, as a gain of one channel would else be a colour of both.
    pub colour_std: [f64; 3],
    /// Standard deviation of what a recording's colours have of their own, over that of the colours of all without the roll-off.
    /// Noises of choosing machines of another hand differ by 0.4 to 1 dB between recordings.
    pub own_colour_std: f64,
    /// Relative variance of the power of a predicted line: the machine's error against its rig.
    pub line_variance: f64,
    /// Share of bins that are neither noise nor a predicted line.
    pub outliers: f64,
    /// Median power of these over the prediction.
    pub outlier_power: f64,
    /// Greatest coherence of the channels: sensors, cables and structure are not those of the rig.
    pub most_coherent: f64,
    /// Half width to which a wandering rotation spreads a line that has lost its phase, Hz. Where the phase has lost more than 1 rad
    /// it grows with that.
    pub wander_hz: f64,
    /// Multiples of that half width for which lines are spread; between them the spread lines are mixed. By hand: for the memory.
    pub wander_widths: [f64; WIDTHS],
    /// Standard deviations of the time of a ball pass around that of an even speed, s, among which a recording's is found.
    pub jitter_s: [f64; 11],
    /// Standard deviations of a ball's place in the cage, rad, among which a machine's is found.
    pub spacing_rad: [f64; 7],
    /// Standard deviation of a ball's place with which uneven machines are simulated, rad, in the middle of those above, and their
    /// count. By hand: for the computing time.
    pub drawn_spacing_rad: f64,
    /// Simulated uneven machines.
    pub drawn_machines: u64,
    /// Standard deviations of the balls' diameters, and amplitudes of the races' roundness, m, among which a machine's are found.
    pub form_m: [[f64; 6]; FORMS],
    /// Those with which machines are simulated, m.
    pub drawn_form_m: [f64; FORMS],
    /// Half width of a line in bins, by the tapers.
    pub lobe_bins: f64,
    /// Half widths of a line from one order of the cage to the next from which these are told apart. By hand: lines at 2 are one.
    pub cage_lobes: f64,
    /// Power over its mean that the weight of an order of the cage follows at most. By hand: a line of another source is no ball.
    pub most_sideband_ratio: f64,
    /// Least weight of an order of the cage: what the balls do not put there, other lines do. By hand.
    pub least_sideband: f64,
    /// Least and greatest mean of these weights: from one standard deviation of a ball's place to the next, that is a factor of 4.
    pub mean_sideband: [f64; 2],
    /// Jitter and spacing of machines that turn evenly and unevenly, by their places in these lists.
    pub usual: [[usize; 2]; 2],
    /// Median of the jitter over all machines, s, and standard deviation of its logarithm.
    pub usual_jitter: [f64; 2],
    /// Standard deviation of a healthy cage's slip; with that of the stated speed it is that of the stretch.
    pub slip_std: f64,
    /// Mean of the same: a healthy cage slips by up to 0.5 %.
    pub slip_mean: f64,
    /// Least standard deviation of a stated speed, as a share of it.
    pub least_speed_std: f64,
    /// Greatest stretch that is considered, as a share, and least step.
    pub stretch: [f64; 2],
    /// Step by which the line of highest frequency moves, bins.
    pub stretch_bins: f64,
    /// Predicted line's power over the noise from which it determines the stretch.
    pub line_ratio: f64,
    /// Most bins of lines that determine it. By hand: for the computing time.
    pub most_lines: usize,
}

impl LikelihoodSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        settle_share: 0.6,
        tapers: 2,
        first_bin: 4,
        knots: [0.002, 0.02, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0],
        level_np: 0.03,
        noise_level_np: 0.2,
        roll_off_np: 0.6,
        cosine_np: 0.06,
        cosines: 3,
        knot_np: 0.05,
        colour_std: [1.0, 1.0, 0.5],
        own_colour_std: 1.0,
        line_variance: 0.5,
        outliers: 0.01,
        outlier_power: 10.0,
        most_coherent: 0.9,
        wander_hz: 4.0,
        wander_widths: [1.0, 3.0, 9.0],
        jitter_s: [0.0, 2e-6, 4e-6, 8e-6, 1.5e-5, 3e-5, 6e-5, 1.2e-4, 2.5e-4, 5e-4, 1e-3],
        spacing_rad: [0.0, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2],
        drawn_spacing_rad: 3e-3,
        drawn_machines: 5,
        form_m: [[0.0, 2e-8, 4e-8, 8e-8, 1.6e-7, 3.2e-7], [0.0, 5e-8, 1e-7, 2e-7, 3.5e-7, 5e-7]],
        drawn_form_m: [8e-8, 2e-7],
        lobe_bins: 2.2,
        cage_lobes: 2.5,
        most_sideband_ratio: 20.0,
        least_sideband: 1e-3,
        mean_sideband: [0.5, 2.0],
        usual: [[2, 2], [6, 3]],
        usual_jitter: [1e-5, 1.5],
        slip_std: 0.0015,
        slip_mean: 0.002,
        least_speed_std: 1e-4,
        stretch: [0.009, 1.5e-4],
        stretch_bins: 0.3,
        line_ratio: 0.5,
        most_lines: 400,
    };
}
