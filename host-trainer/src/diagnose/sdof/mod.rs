//! Diagnosis of the rig of one degree of freedom.
//!
//! | module | stage |
//! |---|---|
//! | `acquire`, `faults`, `hum` | recordings to states; faults of the samples marked, taken off or cut out |
//! | `nominal`, `rough` | the rig's own parameters: which are fitted, what sets the scale; noise, course and delay of the input |
//! | `library`, `terms`, `flexible` | columns of a regression: terms with a name, and others without |
//! | `table`, `select`, `blocks` | cross-validated models of them; none, one, two, seldom three; whether one gains beyond chance |
//! | `causes`, `validate` | effects of the vocabulary, fitted by simulation and judged on what they were not fitted to |
//! | `repeating` | tones, and forces that repeat along the travel, in what a model leaves |
//! | `verdict`, `held_out` | the gate that every cause passes, on held-out stretches |
//! | `report`, `text`, `curve` | what stands, and in which words |
//! | `settings` | thresholds, lengths and counts |

mod acquire;
mod blocks;
mod causes;
mod curve;
mod faults;
mod flexible;
mod held_out;
mod hum;
mod library;
mod nominal;
mod repeating;
mod report;
mod rough;
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
use hum::Hum;
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
    let mut nominal = Nominal::new(machine, equation::unknown(task.rig), &acquired);
    progress("fitting the rig's unknown parameters");
    let mut ratio = rough::fit(task.rig, &mut nominal, &mut acquired);
    let nothing = || crate::identify::force_balance::BalanceError::Nothing {
        expected: "parameters that the recordings determine".into(),
    };
    progress("selecting terms on held-out recordings");
    let healthy = |acquired: &Acquired| acquired.tracks.iter().map(|t| t.healthy).collect::<Vec<_>>();
    // A step of the load needs some time before and after it.
    let events = acquired.under_test().all(|t| t.len() >= SETTINGS.least_for_events);
    let select = |nominal: &Nominal, acquired: &Acquired, ratio: f64| {
        let library = Builder::new(task.rig, nominal, acquired, ratio).library(events);
        let table = Table::new(library, &healthy(acquired));
        let selection = select::select(&table).ok_or_else(nothing)?;
        Ok::<_, DiagnoseError>((table, selection))
    };
    // Known parameters are right within a tolerance only.
    let adjusted = |nominal: &mut Nominal, acquired: &mut Acquired, ratio: f64| {
        let (mut table, mut selection) = select(nominal, acquired, ratio)?;
        for _ in 0..SETTINGS.adjustments {
            let machine = table.machine(nominal, &selection.chosen);
            let causes = causes::causes(&table, &selection.chosen, &machine, acquired);
            let zero: f64 = causes.iter().filter_map(|cause| cause.offset(&machine, acquired.sensed)).sum();
            let is_shifted = acquired.shift_zero(zero);
            if is_shifted {
                acquired.smooth()?;
            }
            if !nominal.adjust(&causes) && !is_shifted {
                break;
            }
            (table, selection) = select(nominal, acquired, ratio)?;
        }
        Ok::<_, DiagnoseError>((table, selection))
    };
    let (mut table, mut selection) = adjusted(&mut nominal, &mut acquired, ratio)?;
    let hum = Hum::find(&Builder::new(task.rig, &nominal, &acquired, ratio), &table, &selection.rich);
    if let Some(hum) = hum {
        hum.take_off(&mut acquired);
        acquired.smooth()?;
        faults.push(hum.fault);
        ratio = rough::fit(task.rig, &mut nominal, &mut acquired);
        (table, selection) = adjusted(&mut nominal, &mut acquired, ratio)?;
    }
    if faults.is_empty() {
        let most = acquired.tracks.len();
        while acquired.tracks.len() < 2 * most
            && let Some(fault) = faults::burst(&mut acquired, &nominal.rig(task.rig), &table, &selection.rich)
        {
            if faults.iter().all(|f| f.entry.kind != fault.entry.kind) {
                faults.push(fault);
            }
            acquired.smooth()?;
            (table, selection) = adjusted(&mut nominal, &mut acquired, ratio)?;
        }
    }
    progress("simulating held-out recordings");
    let case = verdict::Case { task, nominal: &nominal, acquired: &acquired, original: &original, table: &table };
    let judged = case.judge(selection, faults);
    Ok(report::result(&case, judged))
}
