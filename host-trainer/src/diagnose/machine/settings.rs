//! Settings of the diagnosis of real machines.

use serde::Serialize;

use crate::diagnose::shown::ShownSettings;

/// Settings of the squared-envelope spectra in bands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModulationSettings {
    /// Width of the local median that a spectrum is divided by, Hz. By hand: wider than a line with its sidebands of
    /// leakage, narrower than most resonances.
    pub whitening_hz: f64,
    /// Amplitude over that median at which a spectral value is limited, so that a tone's beats do not pass for
    /// modulation. By hand: noise exceeds it once in 70,000 values.
    pub tone_limit: f64,
    /// Narrowest band, over the fastest ball-pass rate of the inner race: shows its first two harmonics. By hand.
    pub narrowest_ball_passes: f64,
    /// Greatest number of bands of a level of the tree. By hand: for the computing time.
    pub most_bands: u32,
    /// Highest order that is used, over the ball-pass order of the inner race. By hand.
    pub highest_ball_passes: f64,
    /// Reach of the median around a line to either side: least and greatest number of values. By hand.
    pub floor_bins: [usize; 2],
    /// Share of a band's width up to which its envelope shows lines. By hand.
    pub usable_share: f64,
}

impl ModulationSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        whitening_hz: 60.0,
        tone_limit: 4.0,
        narrowest_ball_passes: 2.2,
        most_bands: 32,
        highest_ball_passes: 3.6,
        floor_bins: [16, 60],
        usable_share: 0.9,
    };
}

/// Settings of the combs of lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CombSettings {
    /// Least and greatest slip of the cage against pure rolling; negative for a contact angle beyond the stated one, and
    /// for an error of the stated speed.
    pub slip: [f64; 2],
    /// Step of the slip in widths of a spectral value at the highest line. By hand.
    pub slip_step: f64,
    /// Distance in spectral values within which a line is taken for one of the shaft. By hand: the main lobe of the
    /// Hann window.
    pub shaft_guard_bins: f64,
    /// Distance in spectral values within which a line is taken for one of another family. By hand.
    pub rival_guard_bins: f64,
    /// First spectral value that is used: below, the window's lobe around 0 Hz.
    pub first_bin: usize,
    /// Power over the local noise above which a line adds to the depth: noise alone exceeds it once in 400 lines.
    pub line_ratio: f64,
    /// Bound on the ln of a line's power over the noise, so that no single line decides. By hand.
    pub most_log_ratio: f64,
    /// Random orders of no part of the bearing on which the same comb is evaluated. Their tail gives p-values.
    pub decoys: usize,
    /// Relative distance of a decoy from the true orders. Greater than the range of slip on either side.
    pub decoy_guard: f64,
    /// Least square of the modulation depth in a geometric mean over recordings. Depths of healthy bearings are 0.05 to 0.2.
    pub least_power: f64,
}

impl CombSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        slip: [-0.015, 0.02],
        slip_step: 0.7,
        shaft_guard_bins: 2.2,
        rival_guard_bins: 1.6,
        first_bin: 3,
        line_ratio: 6.0,
        most_log_ratio: 8.0,
        decoys: 60,
        decoy_guard: 0.024,
        least_power: 1e-4,
    };
}

/// Settings of the comparison with the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChangeSettings {
    /// Orders of the shaft that are compared.
    pub orders: usize,
    /// Reach around an order that is taken for it, as a share of its frequency: the stated speed may be off.
    pub order_reach: f64,
    /// Standard deviation of an order's amplitude between healthy machines of one make, dB. Two healthy mountings differ by
    /// 3 to 6 at a speed.
    pub order_scatter_db: f64,
    /// Fewest turns of the shaft in a recording for its orders. By hand: three values between two orders.
    pub fewest_turns: f64,
    /// Bands in an octave.
    pub bands_per_octave: f64,
    /// Lowest band edge, Hz. Below, mounting and building decide.
    pub lowest_hz: f64,
    /// Scatter of an order, and of a channel's bands, between two speeds, dB for a unit of the logarithm of their ratio. By hand: twice
    /// that of a force that grows with the square of the speed, whose response has a resonance somewhere.
    pub per_speed_db: f64,
    /// Neighbouring bands whose mean change is examined.
    pub wide_bands: usize,
    /// Mean change of these around the median over all that healthy machines of one make do not reach, dB. Between 2.8, two healthy
    /// bearings of one make on one rig, and 6.6, simulated machines whose friction is louder above 3 kHz.
    pub wide_db: f64,
    /// Finer bands in an octave, in which a moved mode shows, and their lowest edge, Hz. By hand.
    pub parts_per_octave: f64,
    /// Lowest edge of these, Hz. By hand.
    pub lowest_mode_hz: f64,
    /// Greatest move of a mode, octaves. By hand.
    pub most_move_octaves: f64,
    /// Bound on a band's change, dB, so that no single band decides. By hand.
    pub most_db: f64,
    /// Root mean square of the change over bands, its median removed, that healthy machines of one make do not reach, dB.
    /// Between 2.9, two healthy bearings of one make on one rig, and 11, a misaligned shaft.
    pub shape_db: f64,
    /// Median change over bands that healthy machines of one make do not reach, dB. Two healthy bearings differ by 6.
    pub gain_db: f64,
    /// Greatest spread over bands and recordings of a sensor's gain, dB. By hand: a gain is the same everywhere.
    pub even_db: f64,
    /// Ratio to its spread from which the gain of one of two channels is a sensor's, and greatest gain and spread of the other
    /// channel, dB: another bearing changes both. Chosen on simulated machines whose levels scatter by 1 to 2 dB.
    pub one_of_two: [f64; 3],
}

impl ChangeSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        orders: 4,
        order_reach: 0.004,
        order_scatter_db: 4.0,
        fewest_turns: 8.0,
        bands_per_octave: 3.0,
        lowest_hz: 20.0,
        per_speed_db: 40.0,
        wide_bands: 5,
        wide_db: 5.0,
        parts_per_octave: 16.0,
        lowest_mode_hz: 200.0,
        most_move_octaves: 0.45,
        most_db: 20.0,
        shape_db: 6.0,
        gain_db: 10.0,
        even_db: 0.5,
        one_of_two: [2.5, 1.0, 2.0],
    };
}

/// Settings of the faults of the acquisition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FaultSettings {
    /// Least offset, in the vibration's RMS and in the differences of the healthy machine's means. Between 0.3 and 20, two healthy
    /// bearings, whose sensors differ, and 2 and 300, a simulated offset.
    pub offset: [f64; 2],
    /// Greatest share by which the offsets of the recordings differ. By hand.
    pub offset_alike: f64,
    /// Least prominence and change of a line of the mains, dB. By hand: noise has up to 12.
    pub mains: [f64; 2],
    /// Share by which the mains' frequency may be off. Grids keep 0.4 %.
    pub mains_reach: f64,
    /// Hz around the mains that a line is compared with. By hand.
    pub mains_around_hz: f64,
    /// Share of an order within which a line may be the shaft's.
    pub order_guard: f64,
    /// Probability of a fault.
    pub probability: f64,
}

impl FaultSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        offset: [1.0, 20.0],
        offset_alike: 0.3,
        mains: [15.0, 10.0],
        mains_reach: 0.004,
        mains_around_hz: 8.0,
        order_guard: 0.012,
        probability: 0.95,
    };
}

/// Settings of the posterior of the names.
///
/// The depths are between the highest of a wrong and the lowest of a right name: 0.31 and 0.54 for races, on 30 recordings
/// of three public sets and their three sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NameSettings {
    /// Modulation depth at the rate of one race only at which its defect is as probable as none.
    pub race_depth: f64,
    /// The same where the healthy machine's depth is known.
    pub race_depth_now: f64,
    /// What a race's depth needs in addition if another part's rate is as deep.
    pub impure_depth: f64,
    /// Log-odds per ln of the depth over that.
    pub race_slope: f64,
    /// Modulation depth at multiples of the cage's speed at which a ball defect is as probable as none. A healthy bearing has
    /// 0.01 to 0.03.
    pub cage_depth: f64,
    /// Log-odds per ln of the depth over that.
    pub cage_slope: f64,
    /// Depth of a race from which the cage's modulation is taken for that of the race's impacts.
    pub rival_depth: f64,
    /// p-value of a comb among the decoys above which its log-odds fall.
    pub decoy_p_value: f64,
    /// The same for the lines of a ball's strikes: one side line that meets another machine's has p = 0.045.
    pub ball_p_value: f64,
    /// Log-odds lost per ln of the p-value above that.
    pub decoy_slope: f64,
    /// Times the baseline's depth that a comb has to exceed.
    pub times_baseline: f64,
    /// Change of an order, less its standard error, at which its force is as probable a cause as none, dB. Healthy and
    /// otherwise faulty machines have up to 4 over several speeds.
    pub order_db: f64,
    /// Log-odds per dB above that.
    pub order_slope: f64,
    /// Change of the half orders at which looseness is as probable a cause as none, dB, and log-odds per dB above it. Noise has up to
    /// 6 dB, simulated loose machines 20 to 30.
    pub half_order: [f64; 2],
    /// Change at which a moved mode is as probable a cause as none, dB, and log-odds per dB above it. Between 4.1, healthy machines and
    /// 2.3, two healthy bearings of one make, and 8.8, simulated modes that moved by a tenth.
    pub moved_mode: [f64; 2],
    /// Log-odds against none above which a name stands if it also has more than half of the posterior. Above the highest of
    /// a wrong name, 0.60, among synthetic impacts of another machine.
    pub stands: f64,
    /// Greatest probability: one case in thirty is of a kind that no map describes.
    pub most: f64,
    /// Probability of `unexplained` where the change is beyond healthy machines and no name stands. By hand.
    pub unexplained: f64,
}

impl NameSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        race_depth: 0.3,
        race_depth_now: 0.24,
        impure_depth: 0.15,
        race_slope: 5.0,
        cage_depth: 0.2,
        cage_slope: 4.0,
        rival_depth: 0.12,
        decoy_p_value: 0.03,
        ball_p_value: 0.002,
        decoy_slope: 2.0,
        times_baseline: 1.5,
        order_db: 6.0,
        order_slope: 1.0,
        half_order: [10.0, 0.5],
        moved_mode: [6.5, 0.6],
        stands: 0.8,
        most: 0.97,
        unexplained: 0.6,
    };
}

/// Settings of the synthesis of held-out recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SynthesisSettings {
    /// Greatest segment of the power densities, samples.
    pub segment: usize,
    /// Fewest segments of a recording, so that a density is known to a decibel.
    pub least_segments: usize,
    /// Values over which ratios of densities are smoothed.
    pub smooth: usize,
    /// Excess of a line over the noise from which it is part of the modulation, in means of the noise. By hand: noise alone
    /// has it once in 20 lines.
    pub line_excess: f64,
    /// Turns of the shaft over which a modulation's course is examined: the lines of a bearing are then apart.
    pub course_turns: f64,
    /// Least power over its mean: a modulator never stops the noise.
    pub least_power: f64,
    /// Rounds and step of the fit of a bounded modulator's lines. By hand: on a train of impacts a line is then met to 5 %.
    pub rounds: usize,
    /// Share of a line's error that a round takes off.
    pub step: f64,
    /// Rounds in which the modulation that passes is fitted to the one that was measured. By hand.
    pub passes: usize,
    /// Depth of a band's modulation from which that is done. By hand: less is noise.
    pub least_depth: f64,
    /// Greatest amplitude of a line: that of a train of short impacts is 2.
    pub most_amplitude: f64,
    /// Greatest share of the power that a cause may carry in a band: some noise is always left.
    pub most_share: f64,
    /// Greatest p-value of the improvement on held-out recordings of a cause that stands.
    pub p_value: f64,
}

impl SynthesisSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        segment: 4096,
        least_segments: 8,
        smooth: 5,
        line_excess: 2.0,
        course_turns: 40.0,
        least_power: 0.02,
        rounds: 12,
        step: 0.7,
        passes: 4,
        least_depth: 0.05,
        most_amplitude: 1.9,
        most_share: 0.95,
        p_value: 0.05,
    };
}

/// All settings, stage by stage.
pub fn document() -> serde_json::Value {
    serde_json::json!({
        "modulation": ModulationSettings::DEFAULT,
        "comb": CombSettings::DEFAULT,
        "change": ChangeSettings::DEFAULT,
        "fault": FaultSettings::DEFAULT,
        "name": NameSettings::DEFAULT,
        "synthesis": SynthesisSettings::DEFAULT,
        "shown": ShownSettings::DEFAULT,
    })
}
