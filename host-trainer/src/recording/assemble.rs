//! Assembly of a [`Recording`] from a file's raw columns: units, rate, locations, resampling.

use std::{collections::BTreeMap, path::Path};

use super::{
    Channel, LoadOptions, ReadError, Recording, Source,
    error::listed,
    job::Job,
    resample, time_axis,
    unit::{Quantity, Unit, default_location},
};

/// A column as stored in a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub name: String,
    pub samples: Vec<f64>,
}

/// A column with times in s.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TimeColumn {
    pub name: String,
    pub time_s: Vec<f64>,
}

/// Contents of a file alone, without manifest and options. All columns are equally long.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Raw {
    pub columns: Vec<Column>,
    pub time: Option<TimeColumn>,
    /// Row of the first sample, for messages.
    pub first_row: usize,
    pub sample_rate_hz: Option<f64>,
    pub shaft_hz: Option<f64>,
    pub load_n: Option<f64>,
    pub start_s: Option<f64>,
    pub unit: Option<Unit>,
    /// Number of rows kept before each bad row that was dropped.
    pub dropped: Vec<usize>,
}

impl Default for Raw {
    fn default() -> Self {
        Self {
            columns: Vec::new(),
            time: None,
            first_row: 1,
            sample_rate_hz: None,
            shaft_hz: None,
            load_n: None,
            start_s: None,
            unit: None,
            dropped: Vec::new(),
        }
    }
}

impl Raw {
    /// Drops all rows with NaN or an infinity, or reports the first as an error. For binary formats; text is checked as
    /// it is parsed.
    pub(super) fn drop_non_finite(&mut self, path: &Path, skip_bad: bool) -> Result<(), ReadError> {
        let time = self.time.iter().map(|t| (&t.name, &t.time_s));
        let all = self.columns.iter().map(|c| (&c.name, &c.samples)).chain(time);
        let mut bad: Vec<usize> = Vec::new();
        let mut first: Option<(usize, &String, f64)> = None;
        for (name, samples) in all {
            for (index, &value) in samples.iter().enumerate().filter(|(_, v)| !v.is_finite()) {
                bad.push(index);
                if first.is_none_or(|(row, ..)| index < row) {
                    first = Some((index, name, value));
                }
            }
        }
        let Some((index, column, value)) = first else {
            return Ok(());
        };
        if !skip_bad {
            let (column, found) = (column.clone(), value.to_string());
            return Err(ReadError::NotFinite { path: path.into(), row: index + 1, column, found });
        }
        bad.sort_unstable();
        bad.dedup();
        let keep = |samples: &mut Vec<f64>| {
            let mut index = 0;
            samples.retain(|_| {
                index += 1;
                bad.binary_search(&(index - 1)).is_err()
            });
        };
        self.columns.iter_mut().for_each(|c| keep(&mut c.samples));
        self.time.iter_mut().for_each(|t| keep(&mut t.time_s));
        self.dropped.extend(bad.iter().enumerate().map(|(before, row)| row - before));
        Ok(())
    }
}

/// Channels to read, and their locations.
#[derive(Clone, Debug, Default)]
pub(super) struct Selection<'a> {
    wanted: Option<&'a [String]>,
    locations: Option<&'a BTreeMap<String, String>>,
    /// Whether every key of `locations` must be a channel.
    strict: bool,
}

impl<'a> Selection<'a> {
    pub(super) fn new(job: &'a Job, options: &'a LoadOptions) -> Self {
        Self {
            wanted: options.channels.as_deref(),
            locations: job.entry.channels.as_ref(),
            strict: job.entry.own_channels,
        }
    }

    fn location(&self, name: &str) -> Option<&str> {
        let stated = self.locations.and_then(|l| l.get(name)).map(String::as_str);
        stated.or_else(|| default_location(name))
    }

    /// Whether the channel of this name is wanted.
    pub(super) fn takes(&self, name: &str) -> bool {
        self.wanted.is_none_or(|wanted| wanted.iter().any(|w| w == name || Some(w.as_str()) == self.location(name)))
    }

    /// Checks that every wanted or located channel is `available`.
    pub(super) fn check(&self, path: &Path, available: &[&str]) -> Result<(), ReadError> {
        let is_there =
            |wanted: &str| available.iter().any(|name| *name == wanted || self.location(name) == Some(wanted));
        let located = self.locations.filter(|_| self.strict).into_iter().flat_map(|l| l.keys());
        let missing = self.wanted.into_iter().flatten().find(|w| !is_there(w));
        match missing.or_else(|| located.into_iter().find(|l| !available.contains(&l.as_str()))) {
            None => Ok(()),
            Some(channel) => Err(ReadError::UnknownChannel {
                path: path.into(),
                channel: channel.clone(),
                available: listed(available),
            }),
        }
    }
}

/// Assembles a recording. Options override the manifest, and the manifest the file.
pub(super) fn assemble(
    raw: Raw,
    job: &Job,
    selection: &Selection,
    options: &LoadOptions,
) -> Result<Recording, ReadError> {
    let (path, entry) = (&job.entry.file, &job.entry);
    let first_row = raw.first_row;
    if raw.columns.first().is_none_or(|c| c.samples.is_empty()) {
        return Err(ReadError::Empty { path: path.clone() });
    }
    let stated = options.sample_rate_hz.or(entry.sample_rate_hz).or(raw.sample_rate_hz);
    let (sample_rate_hz, mut gaps) = match (stated, raw.time) {
        (Some(rate), _) => (rate, Vec::new()),
        (None, Some(time)) => {
            let axis = time_axis::read(&time.time_s, &time.name, path, first_row)?;
            (axis.sample_rate_hz, axis.gaps)
        }
        (None, None) => return Err(ReadError::MissingRate { path: path.clone() }),
    };

    gaps.extend(raw.dropped.iter().filter_map(|kept| kept.checked_sub(1)));
    gaps.sort_unstable();
    gaps.dedup();

    let convert = |column: Column| {
        let unit = match Quantity::from_name(&column.name) {
            Quantity::Acceleration => options.unit.or(entry.unit).or(raw.unit).unwrap_or_default(),
            Quantity::AccelerationIn(unit) => options.unit.unwrap_or(unit),
            Quantity::Other => Unit::MetrePerSecondSquared,
        };
        let Column { name, mut samples } = column;
        if unit != Unit::MetrePerSecondSquared {
            let factor = unit.factor();
            samples.iter_mut().for_each(|sample| *sample *= factor);
        }
        Channel { location: selection.location(&name).map(String::from), name, samples }
    };
    let recording = Recording {
        source: Source { path: path.clone(), variable: job.variable.clone() },
        channels: raw.columns.into_iter().map(convert).collect(),
        sample_rate_hz,
        shaft_hz: entry.shaft_hz.or(raw.shaft_hz),
        shaft_hz_std: entry.shaft_hz_std,
        load_n: entry.load_n.or(raw.load_n),
        start_s: raw.start_s,
        skipped_rows: raw.dropped.len(),
        gaps,
    };
    Ok(match options.resample_hz.or(entry.resample_hz) {
        Some(rate) => resample::recording(recording, rate),
        None => recording,
    })
}
