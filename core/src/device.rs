//! Device of one channel, the firmware's interface: screen, evaluator and monitor, theory (85).
//!
//! This code runs on the microcontroller, in the host's `monitor` command and in the tests.

use serde::Serialize;

use crate::evaluator::{self, Evaluator, Step};
use crate::input_check::{FaultCounts, Quality, Screen};
use crate::model::Model;
use crate::monitor::{BlockReport, Monitor, Status};

/// Screen, evaluator and monitor of one channel.
///
/// # Examples
///
/// A model of one virtual state whose library is 1 and z:
///
/// ```
/// use ballrace_core::device::Device;
/// use ballrace_core::model::Model;
///
/// let text = include_str!("../examples/least.json");
/// let mut storage = [[0; 4]; 64];
/// let model = Model::from_json(text, &mut storage)?;
/// let mut scratch = [0.0; 64];
/// let mut device = Device::new(&model, &mut scratch[..Device::scratch_len(&model)])?;
/// let broken = device.push(f32::NAN);
/// assert!(broken.step.is_none());
/// for k in 0..10 {
///     device.push((0.3 * k as f32) % 1.0);
/// }
/// assert!(device.push(0.1).step.is_some());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Device<'a, 's> {
    screen: Screen,
    evaluator: Evaluator<'a, 's>,
    monitor: Monitor,
}

/// Error of a scratch slice shorter than [`Device::scratch_len`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScratchTooSmall {
    /// Floats needed.
    pub needed: usize,
    /// Floats found.
    pub found: usize,
}

impl core::fmt::Display for ScratchTooSmall {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "scratch has {} floats, the model needs {}", self.found, self.needed)
    }
}

impl core::error::Error for ScratchTooSmall {}

/// Result of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleResult<'e> {
    /// Quality of the sample; only [`Quality::Good`] samples are evaluated.
    pub quality: Quality,
    /// Step of the model; `None` for a broken sample and while the differences fill.
    pub step: Option<Step<'e>>,
    /// Report of the monitor, if the sample ended a block.
    pub block: Option<BlockReport>,
}

/// Totals since the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Summary {
    /// Current status.
    pub status: Status,
    /// Counts of broken samples.
    pub faults: FaultCounts,
}

impl<'a, 's> Device<'a, 's> {
    /// Number of floats of scratch that a model needs.
    pub fn scratch_len(model: &Model<'_>) -> usize {
        evaluator::scratch_len(model)
    }

    /// Device before the first sample.
    ///
    /// # Errors
    /// [`ScratchTooSmall`] with the length needed.
    pub fn new(model: &'a Model<'a>, scratch: &'s mut [f32]) -> Result<Self, ScratchTooSmall> {
        let (needed, found) = (Self::scratch_len(model), scratch.len());
        let evaluator = Evaluator::new(model, scratch).ok_or(ScratchTooSmall { needed, found })?;
        Ok(Self { screen: Screen::new(model.screen), evaluator, monitor: Monitor::new(model.monitor) })
    }

    /// Takes a sample, m/s².
    pub fn push(&mut self, sample: f32) -> SampleResult<'_> {
        let quality = self.screen.check(sample);
        if quality != Quality::Good {
            // The next sample does not continue the last good one.
            self.evaluator.reset();
            return SampleResult { quality, step: None, block: self.broken(quality) };
        }
        let step = self.evaluator.step(sample);
        let block = match &step {
            Some(step) if step.comparable => self.monitor.residual(step.normalised_residuals()),
            _ => self.monitor.idle(),
        };
        SampleResult { quality, step, block }
    }

    /// Takes a sample that was screened and evaluated elsewhere, as a host does for many at once: its quality, and its
    /// normalised residuals if it has any.
    pub fn judge(
        &mut self,
        quality: Quality,
        residuals: Option<impl ExactSizeIterator<Item = f32>>,
    ) -> Option<BlockReport> {
        self.screen.count(quality);
        match residuals {
            _ if quality != Quality::Good => self.broken(quality),
            Some(residuals) => self.monitor.residual(residuals),
            None => self.monitor.idle(),
        }
    }

    fn broken(&mut self, quality: Quality) -> Option<BlockReport> {
        if quality == Quality::Stuck {
            // The first samples of the run were counted as good.
            self.monitor.discard();
        }
        if quality == Quality::Saturated { self.monitor.overload() } else { self.monitor.broken(1) }
    }

    /// Takes the number of samples not received; returns a report at the end of a block.
    pub fn missing(&mut self, count: u32) -> Option<BlockReport> {
        if count == 0 {
            return None;
        }
        self.screen.missing(count);
        self.evaluator.reset();
        self.monitor.broken(count)
    }

    /// Ends a recording: the next sample does not continue it, which is no fault.
    pub fn end_of_recording(&mut self) -> Option<BlockReport> {
        self.evaluator.reset();
        self.screen.end_of_recording();
        self.monitor.end_of_recording()
    }

    /// Current status and counts of broken samples.
    pub fn summary(&self) -> Summary {
        Summary { status: self.monitor.status(), faults: self.screen.counts() }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::states::{Alignment, Estimator, Orders, StateSpec};
    use crate::testing::{Parts, samples};
    use std::vec::Vec;

    const SAVITZKY_GOLAY: Estimator = Estimator::SavitzkyGolay { excess: 0, stretch: 1.25 };
    const KALMAN: Estimator = Estimator::Kalman { cutoff: 0.22 };

    fn spec(alignment: Alignment) -> StateSpec {
        StateSpec { dimension: 3, orders: Orders::Even, alignment, estimator: Estimator::Differences }
    }

    fn run(device: &mut Device<'_, '_>, samples: &[f32]) -> Vec<Option<Vec<u32>>> {
        let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let step = |s: &f32| device.push(*s).step.map(|s| [bits(s.states), bits(s.predicted)].concat());
        samples.iter().map(step).collect()
    }

    #[test]
    fn a_broken_sample_never_reads_as_healthy_and_leaves_no_trace() {
        let all = [Alignment::Forward, Alignment::Half, Alignment::Causal].map(spec);
        let estimated = [SAVITZKY_GOLAY, KALMAN].map(|estimator| StateSpec { estimator, ..spec(Alignment::Causal) });
        for spec in all.into_iter().chain(estimated) {
            let parts = Parts::new(spec);
            let model = parts.model();
            let mut scratch = std::vec![f32::NAN; Device::scratch_len(&model)];
            let mut device = Device::new(&model, &mut scratch).unwrap();
            let clean = samples(100);
            let expected = run(&mut device, &clean);
            assert!(expected.iter().any(Option::is_some));
            for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e9, -60.0] {
                let outcome = device.push(broken);
                assert_ne!(outcome.quality, Quality::Good);
                assert_eq!(outcome.step, None);
                assert_eq!(run(&mut device, &clean), expected, "{spec:?} after {broken}");
            }
            device.missing(3);
            assert_eq!(run(&mut device, &clean), expected, "after a gap");
            assert_eq!(device.summary().faults.total(), 8);
        }
    }

    /// Steps of these samples on a device after a healthy recording, and its final status.
    fn after_good_ones(then: &[f32]) -> (Vec<Option<Vec<u32>>>, Status) {
        let parts = Parts::new(spec(Alignment::Half));
        let model = parts.model();
        let mut scratch = std::vec![0.0; Device::scratch_len(&model)];
        let mut device = Device::new(&model, &mut scratch).unwrap();
        run(&mut device, &samples(200));
        assert_ne!(device.summary().status, Status::Blind);
        (run(&mut device, then), device.summary().status)
    }

    #[test]
    fn a_sensor_that_breaks_again_before_the_differences_fill_ends_blind() {
        // Every fourth sample is broken, and six are needed: nothing is ever evaluated.
        let broken: Vec<f32> =
            samples(64).into_iter().enumerate().map(|(i, s)| if i % 4 == 0 { f32::NAN } else { s }).collect();
        let (steps, status) = after_good_ones(&broken);
        assert!(steps.iter().all(Option::is_none));
        assert_eq!(status, Status::Blind);
    }

    #[test]
    fn a_stuck_sensor_ends_blind() {
        assert_eq!(after_good_ones(&[1.25; 64]).1, Status::Blind);
    }

    #[test]
    fn a_causal_model_predicts_the_next_sample_from_the_past_only() {
        for estimator in [Estimator::Differences, SAVITZKY_GOLAY, KALMAN] {
            let parts = Parts::new(StateSpec { estimator, ..spec(Alignment::Causal) });
            let model = parts.model();
            let mut scratch = std::vec![0.0; Device::scratch_len(&model)];
            let mut device = Device::new(&model, &mut scratch).unwrap();
            let clean = samples(80);
            let mut predictions: Vec<f32> = Vec::new();
            for (t, sample) in clean.iter().enumerate() {
                let outcome = device.push(*sample);
                let Some(step) = outcome.step else { continue };
                if let Some(&expected) = predictions.last() {
                    let measured: f32 = step.measured[0] * parts.scale(2) + parts.scale(3);
                    let residual: f32 = step.residuals().next().unwrap() * parts.scale(2);
                    assert!((measured - (sample - clean[t - 1])).abs() < 1e-5);
                    assert!((sample - expected - residual).abs() < 1e-5, "{sample} {expected} {residual}");
                }
                predictions.push(step.next_sample.unwrap());
            }
            assert!(predictions.len() > 50);
        }
    }

    #[test]
    fn too_little_scratch_is_refused_with_the_number() {
        let parts = Parts::new(spec(Alignment::Half));
        let model = parts.model();
        let needed = Device::scratch_len(&model);
        let mut scratch = std::vec![0.0; needed - 1];
        let refused = Device::new(&model, &mut scratch).err();
        assert_eq!(refused, Some(ScratchTooSmall { needed, found: needed - 1 }));
    }
}
