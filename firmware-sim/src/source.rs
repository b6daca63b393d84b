//! Sources of a device's samples and of notices of missing ones.
//!
//! A source is an iterator over the [`Arrival`]s of one recording, which ends with the iterator. Pacing and
//! [faults](crate::faults) are sources over a source.

use std::time::{Duration, Instant};

/// Input of the device from the converter's interrupt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival {
    /// A sample, m/s².
    Sample(f32),
    /// Number of missing samples that the hardware detected (an overrun flag, a sequence number).
    Missing(u32),
}

impl Arrival {
    /// Number of sample periods.
    pub const fn periods(self) -> u32 {
        match self {
            Self::Sample(_) => 1,
            Self::Missing(count) => count,
        }
    }
}

/// Arrivals of one recording; every iterator over them is a source.
pub trait SampleSource: Iterator<Item = Arrival> + Sized {
    /// Source paced to at most a rate, samples per second: the recording's sample rate times a speed-up. Not paced if
    /// the rate is not a positive number.
    fn paced(self, rate_hz: f64) -> Paced<Self> {
        Paced { source: self, rate_hz, periods: 0, block: pace_block(rate_hz), start: None }
    }
}

impl<S: Iterator<Item = Arrival>> SampleSource for S {}

/// Source of samples in memory, m/s², not paced.
pub fn in_memory(samples: &[f32]) -> impl SampleSource + '_ {
    samples.iter().map(|sample| Arrival::Sample(*sample))
}

/// Source of [`SampleSource::paced`].
#[derive(Debug)]
pub struct Paced<S> {
    source: S,
    rate_hz: f64,
    periods: u64,
    /// Sample periods between two sleeps: a host's sleep is too coarse for each sample.
    block: u64,
    start: Option<Instant>,
}

/// Samples of about 5 ms, too short to be seen as steps.
fn pace_block(rate_hz: f64) -> u64 {
    (rate_hz * 5e-3).max(1.0) as u64
}

impl<S: SampleSource> Iterator for Paced<S> {
    type Item = Arrival;

    fn next(&mut self) -> Option<Arrival> {
        let arrival = self.source.next()?;
        let start = *self.start.get_or_insert_with(Instant::now);
        let before = self.periods;
        self.periods += u64::from(arrival.periods());
        if before / self.block != self.periods / self.block && self.rate_hz > 0.0 {
            // From the start, not the last sleep, so that errors of the sleeps do not add up.
            let due = Duration::try_from_secs_f64(self.periods as f64 / self.rate_hz).unwrap_or_default();
            std::thread::sleep(due.saturating_sub(start.elapsed()));
        }
        Some(arrival)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pace_is_kept_and_changes_nothing() {
        let samples = [1.0, 2.0, 3.0].repeat(40);
        let start = Instant::now();
        let paced: Vec<_> = in_memory(&samples).chain([Arrival::Missing(80)]).paced(2000.0).collect();
        assert!(start.elapsed() >= Duration::from_millis(95), "{:?}", start.elapsed());
        assert_eq!(paced.len(), 121);
        assert!(paced.iter().copied().eq(in_memory(&samples).chain([Arrival::Missing(80)])));
        for no_rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(in_memory(&samples).paced(no_rate).count(), 120);
        }
    }
}
