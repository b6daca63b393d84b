//! Question on the CWRU records: which part of the bearing is damaged.

use super::leave_one_out::{Aim, Bearing, Score};
use super::measure::Measured;
use super::set::FeatureSet;
use super::settings::FeatureSettings;
use crate::recording::input::Series;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Damaged parts.
pub const CLASSES: [&str; 3] = ["inner race", "ball", "outer race"];

/// What is predicted: the damaged part of a segment.
pub const AIM: Aim = Aim { score: Score::Recall, classes: CLASSES.len() };

/// Record of one bearing with one fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Number of the record.
    pub number: u16,
    /// File in the folder.
    pub file: &'static str,
    /// Place of the damaged part among [`CLASSES`].
    pub class: usize,
}

impl Record {
    /// Variable of the accelerometer at the drive end.
    pub fn variable(self) -> String {
        format!("X{:03}_DE_time", self.number)
    }
}

/// Sample rate of the records, Hz; the files do not state it.
pub const SAMPLE_RATE_HZ: f64 = 12_000.0;

/// Records at no load. 97 is the only healthy one and cannot be left out, so the question is not asked of it.
pub const RECORDS: [Record; 8] = [
    Record { number: 105, file: "105_0.mat", class: 0 },
    Record { number: 209, file: "209_0.mat", class: 0 },
    Record { number: 278, file: "278_0.mat", class: 0 },
    Record { number: 118, file: "118_0.mat", class: 1 },
    Record { number: 185, file: "185_0.mat", class: 1 },
    Record { number: 222, file: "222_0.mat", class: 1 },
    Record { number: 130, file: "130_at_6_0.mat", class: 2 },
    Record { number: 144, file: "144_at_3_0.mat", class: 2 },
];

/// Segments of a record; the rest at its end is left out.
pub fn segments(series: &Series) -> Vec<Series> {
    let segments = series.samples.chunks_exact(SETTINGS.segment).enumerate();
    segments
        .map(|(n, samples)| Series { name: format!("{} {}", series.name, n + 1), samples: samples.to_vec() })
        .collect()
}

/// Segments of a record with their features.
#[derive(Clone, Debug)]
pub struct Measurements {
    /// The record.
    pub record: Record,
    /// Features of its segments.
    pub measured: Vec<Measured>,
}

/// Rows of the records.
pub fn bearings(records: &[Measurements], set: FeatureSet) -> Vec<Bearing> {
    let one = |Measurements { record, measured }: &Measurements| Bearing {
        name: record.number.to_string(),
        rows: measured.iter().map(|measured| set.values(measured)).collect(),
        targets: vec![record.class as f64; measured.len()],
    };
    records.iter().map(one).collect()
}
