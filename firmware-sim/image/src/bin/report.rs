//! Runs the embedded model over the embedded samples on the board and prints the report of the
//! host's `ballrace-firmware-sim` with instructions and memory added.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::panic::PanicInfo;

use ballrace_core::device::{Device, ScratchTooSmall};
use ballrace_core::model::Model;
use ballrace_firmware_sim::intermediates::{self, JSON_LEN};
use ballrace_image::arch::entry;
use ballrace_image::board::InstructionCounter;
use ballrace_image::{embedded, scratch, semihosted, stack};

/// Cost of a run.
struct Cost {
    /// Instructions of all samples.
    instructions: u64,
    /// Instructions of the most expensive sample.
    worst: u64,
    /// Greatest stack use, bytes.
    stack: usize,
}

#[entry]
fn main() -> ! {
    let scratch = scratch::take();
    let result = match Model::from_bytes(embedded::model()) {
        Ok(model) => measure(&model, scratch).and_then(|cost| report(&model, scratch, &cost)).map_err(|_| "scratch"),
        Err(_) => Err("model"),
    };
    match result {
        Ok(()) => semihosted::exit(true),
        Err(what) => {
            semihosted::say(what);
            semihosted::exit(false)
        }
    }
}

/// Cost of a run as in an application. Apart from [`report`], whose instructions and stack must not count.
#[inline(never)]
fn measure<'a>(model: &'a Model<'a>, scratch: &mut [f32]) -> Result<Cost, ScratchTooSmall> {
    stack::paint();
    let mut device = Device::new(model, scratch)?;
    let (mut ticks, mut worst) = (0, 0);
    let mut counter = InstructionCounter::start();
    for sample in embedded::samples().iter() {
        // By reference, as an application reads it: by value it would be copied.
        core::hint::black_box(&device.push(sample));
        let lap = counter.lap();
        ticks += u64::from(lap);
        worst = worst.max(lap);
    }
    Ok(Cost {
        instructions: InstructionCounter::instructions(ticks),
        worst: InstructionCounter::instructions(worst.into()),
        stack: stack::high_water(),
    })
}

/// Prints one line of JSON.
#[inline(never)]
fn report<'a>(model: &'a Model<'a>, scratch: &mut [f32], cost: &Cost) -> Result<(), ScratchTooSmall> {
    let report = intermediates::run(model, scratch, embedded::samples().iter())?;
    let mut buffer = [0; JSON_LEN];
    let json = report.to_json(&mut buffer).unwrap_or_default();
    let mut line = Line::default();
    let Cost { instructions, worst, stack } = cost;
    let mean = instructions / u64::from(report.samples.max(1));
    // The host's line with its last brace after the added keys.
    let written = write!(
        line,
        "{},\"instructions_per_sample\":{mean},\"instructions_worst\":{worst},\"scratch_bytes\":{},\"stack_bytes\":{stack}}}",
        json.strip_suffix('}').unwrap_or_default(),
        size_of_val(scratch),
    );
    semihosted::say(if written.is_ok() { line.text() } else { "report too long" });
    Ok(())
}

/// Line buffer, so that a line reaches the host in one piece.
struct Line {
    bytes: [u8; JSON_LEN],
    length: usize,
}

impl Default for Line {
    fn default() -> Self {
        Self { bytes: [0; JSON_LEN], length: 0 }
    }
}

impl Line {
    fn text(&self) -> &str {
        self.bytes.get(..self.length).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or_default()
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        let end = self.length + text.len();
        self.bytes.get_mut(self.length..end).ok_or(core::fmt::Error)?.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let mut line = Line::default();
    let _ = write!(line, "{info}");
    semihosted::say(line.text());
    semihosted::exit(false)
}

ballrace_image::on_fault!(fault);

/// Reports a fault of the processor.
fn fault(address: u32) -> ! {
    let mut line = Line::default();
    let _ = write!(line, "fault at {address:#010x}");
    semihosted::say(line.text());
    semihosted::exit(false)
}
