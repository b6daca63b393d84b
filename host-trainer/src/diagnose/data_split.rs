//! Split of a bearing rig's recordings: fitted, held out, subset for screening.

use super::DiagnoseError;
use crate::identify::calibrate::split::{Split, part};
use crate::identify::likelihood::observed::Observed;
use crate::recording::Recording;

/// Length of the beginnings that all hypotheses are first tried on, s.
const BRIEF_S: f64 = 0.4;

/// Recordings by their use.
pub struct DataSplit {
    /// Fitted and held-out recordings.
    pub split: Split,
    /// Fitted recordings, observed.
    pub fitted: Vec<Observed>,
    /// Held-out recordings, observed.
    pub held_out: Vec<Observed>,
    /// Subset: the fitted recordings of least and greatest load, which differ by load effects.
    pub subset: Vec<Observed>,
    /// Indices of the subset among the fitted.
    pub which: Vec<usize>,
    /// Beginnings of the subset.
    pub beginnings: Vec<Observed>,
    /// Mean load over all recordings, N.
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
