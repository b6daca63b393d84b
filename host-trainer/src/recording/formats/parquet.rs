//! Reader of Parquet: one numeric column for each channel, and at most one time column.
//!
//! Columns that hold neither floats nor integers are left out. A null is treated as NaN.

use std::{
    fs::File,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use parquet::{
    basic::ConvertedType,
    column::reader::{ColumnReader, ColumnReaderImpl},
    data_type::DataType,
    errors::ParquetError,
    file::{reader::FileReader, serialized_reader::SerializedFileReader},
    schema::types::ColumnDescriptor,
};

use crate::recording::{
    ReadError,
    assemble::{Column, Raw, Selection, TimeColumn},
    bounded,
    settings::SizeSettings,
    time_axis,
};

/// Reads one file.
pub(crate) fn read(path: &Path, selection: &Selection, skip_bad: bool) -> Result<Raw, ReadError> {
    let file = bounded::check_samples(path).and_then(|()| File::open(path));
    let file = file.map_err(|source| ReadError::of(path, source))?;
    if file.metadata().is_ok_and(|m| m.len() == 0) {
        return Err(ReadError::Empty { path: path.into() });
    }
    // The crate may panic on damaged files.
    let columns = catch_unwind(AssertUnwindSafe(|| columns(file, path, selection)));
    let mut raw = columns.unwrap_or_else(|_| {
        Err(ReadError::BadParquet {
            path: path.into(),
            part: "data".into(),
            found: "contents that contradict each other".into(),
            expected: "an intact Parquet file",
        })
    })?;
    raw.drop_non_finite(path, skip_bad)?;
    Ok(raw)
}

fn columns(file: File, path: &Path, selection: &Selection) -> Result<Raw, ReadError> {
    let bad = |part: String, error: ParquetError| ReadError::BadParquet {
        path: path.into(),
        part,
        found: error.to_string(),
        expected: "an intact Parquet file",
    };
    let reader = SerializedFileReader::new(file).map_err(|e| bad("footer".into(), e))?;
    let metadata = reader.metadata();
    let schema = metadata.file_metadata().schema_descr();
    let numeric: Vec<(usize, &ColumnDescriptor)> = schema
        .columns()
        .iter()
        .enumerate()
        .map(|(index, column)| (index, column.as_ref()))
        .filter(|(_, column)| is_numeric(column))
        .collect();
    let name = |column: &ColumnDescriptor| column.path().string();
    let names: Vec<String> = numeric.iter().map(|(_, column)| name(column)).collect();
    let channels: Vec<&str> = names.iter().map(String::as_str).filter(|name| !time_axis::is_time(name)).collect();
    if channels.is_empty() {
        return Err(ReadError::Empty { path: path.into() });
    }
    selection.check(path, &channels)?;
    // A row that repeats takes next to nothing in the file.
    let rows = usize::try_from(metadata.file_metadata().num_rows()).unwrap_or_default();
    let most = SizeSettings::DEFAULT.samples;
    if rows.checked_mul(numeric.len()).is_none_or(|samples| samples > most) {
        return Err(ReadError::TooMany { path: path.into(), most });
    }

    let mut raw = Raw::default();
    for (index, column) in numeric {
        let name = name(column);
        let is_time = time_axis::is_time(&name);
        if !is_time && !selection.takes(&name) {
            continue;
        }
        let mut samples = Vec::new();
        for group in 0..reader.num_row_groups() {
            let part = |e| bad(format!("row group {group}, column `{name}`"), e);
            let group = reader.get_row_group(group).map_err(part)?;
            let chunk = group.get_column_reader(index).map_err(part)?;
            let unsigned = column.converted_type() == ConvertedType::UINT_32;
            let levels = column.max_def_level();
            match chunk {
                ColumnReader::FloatColumnReader(c) => read_chunk(c, levels, &mut samples, f64::from),
                ColumnReader::DoubleColumnReader(c) => read_chunk(c, levels, &mut samples, |v| v),
                ColumnReader::Int32ColumnReader(c) => {
                    let convert = |v: i32| {
                        if unsigned { f64::from(v as u32) } else { f64::from(v) }
                    };
                    read_chunk(c, levels, &mut samples, convert)
                }
                ColumnReader::Int64ColumnReader(c) => read_chunk(c, levels, &mut samples, |v| v as f64),
                // `is_numeric` lets no other type through.
                _ => Ok(()),
            }
            .map_err(part)?;
            if samples.len() > rows {
                break;
            }
        }
        if is_time {
            raw.time = Some(TimeColumn { name, time_s: samples });
        } else {
            raw.columns.push(Column { name, samples });
        }
    }
    let lengths = raw.columns.iter().map(|c| c.samples.len());
    let lengths = lengths.chain(raw.time.iter().map(|t| t.time_s.len()));
    for found in lengths {
        if found != rows {
            return Err(ReadError::RowWidth { path: path.into(), row: found + 1, found: 0, expected: rows });
        }
    }
    Ok(raw)
}

/// Whether a column holds floats or integers; dates and decimals are stored as integers and do not count.
fn is_numeric(column: &ColumnDescriptor) -> bool {
    use ConvertedType as C;
    use parquet::basic::Type;
    let is_number = matches!(
        column.converted_type(),
        C::NONE | C::INT_8 | C::INT_16 | C::INT_32 | C::INT_64 | C::UINT_8 | C::UINT_16 | C::UINT_32 | C::UINT_64
    );
    let is_stored_as_one = matches!(column.physical_type(), Type::FLOAT | Type::DOUBLE | Type::INT32 | Type::INT64);
    let is_timestamp = column
        .logical_type_ref()
        .is_some_and(|logical| !matches!(logical, parquet::basic::LogicalType::Integer { .. }));
    is_number && is_stored_as_one && !is_timestamp && column.max_rep_level() == 0
}

/// Appends a column chunk; nulls become NaN.
fn read_chunk<T: DataType>(
    mut chunk: ColumnReaderImpl<T>,
    defined: i16,
    samples: &mut Vec<f64>,
    convert: impl Fn(T::T) -> f64,
) -> Result<(), ParquetError> {
    const BATCH: usize = 1 << 16;
    loop {
        let (mut values, mut levels) = (Vec::new(), Vec::new());
        let definition = (defined > 0).then_some(&mut levels);
        let (records, ..) = chunk.read_records(BATCH, definition, None, &mut values)?;
        if records == 0 {
            return Ok(());
        }
        let mut values = values.into_iter().map(&convert);
        if defined > 0 {
            let is_defined = levels.iter().map(|&level| level == defined);
            samples.extend(is_defined.map(|is| is.then(|| values.next()).flatten().unwrap_or(f64::NAN)));
        } else {
            samples.extend(values);
        }
    }
}
