//! Manifest `recordings.toml`: metadata of the files of a folder.
//!
//! ```toml
//! [defaults]                 # any key below, `file` excepted
//! sample_rate_hz = 25600.0
//! unit = "m/s^2"             # or "g"
//! [[recording]]
//! file = "r01.csv"           # next to this manifest; or .mat, .npy, .parquet
//! variable = "bearing.gs"    # .mat only
//! shaft_hz = 24.5
//! load_n = 1390.7           # optional
//! shaft_hz_std = 0.05       # optional: standard deviation of the stated speed
//! channels = { ax = "outer-x", ay = "resonator-y" }
//! resample_hz = 12000.0
//! ```

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use toml::{Table, Value};

use super::settings::StatedSettings;
use super::{ReadError, Unit, bounded, error::shown};

const STATED: StatedSettings = StatedSettings::DEFAULT;

/// File name of a folder's manifest.
pub const FILE_NAME: &str = "recordings.toml";

/// A manifest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Manifest {
    /// Entries in their order, with the defaults filled in; at least one.
    pub entries: Vec<Entry>,
}

/// Metadata of one recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Entry {
    /// Path of the file, its folder included.
    pub file: PathBuf,
    /// Sample rate, Hz.
    pub sample_rate_hz: Option<f64>,
    /// Unit of accelerations.
    pub unit: Option<Unit>,
    /// Variable of a `.mat` file.
    pub variable: Option<String>,
    /// Shaft speed, revolutions per second.
    pub shaft_hz: Option<f64>,
    /// Standard deviation of the stated speed, Hz.
    pub shaft_hz_std: Option<f64>,
    /// Radial load, N.
    pub load_n: Option<f64>,
    /// Location of each channel, by name.
    pub channels: Option<BTreeMap<String, String>>,
    /// Whether `channels` is this entry's own, so that each must be in the file; defaults may
    /// name channels of other files.
    pub own_channels: bool,
    /// Rate to resample to, Hz.
    pub resample_hz: Option<f64>,
}

impl Entry {
    /// Entry without metadata.
    pub fn new(file: PathBuf) -> Self {
        Self { file, ..Self::default() }
    }
}

const KEYS: &str = "file, sample_rate_hz, unit, variable, shaft_hz, shaft_hz_std, load_n, channels, resample_hz";
const DEFAULT_KEYS: &str = "sample_rate_hz, unit, variable, shaft_hz, shaft_hz_std, load_n, channels, resample_hz";

impl Manifest {
    /// Reads a manifest; its files are in its folder.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, and unknown, missing and wrong keys, each with its table, such as
    /// `recording[2].unit` (counted from 1).
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let bytes = bounded::settings(path).map_err(|source| ReadError::of(path, source))?;
        Self::parse(&String::from_utf8_lossy(&bytes), path)
    }

    fn parse(text: &str, path: &Path) -> Result<Self, ReadError> {
        let table: Table = text.parse().map_err(|error: toml::de::Error| {
            let start = error.span().map_or(0, |span| span.start.min(text.len()));
            let row = text.as_bytes()[..start].iter().filter(|&&b| b == b'\n').count() + 1;
            ReadError::ManifestSyntax { path: path.into(), row, found: error.message().into() }
        })?;
        let place = Place { path, table: String::new() };
        if let Some(key) = table.keys().find(|k| !["defaults", "recording"].contains(&k.as_str())) {
            return Err(place.unknown(key, "defaults, recording"));
        }
        let mut defaults = Entry::default();
        if let Some(value) = table.get("defaults") {
            let value = value.as_table().ok_or_else(|| place.bad("defaults", value, "a table"))?;
            let place = Place { path, table: "defaults.".into() };
            place.fill(&mut defaults, value, DEFAULT_KEYS)?;
        }
        defaults.own_channels = false;

        const EXPECTED: &str = "at least one [[recording]]";
        let Some(list) = table.get("recording") else {
            return Err(place.missing("recording", EXPECTED));
        };
        let list =
            list.as_array().filter(|list| !list.is_empty()).ok_or_else(|| place.bad("recording", list, EXPECTED))?;
        let mut entries = Vec::with_capacity(list.len());
        for (index, value) in list.iter().enumerate() {
            let number = format!("recording[{}]", index + 1);
            let value = value.as_table().ok_or_else(|| place.bad(&number, value, "a table"))?;
            let place = Place { path, table: format!("{number}.") };
            let mut entry = defaults.clone();
            place.fill(&mut entry, value, KEYS)?;
            if entry.file.as_os_str().is_empty() {
                return Err(place.missing("file", "the name of a file"));
            }
            entry.file = path.parent().unwrap_or(Path::new("")).join(entry.file);
            entries.push(entry);
        }
        Ok(Self { entries })
    }
}

/// A table of a manifest, for messages.
struct Place<'a> {
    path: &'a Path,
    table: String,
}

impl Place<'_> {
    fn key(&self, key: &str) -> String {
        format!("{}{key}", self.table)
    }

    fn unknown(&self, key: &str, expected: &'static str) -> ReadError {
        ReadError::UnknownKey { path: self.path.into(), key: self.key(key), expected }
    }

    fn missing(&self, key: &str, expected: &'static str) -> ReadError {
        ReadError::MissingKey { path: self.path.into(), key: self.key(key), expected }
    }

    fn bad(&self, key: &str, value: &Value, expected: &'static str) -> ReadError {
        let found = shown(value.to_string().as_bytes());
        ReadError::BadValue { path: self.path.into(), key: self.key(key), found, expected }
    }

    /// Overwrites the keys that `table` states.
    fn fill(&self, entry: &mut Entry, table: &Table, keys: &'static str) -> Result<(), ReadError> {
        for (key, value) in table {
            if !keys.split(", ").any(|known| known == key) {
                return Err(self.unknown(key, keys));
            }
            let text = || value.as_str().filter(|text| !text.is_empty()).map(String::from);
            let number = || {
                let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
                number.filter(|number| number.is_finite())
            };
            let positive = || number().filter(|number| *number > 0.0);
            let bad = |expected| self.bad(key, value, expected);
            let up_to = |most: f64| number().filter(|number| number.abs() <= most);
            let rate = || {
                number().filter(|rate| STATED.sample_rate_hz.contains(rate)).ok_or_else(|| bad(StatedSettings::RATES))
            };
            match key.as_str() {
                "file" => entry.file = text().ok_or_else(|| bad("the name of a file"))?.into(),
                "variable" => {
                    entry.variable = Some(text().ok_or_else(|| bad("the name of a variable"))?);
                }
                "unit" => {
                    let unit = value.as_str().and_then(Unit::parse);
                    entry.unit = Some(unit.ok_or_else(|| bad("\"m/s^2\" or \"g\""))?);
                }
                "sample_rate_hz" => {
                    entry.sample_rate_hz = Some(rate()?);
                }
                "resample_hz" => entry.resample_hz = Some(rate()?),
                "shaft_hz" => {
                    let speed = up_to(STATED.shaft_hz).filter(|speed| *speed >= 0.0);
                    entry.shaft_hz = Some(speed.ok_or_else(|| bad(StatedSettings::SPEEDS))?);
                }
                "shaft_hz_std" => entry.shaft_hz_std = Some(positive().ok_or_else(|| bad("a positive number of Hz"))?),
                "load_n" => entry.load_n = Some(up_to(STATED.load_n).ok_or_else(|| bad(StatedSettings::LOADS))?),
                _ => entry.channels = Some(self.channels(key, value)?),
            }
            entry.own_channels |= key == "channels";
        }
        Ok(())
    }

    fn channels(&self, key: &str, value: &Value) -> Result<BTreeMap<String, String>, ReadError> {
        const EXPECTED: &str = "a table of channel = \"location\"";
        let table = value.as_table().ok_or_else(|| self.bad(key, value, EXPECTED))?;
        let mut channels = BTreeMap::new();
        for (channel, location) in table {
            let place = format!("{key}.{channel}");
            let Some(location) = location.as_str() else {
                return Err(self.bad(&place, location, "the name of a location"));
            };
            channels.insert(channel.clone(), location.into());
        }
        Ok(channels)
    }
}
