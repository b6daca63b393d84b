//! Aging phases of a machine's life: start of aging by kurtosis, start of failure by RMS, theory (100), (101).
//!
//! | module | holds |
//! |---|---|
//! | this one | the rules, and the phases of a life |
//! | [`life`] | features of recordings, their order in time |
//! | [`machine`] | every channel of a machine, raw and denoised |
//!
//! The start of aging is the first prediction time (FPT) of N. Li, Y. Lei, J. Lin, S. X. Ding, "An improved exponential model for
//! predicting remaining useful life of rolling element bearings", IEEE Trans. Ind. Electron. 62 (2015) 7762–7773.

pub mod life;
pub mod machine;

use serde::Serialize;

use self::life::Features;
use super::settings::PhaseSettings;

/// Rules for the phases of a life.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rules {
    /// Recordings at the beginning that are healthy; `None` for a quarter, at least 10 and at most 100.
    pub healthy: Option<usize>,
    /// Standard deviations of the healthy kurtosis within which a recording is healthy.
    pub sigmas: f64,
    /// Increments of the RMS that are compared.
    pub failure: FailureRule,
    /// Ratio of the increments from which a machine fails.
    pub ratio: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Self { healthy: None, sigmas: 3.0, failure: FailureRule::Largest, ratio: 3.0 }
    }
}

/// Value that is refused: its name, what was found, and what is expected.
pub type Refused = (&'static str, String, String);

/// A number that is not positive, refused by its name; `unit` follows what is expected.
pub fn not_positive(name: &'static str, value: f64, unit: &str) -> Option<Refused> {
    let is_positive = value.is_finite() && value > 0.0;
    (!is_positive).then(|| (name, value.to_string(), format!("a positive number{unit}")))
}

impl Rules {
    /// First value that no life can be judged by.
    pub fn refused(&self) -> Option<Refused> {
        let fewest = self.healthy.filter(|count| *count < FEWEST_HEALTHY);
        let few = fewest.map(|count| ("healthy", count.to_string(), format!("at least {FEWEST_HEALTHY}")));
        few.or_else(|| not_positive("sigmas", self.sigmas, "")).or_else(|| not_positive("ratio", self.ratio, ""))
    }
}

/// Increments of the RMS against which an increment is compared. The paper's text, d_(j+1) > 3 d_j, can be read in each way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum FailureRule {
    /// The one before it, as written: any rise after a fall is a failure.
    Successive,
    /// The one before it, if that is a rise.
    Rising,
    /// The largest before it in the machine's life, rise or fall.
    Largest,
}

impl FailureRule {
    /// All rules.
    pub const ALL: [Self; 3] = [Self::Successive, Self::Rising, Self::Largest];
}

/// Phases of a life, as indices of recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Phases {
    /// Healthy recordings at the beginning.
    pub healthy: usize,
    /// Mean of their kurtosis.
    pub mean: f64,
    /// Its standard deviation.
    pub std: f64,
    /// First recording of the aging phase; `None` if the machine does not age.
    pub aging: Option<usize>,
    /// Recordings in a row outside the limits that start it.
    pub in_a_row: usize,
    /// First recording of the failure; `None` if there is none.
    pub failure: Option<usize>,
}

impl Phases {
    /// Recordings from the start of aging to that of the failure, or to the end of `recordings` without one.
    pub fn between(&self, recordings: usize) -> Option<usize> {
        Some(self.failure.unwrap_or(recordings) - self.aging?)
    }
}

const SETTINGS: PhaseSettings = PhaseSettings::DEFAULT;
/// Fewest healthy recordings.
pub const FEWEST_HEALTHY: usize = SETTINGS.fewest_healthy;

/// Phases of a life by the features of its recordings; `follows` says which of them follow the one before without a gap. `None`
/// if no recording remains after the healthy ones, or these are fewer than [`FEWEST_HEALTHY`].
///
/// ```
/// use ballrace::signal::phases::{Rules, life::Features, phases};
/// let life: Vec<Features> = (0..100)
///     .map(|n| Features { kurtosis: 3.0 + 0.1 * f64::from(n % 3) + if n < 60 { 0.0 } else { 2.0 }, rms: 1.0 })
///     .collect();
/// assert_eq!(phases(&life, &[true; 100], &Rules::default()).unwrap().aging, Some(60));
/// ```
pub fn phases(life: &[Features], follows: &[bool], rules: &Rules) -> Option<Phases> {
    let healthy = rules.healthy.unwrap_or((life.len() / 4).clamp(FEWEST_HEALTHY, SETTINGS.most_healthy));
    if healthy < FEWEST_HEALTHY || healthy >= life.len() {
        return None;
    }
    let known: Vec<f64> = life[..healthy].iter().map(|f| f.kurtosis).filter(|k| k.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    let std = (known.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / known.len() as f64).sqrt();
    let is_outside = |n: usize| (life[n].kurtosis - mean).abs() > rules.sigmas * std;
    let runs = runs(healthy..life.len(), is_outside, follows);
    let aging = first_stable(&runs);
    Some(Phases {
        healthy,
        mean,
        std,
        aging: aging.map(|(start, _)| start),
        in_a_row: aging.map_or(0, |(_, count)| count),
        failure: aging.and_then(|(start, _)| failure(life, follows, start, rules)),
    })
}

/// First recording and number of each run of recordings outside the limits; a gap ends a run.
fn runs(range: std::ops::Range<usize>, is_outside: impl Fn(usize) -> bool, follows: &[bool]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for n in range.filter(|n| is_outside(*n)) {
        match runs.last_mut() {
            Some((start, count)) if *start + *count == n && follows[n] => *count += 1,
            _ => runs.push((n, 1)),
        }
    }
    runs
}

/// First of the l + 1 recordings in a row outside the limits, l raised from 0 until it moves no further, and l + 1.
fn first_stable(runs: &[(usize, usize)]) -> Option<(usize, usize)> {
    let first = |count: usize| runs.iter().find(|run| run.1 >= count).map(|run| run.0);
    let mut before = first(1)?;
    for count in 2.. {
        let now = first(count)?;
        if now == before {
            return Some((now, count));
        }
        before = now;
    }
    None
}

/// First recording after the start of aging whose increment of the RMS is large.
fn failure(life: &[Features], follows: &[bool], aging: usize, rules: &Rules) -> Option<usize> {
    let increment = |n: usize| (n > 0 && follows[n]).then(|| life[n].rms - life[n - 1].rms);
    let mut largest = (1..=aging).filter_map(increment).fold(0.0, |most: f64, d| most.max(d.abs()));
    for n in aging + 1..life.len() {
        let Some(now) = increment(n) else { continue };
        let before = increment(n - 1).filter(|_| n > aging + 1);
        let is_large = match rules.failure {
            FailureRule::Successive => before.is_some_and(|before| now > rules.ratio * before),
            FailureRule::Rising => before.is_some_and(|before| before > 0.0 && now > rules.ratio * before),
            FailureRule::Largest => now > rules.ratio * largest,
        };
        if is_large {
            return Some(n);
        }
        largest = largest.max(now.abs());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::test_signals::gaussian;

    fn life(kurtosis: impl Fn(usize) -> f64, rms: impl Fn(usize) -> f64, count: usize) -> Vec<Features> {
        let noise = gaussian(count, 5);
        (0..count).map(|n| Features { kurtosis: kurtosis(n) + 0.1 * noise[n], rms: rms(n) }).collect()
    }

    fn found(life: &[Features], failure: FailureRule) -> Phases {
        phases(life, &vec![true; life.len()], &Rules { failure, ..Rules::default() }).unwrap()
    }

    #[test]
    fn a_single_shock_does_not_start_the_aging() {
        let kurtosis = |n: usize| if n == 150 || n >= 300 { 6.0 } else { 3.0 };
        let found = found(&life(kurtosis, |_| 1.0, 400), FailureRule::Largest);
        assert_eq!((found.aging, found.in_a_row, found.failure, found.healthy), (Some(300), 3, None, 100));
    }

    #[test]
    fn a_failure_is_where_the_rms_jumps() {
        let kurtosis = |n: usize| if n >= 200 { 6.0 } else { 3.0 };
        let rms = |n: usize| if n >= 320 { 3.0 } else { 1.0 + if n.is_multiple_of(2) { 0.01 } else { -0.01 } };
        let life = life(kurtosis, rms, 400);
        assert_eq!(found(&life, FailureRule::Largest).failure, Some(320));
        // As written, any rise after a fall counts.
        assert_eq!(found(&life, FailureRule::Successive).failure, Some(202));
    }

    #[test]
    fn a_gap_ends_a_run_and_is_no_increment() {
        let kurtosis = |n: usize| if (150..152).contains(&n) || n >= 200 { 6.0 } else { 3.0 };
        let rms = |n: usize| if n >= 260 { 3.0 } else { 1.0 + 0.01 * (n % 2) as f64 };
        let life = life(kurtosis, rms, 300);
        let mut follows = vec![true; 300];
        follows[151] = false;
        follows[260] = false;
        let found = phases(&life, &follows, &Rules::default()).unwrap();
        assert_eq!((found.aging, found.failure), (Some(200), None));
    }

    #[test]
    fn null_a_machine_that_never_ages_has_no_aging_phase() {
        let found = found(&life(|_| 3.0, |_| 1.0, 3000), FailureRule::Largest);
        assert_eq!((found.aging, found.failure), (None, None));
    }

    #[test]
    fn a_life_that_is_too_short_has_no_phases() {
        let life = life(|_| 3.0, |_| 1.0, 10);
        assert_eq!(phases(&life, &[true; 10], &Rules::default()), None);
        assert_eq!(phases(&life, &[true; 10], &Rules { healthy: Some(3), ..Rules::default() }), None);
    }

    #[test]
    fn a_constant_channel_does_not_age() {
        let life = vec![Features { kurtosis: f64::NAN, rms: 0.0 }; 50];
        assert_eq!(found(&life, FailureRule::Largest).aging, None);
    }
}
