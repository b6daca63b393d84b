//! Model file of `fit`: the device's model with its report.
//!
//! `{"schema", "checksum", "content": {"device", "training", "scores", …}}`. The checksum is the
//! CRC-32 of the text of `content`. The device's part is read by core's own reader.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::model::OwnedModel;
use crate::model::fit::report::Report;

/// Schema of the file.
pub const SCHEMA: &str = "ballrace-model/1";

/// Failure to read or write a model file.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Error of the operating system.
    #[error("{path}: {source}")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// Not JSON, or not of this shape.
    #[error("{path}: {source}; expected a model file of schema {SCHEMA}, as `ballrace fit` writes it")]
    Json {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: serde_json::Error,
    },
    /// Another schema.
    #[error("{path}, key `schema`: found {found:?}, expected {SCHEMA:?}")]
    Schema {
        /// Path of the file.
        path: PathBuf,
        /// Schema found.
        found: String,
    },
    /// Content changed after it was written.
    #[error("{path}, key `checksum`: found {stored}, expected {computed} of its content: it was changed after the fit")]
    Checksum {
        /// Path of the file.
        path: PathBuf,
        /// Checksum stored.
        stored: String,
        /// Checksum of the content.
        computed: String,
    },
    /// Device part that is not a model.
    #[error("{path}: {source}")]
    Model {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: ballrace_core::model::ModelError,
    },
}

#[derive(Serialize, Deserialize)]
struct Envelope {
    schema: String,
    checksum: String,
    content: Box<RawValue>,
}

#[derive(Serialize, Deserialize)]
struct Content {
    device: Box<RawValue>,
    #[serde(flatten)]
    report: Report,
}

/// Text of the file.
///
/// # Errors
/// A model or report that cannot be written as JSON.
fn to_text(path: &Path, model: &OwnedModel, report: &Report) -> Result<String, FileError> {
    let json = |source| FileError::Json { path: path.to_owned(), source };
    let device = model.to_json().map_err(|source| FileError::Model { path: path.to_owned(), source })?;
    let content = Content { device: RawValue::from_string(device).map_err(json)?, report: report.clone() };
    let content = serde_json::value::to_raw_value(&content).map_err(json)?;
    let envelope = Envelope { schema: SCHEMA.into(), checksum: checksum(content.get()), content };
    serde_json::to_string(&envelope).map_err(json)
}

/// Writes the file atomically.
///
/// # Errors
/// A model or report that cannot be written as JSON, or the operating system's error.
pub fn write(path: &Path, model: &OwnedModel, report: &Report) -> Result<(), FileError> {
    let text = to_text(path, model, report)?;
    crate::recording::atomic_write::write_atomically(path, text.as_bytes())
        .map_err(|source| FileError::Io { path: path.to_owned(), source })
}

/// Parses a file of `fit`.
fn parse(path: &Path, text: &str) -> Result<(OwnedModel, Report), FileError> {
    let json = |source| FileError::Json { path: path.to_owned(), source };
    let envelope: Envelope = serde_json::from_str(text).map_err(json)?;
    if envelope.schema != SCHEMA {
        return Err(FileError::Schema { path: path.to_owned(), found: envelope.schema });
    }
    let computed = checksum(envelope.content.get());
    if envelope.checksum != computed {
        return Err(FileError::Checksum { path: path.to_owned(), stored: envelope.checksum, computed });
    }
    let content: Content = serde_json::from_str(envelope.content.get()).map_err(json)?;
    let model = OwnedModel::from_json(content.device.get())
        .map_err(|source| FileError::Model { path: path.to_owned(), source })?;
    Ok((model, content.report))
}

/// Reads a model for the device: the binary form, the device's JSON, or a file that `fit` wrote.
///
/// # Errors
/// [`FileError`] of the form that the file starts like.
pub fn read(path: &Path) -> Result<(OwnedModel, Option<Report>), FileError> {
    let bytes =
        crate::recording::bounded::settings(path).map_err(|source| FileError::Io { path: path.to_owned(), source })?;
    let model_error = |source| FileError::Model { path: path.to_owned(), source };
    let text = std::str::from_utf8(&bytes).ok().filter(|text| text.trim_start().starts_with('{'));
    let Some(text) = text else { return Ok((OwnedModel::from_bytes(bytes).map_err(model_error)?, None)) };
    // A file of `fit` holds the device's schema too, in its content.
    if text.contains("\"ballrace-device-model/") && !text.contains("\"content\"") {
        return Ok((OwnedModel::from_json(text).map_err(model_error)?, None));
    }
    parse(path, text).map(|(model, report)| (model, Some(report)))
}

fn checksum(text: &str) -> String {
    format!("crc32:{:08x}", ballrace_core::model::crc32(text.as_bytes()))
}
