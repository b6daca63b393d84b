//! Diagnosis of the rig of one degree of freedom.
//!
//! | module | stage |
//! |---|---|
//! | `acquire`, `faults` | recordings to states; faults of the samples marked, taken off or cut out |
//! | `nominal` | the rig's own parameters: which are fitted, what sets the scale |
//! | `library`, `terms`, `flexible` | columns of a regression: terms with a name, and others without |
//! | `table`, `select` | cross-validated models of them; none, one, two, seldom three |
//! | `causes`, `validate` | effects of the vocabulary, fitted by simulation and judged on what they were not fitted to |
//! | `repeating` | tones, and forces that repeat along the travel, in what a model leaves |
//! | `verdict`, `held_out` | the gate that every cause passes, on held-out stretches |
//! | `report`, `text`, `curve` | what stands, and in which words |
//! | `settings` | thresholds, lengths and counts |

mod acquire;
mod causes;
mod curve;
mod faults;
mod flexible;
mod held_out;
mod library;
mod nominal;
mod repeating;
mod report;
mod select;
mod settings;
mod table;
mod terms;
#[cfg(test)]
mod tests;
mod text;
mod validate;
mod verdict;

use super::result::DiagnosisResult;
use super::{DiagnoseError, Task};
use crate::identify::force_balance::equation;
use acquire::Acquired;
use library::Builder;
use nominal::Nominal;
use settings::SdofSettings;
use table::Table;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// Diagnoses a rig of one degree of freedom: named causes, no mismatch, or a mismatch that no cause of the vocabulary
/// explains.
///
/// `baseline` are recordings of the healthy machine: unknown parameters are fitted to them and to the others alike, effects
/// act on the others only. Without any, unknown parameters are fitted together with each hypothesis.
///
/// # Errors
///
/// A rig of another kind, recordings without the needed channels or with too few samples.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let machine = equation::machine(task.rig)?;
    progress("estimating states");
    let mut acquired = Acquired::new(task.recordings, task.baseline.unwrap_or_default())?;
    let original = acquired.clone();
    let mut faults = faults::clean(&mut acquired)?;
    let unknown = equation::unknown(task.rig);
    let mut nominal = Nominal::new(machine, unknown.clone(), &acquired);
    progress("fitting the rig's unknown parameters");
    let ratio = fit_nominal(task, &mut nominal, &mut acquired)?;
    let nothing = || crate::identify::force_balance::BalanceError::Nothing {
        expected: "parameters that the recordings determine".into(),
    };
    progress("selecting terms on held-out recordings");
    let healthy = |acquired: &Acquired| acquired.tracks.iter().map(|t| t.healthy).collect::<Vec<_>>();
    // A step of the load needs some time before and after it.
    let events = acquired.under_test().all(|t| t.len() >= SETTINGS.least_for_events);
    let select = |nominal: &Nominal, acquired: &Acquired| {
        let library = Builder::new(task.rig, nominal, acquired, ratio).library(events);
        let table = Table::new(library, &healthy(acquired));
        let selection = select::select(&table).ok_or_else(nothing)?;
        Ok::<_, DiagnoseError>((table, selection))
    };
    // Known parameters are right within a tolerance only.
    let adjusted = |nominal: &mut Nominal, acquired: &Acquired| {
        let (mut table, mut selection) = select(nominal, acquired)?;
        for _ in 0..SETTINGS.adjustments {
            let machine = table.machine(nominal, &selection.chosen);
            if !nominal.adjust(&causes::causes(&table, &selection.chosen, &machine, acquired)) {
                break;
            }
            (table, selection) = select(nominal, acquired)?;
        }
        Ok::<_, DiagnoseError>((table, selection))
    };
    let (mut table, mut selection) = adjusted(&mut nominal, &acquired)?;
    if faults.is_empty() {
        let most = acquired.tracks.len();
        while acquired.tracks.len() < 2 * most
            && let Some(fault) = faults::burst(&mut acquired, &nominal.rig(task.rig), &table, &selection.rich)
        {
            if faults.iter().all(|f| f.entry.kind != fault.entry.kind) {
                faults.push(fault);
            }
            acquired.smooth()?;
            (table, selection) = adjusted(&mut nominal, &acquired)?;
        }
    }
    progress("simulating held-out recordings");
    let case = verdict::Case { task, nominal: &nominal, acquired: &acquired, original: &original, table: &table };
    let judged = case.judge(selection, faults);
    Ok(report::result(&case, judged))
}

/// Fits the unknown parameters roughly, learns the input's course between samples, and the ratio of force noise to sensor
/// noise of greatest likelihood beside a few nonlinear terms.
fn fit_nominal(task: &Task, nominal: &mut Nominal, acquired: &mut Acquired) -> Result<f64, DiagnoseError> {
    use crate::identify::force_balance::gram::{Gram, Rows};
    use crate::rig::sdof::Interpolation;
    let (low, high, count) = SETTINGS.force_noise;
    let mut noise = acquired.noise_std.powi(2);
    let mut part = acquired.beginning(SETTINGS.noise_samples);
    let mut best: Option<(f64, f64, Interpolation, f64)> = None;
    for round in 0..2 {
        let force = mean_square_force(nominal, acquired);
        let rate = acquired.tracks[0].sample_rate_hz;
        let ratio = |log: f64| (10f64.powf(log) * force / rate / noise.max(f64::MIN_POSITIVE)).max(1e-300);
        best = None;
        let courses: &[Interpolation] = if acquired.driven {
            &[Interpolation::Hold, Interpolation::Linear, Interpolation::Smooth]
        } else {
            &[Interpolation::Hold]
        };
        let mut change = Vec::new();
        for interpolation in courses {
            part.interpolation = *interpolation;
            for cell in 0..count {
                let log = low + (high - low) * cell as f64 / (count - 1) as f64;
                let library = Builder::new(task.rig, nominal, &part, ratio(log)).rough();
                let rows = library.columns[0].len();
                let gram = Gram::new(&library.columns, &[rows], &[0], 0);
                let columns: Vec<usize> = (1..library.columns.len()).collect();
                let Some(values) = gram.solve(&columns, &[], Rows::All, table::RIDGE) else { continue };
                let left = gram.left_in(&columns, &values, Rows::All).max(f64::MIN_POSITIVE);
                let value = -(rows as f64 * left.ln() + library.log_variance);
                if best.is_none_or(|(most, ..)| value > most) {
                    best = Some((value, ratio(log), *interpolation, left / rows as f64));
                    let own: Vec<usize> = library.own.iter().map(|(_, column, _)| *column).collect();
                    let alone = gram.solve(&own, &[], Rows::All, 0.0).unwrap_or_default();
                    change = library.own.iter().zip(alone).map(|((p, ..), v)| (*p, v)).collect();
                }
            }
        }
        // The rig's dynamics tell noise from motion where a spline takes fast motion for either.
        noise = best.map_or(noise, |(.., left)| left);
        if round == 0 {
            change.into_iter().for_each(|(parameter, value): (equation::Parameter, f64)| nominal.add(parameter, value));
        }
    }
    let (_, ratio, interpolation, _) = best.unwrap_or((0.0, 1.0, Interpolation::Hold, noise));
    acquired.interpolation = interpolation;
    acquired.noise_std = noise.sqrt();
    Ok(ratio)
}

/// Mean square of the largest force of the balance, N².
fn mean_square_force(nominal: &Nominal, acquired: &Acquired) -> f64 {
    let (mut sums, mut count) = ([0.0f64; 4], 0.0f64);
    let machine = &nominal.machine;
    for track in &acquired.tracks {
        let states = &track.states;
        for ((q, v), a) in states.position.iter().zip(&states.velocity).zip(&states.acceleration) {
            let forces = [machine.mass_kg * a, machine.damping_n_s_per_m * v, machine.stiffness_n_per_m * q];
            (0..3).for_each(|i| sums[i] += forces[i] * forces[i]);
        }
        count += states.position.len() as f64;
        let scale = machine.input_gain_n_per_unit.powi(2) * track.fine as f64;
        sums[3] += scale * track.input.iter().map(|u| u * u).sum::<f64>();
    }
    sums.iter().fold(0.0f64, |most, s| most.max(*s)) / count.max(1.0)
}
