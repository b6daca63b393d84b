//! What every board under an emulator has: its output, its way out.

/// Says a line of text.
#[cfg(not(feature = "defmt"))]
pub fn say(line: &str) {
    use semihosting::io::{Write, stdout};
    if let Ok(mut out) = stdout() {
        // Nowhere to report an error of the only output to.
        let _ = out.write_all(line.as_bytes());
        let _ = out.write_all(b"\n");
    }
}

/// Says a line of text, through defmt.
#[cfg(feature = "defmt")]
pub fn say(line: &str) {
    defmt::println!("{=str}", line);
}

/// Ends the emulator.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}
