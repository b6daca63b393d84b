//! Assembly of a [`Recording`] from a file's raw columns: units, rate, locations, resampling.

use std::{collections::BTreeMap, path::Path};

use super::{
    Channel, LoadOptions, ReadError, Recording, Source,
    error::listed,
    job::Job,
    resample,
    settings::{SizeSettings, StatedSettings},
    time_axis,
    unit::{Quantity, Unit, default_location},
};

const SIZES: SizeSettings = SizeSettings::DEFAULT;
const STATED: StatedSettings = StatedSettings::DEFAULT;

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

/// Whether a number can be a sample.
pub(super) fn is_sample(value: f64) -> bool {
    // NaN is not.
    value.abs() <= SIZES.largest_sample
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
    /// Drops all rows with NaN, an infinity or a number too large, or reports the first as an error. For binary
    /// formats; text is checked as it is parsed.
    pub(super) fn drop_non_finite(&mut self, path: &Path, skip_bad: bool) -> Result<(), ReadError> {
        let time = self.time.iter().map(|t| (&t.name, &t.time_s));
        let all = self.columns.iter().map(|c| (&c.name, &c.samples)).chain(time);
        let mut bad: Vec<usize> = Vec::new();
        let mut first: Option<(usize, &String, f64)> = None;
        for (name, samples) in all {
            for (index, &value) in samples.iter().enumerate().filter(|(_, v)| !is_sample(**v)) {
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
            return Err(ReadError::not_a_sample(path, index + 1, column.clone(), value, format!("{value:?}")));
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

    if !STATED.sample_rate_hz.contains(&sample_rate_hz) {
        return Err(ReadError::BadRate {
            path: path.clone(),
            key: "sample_rate_hz",
            found: sample_rate_hz,
            expected: StatedSettings::RATES.into(),
        });
    }
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
        resampled_from_hz: None,
        skipped_rows: raw.dropped.len(),
        gaps,
    };
    match options.resample_hz.or(entry.resample_hz) {
        Some(rate) => {
            check_resampling(&recording, rate, options.resample_hz.is_some())?;
            Ok(resample::recording(recording, rate))
        }
        None => Ok(recording),
    }
}

/// Checks a rate to resample to. In a manifest, a rate above the recording's own is a mistake; `--resample` brings
/// recordings of several rates to one.
fn check_resampling(recording: &Recording, rate_hz: f64, by_option: bool) -> Result<(), ReadError> {
    let ratio = rate_hz / recording.sample_rate_hz;
    let samples = recording.len() as f64 * ratio;
    let refuse = |expected: String| {
        let path = recording.source.path.clone();
        Err(ReadError::BadRate { path, key: "resample_hz", found: rate_hz, expected })
    };
    if !(1.0 / STATED.resample_ratio..=STATED.resample_ratio).contains(&ratio) {
        return refuse(format!("within a factor of {} of {} Hz", STATED.resample_ratio, recording.sample_rate_hz));
    }
    if samples > SIZES.resampled {
        return refuse(format!("at most {:.0} samples, not {samples:.0}", SIZES.resampled));
    }
    if ratio > 1.0 && !by_option {
        return refuse(format!("at most the sample rate of {} Hz: more adds no content", recording.sample_rate_hz));
    }
    Ok(())
}
