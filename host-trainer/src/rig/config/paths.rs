//! `[[path]]` tables.

use toml_edit::{Array, ArrayOfTables, Item, Table};

use crate::rig::transfer_path::TransmissionPath;

/// The keys of a table.
pub(super) const KEYS: [&str; 4] = ["channel", "sample_rate_hz", "gain", "reflection"];

/// Reads a table; the error is the key at fault and the expected value.
pub(super) fn read(table: &Table) -> Result<TransmissionPath, (String, String)> {
    let fault = |key: &str, expected: &str| (key.to_owned(), expected.to_owned());
    if let Some((key, _)) = table.iter().find(|(key, _)| !KEYS.contains(key)) {
        return Err(fault(key, &format!("one of {}", KEYS.join(", "))));
    }
    let number = |item: &toml_edit::Value| item.as_float().or_else(|| item.as_integer().map(|i| i as f64));
    let positive = |key: &str| {
        let value = table.get(key).and_then(Item::as_value).and_then(number);
        value.filter(|v| v.is_finite() && *v > 0.0).ok_or_else(|| fault(key, "a number above 0"))
    };
    let channel = table.get("channel").and_then(Item::as_str).filter(|c| ["ax", "ay"].contains(c));
    let reflection = table.get("reflection").and_then(Item::as_array);
    let within = |v: &toml_edit::Value| number(v).filter(|k| k.abs() < 1.0);
    let reflection: Option<Vec<f64>> = reflection.and_then(|list| list.iter().map(within).collect());
    Ok(TransmissionPath {
        channel: channel.ok_or_else(|| fault("channel", "\"ax\" or \"ay\""))?.into(),
        sample_rate_hz: positive("sample_rate_hz")?,
        gain: positive("gain")?,
        reflection: reflection.ok_or_else(|| fault("reflection", "a list of numbers between -1 and 1"))?,
    })
}

/// Tables of the paths.
pub(super) fn write(paths: &[TransmissionPath]) -> ArrayOfTables {
    let mut tables = ArrayOfTables::new();
    for path in paths {
        let mut table = Table::new();
        table["channel"] = path.channel.as_str().into();
        table["sample_rate_hz"] = path.sample_rate_hz.into();
        table["gain"] = path.gain.into();
        table["reflection"] = toml_edit::Value::from(path.reflection.iter().copied().collect::<Array>()).into();
        tables.push(table);
    }
    tables
}
