//! Recordings of a bearing rig by the part that they take in a diagnosis.

use super::DiagnoseError;
use crate::identify::calibrate::split::{Split, part};
use crate::identify::likelihood::observed::Observed;
use crate::recording::Recording;

/// Length of the beginnings that all hypotheses are first tried on, s.
const BRIEF_S: f64 = 0.4;

/// Recordings by the part that they take.
pub struct DataSplit {
    /// Which took part, and which not.
    pub split: Split,
    /// What is fitted.
    pub fitted: Vec<Observed>,
    /// What took no part.
    pub held_out: Vec<Observed>,
    /// Those of the least and the greatest load among the fitted ones: what depends on it shows between them.
    pub subset: Vec<Observed>,
    /// Their places among the fitted.
    pub which: Vec<usize>,
    /// Their beginnings.
    pub beginnings: Vec<Observed>,
    /// Mean over all recordings.
    pub load_n: f64,
}

impl DataSplit {
    /// Splits recordings, at least one.
    ///
    /// # Errors
    /// Recordings without acceleration, speed or load.
    pub fn new(recordings: &[Recording]) -> Result<Self, DiagnoseError> {
        let split = Split::new(recordings);
        let which = extremes(&split.fitted);
        let subset: Vec<Recording> = which.iter().map(|n| split.fitted[*n].clone()).collect();
        let beginning = |r: &Recording| part(r, 0..r.len().min((BRIEF_S * r.sample_rate_hz) as usize));
        let beginnings: Vec<Recording> = subset.iter().map(beginning).collect();
        Ok(Self {
            fitted: Observed::from_recordings(&split.fitted)?,
            held_out: Observed::from_recordings(&split.held_out)?,
            subset: Observed::from_recordings(&subset)?,
            which,
            beginnings: Observed::from_recordings(&beginnings)?,
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
