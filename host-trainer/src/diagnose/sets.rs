//! Recordings of a bearing rig by the part that they take in a diagnosis.

use super::DiagnoseError;
use crate::calibrate::split::{Split, part};
use crate::recording::Recording;
use crate::whittle::observed::Observed;

/// Length of the beginnings that all hypotheses are first tried on, s.
const BRIEF_S: f64 = 0.4;

/// Recordings by the part that they take.
pub struct Sets {
    /// Which took part, and which not.
    pub split: Split,
    /// What is fitted.
    pub fitted: Vec<Observed>,
    /// What took no part.
    pub held_out: Vec<Observed>,
    /// Those of the least and the greatest load among the fitted ones: what depends on it shows between them.
    pub few: Vec<Observed>,
    /// Their places among the fitted.
    pub which: Vec<usize>,
    /// Their beginnings.
    pub brief: Vec<Observed>,
    /// Mean over all recordings.
    pub load_n: f64,
}

impl Sets {
    /// Splits recordings, at least one.
    ///
    /// # Errors
    /// Recordings without acceleration, speed or load.
    pub fn of(recordings: &[Recording]) -> Result<Self, DiagnoseError> {
        let split = Split::of(recordings);
        let which = extremes(&split.fitted);
        let few: Vec<Recording> = which.iter().map(|n| split.fitted[*n].clone()).collect();
        let beginning = |r: &Recording| part(r, 0..r.len().min((BRIEF_S * r.sample_rate_hz) as usize));
        let brief: Vec<Recording> = few.iter().map(beginning).collect();
        Ok(Self {
            fitted: Observed::of_all(&split.fitted)?,
            held_out: Observed::of_all(&split.held_out)?,
            few: Observed::of_all(&few)?,
            which,
            brief: Observed::of_all(&brief)?,
            load_n: recordings.iter().filter_map(|r| r.load_n).sum::<f64>() / recordings.len() as f64,
            split,
        })
    }
}

/// The recordings of the least and of the greatest load; one where that is the same.
fn extremes(recordings: &[Recording]) -> Vec<usize> {
    let load = |n: &usize| recordings[*n].load_n.unwrap_or_default();
    let least = (0..recordings.len()).min_by(|a, b| load(a).total_cmp(&load(b)));
    let greatest = (0..recordings.len()).max_by(|a, b| load(a).total_cmp(&load(b)));
    least.into_iter().chain(greatest.filter(|g| Some(*g) != least)).collect()
}
