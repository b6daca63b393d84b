//! Reading of whole files, which must have an end.
//!
//! Devices and named pipes are refused, since they may never end; `<(…)` of a shell is read, up to the limit.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::settings::SizeSettings;

const SETTINGS: SizeSettings = SizeSettings::DEFAULT;

/// Reads a file of settings: a rig, a manifest, a model, a diagnosis.
///
/// # Errors
/// Error of the operating system; a device, a pipe, or a file that is too large.
pub fn settings(path: &Path) -> io::Result<Vec<u8>> {
    read(path, SETTINGS.settings_bytes)
}

/// Reads a file of samples.
///
/// # Errors
/// Those of [`settings`].
pub(super) fn samples(path: &Path) -> io::Result<Vec<u8>> {
    read(path, SETTINGS.recording_bytes)
}

/// Checks that a file of samples can be read, before it is opened.
///
/// # Errors
/// Those of [`settings`].
pub(super) fn check_samples(path: &Path) -> io::Result<()> {
    check(path, SETTINGS.recording_bytes)
}

fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    check(path, most)?;
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large(format!("more than {most}"))) } else { Ok(bytes) }
}

fn check(path: &Path, most: u64) -> io::Result<()> {
    let metadata = fs::metadata(path)?;
    // The pipe of a shell's `<(…)` has no path of its own.
    if !metadata.is_file() && !metadata.is_dir() && path.canonicalize().is_ok() {
        return Err(io::Error::other("a device or a pipe, which need not end"));
    }
    if metadata.len() > most { Err(too_large(metadata.len().to_string())) } else { Ok(()) }
}

fn too_large(bytes: String) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("{bytes} bytes, which is too large to be one"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_need_not_end_is_refused_without_opening_it() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for endless in [pipe.as_path(), Path::new("/dev/zero"), Path::new("/dev/null")] {
            let error = settings(endless).unwrap_err().to_string();
            assert!(error.contains("a device or a pipe"), "{error}");
        }
    }

    #[test]
    fn a_file_beyond_the_limit_is_refused_by_its_size() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.toml");
        File::create(&path).unwrap().set_len(SETTINGS.settings_bytes + 1).unwrap();
        assert_eq!(settings(&path).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert!(read(&path, SETTINGS.settings_bytes + 1).is_ok());
    }
}
