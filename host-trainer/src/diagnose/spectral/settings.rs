//! Settings of the diagnosis by power spectra.

use serde::Serialize;

use crate::rig::effect::{EffectKind, ParameterKey};
use crate::stats::optimise::GeometricDamping;

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
    /// Relative variance of the power of a predicted line: the machine's error against its rig.
    pub line_variance: f64,
    /// Share of bins that are neither noise nor a predicted line.
    pub outliers: f64,
    /// Median power of these over the prediction.
    pub outlier_power: f64,
    /// Greatest coherence of the channels: sensors, cables and structure are not those of the rig.
    pub most_coherent: f64,
    /// Half width to which a wandering speed spreads a line that has lost its phase, Hz.
    pub wander_hz: f64,
    /// Standard deviations of the time of a ball pass around that of an even speed, s, among which a recording's is found.
    pub jitter_s: [f64; 10],
    /// Standard deviations of a ball's place in the cage, rad, among which a machine's is found.
    pub spacing_rad: [f64; 7],
    /// Standard deviation of a ball's place with which uneven machines are simulated, rad, in the middle of those above, and their
    /// count. By hand: for the computing time.
    pub drawn_spacing_rad: f64,
    /// Simulated uneven machines.
    pub drawn_machines: u64,
    /// Half width of a line in bins, by the tapers.
    pub lobe_bins: f64,
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
        line_variance: 0.5,
        outliers: 0.01,
        outlier_power: 10.0,
        most_coherent: 0.9,
        wander_hz: 4.0,
        jitter_s: [0.0, 2e-6, 4e-6, 8e-6, 1.5e-5, 3e-5, 6e-5, 1.2e-4, 2.5e-4, 5e-4],
        spacing_rad: [0.0, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2],
        drawn_spacing_rad: 3e-3,
        drawn_machines: 5,
        lobe_bins: 2.2,
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
    /// Steps of the stretch within which it is refined.
    pub near_steps: f64,
    /// Range of the stretch of a speed that drifts over the usual range.
    pub drift_reach: f64,
    /// Steps of the nominal rig's fit.
    pub nominal_steps: usize,
    /// Steps of a fit to held-out recordings.
    pub held_out_steps: usize,
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
        near_steps: 4.0,
        drift_reach: 4.0,
        nominal_steps: 10,
        held_out_steps: 4,
    };
}

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

/// Settings of the lack of fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LackSettings {
    /// Bands of an octave.
    pub bands_per_octave: f64,
    /// Bound on a bin's power over the prediction, so that no line decides about a band, and the mean that noise has below it.
    pub most_power: f64,
    /// Mean of noise under this bound, 1 − e^−6 for 6.
    pub mean_power: f64,
    /// Excess of −ln L that chance gives a band at most.
    pub band_nats: f64,
    /// Excess of −ln L that chance gives a bin at most.
    pub line_nats: f64,
    /// Lines that are stated.
    pub most_lines: usize,
}

impl LackSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        bands_per_octave: 6.0,
        most_power: 6.0,
        mean_power: 0.9975,
        band_nats: 6.0,
        line_nats: 7.0,
        most_lines: 6,
    };
}

/// Settings of what counts as a cause.
///
/// The gains, shares and the lack of fit were chosen by hand on imperfect machines of another hand (docs/results.md, power spectra),
/// which therefore do not score them; `evaluate` on its scoring seeds does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GateSettings {
    /// Gain on the fitted recordings that a cause must have.
    pub gain: f64,
    /// Gain on held-out recordings that a cause must have.
    pub held_out: f64,
    /// Gain on the held-out recordings over that on as many fitted ones that a cause must have: a cause is in all recordings.
    pub held_out_share: f64,
    /// Gain on the held-out recordings over that at the effect's best there, from which they agree about it. By hand.
    pub agreement: f64,
    /// Gain over the lack of fit that a first cause must have.
    pub first_share: f64,
    /// Gain over the lack of fit that the first cause leaves, for a second one.
    pub second_share: f64,
    /// Greatest constant force in the direction of the load, over the load, that is an error of the stated load.
    pub load_share: f64,
    /// Gain below the best, in nats, within which an error of the load is preferred.
    pub load_nats: f64,
    /// The same as a share of the best gain.
    pub load_share_of_gain: f64,
    /// Loss of the phase between the channels, nats, from which a second cause is refused, and its share of the gain: what explains
    /// the powers alone is not it. Chosen on `evaluate`, seeds 53 to 56, every second case: right causes lose at most 0.05 of their
    /// gain, wrong ones 0.13 to 0.7 or nothing.
    pub phase: [f64; 2],
    /// Lack of fit below which no second cause is searched for.
    pub second_lack: f64,
    /// Lack of fit from which a mismatch without a cause is unexplained.
    pub lack: f64,
    /// Gain of an effect that did not pass from which there is a mismatch all the same. Healthy machines of choosing seeds 43 to
    /// 46 had at most 18, recordings that did not agree about an effect 909.
    pub doubtful_gain: f64,
    /// Nats of model error by which rivals count as equally probable, and its share of the gain. The share is chosen on `evaluate`,
    /// seeds 53 to 55, every second case: the Brier score is flat from 0.005 to 0.015.
    pub rivalry: [f64; 2],
    /// Doubt of a cause by its gain g: its probability falls by this over √g. Chosen on `evaluate`, seeds 41 (`real`) and 42
    /// (`exact`), every fourth case: the Brier score is flat from 3 to 4.
    pub doubt: f64,
    /// Probability of a second cause over that of a first one with its gain. Chosen on the same cases, flat from 0.4 to 0.7.
    pub second_trust: f64,
    /// Share of the lack of fit beside causes up to which they are trusted, and from which not at all, where what is left is by
    /// itself beyond chance. Chosen on `evaluate`, seeds 43 (`real`) and 44 (`exact`), every fourth case: right causes left at
    /// most 0.27, wrong ones 0.56 to 1, but for one of each.
    pub left_share: [f64; 2],
    /// Trust of a local defect at least: its lines are at frequencies of their own, and its form is seldom that of the rig's.
    pub defect_trust: f64,
    /// Least probability of a cause that is stated.
    pub least_probable: f64,
    /// Greatest probability of a cause: effects outside the vocabulary are possible.
    pub most_probable: f64,
    /// Probability of an event.
    pub event_probability: f64,
    /// Loss on the baseline, nats, up to which an effect is there as well.
    pub baseline_nats: f64,
    /// The same over the gain on as many of the recordings.
    pub baseline_share: f64,
    /// Most effects that correct the calibration.
    pub most_corrections: usize,
}

impl GateSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        gain: 25.0,
        held_out: 8.0,
        held_out_share: 0.4,
        agreement: 0.7,
        first_share: 0.1,
        second_share: 0.3,
        load_share: 0.025,
        load_nats: 20.0,
        load_share_of_gain: 0.03,
        phase: [6.0, 0.1],
        second_lack: 100.0,
        lack: 150.0,
        doubtful_gain: 100.0,
        rivalry: [6.0, 0.01],
        doubt: 3.0,
        second_trust: 0.6,
        left_share: [0.3, 0.7],
        defect_trust: 0.5,
        least_probable: 0.3,
        most_probable: 0.97,
        event_probability: 0.95,
        baseline_nats: 5.0,
        baseline_share: 0.1,
        most_corrections: 3,
    };
}

/// Settings of the test for a level that swings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SwingSettings {
    /// Parts of a recording whose levels are compared. By hand.
    pub parts: usize,
    /// Standard deviation of the logarithm of their levels from which a recording is not that of a steady machine. Between what is
    /// measured on `evaluate`, seeds 53 and 54, every second case: 0.11 at most, but for spikes of 0.23, and 0.72 of a gain that swings.
    pub swing: f64,
}

impl SwingSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { parts: 8, swing: 0.25 };
}

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

/// Settings of the intervals: standard deviations of what a form that is not quite the rig's moves an estimate by. Chosen on
/// `evaluate`, seeds 43 (`real`) and 44 (`exact`), every fourth case, and 53 to 56 (`exact` and `real`), every second, by the
/// errors of right causes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IntervalSettings {
    /// Of a strength, as a share of it.
    pub strength: f64,
    /// Of a defect's depth, as a share of it.
    pub depth: f64,
    /// Of a defect's width, as a share of it.
    pub width: f64,
    /// Of a waviness's amplitude, as a share of it.
    pub waviness: f64,
    /// Of an angle, rad.
    pub angle_rad: f64,
    /// Of a mass, stiffness, damping, frequency or an exponent, as a share of it.
    pub number: f64,
    /// Of a mode's damping ratio, as a share of it: what excites it is not known.
    pub damping_ratio: f64,
    /// Of a sensor's gain, as a share of it: the noise of the machine has a level of its own.
    pub gain: f64,
    /// Of the cage's slip: that of a healthy machine is not known.
    pub slip: f64,
}

impl IntervalSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        strength: 0.04,
        depth: 0.2,
        width: 0.3,
        waviness: 0.15,
        angle_rad: 0.02,
        number: 0.01,
        damping_ratio: 0.25,
        gain: 0.05,
        slip: 0.0015,
    };

    /// Standard deviation of a parameter at a value by the form of its effect.
    pub fn form_error(&self, kind: EffectKind, key: ParameterKey, value: f64) -> f64 {
        use ParameterKey::{
            AmplitudeM, AngleRad, DampingRatio, DepthM, Exponent, Fraction, FrequencyHz, Value, WidthRad,
        };
        let share = match key {
            AngleRad => return self.angle_rad,
            Fraction => return self.slip,
            DepthM => self.depth,
            WidthRad => self.width,
            AmplitudeM => self.waviness,
            DampingRatio => self.damping_ratio,
            Value if kind == EffectKind::SensorGain => self.gain,
            Exponent | FrequencyHz | Value => self.number,
            _ => self.strength,
        };
        share * value.abs()
    }
}

/// Settings of the guesses from which searches start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GuessSettings {
    /// Middle and half width of the range of a slipping cage's slip.
    pub slip: [f64; 2],
    /// Gain of such a slip over a healthy one.
    pub slip_gain: f64,
    /// Difference of slips that are one.
    pub same_slip: f64,
    /// Rates of the speed without a tachometer, 1/s.
    pub drifts_per_s: [f64; 5],
    /// Least rate by a tachometer, 1/s.
    pub least_drift_per_s: f64,
    /// Bands of an octave in which a mode is searched for.
    pub bands_per_octave: f64,
    /// Least frequency of a mode, Hz.
    pub least_mode_hz: f64,
    /// Bound on a bin's power over the prediction, so that lines are no modes.
    pub most_power: f64,
    /// Mean of noise below this bound.
    pub mean_power: f64,
    /// Least standard errors of a mode's band.
    pub peak_z: f64,
    /// Modes of a channel.
    pub peaks: usize,
    /// Bands between two modes.
    pub apart: i64,
}

impl GuessSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        slip: [0.05, 0.04],
        slip_gain: 8.0,
        same_slip: 1e-3,
        drifts_per_s: [0.008, 0.014, 0.025, 0.045, 0.08],
        least_drift_per_s: 3e-3,
        bands_per_octave: 16.0,
        least_mode_hz: 150.0,
        most_power: 6.0,
        mean_power: 0.985,
        peak_z: 4.0,
        peaks: 3,
        apart: 4,
    };
}

/// Settings of the search for an effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SearchSettings {
    /// Lengths of the brief recordings of the first and the second screening, s.
    pub brief_s: [f64; 2],
    /// Steps of a fit to brief recordings.
    pub brief_steps: usize,
    /// Starts that are simulated together. By hand: a multiple of a vector's runs, few enough for the memory.
    pub side_by_side: usize,
    /// Sizes over that of the start at which a score is taken too, where one run gives them. By hand: half a decade apart.
    pub scales: [f64; 7],
    /// Starts after the first screening.
    pub starts: usize,
    /// Starts of a hypothesis after it.
    pub starts_each: usize,
    /// Hypotheses after the second screening.
    pub hypotheses: usize,
    /// Most hypotheses of a kind, at different components or numbers of lobes.
    pub places: usize,
    /// Share of the greatest gain in the screening from which a hypothesis is fitted to all recordings.
    pub rival_share: f64,
    /// Most hypotheses that are fitted to all recordings.
    pub full_fits: usize,
    /// Steps of these fits, then of those that are close to the best.
    pub steps: [usize; 2],
    /// Difference in gain, nats, that is chance: below it an effect in one direction and in both are the same. By hand.
    pub twin_nats: f64,
    /// Factor by which a gain can grow in a longer search; what is farther from the gain that is asked for is not followed up.
    pub growth: f64,
    /// Loss by a start on all recordings beyond what there is to gain, nats, from which it is not searched.
    pub hopeless_nats: f64,
    /// Damping and gain from which a mode's search is repeated, over those found: weaker, as there, and wider, twice.
    pub other_modes: [[f64; 2]; 4],
    /// Sizes of a law of the other symmetry from which its search is repeated, over the one found.
    pub other_sizes: [f64; 4],
    /// Gain of a mode at the other sensor over that at its own, and share of neighbouring lobes, from which their fits start. By
    /// hand.
    pub extension: [f64; 2],
    /// Sizes of a friction from which its full fit starts, over that of the screening.
    pub weaker: [f64; 4],
    /// Widths of a defect from which its search is repeated, over the one found. By hand: close enough that one of them is in
    /// the right valley between the zeros of the lines' envelope.
    pub other_widths: [f64; 10],
    /// Depths from which it is repeated, over the one found.
    pub other_depths: [f64; 6],
    /// Angles from the load over that found, on either side, at which a defect is tried too. By hand, as those below: as close as
    /// the valleys are wide.
    pub turns: [f64; 8],
    /// Angles from the best of these at which it is tried in the end, rad.
    pub near_turns_rad: [f64; 10],
    /// Searches from the best of these.
    pub restarts: usize,
    /// Gain below the best, nats, within which a fit is continued.
    pub close_nats: f64,
    /// The same as a share of the best gain.
    pub close_share: f64,
}

impl SearchSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        brief_s: [0.3, 0.5],
        brief_steps: 3,
        side_by_side: 64,
        scales: [0.02, 0.06, 0.2, 0.6, 2.0, 6.0, 20.0],
        starts: 40,
        starts_each: 4,
        hypotheses: 9,
        places: 3,
        rival_share: 0.4,
        full_fits: 6,
        steps: [4, 8],
        twin_nats: 2.0,
        growth: 3.0,
        hopeless_nats: 300.0,
        other_sizes: [0.5, 0.8, 1.2, 2.0],
        extension: [0.4, -0.4],
        weaker: [1.0, 0.6, 0.35, 0.2],
        other_widths: [0.35, 0.45, 0.55, 0.65, 0.78, 0.9, 1.0, 1.15, 1.4, 1.8],
        other_depths: [0.3, 0.45, 0.65, 0.8, 1.3, 2.0],
        turns: [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1],
        near_turns_rad: [-0.06, -0.04, -0.03, -0.02, -0.01, 0.01, 0.02, 0.03, 0.04, 0.06],
        other_modes: [[1.0, 0.3], [1.0, 1.0], [3.0, 1.0], [3.0, 3.0]],
        restarts: 4,
        close_nats: 40.0,
        close_share: 0.05,
    };
}

/// All settings, stage by stage.
pub fn document() -> serde_json::Value {
    serde_json::json!({
        "likelihood": LikelihoodSettings::DEFAULT,
        "fit": FitSettings::DEFAULT,
        "event": EventSettings::DEFAULT,
        "lack": LackSettings::DEFAULT,
        "gate": GateSettings::DEFAULT,
        "intervals": IntervalSettings::DEFAULT,
        "mains": MainsSettings::DEFAULT,
        "swing": SwingSettings::DEFAULT,
        "guess": GuessSettings::DEFAULT,
        "search": SearchSettings::DEFAULT,
    })
}
