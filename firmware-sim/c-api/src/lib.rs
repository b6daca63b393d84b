//! C interface of [`ballrace_core::device`]: `include/ballrace.h` and the static library `libballrace.a`.
//!
//! A device lives in one piece of the caller's memory: its state, then the model's scratch. All of the interface's
//! `unsafe` is in this file. Nothing unwinds: the release profile aborts, and no panic is linked on bare metal.
#![cfg_attr(target_os = "none", no_std)]
#![deny(missing_docs)]

mod types;

use core::ffi::{c_char, c_void};
use core::ptr;

use ballrace_core::device::Device;
use ballrace_core::model::{Input, Model};

pub use types::{Block, Error, Quality, SampleResult, Status, Step, Summary};

/// Bytes that a device needs at most beside the model's scratch, on 32-bit and 64-bit machines.
pub const STATE_SIZE: usize = 1_536;
/// Alignment that the memory of a device needs, bytes.
pub const MEMORY_ALIGNMENT: usize = 8;

/// A device in the caller's memory.
pub struct DeviceHandle {
    /// [`MAGIC`] while there is a device.
    magic: u32,
    model: Model<'static>,
    device: Device<'static, 'static>,
}

/// First word of a device.
const MAGIC: u32 = u32::from_le_bytes(*b"BRDV");

const _: () = assert!(size_of::<DeviceHandle>() <= STATE_SIZE && align_of::<DeviceHandle>() <= MEMORY_ALIGNMENT);
// The scratch follows the state.
const _: () = assert!(size_of::<DeviceHandle>().is_multiple_of(align_of::<f32>()));

/// A checked model that takes samples, used where it lies.
///
/// # Safety
/// `bytes` is null or `len` readable bytes that stay unchanged for `'a`.
unsafe fn checked<'a>(bytes: *const u8, len: usize) -> Result<Model<'a>, Error> {
    if bytes.is_null() {
        return Err(Error::NullPointer);
    }
    // SAFETY: the caller's promise; a slice of more than isize::MAX bytes does not exist.
    let bytes = unsafe { core::slice::from_raw_parts(bytes, len.min(isize::MAX as usize)) };
    let model = Model::from_bytes(bytes)?;
    match model.input {
        Input::VirtualStates(_) => Ok(model),
        Input::Direct(_) => Err(Error::ModelTakesStates),
    }
}

/// Bytes of memory of a device with this model.
fn memory_size(model: &Model<'_>) -> usize {
    size_of::<DeviceHandle>() + size_of::<f32>() * Device::scratch_len(model)
}

/// The device behind a handle.
///
/// # Safety
/// `handle` is null or readable memory for a device; if it is one, nothing else uses it for `'a`.
unsafe fn device<'a>(handle: *mut DeviceHandle) -> Result<&'a mut Device<'static, 'static>, Error> {
    if handle.is_null() {
        return Err(Error::NullPointer);
    }
    if !handle.is_aligned() {
        return Err(Error::NotADevice);
    }
    // SAFETY: not null, aligned, and readable by the caller's promise.
    if unsafe { ptr::addr_of!((*handle).magic).read() } != MAGIC {
        return Err(Error::NotADevice);
    }
    // SAFETY: `ballrace_init` wrote a device, and nothing else uses it. The model beside it stays shared.
    Ok(unsafe { &mut *ptr::addr_of_mut!((*handle).device) })
}

/// Writes through a pointer of the caller's.
///
/// # Safety
/// `to` is null or writable memory for a `T`.
unsafe fn give<T>(to: *mut T, value: impl FnOnce() -> T) -> Error {
    if to.is_null() {
        return Error::NullPointer;
    }
    // SAFETY: not null, and writable by the caller's promise.
    unsafe { to.write(value()) };
    Error::None
}

/// Says how many bytes of memory a device with a model needs. The model is the binary form, `ballrace export --format bin`
/// or `c`; it is checked.
///
/// # Safety
/// `model` is null or `model_len` readable bytes, `size` null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_memory_size(model: *const u8, model_len: usize, size: *mut usize) -> Error {
    // SAFETY: the caller's promise, for the time of this call.
    match unsafe { checked(model, model_len) } {
        // SAFETY: the caller's promise.
        Ok(model) => unsafe { give(size, || memory_size(&model)) },
        Err(error) => error,
    }
}

/// Makes a device in `memory`, which is `BALLRACE_MEMORY_ALIGNMENT`-aligned, and gives its handle. The model is checked and
/// used where it lies: model and memory must stay, the model unchanged, as long as the device is used. There is nothing to
/// free; a new device may be made in the same memory.
///
/// # Safety
/// `memory` is null or `memory_len` bytes that nothing else uses, `model` null or `model_len` readable bytes, both as long
/// as the device is used; `device` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_init(
    memory: *mut c_void,
    memory_len: usize,
    model: *const u8,
    model_len: usize,
    device: *mut *mut DeviceHandle,
) -> Error {
    if memory.is_null() || device.is_null() {
        return Error::NullPointer;
    }
    if !memory.addr().is_multiple_of(MEMORY_ALIGNMENT) {
        return Error::MemoryMisaligned;
    }
    // SAFETY: the caller's promise, as long as the device is used.
    let model = match unsafe { checked::<'static>(model, model_len) } {
        Ok(model) => model,
        Err(error) => return error,
    };
    if memory_len < memory_size(&model) {
        return Error::MemoryTooSmall;
    }
    let scratch_len = Device::scratch_len(&model);
    let handle = memory.cast::<DeviceHandle>();
    // SAFETY: the memory holds the state and, after it, the scratch; both are aligned, the caller leaves both to the
    // device, and zeros are floats.
    let (model, scratch) = unsafe {
        ptr::addr_of_mut!((*handle).magic).write(0);
        let place = ptr::addr_of_mut!((*handle).model);
        place.write(model);
        let floats = handle.add(1).cast::<f32>();
        floats.write_bytes(0, scratch_len);
        (&*place, core::slice::from_raw_parts_mut(floats, scratch_len))
    };
    let Ok(made) = Device::new(model, scratch) else { return Error::MemoryTooSmall };
    // SAFETY: as above; the magic comes last, so that no half-made device is taken for one.
    unsafe {
        ptr::addr_of_mut!((*handle).device).write(made);
        ptr::addr_of_mut!((*handle).magic).write(MAGIC);
        give(device, || handle)
    }
}

/// Takes a sample, m/s^2.
///
/// # Safety
/// `device` is null or a handle of `ballrace_init` that nothing else uses, `result` null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_push(device: *mut DeviceHandle, sample: f32, result: *mut SampleResult) -> Error {
    // SAFETY: the caller's promise.
    match unsafe { self::device(device) } {
        // SAFETY: the caller's promise.
        Ok(device) => unsafe { give(result, || device.push(sample).into()) },
        Err(error) => error,
    }
}

/// Takes the number of samples not received.
///
/// # Safety
/// `device` is null or a handle of `ballrace_init` that nothing else uses, `block` null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_missing(device: *mut DeviceHandle, count: u32, block: *mut Block) -> Error {
    // SAFETY: the caller's promise.
    match unsafe { self::device(device) } {
        // SAFETY: the caller's promise.
        Ok(device) => unsafe { give(block, || device.missing(count).into()) },
        Err(error) => error,
    }
}

/// Ends a recording: the next sample does not continue it, which is no fault.
///
/// # Safety
/// `device` is null or a handle of `ballrace_init` that nothing else uses, `block` null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_end_of_recording(device: *mut DeviceHandle, block: *mut Block) -> Error {
    // SAFETY: the caller's promise.
    match unsafe { self::device(device) } {
        // SAFETY: the caller's promise.
        Ok(device) => unsafe { give(block, || device.end_of_recording().into()) },
        Err(error) => error,
    }
}

/// Gives the current status and the counts of broken samples.
///
/// # Safety
/// `device` is null or a handle of `ballrace_init` that nothing else uses, `summary` null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_get_summary(device: *mut DeviceHandle, summary: *mut Summary) -> Error {
    // SAFETY: the caller's promise.
    match unsafe { self::device(device) } {
        // SAFETY: the caller's promise.
        Ok(device) => unsafe { give(summary, || device.summary().into()) },
        Err(error) => error,
    }
}

/// Says what an error means, in one sentence; never null.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_error_text(error: i32) -> *const c_char {
    Error::text(error).as_ptr()
}

/// Stops: nothing in this library leads here, which `compare.sh` checks in the linked program.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
