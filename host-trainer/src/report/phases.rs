//! Report of `ballrace phases`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{Cell, Document, Section, Tone};
use crate::paper::aged_bearing;
use crate::recording::{Recording, Source};
use crate::report::plot::{DrawError, life};
use crate::signal::phases::life::Timeline;
use crate::signal::phases::machine::{Filter, Lives};
use crate::signal::phases::{FEWEST_HEALTHY, Phases, Rules};
use crate::signal::wavelet::denoise::Denoising;

/// Machine of a report.
pub struct Machine {
    /// Name of its folder.
    pub name: String,
    /// Lives of its channels.
    pub lives: Lives,
    /// Phases of each.
    pub phases: Vec<Option<Phases>>,
}

/// Recordings in which phases cannot be sought.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// Too few recordings.
    #[error("{folder}: found {found} recordings, expected more than {fewest}: so many are healthy at the beginning")]
    TooFew {
        /// Folder of the machine.
        folder: PathBuf,
        /// Recordings found.
        found: usize,
        /// Healthy recordings at the beginning.
        fewest: usize,
    },
    /// Recording of another rate than the first.
    #[error("{recording}: found {found} Hz, expected {expected} Hz as {first} has; --resample makes them equal")]
    Rate {
        /// Source of the recording.
        recording: Source,
        /// Sample rate of the recording, Hz.
        found: f64,
        /// Sample rate of the first recording, Hz.
        expected: f64,
        /// Source of the first recording.
        first: Source,
    },
}

impl Machine {
    /// Phases of a folder's recordings; `denoising` at their sample rate, Hz.
    ///
    /// # Errors
    /// [`MachineError`]: too few recordings, or of several rates.
    pub fn new(
        folder: &Path,
        recordings: &[Recording],
        rules: &Rules,
        denoising: impl FnOnce(f64) -> Denoising,
    ) -> Result<Self, MachineError> {
        let fewest = rules.healthy.unwrap_or(FEWEST_HEALTHY);
        let Some(first) = recordings.first().filter(|_| recordings.len() > fewest) else {
            return Err(MachineError::TooFew { folder: folder.to_owned(), found: recordings.len(), fewest });
        };
        if let Some(other) = recordings.iter().find(|r| r.sample_rate_hz != first.sample_rate_hz) {
            return Err(MachineError::Rate {
                recording: other.source.clone(),
                found: other.sample_rate_hz,
                expected: first.sample_rate_hz,
                first: first.source.clone(),
            });
        }
        let lives = Lives::new(recordings, &denoising(first.sample_rate_hz));
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, phases: lives.phases(rules), lives })
    }

    /// JSON document of the phases of each channel.
    pub fn document(&self) -> Value {
        let timeline = &self.lives.timeline;
        let recording = |index: usize| {
            json!({ "index": index, "name": timeline.names[index],
                    "time_s": timeline.times_s.as_ref().map(|times| times[index]) })
        };
        let channel = |(n, phases): (usize, &Option<Phases>)| {
            let life = &self.lives.channels[n];
            phases.map(|phases| {
                json!({ "channel": life.channel, "denoised": life.filter == Filter::Wavelet,
                        "healthy": { "recordings": phases.healthy, "kurtosis": phases.mean, "kurtosis_std": phases.std },
                        "aging": phases.aging.map(recording), "in_a_row": phases.in_a_row,
                        "failure": phases.failure.map(recording),
                        "aging_recordings": phases.between(life.features.len()) })
            })
        };
        json!({
            "name": self.name, "recordings": timeline.names.len(), "gaps": timeline.gaps(),
            "paper_aging_recordings": aged_bearing(&self.name).map(|paper| paper.aging_recordings),
            "channels": self.phases.iter().enumerate().filter_map(channel).collect::<Vec<_>>(),
        })
    }
}

/// Report of the phases of machines.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(machines: &[Machine], rules: &Rules) -> Result<Document, DrawError> {
    let names: Vec<&str> = machines.iter().map(|machine| machine.name.as_str()).collect();
    let verdict: Vec<String> = machines.iter().map(verdict).collect();
    let mut document = Document::new("Aging phases", names.join(", "), Tone::Open, verdict.join(" "));
    for machine in machines {
        document = document.section(section(machine, rules)?);
    }
    Ok(document)
}

/// Start of aging of each raw channel in a sentence.
pub fn verdict(machine: &Machine) -> String {
    let Machine { name, lives, phases } = machine;
    let raw = lives.channels.iter().zip(phases).filter(|(life, _)| life.filter == Filter::Raw);
    let each = raw.map(|(life, phases)| match phases.and_then(|phases| phases.aging) {
        Some(start) => format!("{} ages from {}", life.channel, place(&lives.timeline, start)),
        None => format!("{} shows no aging", life.channel),
    });
    format!("{name}: {}.", each.collect::<Vec<_>>().join(", "))
}

/// Name of a recording with its time.
pub fn place(timeline: &Timeline, index: usize) -> String {
    let name = &timeline.names[index];
    timeline.times_s.as_ref().map_or_else(|| name.clone(), |times| format!("{name} ({:.0} s)", times[index]))
}

/// Name of the signal of which features are taken.
pub fn filter_name(filter: Filter) -> &'static str {
    match filter {
        Filter::Raw => "raw",
        Filter::Wavelet => "denoised",
    }
}

/// Names of the columns of [`row`].
pub const HEAD: [&str; 7] =
    ["channel", "signal", "healthy kurtosis", "aging from", "in a row", "failure from", "recordings between"];

/// Phases of a channel as words.
pub fn row(lives: &Lives, index: usize, phases: &Phases) -> [String; 7] {
    let life = &lives.channels[index];
    let start = |index: Option<usize>| index.map_or("none".into(), |index| place(&lives.timeline, index));
    [
        life.channel.clone(),
        filter_name(life.filter).into(),
        format!("{:.2} ± {:.2}", phases.mean, phases.std),
        start(phases.aging),
        phases.aging.map_or(String::new(), |_| phases.in_a_row.to_string()),
        start(phases.failure),
        phases.between(life.features.len()).map_or(String::new(), |count| count.to_string()),
    ]
}

fn section(machine: &Machine, rules: &Rules) -> Result<Section, DrawError> {
    let lives = &machine.lives;
    let rows = machine.phases.iter().enumerate().filter_map(|(n, phases)| Some(row(lives, n, phases.as_ref()?)));
    let rows = rows.map(|row| row.into_iter().map(Cell::text).collect()).collect();
    pictures(Section::new(&machine.name).table("", &HEAD, rows), machine, rules)
}

/// Section with a picture of each channel of a machine.
///
/// # Errors
/// Errors of the drawing library.
pub fn pictures(mut section: Section, machine: &Machine, rules: &Rules) -> Result<Section, DrawError> {
    for (life, phases) in machine.lives.channels.iter().zip(&machine.phases) {
        let Some(phases) = phases else { continue };
        let Ok(svg) = life::svg(&life.features, phases, rules) else { continue };
        let caption = format!(
            "Channel {}, {}. Shaded, the {} healthy recordings; dashed, {} standard deviations of their kurtosis.",
            life.channel,
            filter_name(life.filter),
            phases.healthy,
            rules.sigmas
        );
        section = section.figure(svg, caption);
    }
    Ok(section)
}
