//! Runs a model over samples on the host and prints the report that the bare-metal image prints.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use ballrace_core::Floats;
use ballrace_core::device::Device;
use ballrace_core::model::Model;
use ballrace_firmware_sim::intermediates::{self, JSON_LEN};

const HELP: &str = "\
Runs a model over samples on the host and prints one line of JSON: the counts, the status, and a
CRC-32 of every intermediate number. The bare-metal image prints the same line.

Usage: ballrace-firmware-sim --model MODEL.bin --samples SAMPLES.f32

  --model    the binary form of a model (ballrace export --format bin)
  --samples  little-endian f32 values, m/s^2, without a header

Example: ballrace-firmware-sim --model model.bin --samples recording.f32
";

fn main() -> ExitCode {
    match run(std::env::args_os().skip(1)) {
        Ok(text) => {
            println!("{}", text.trim_end());
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

/// Text to print, or the error of the arguments or files.
fn run(mut arguments: impl Iterator<Item = OsString>) -> Result<String, String> {
    let (mut model, mut samples) = (None, None);
    while let Some(argument) = arguments.next() {
        let slot = match argument.to_str() {
            Some("--help" | "-h") => return Ok(HELP.into()),
            Some("--model") => &mut model,
            Some("--samples") => &mut samples,
            _ => return Err(format!("found argument {argument:?}, expected --model, --samples or --help")),
        };
        let value = arguments.next().ok_or_else(|| format!("{argument:?}: found nothing after it, expected a file"))?;
        *slot = Some(PathBuf::from(value));
    }
    let given = |path: Option<PathBuf>, name| path.ok_or_else(|| format!("found no {name}, expected {name} FILE"));
    let (model_path, samples_path) = (given(model, "--model")?, given(samples, "--samples")?);
    let read = |path: &PathBuf| std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
    let (model, samples) = (read(&model_path)?, read(&samples_path)?);

    let model = Model::from_bytes(&model).map_err(|error| format!("{}: {error}", model_path.display()))?;
    let (words, rest) = samples.as_chunks::<4>();
    if !rest.is_empty() {
        let (path, found) = (samples_path.display(), samples.len());
        return Err(format!("{path}: found {found} bytes, expected a multiple of 4 (little-endian f32 values)"));
    }
    let mut scratch = vec![0.0; Device::scratch_len(&model)];
    let report = intermediates::run(&model, &mut scratch, Floats(words).iter()).map_err(|error| error.to_string())?;
    let mut buffer = [0; JSON_LEN];
    report.to_json(&mut buffer).map(str::to_owned).ok_or_else(|| format!("report over {JSON_LEN} bytes"))
}
