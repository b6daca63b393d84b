//! The interface as a C program uses it: results of `ballrace_core`, and an error for every misuse.
#![allow(clippy::undocumented_unsafe_blocks, reason = "the calls are those of a C program, misuse among them")]

use std::ffi::{CStr, c_void};
use std::ptr;

use ballrace::*;
use ballrace_core::device::Device;
use ballrace_core::model::Model;

#[path = "../../tests/common/mod.rs"]
mod common;

/// Memory as a C program has it.
fn memory(bytes: usize) -> Vec<u64> {
    vec![0xdead_beef_dead_beef; bytes.div_ceil(8)]
}

fn small() -> Vec<u8> {
    common::model(common::Sizes { dimension: 2, hidden: 4, nonzeros: 5, ..common::SMALL }, &common::signal(200, 4))
}

fn size(model: &[u8]) -> usize {
    let mut size = 0;
    assert_eq!(unsafe { ballrace_memory_size(model.as_ptr(), model.len(), &mut size) }, Error::None);
    size
}

fn init(memory: &mut [u64], bytes: usize, model: &[u8]) -> Result<*mut DeviceHandle, Error> {
    let mut device = ptr::null_mut();
    let memory = memory.as_mut_ptr().cast::<c_void>();
    match unsafe { ballrace_init(memory, bytes, model.as_ptr(), model.len(), &mut device) } {
        Error::None => Ok(device),
        error => Err(error),
    }
}

fn floats(at: *const f32, len: usize) -> Vec<u32> {
    (0..len).map(|i| unsafe { at.add(i).read() }.to_bits()).collect()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn same_numbers_as_the_device_in_rust() {
    let bytes = small();
    let (mut place, size) = (memory(size(&bytes)), size(&bytes));
    let handle = init(&mut place, size, &bytes).unwrap();

    let model = Model::from_bytes(&bytes).unwrap();
    let mut scratch = vec![0.0; Device::scratch_len(&model)];
    let mut device = Device::new(&model, &mut scratch).unwrap();

    let mut samples = common::signal(200, 9);
    samples[50] = f32::NAN;
    samples[90] = 80.0;
    let (mut evaluated, mut blocks) = (0, 0);
    for (i, sample) in samples.iter().enumerate() {
        if i == 120 {
            let mut block = Block::default();
            assert_eq!(unsafe { ballrace_missing(handle, 3, &mut block) }, Error::None);
            assert_eq!(block.ended, device.missing(3).is_some());
        }
        let mut found = std::mem::MaybeUninit::uninit();
        assert_eq!(unsafe { ballrace_push(handle, *sample, found.as_mut_ptr()) }, Error::None);
        let found: SampleResult = unsafe { found.assume_init() };
        let expected = device.push(*sample);
        assert_eq!(found.quality, expected.quality.into());
        assert_eq!(found.evaluated, expected.step.is_some());
        if let Some(step) = &expected.step {
            evaluated += 1;
            let (states, latent) = (found.step.state_count, found.step.latent_count);
            assert_eq!(floats(found.step.states, states), bits(step.states));
            assert_eq!(floats(found.step.latent, latent), bits(step.latent));
            assert_eq!(floats(found.step.latent_rate, latent), bits(step.latent_rate));
            assert_eq!(floats(found.step.predicted, states), bits(step.predicted));
            assert_eq!(floats(found.step.measured, states), bits(step.measured));
            assert_eq!(floats(found.step.expected, states), bits(step.expected));
            assert_eq!(found.step.comparable, step.comparable);
            assert_eq!(found.step.has_next_sample.then_some(found.step.next_sample), step.next_sample);
        }
        assert_eq!(found.block.ended, expected.block.is_some());
        if let Some(block) = expected.block {
            blocks += 1;
            assert_eq!((found.block.block, found.block.status), (block.block, block.status.into()));
            assert_eq!(
                bits(&[found.block.level, found.block.deviation, found.block.ewma]),
                bits(&[block.level, block.deviation, block.ewma])
            );
        }
    }
    assert!(evaluated > 150 && blocks > 1, "{evaluated} {blocks}");
    let mut block = Block::default();
    assert_eq!(unsafe { ballrace_end_of_recording(handle, &mut block) }, Error::None);
    assert_eq!(block.ended, device.end_of_recording().is_some());
    let mut summary = Summary { status: Status::Blind, non_finite: 9, saturated: 9, stuck: 9, missing: 9 };
    assert_eq!(unsafe { ballrace_get_summary(handle, &mut summary) }, Error::None);
    assert_eq!(summary, device.summary().into());
    assert_eq!((summary.non_finite, summary.saturated, summary.missing), (1, 1, 3));
}

#[test]
fn null_pointers_are_errors() {
    let bytes = small();
    let (model, len, size) = (bytes.as_ptr(), bytes.len(), size(&bytes));
    let mut place = memory(size);
    let handle = init(&mut place, size, &bytes).unwrap();
    let (mut bytes_needed, mut device) = (0, ptr::null_mut());
    let (mut block, mut summary) = (Block::default(), std::mem::MaybeUninit::uninit());
    let mut result = std::mem::MaybeUninit::uninit();
    let mut other = memory(size);
    let other = other.as_mut_ptr().cast::<c_void>();
    let errors = unsafe {
        [
            ballrace_memory_size(ptr::null(), len, &mut bytes_needed),
            ballrace_memory_size(model, len, ptr::null_mut()),
            ballrace_init(ptr::null_mut(), size, model, len, &mut device),
            ballrace_init(other, size, ptr::null(), len, &mut device),
            ballrace_init(other, size, model, len, ptr::null_mut()),
            ballrace_push(ptr::null_mut(), 0.0, result.as_mut_ptr()),
            ballrace_push(handle, 0.0, ptr::null_mut()),
            ballrace_missing(ptr::null_mut(), 1, &mut block),
            ballrace_missing(handle, 1, ptr::null_mut()),
            ballrace_end_of_recording(ptr::null_mut(), &mut block),
            ballrace_end_of_recording(handle, ptr::null_mut()),
            ballrace_get_summary(ptr::null_mut(), summary.as_mut_ptr()),
            ballrace_get_summary(handle, ptr::null_mut()),
        ]
    };
    assert_eq!(errors, [Error::NullPointer; 13]);
    // A refused call changes nothing: no sample was missing.
    assert_eq!(unsafe { ballrace_get_summary(handle, summary.as_mut_ptr()) }, Error::None);
    assert_eq!(unsafe { summary.assume_init() }.missing, 0);
}

#[test]
fn short_or_misaligned_memory_and_what_is_no_device_are_errors() {
    let bytes = small();
    let size = size(&bytes);
    let mut place = memory(size + 8);
    assert_eq!(init(&mut place, size - 1, &bytes), Err(Error::MemoryTooSmall));
    assert_eq!(init(&mut place, 0, &bytes), Err(Error::MemoryTooSmall));
    let mut device = ptr::null_mut();
    for offset in 1..8 {
        let memory = place.as_mut_ptr().wrapping_byte_add(offset).cast::<c_void>();
        let error = unsafe { ballrace_init(memory, size, bytes.as_ptr(), bytes.len(), &mut device) };
        assert_eq!(error, Error::MemoryMisaligned);
    }
    assert!(device.is_null());
    // Refused, the memory holds no device.
    let mut block = Block::default();
    let handle = place.as_mut_ptr().cast::<DeviceHandle>();
    assert_eq!(unsafe { ballrace_missing(handle, 1, &mut block) }, Error::NotADevice);
    let handle = handle.wrapping_byte_add(1);
    assert_eq!(unsafe { ballrace_missing(handle, 1, &mut block) }, Error::NotADevice);
}

#[test]
fn the_macro_for_static_memory_is_enough_and_memory_can_be_used_again() {
    let bytes = small();
    let model = Model::from_bytes(&bytes).unwrap();
    let enough = STATE_SIZE + 4 * Device::scratch_len(&model);
    assert!(size(&bytes) <= enough);
    let mut place = memory(enough);
    let mut block = Block::default();
    for _ in 0..2 {
        let handle = init(&mut place, enough, &bytes).unwrap();
        let mut summary = Summary { status: Status::Blind, non_finite: 9, saturated: 9, stuck: 9, missing: 9 };
        assert_eq!(unsafe { ballrace_get_summary(handle, &mut summary) }, Error::None);
        assert_eq!(summary.missing, 0);
        assert_eq!(unsafe { ballrace_missing(handle, 1, &mut block) }, Error::None);
    }
}

#[test]
fn a_damaged_model_is_refused_with_its_reason() {
    let bytes = small();
    let mut place = memory(4096);
    let mut refused = |model: &[u8]| init(&mut place, 4096, model).unwrap_err();
    assert_eq!(refused(&bytes[..bytes.len() - 4]), Error::ModelTruncated);
    assert_eq!(refused(&[]), Error::ModelTruncated);
    for (at, expected) in [(0, Error::ModelMagic), (4, Error::ModelVersion), (bytes.len() / 2, Error::ModelChecksum)] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x40;
        assert_eq!(refused(&damaged), expected, "byte {at}");
    }
}

#[test]
fn every_error_has_a_text_of_its_own() {
    let text = |code| unsafe { CStr::from_ptr(ballrace_error_text(code)) }.to_str().unwrap();
    let mut texts: Vec<_> = (0..=Error::ModelTakesStates as i32).map(text).collect();
    let unknown = [-1, Error::ModelTakesStates as i32 + 1, i32::MIN, i32::MAX].map(text);
    assert!(unknown.iter().all(|text| *text == "no error has this number"));
    texts.push(unknown[0]);
    texts.sort_unstable();
    let count = texts.len();
    texts.dedup();
    assert_eq!(texts.len(), count);
}
