//! Which recordings ballrace itself wrote, and may therefore replace.
//!
//! A manifest that [`write::folder`](super::write::folder) wrote begins with the CRC-32 of its files and of its own text.
//! What somebody changed or put in their place since is not replaced.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use flate2::{Crc, CrcWriter};

use super::job::Format;
use super::manifest;

const MARK: &str = "# Written by ballrace, which replaces a file only while its CRC-32 is this:\n";

/// A manifest's text with the mark: names and contents of the files beside it.
pub(super) fn marked(text: &str, files: &[(String, u32)]) -> String {
    let mut marked = MARK.to_owned();
    let own = (manifest::FILE_NAME.to_owned(), crc32(text.as_bytes()));
    for (name, crc) in files.iter().chain([&own]) {
        // Writing to a text cannot fail.
        let _ = writeln!(marked, "# {crc:08x} {name}");
    }
    marked + text
}

/// CRC-32 of a file's contents; `None` if it cannot be read.
pub(super) fn file_crc(path: &Path) -> Option<u32> {
    let mut crc = CrcWriter::new(io::sink());
    io::copy(&mut fs::File::open(path).ok()?, &mut crc).ok()?;
    Some(crc.crc().sum())
}

fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Whether a file is a recording or a manifest by its name.
pub fn is_recording(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == manifest::FILE_NAME) || Format::from_path(path).is_ok()
}

/// Whether ballrace wrote a recording or a manifest and nobody changed it since.
pub fn is_own(path: &Path) -> bool {
    let Ok(path) = path.canonicalize() else { return false };
    let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else {
        return false;
    };
    let Some((marks, text)) = marks(folder.join(manifest::FILE_NAME)) else { return false };
    let Some((_, stored)) = marks.iter().find(|(file, _)| file == name) else { return false };
    let found = if name == manifest::FILE_NAME { Some(crc32(text.as_bytes())) } else { file_crc(&path) };
    found == Some(*stored)
}

/// Names and CRC-32 of a manifest's mark, and the text after it.
fn marks(manifest: PathBuf) -> Option<(Vec<(String, u32)>, String)> {
    let text = fs::read_to_string(manifest).ok()?;
    let mut rest = text.strip_prefix(MARK)?;
    let mut marks = Vec::new();
    while let Some((line, after)) = rest.strip_prefix("# ").and_then(|rest| rest.split_once('\n')) {
        let (crc, name) = line.split_once(' ')?;
        marks.push((name.to_owned(), u32::from_str_radix(crc, 16).ok()?));
        rest = after;
    }
    Some((marks, rest.to_owned()))
}
