//! What the fuzz targets share: calls of a device read from arbitrary bytes, and what must hold after each.

use ballrace_core::device::Device;
use ballrace_core::input_check::Quality;
use ballrace_core::model::{Input, Model};
use ballrace_core::monitor::{BlockReport, Status};

/// Greatest scratch of a model that is run, floats.
const MAX_SCRATCH: usize = 1 << 14;
/// Greatest number of calls, so that large models do not take seconds.
const MAX_CALLS: usize = 512;

/// Runs a model over calls read from bytes, five a call: what to do, and a sample's bits or a count.
pub fn run(model: &Model<'_>, calls: &[u8]) {
    let needed = Device::scratch_len(model);
    if needed > MAX_SCRATCH {
        return;
    }
    // What is in the scratch does not matter, and one float less is refused.
    let mut scratch = vec![f32::NAN; needed];
    assert_eq!(Device::new(model, &mut scratch[1..]).err().map(|error| error.needed), Some(needed));
    let Ok(mut device) = Device::new(model, &mut scratch) else { panic!("scratch of {needed} floats refused") };
    let mut broken: u64 = 0;
    for call in calls.as_chunks::<5>().0.iter().take(MAX_CALLS) {
        let [what, bits @ ..] = *call;
        let block = match what % 16 {
            0 => {
                let count = u32::from_le_bytes(bits);
                broken += u64::from(count);
                device.missing(count)
            }
            1 => device.end_of_recording(),
            _ => {
                let sample = f32::from_le_bytes(bits);
                let result = device.push(sample);
                assert!(sample.is_finite() || result.quality == Quality::NonFinite);
                assert!(result.quality == Quality::Good || result.step.is_none());
                if let Some(step) = &result.step {
                    assert!(!matches!(model.input, Input::Direct(_)));
                    assert_eq!(step.residuals().len(), if step.comparable { step.measured.len() } else { 0 });
                }
                broken += u64::from(result.quality != Quality::Good);
                result.block
            }
        };
        if let Some(block) = block {
            check(&block);
            assert_eq!(block.status, device.summary().status);
        }
    }
    assert_eq!(u64::from(device.summary().faults.total()), broken.min(u32::MAX.into()));
}

/// What holds for every block, whatever the samples and the weights.
fn check(block: &BlockReport) {
    let BlockReport { level, deviation, ewma, status, .. } = *block;
    assert!(block.block > 0);
    assert!(ewma.is_finite(), "{block:?}");
    assert!(level.is_nan() || level >= 0.0, "{block:?}");
    assert_eq!(deviation.is_nan(), level.is_nan(), "{block:?}");
    assert_eq!(level.is_nan(), status == Status::Blind, "{block:?}");
}
