//! Causes named by a `diagnosis.json`.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::result::{SCHEMA, Verdict};
use crate::recording::bounded;
use crate::rig::effect::EffectKind;

/// Error of reading the causes of a diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CausesError {
    /// File that cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// File that is not JSON.
    #[error("{path}: {source}; expected the diagnosis.json of `ballrace diagnose`")]
    Json {
        /// The file.
        path: PathBuf,
        /// Error with line and column.
        source: serde_json::Error,
    },
    /// Key with an unexpected value.
    #[error("{path}, key `{key}`: found {found}, expected {expected}")]
    Key {
        /// The file.
        path: PathBuf,
        /// Path of the key.
        key: String,
        /// Value found.
        found: String,
        /// Value expected.
        expected: String,
    },
}

/// Causes of a diagnosis, the most probable first; empty if there are none, or if it names `unexplained` alone.
///
/// # Errors
/// A file that is no diagnosis, or a cause that is not in the vocabulary.
pub fn read(path: &Path) -> Result<Vec<EffectKind>, CausesError> {
    let text = bounded::settings(path).map_err(|source| CausesError::Io { path: path.to_owned(), source })?;
    parse(path, &text)
}

fn parse(path: &Path, text: &[u8]) -> Result<Vec<EffectKind>, CausesError> {
    let document: Value =
        serde_json::from_slice(text).map_err(|source| CausesError::Json { path: path.to_owned(), source })?;
    let refuse = |key: String, found: Option<&Value>, expected: String| CausesError::Key {
        path: path.to_owned(),
        key,
        found: found.map_or_else(|| "nothing".into(), shown),
        expected,
    };
    let schema = document.get("schema");
    if schema.and_then(Value::as_str) != Some(SCHEMA) {
        return Err(refuse("schema".into(), schema, format!("{SCHEMA:?}")));
    }
    let causes = document.get("causes");
    let list = causes.and_then(Value::as_array).ok_or_else(|| refuse("causes".into(), causes, "a list".into()))?;
    let name = |(index, cause): (usize, &Value)| {
        let name = cause.get("name");
        name.and_then(Value::as_str).and_then(EffectKind::parse).ok_or_else(|| {
            let names: Vec<_> = EffectKind::ALL.iter().map(|kind| kind.name()).collect();
            refuse(format!("causes[{index}].name"), name, format!("one of {}", names.join(", ")))
        })
    };
    let is_named = |cause: &&Value| cause.get("name").and_then(Value::as_str) != Some(Verdict::Unexplained.name());
    list.iter().filter(is_named).enumerate().map(name).collect()
}

/// A value short enough for a message.
fn shown(value: &Value) -> String {
    match value {
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "an object".into(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Vec<EffectKind>, String> {
        super::parse(Path::new("d.json"), text.as_bytes()).map_err(|e| e.to_string())
    }

    #[test]
    fn causes_are_read_in_order() {
        let text = r#"{"schema": "ballrace-diagnosis/1", "causes": [{"name": "backlash", "probability": 1},
                       {"name": "unbalance"}]}"#;
        assert_eq!(parse(text).unwrap(), [EffectKind::Backlash, EffectKind::Unbalance]);
        for none in ["", r#"{"name": "unexplained"}"#] {
            let text = format!(r#"{{"schema": "ballrace-diagnosis/1", "causes": [{none}]}}"#);
            assert!(parse(&text).unwrap().is_empty(), "{text}");
        }
    }

    #[test]
    fn what_is_no_diagnosis_is_refused_by_file_key_found_and_expected() {
        let error = |text: &str| parse(text).unwrap_err();
        assert!(error("{").starts_with("d.json: EOF while parsing"), "{}", error("{"));
        assert_eq!(error("{}"), "d.json, key `schema`: found nothing, expected \"ballrace-diagnosis/1\"");
        let schema = r#""schema": "ballrace-diagnosis/1""#;
        assert_eq!(error(&format!("{{{schema}}}")), "d.json, key `causes`: found nothing, expected a list");
        let unknown = error(&format!(r#"{{{schema}, "causes": [{{"name": "gremlins"}}]}}"#));
        assert!(
            unknown
                .starts_with("d.json, key `causes[0].name`: found \"gremlins\", expected one of outer-race-defect, ")
        );
        let none = error(&format!(r#"{{{schema}, "causes": [3]}}"#));
        assert!(none.starts_with("d.json, key `causes[0].name`: found nothing"), "{none}");
    }
}
