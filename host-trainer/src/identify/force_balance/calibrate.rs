//! Unknown parameters of a rig from healthy recordings: force balance or simulation, theory (62) to (68).

use crate::rig::config::RigKey;
use serde::Serialize;

use super::{
    equation::{self, Equation, Parameter},
    error::BalanceError,
    regression::{self, Fit},
    settings::BalanceSettings,
    shooting::{self, Refined},
    states::States,
    traces::{self, HeldOutTrace},
};
use crate::recording::Recording;
use crate::rig::Rig;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Method of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Simulation, whose residual is the sensor's noise.
    Simulation,
    /// Force balance: the simulation's residual exceeds the sensor's noise, so that forces disturb the machine.
    ForceBalance,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Key in `rig.toml`.
    pub key: String,
    /// Unit.
    pub unit: &'static str,
    /// Value of the file.
    pub guess: f64,
    /// Estimated value.
    pub value: f64,
    /// 95 % interval.
    pub interval95: [f64; 2],
}

/// Root mean square error on held-out recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOutError {
    /// Held-out recordings, or part of the only one.
    pub recordings: String,
    /// Residual of the balance with the file's values, N.
    pub balance_before_n: f64,
    /// Residual of the balance with the fitted values, N.
    pub balance_after_n: f64,
    /// Residual of the simulation with the file's values, in the sensor's unit; `None` if it diverges.
    pub simulation_before: Option<f64>,
    /// Residual of the simulation with the fitted values, in the sensor's unit; `None` if it diverges.
    pub simulation_after: Option<f64>,
    /// Length of the simulated windows, each from a fitted start, s.
    pub window_s: f64,
}

/// The result of a calibration.
#[derive(Clone, Debug, Serialize)]
pub struct SdofCalibration {
    /// Rig with the fitted values; `unknown` stays, as a fitted value is no more certain than its interval.
    #[serde(skip)]
    pub rig: Rig,
    /// Estimates of the unknown parameters that the data determine.
    pub estimates: Vec<Estimate>,
    /// Sentences on undetermined parameters.
    pub undetermined: Vec<String>,
    /// Method of the estimates.
    pub method: Method,
    /// Error on held-out recordings; `None` if the data are too short to hold any out.
    pub held_out: Option<HeldOutError>,
    /// Held-out recordings, by the rig of the file and by one fitted to the others.
    #[serde(skip)]
    pub traces: Vec<HeldOutTrace>,
    /// Standard deviation of the sensor's noise in its unit, from the spectrum above the signal's band.
    pub sensor_noise_std: f64,
    /// Frequency at which the gain of the balance's filter is one half, Hz.
    pub cutoff_hz: f64,
}

/// Fits the rig's unknown parameters to healthy recordings with channels `u` and `q` (or `qdd`).
///
/// The force balance gives a first estimate (IDIM-LS, Gautier, Janot, Vandanjon 2013), simulation over whole recordings
/// the final one if theory (68) accepts it. Intervals allow for correlated rows.
///
/// # Errors
///
/// A rig of another kind, recordings without the needed channels, no unknown parameter, or none that the data determine.
pub fn calibrate_sdof(rig: &Rig, recordings: &[Recording]) -> Result<SdofCalibration, BalanceError> {
    let machine = equation::machine(rig)?;
    let mut states = States::new(recordings)?;
    states.learn_hold(rig)?;
    let unknown = equation::unknown(rig);
    if unknown.is_empty() {
        return Err(BalanceError::Nothing { expected: "`unknown` to name at least one key of the rig".into() });
    }
    let found = fit(rig, &states, &unknown)?;
    let (held_out, traces) = held_out(rig, &states, &found.determined).unzip();
    let estimates = found
        .determined
        .iter()
        .zip(&found.fit.values)
        .zip(found.fit.half_widths())
        .map(|((parameter, value), half)| Estimate {
            key: parameter.key().to_string(),
            unit: parameter.unit(),
            guess: parameter.value_in(machine),
            value: *value,
            interval95: [value - half, value + half],
        })
        .collect();
    Ok(SdofCalibration {
        rig: found.rig,
        estimates,
        undetermined: found.undetermined,
        method: found.method,
        held_out,
        traces: traces.unwrap_or_default(),
        sensor_noise_std: states.band.noise_std,
        cutoff_hz: states.cutoff_hz(),
    })
}

/// A fit of the rig's own parameters.
pub struct OwnFit {
    /// Rig with the fitted parameters.
    pub rig: Rig,
    /// Determined parameters.
    pub determined: Vec<Parameter>,
    /// Values and covariance in the order of `determined`.
    pub fit: Fit,
    /// Method of the estimates.
    pub method: Method,
    /// Sentences on undetermined parameters.
    pub undetermined: Vec<String>,
}

/// Fits the parameters `unknown`.
///
/// # Errors
///
/// A rig of another kind, or no parameter that the data determine.
pub fn fit(rig: &Rig, states: &States, unknown: &[Parameter]) -> Result<OwnFit, BalanceError> {
    let equation = Equation::new(rig, states)?;
    let (determined, mut undetermined) = determined(&equation, unknown);
    let nothing = || BalanceError::Nothing { expected: "recordings in which an unknown parameter shows".into() };
    if determined.is_empty() {
        return Err(nothing());
    }
    let balance = balance(&equation, &determined, states).ok_or_else(nothing)?;
    let mut start = rig.clone();
    for (parameter, value) in determined.iter().zip(&balance.values) {
        // An estimate out of range, such as a slightly negative damping, is raised to the least value.
        let value =
            if rig.domain(parameter.key().into()).is_some_and(|d| d.holds(*value)) { *value } else { value.max(1e-9) };
        start.set(parameter.key(), value)?;
    }
    let keys: Vec<RigKey> = determined.iter().map(|p| p.key().into()).collect();
    let refined = refined_whole(&start, &keys, states).filter(|refined| consistent(refined, states));
    let (rig, fit, method) = match refined {
        Some(Refined { rig, fit, .. }) => (rig, fit, Method::Simulation),
        None => (start, balance, Method::ForceBalance),
    };
    undetermined.extend(too_wide(&determined, &fit));
    Ok(OwnFit { rig, determined, fit, method, undetermined })
}

fn refined_whole(rig: &Rig, keys: &[RigKey], states: &States) -> Option<Refined> {
    let observed = states.observed();
    shooting::refine(rig, keys, &observed, &observed.spans(None))
}

/// Whether a simulation's residual is no more than the sensor's noise, theory (68).
pub fn consistent(refined: &Refined, states: &States) -> bool {
    let count: usize = states.tracks.iter().map(|t| t.len()).sum();
    let square: f64 = states.tracks.iter().flat_map(|t| &t.sensed).map(|x| x * x).sum();
    let signal = (square / count.max(1) as f64).sqrt();
    refined.rms <= (SETTINGS.max_noise_ratio * states.band.noise_std).max(SETTINGS.max_signal_ratio * signal)
}

/// Least squares of the balance on the columns of `unknown`, theory (62) and (66).
pub fn balance(equation: &Equation, unknown: &[Parameter], states: &States) -> Option<Fit> {
    let columns: Vec<Vec<f64>> = unknown.iter().map(|p| equation.column(*p).to_vec()).collect();
    let target = equation.target(unknown);
    let groups: Vec<usize> = states.tracks.iter().map(|t| t.rows.len()).collect();
    let rough = regression::least_squares(&columns, &target, &groups, SETTINGS.min_lags)?;
    let lags = regression::correlation_length(&rough.residual, &groups);
    regression::least_squares(&columns, &target, &groups, lags)
}

/// Parameters that can be fitted together, and sentences on the others.
pub fn determined(equation: &Equation, unknown: &[Parameter]) -> (Vec<Parameter>, Vec<String>) {
    let (mut left, mut sentences) = (unknown.to_vec(), Vec::new());
    // The last of a dependent set keeps its value: the gain before the mass.
    loop {
        let columns: Vec<Vec<f64>> = left.iter().map(|p| equation.column(*p).to_vec()).collect();
        let Some(open) = regression::undetermined(&columns).into_iter().next() else { break };
        let names: Vec<&str> = open.parts.iter().map(|(j, _)| left[*j].key().name()).collect();
        let Some(keep) = open.parts.iter().map(|(j, _)| *j).max() else { break };
        sentences.push(if names.len() == 1 {
            format!("{} does not show in these recordings; it keeps its value", names[0])
        } else {
            format!(
                "only a combination of {} shows in these recordings; {} keeps its value",
                names.join(", "),
                left[keep].key()
            )
        });
        left.remove(keep);
    }
    let size = regression::norm(&equation.target(&left));
    let force = regression::norm(equation.column(Parameter::Gain)) * equation.rig.input_gain_n_per_unit.abs();
    let scale = left.iter().position(|p| *p == Parameter::Gain);
    if let Some(gain) = scale.filter(|_| size <= 1e-9 * force) {
        sentences.push(format!(
            "only the ratios of {} show in these recordings; {} keeps its value",
            left.iter().map(|p| p.key().name()).collect::<Vec<_>>().join(", "),
            Parameter::Gain.key()
        ));
        left.remove(gain);
    }
    (left, sentences)
}

/// Sentences on parameters whose interval is wider than their value.
fn too_wide(parameters: &[Parameter], fit: &Fit) -> Vec<String> {
    let half = fit.half_widths();
    let wide = |i: &usize| half[*i] > SETTINGS.max_half_width * fit.values[*i].abs();
    let mut sentences = Vec::new();
    for i in (0..parameters.len()).filter(wide) {
        let variance = |j: usize| fit.covariance[j][j].max(f64::MIN_POSITIVE);
        let correlation = |j: usize| fit.covariance[i][j] / (variance(i) * variance(j)).sqrt();
        let tied = |j: &usize| *j != i && correlation(*j).abs() > SETTINGS.max_correlation;
        let partners: Vec<&str> = (0..parameters.len()).filter(tied).map(|j| parameters[j].key().name()).collect();
        let key = parameters[i].key();
        sentences.push(if partners.is_empty() {
            format!("{key} is not determined: its interval is wider than its value")
        } else {
            format!("{key} is not determined apart from {}", partners.join(", "))
        });
    }
    sentences
}

/// Error on held-out recordings of a fit to the others.
fn held_out(rig: &Rig, states: &States, unknown: &[Parameter]) -> Option<(HeldOutError, Vec<HeldOutTrace>)> {
    let (train, test, recordings) = states.split()?;
    let after = fit(rig, &train, unknown).ok()?;
    let balance = |rig: &Rig| {
        let target = Equation::new(rig, &test).ok()?.target(&[]);
        Some(regression::norm(&target) / (target.len().max(1) as f64).sqrt())
    };
    let window = (after.method == Method::ForceBalance).then(|| test.short_window());
    let shortest = test.tracks.iter().map(|t| t.len()).min()?;
    let observed = test.observed();
    let spans = observed.spans(window);
    let error = HeldOutError {
        recordings,
        balance_before_n: balance(rig)?,
        balance_after_n: balance(&after.rig)?,
        simulation_before: shooting::error(rig, &observed, &spans),
        simulation_after: shooting::error(&after.rig, &observed, &spans),
        window_s: window.unwrap_or(shortest) as f64 * test.step_s(),
    };
    Some((error, traces::simulated(rig, &after.rig, &test)))
}

#[cfg(test)]
mod tests;
