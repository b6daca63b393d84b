//! Puts a model, samples and a board into the image, and states the memory that the model needs.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use ballrace_core::device::Device;
use ballrace_core::model::{Input, Model};

fn main() {
    if let Err(message) = embed() {
        println!("cargo::error={message}");
    }
}

fn embed() -> Result<(), String> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("no OUT_DIR")?);
    let (model_path, bytes) = read("BALLRACE_MODEL", "the binary form of a model")?;
    let model = Model::from_bytes(&bytes).map_err(|error| format!("{}: {error}", model_path.display()))?;
    if let Input::Direct(_) = model.input {
        return Err(format!("{}: the model takes states, expected one that takes samples", model_path.display()));
    }
    let (samples_path, samples) = read("BALLRACE_SAMPLES", "little-endian f32 values, m/s^2")?;
    if samples.is_empty() || samples.len() % 4 != 0 {
        let (path, found) = (samples_path.display(), samples.len());
        return Err(format!("{path}: found {found} bytes, expected a multiple of 4"));
    }
    let scratch_len = Device::scratch_len(&model);
    let constant =
        format!("/// Floats of scratch that the model needs.\npub const SCRATCH_LEN: usize = {scratch_len};\n");
    write(&out.join("scratch_len.rs"), constant.as_bytes())?;
    write(&out.join("model.bin"), &bytes)?;
    write(&out.join("samples.f32"), &samples)?;
    board(&out)?;
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    }
    Ok(())
}

/// The memory map and the module of the board that `BALLRACE_BOARD` names.
fn board(out: &Path) -> Result<(), String> {
    println!("cargo::rerun-if-env-changed=BALLRACE_BOARD");
    let name = env::var("BALLRACE_BOARD").unwrap_or("mps2_an386".into());
    let boards = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or("no CARGO_MANIFEST_DIR")?).join("boards");
    let folder = boards.join(&name);
    let module = folder.join("board.rs");
    println!("cargo::rerun-if-changed={}", folder.display());
    if !module.is_file() {
        let there = fs::read_dir(&boards).map_err(|error| format!("{}: {error}", boards.display()))?;
        let names: Vec<_> = there.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        return Err(format!("BALLRACE_BOARD: found {name:?}, expected one of {}", names.join(", ")));
    }
    for (file, expected) in [("qemu.args", "the machine's options for QEMU"), ("emulator", "QEMU's program")] {
        if !folder.join(file).is_file() {
            return Err(format!("{}: found no {file}, expected {expected}", folder.display()));
        }
    }
    let target = folder.join("target");
    let expected = fs::read_to_string(&target).map_err(|error| format!("{}: {error}", target.display()))?;
    let found = env::var("TARGET").map_err(|error| format!("TARGET: {error}"))?;
    if found != expected.trim() {
        return Err(format!("found --target {found}, board {name} needs {}", expected.trim()));
    }
    let text = format!("/// The board.\n#[path = {:?}]\npub mod board;\n", module.display());
    write(&out.join("board_module.rs"), text.as_bytes())?;
    let memory = folder.join("memory.x");
    let bytes = fs::read(&memory).map_err(|error| format!("{}: {error}", memory.display()))?;
    write(&out.join("memory.x"), &bytes)
}

/// The file that a variable names.
fn read(variable: &str, expected: &str) -> Result<(PathBuf, Vec<u8>), String> {
    println!("cargo::rerun-if-env-changed={variable}");
    let path = env::var_os(variable).ok_or(format!("{variable} is not set, expected a file: {expected}"))?;
    let path = PathBuf::from(path);
    println!("cargo::rerun-if-changed={}", path.display());
    let bytes = fs::read(&path).map_err(|error| format!("{variable}: {}: {error}", path.display()))?;
    Ok((path, bytes))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}
