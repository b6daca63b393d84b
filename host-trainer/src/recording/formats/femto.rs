//! Reader of PRONOSTIA/FEMTO run-to-failure recordings (Nectoux et al., 2012): `acc_00001.csv` and on.
//!
//! No header; hour, minute, second, microsecond, horizontal and vertical acceleration in g, at
//! 25.6 kHz. Most folders separate by comma, some by semicolon.

use std::path::Path;

use crate::recording::{
    ReadError, Unit,
    assemble::{Column, Raw, Selection},
    parse_number,
    table::{self, ColumnSpec, Layout, Role},
};

const SAMPLE_RATE_HZ: f64 = 25_600.0;
const TIME: [&str; 4] = ["hour", "minute", "second", "microsecond"];
const CHANNELS: [&str; 2] = ["horizontal", "vertical"];
const WIDTH: usize = TIME.len() + CHANNELS.len();

/// Whether a file has the data set's name for accelerations: `acc_` and a number.
pub(crate) fn is_named(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.strip_prefix("acc_")
        .and_then(|rest| rest.strip_suffix(".csv"))
        .is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// Whether the first line of a file is a row of this format.
pub(crate) fn is_row(line: &[u8]) -> bool {
    let fields = table::split(line, table::separator(line));
    fields.len() == WIDTH && fields.iter().all(|f| parse_number::parse(f).is_some())
}

/// Shaft speed in Hz and load in N of a folder `BearingX_Y`: X is the operating condition
/// (Nectoux et al., 2012, table 2).
pub(crate) fn condition(folder: &str) -> Option<(f64, f64)> {
    let (condition, bearing) = folder.strip_prefix("Bearing")?.split_once('_')?;
    if bearing.is_empty() || !bearing.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let (rpm, load_n) = match condition {
        "1" => (1800.0, 4000.0),
        "2" => (1650.0, 4200.0),
        "3" => (1500.0, 5000.0),
        _ => return None,
    };
    Some((rpm / 60.0, load_n))
}

/// Reads one file.
pub(crate) fn read(bytes: &[u8], path: &Path, selection: &Selection, skip_bad: bool) -> Result<Raw, ReadError> {
    selection.check(path, &CHANNELS)?;
    let columns: Vec<ColumnSpec> = TIME
        .iter()
        .map(|name| (*name, Role::Number))
        .chain(CHANNELS.iter().map(|name| (*name, if selection.takes(name) { Role::Value } else { Role::Number })))
        .map(|(name, role)| ColumnSpec { name: name.into(), role })
        .collect();
    let separator = table::separator(table::first_line(bytes).0);
    let layout = Layout { path, separator, columns: &columns, first_row: 1, skip_bad };
    let table = table::parse(bytes, &layout)?;

    let names = columns.into_iter().filter(|c| c.role == Role::Value).map(|c| c.name);
    let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    let condition = condition(&folder);
    Ok(Raw {
        columns: names.zip(table.columns).map(|(name, samples)| Column { name, samples }).collect(),
        sample_rate_hz: Some(SAMPLE_RATE_HZ),
        shaft_hz: condition.map(|c| c.0),
        load_n: condition.map(|c| c.1),
        start_s: start_s(bytes, separator),
        unit: Some(Unit::StandardGravity),
        dropped: table.dropped,
        ..Raw::default()
    })
}

/// Seconds after midnight of the first row; `None` if that row is bad.
fn start_s(bytes: &[u8], separator: u8) -> Option<f64> {
    let fields = table::split(table::first_line(bytes).0, separator);
    let time: Vec<f64> = fields.iter().take(TIME.len()).map_while(|f| parse_number::parse(f)).collect();
    let [hour, minute, second, microsecond] = time[..] else {
        return None;
    };
    let start = hour * 3600.0 + minute * 60.0 + second + microsecond * 1e-6;
    start.is_finite().then_some(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Literature: Nectoux et al. (2012), table 2.
    #[test]
    fn operating_conditions() {
        assert_eq!(condition("Bearing1_4"), Some((30.0, 4000.0)));
        assert_eq!(condition("Bearing2_7"), Some((27.5, 4200.0)));
        assert_eq!(condition("Bearing3_3"), Some((25.0, 5000.0)));
        for other in ["Bearing4_1", "Bearing1", "Bearing1_", "Bearing1_x", "bearing1_1", "Test"] {
            assert_eq!(condition(other), None, "{other}");
        }
    }

    #[test]
    fn names() {
        assert!(is_named(Path::new("a/acc_00001.csv")));
        for other in ["acc_.csv", "temp_00001.csv", "acc_1.txt", "acc_x.csv"] {
            assert!(!is_named(Path::new(other)), "{other}");
        }
    }
}
