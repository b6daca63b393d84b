//! Reader of MATLAB v5 files, compressed or not, with structs.
//!
//! Not a crate's: `matfile` 0.5 leaves structs out and accepts truncated files, `matrw` 0.1 panics on them.
//!
//! A named variable is read (`X130_DE_time`, `bearing.gs`), else all real vectors and matrices that are as long as the
//! longest; the columns of a matrix `m` are `m[1]`, `m[2]`, …. A time vector, `XnnnRPM` (CWRU) and `sr`, `rate`, `load`
//! of the struct (MFPT) in the same scope are read as well.

use std::path::Path;

use crate::recording::{
    ReadError, Unit,
    assemble::{Column, Raw, Selection, TimeColumn},
    error::listed,
    time_axis,
};
use element::Bad;
use value::{Numbers, Value};

mod element;
#[cfg(test)]
mod tests;
mod value;

/// Newtons per pound-force, the unit of MFPT's loads.
const NEWTON_PER_POUND: f64 = 4.448_221_615_260_5;

/// A leaf of the tree of variables.
struct Leaf<'a> {
    /// Full name, such as `bearing.gs`.
    name: String,
    value: &'a Value<'a>,
}

impl Leaf<'_> {
    fn numbers(&self) -> Option<&Numbers<'_>> {
        match self.value {
            Value::Numbers(numbers) => Some(numbers),
            _ => None,
        }
    }

    fn scalar(&self) -> Option<f64> {
        match self.value {
            Value::Numbers(numbers) if numbers.len() == 1 => numbers.to_f64().first().copied(),
            Value::Text(text) => text.trim().parse().ok(),
            _ => None,
        }
    }
}

/// Reads one file.
pub(crate) fn read(
    bytes: &[u8],
    path: &Path,
    variable: Option<&str>,
    selection: &Selection,
    skip_bad: bool,
) -> Result<Raw, ReadError> {
    let bad = |bad: Bad| {
        let Bad { offset, found, expected } = bad;
        ReadError::BadMat { path: path.into(), offset, found, expected }
    };
    if bytes.is_empty() {
        return Err(ReadError::Empty { path: path.into() });
    }
    let (order, matrices) = element::matrices(bytes).map_err(bad)?;
    let mut variables = Vec::new();
    for matrix in &matrices {
        variables.push(value::array(matrix, order, 0).map_err(bad)?);
    }
    let mut leaves = Vec::new();
    for (name, value) in &variables {
        flatten(name, value, &mut leaves);
    }
    let chosen = choose(&leaves, path, variable)?;

    let names: Vec<String> = chosen.iter().flat_map(|(leaf, n)| column_names(&leaf.name, n)).collect();
    selection.check(path, &names.iter().map(String::as_str).collect::<Vec<_>>())?;
    let mut raw = Raw::default();
    for (leaf, numbers) in &chosen {
        let mut samples = numbers.to_f64();
        // Columns are split off from the last one on, so that none is copied twice.
        let mut columns = Vec::new();
        for (column, name) in column_names(&leaf.name, numbers).into_iter().enumerate().rev() {
            let samples = samples.split_off(column * numbers.rows());
            if selection.takes(&name) {
                columns.push(Column { name, samples });
            }
        }
        raw.columns.extend(columns.into_iter().rev());
    }
    if let Some((leaf, numbers)) = chosen.first() {
        describe(&mut raw, &leaf.name, numbers.rows(), &leaves);
    }
    raw.drop_non_finite(path, skip_bad)?;
    Ok(raw)
}

fn flatten<'a>(name: &str, value: &'a Value<'a>, leaves: &mut Vec<Leaf<'a>>) {
    if let Value::Struct(fields) = value {
        for (field, value) in fields {
            flatten(&format!("{name}.{field}"), value, leaves);
        }
    } else {
        leaves.push(Leaf { name: name.into(), value });
    }
}

/// Leaves to read: the named one, else the longest.
fn choose<'a>(
    leaves: &'a [Leaf<'a>],
    path: &Path,
    variable: Option<&str>,
) -> Result<Vec<(&'a Leaf<'a>, &'a Numbers<'a>)>, ReadError> {
    let numeric = || leaves.iter().filter_map(|leaf| Some((leaf, leaf.numbers()?)));
    if let Some(variable) = variable {
        let found = numeric().find(|(leaf, _)| leaf.name == variable);
        let Some((leaf, numbers)) = found else {
            let available = listed(numeric().map(|(leaf, _)| &leaf.name));
            let (path, variable) = (path.into(), variable.into());
            return Err(ReadError::UnknownVariable { path, variable, available });
        };
        if numbers.len() == 0 {
            return Err(ReadError::Empty { path: path.into() });
        }
        return Ok(vec![(leaf, numbers)]);
    }
    let signals = || numeric().filter(|(leaf, n)| n.rows() > 1 && !is_time(leaf));
    let longest = signals().map(|(_, n)| n.rows()).max();
    let chosen: Vec<_> = signals().filter(|(_, n)| Some(n.rows()) == longest).collect();
    if chosen.is_empty() { Err(ReadError::Empty { path: path.into() }) } else { Ok(chosen) }
}

fn is_time(leaf: &Leaf) -> bool {
    time_axis::is_time(leaf.name.rsplit('.').next().unwrap_or_default())
}

fn column_names(name: &str, numbers: &Numbers) -> Vec<String> {
    if numbers.is_vector() {
        vec![name.into()]
    } else {
        (1..=numbers.shape[1]).map(|column| format!("{name}[{column}]")).collect()
    }
}

/// Adds time, rate, speed and load from the scope of a signal of `rows` samples.
fn describe(raw: &mut Raw, signal: &str, rows: usize, leaves: &[Leaf]) {
    let (scope, leaf) = signal.rsplit_once('.').map_or(("", signal), |(s, l)| (s, l));
    let sibling = |name: &str| {
        let name = if scope.is_empty() { name.into() } else { format!("{scope}.{name}") };
        leaves.iter().find(|leaf| leaf.name == name)
    };
    let positive = |name: &str| sibling(name).and_then(Leaf::scalar).filter(|value| value.is_finite() && *value > 0.0);
    let scope_of = |leaf: &Leaf| leaf.name.rsplit_once('.').map_or("", |(s, _)| s).to_owned();
    let time =
        leaves.iter().find(|l| is_time(l) && scope_of(l) == scope && l.numbers().is_some_and(|n| n.rows() == rows));
    if let Some((leaf, numbers)) = time.and_then(|leaf| Some((leaf, leaf.numbers()?))) {
        raw.time = Some(TimeColumn { name: leaf.name.clone(), time_s: numbers.to_f64() });
    }
    // CWRU: X130_DE_time is in g, and X130RPM is the shaft speed.
    if let Some((record, place)) = leaf.split_once('_')
        && matches!(place, "DE_time" | "FE_time" | "BA_time")
    {
        raw.unit = Some(Unit::StandardGravity);
        raw.shaft_hz = positive(&format!("{record}RPM")).map(|rpm| rpm / 60.0);
    }
    // MFPT: gs is in g; sr is the sample rate, rate the shaft speed in Hz, load in pounds.
    if leaf == "gs" {
        raw.unit = Some(Unit::StandardGravity);
        raw.sample_rate_hz = positive("sr");
        raw.shaft_hz = positive("rate");
        raw.load_n = sibling("load")
            .and_then(Leaf::scalar)
            .filter(|pounds| pounds.is_finite())
            .map(|pounds| pounds * NEWTON_PER_POUND);
    }
}
