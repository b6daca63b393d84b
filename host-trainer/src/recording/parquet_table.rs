//! Tables as Parquet: columns of text, counts and numbers, in which each value may be unknown.

use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// Values of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values {
    /// UTF-8.
    Text(Vec<Option<String>>),
    /// INT64.
    Count(Vec<Option<i64>>),
    /// DOUBLE.
    Number(Vec<Option<f64>>),
}

/// Parquet file of one row group; `name` is that of its schema.
///
/// # Errors
/// Errors of the Parquet library.
pub(crate) fn encode(name: &str, columns: Vec<(&str, Values)>) -> Result<Vec<u8>, ParquetError> {
    let field = |(name, values): &(&str, Values)| match values {
        Values::Text(_) => format!("OPTIONAL BYTE_ARRAY {name} (UTF8);"),
        Values::Count(_) => format!("OPTIONAL INT64 {name};"),
        Values::Number(_) => format!("OPTIONAL DOUBLE {name};"),
    };
    let schema = format!("message {name} {{ {} }}", columns.iter().map(field).collect::<Vec<_>>().join(" "));
    let mut bytes = Vec::new();
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer =
        SerializedFileWriter::new(&mut bytes, Arc::new(parse_message_type(&schema)?), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (name, values) in columns {
        let Some(mut place) = group.next_column()? else { break };
        match (values, place.untyped()) {
            (Values::Text(values), ColumnWriter::ByteArrayColumnWriter(to)) => {
                let levels = levels(&values);
                let known = values.into_iter().flatten().map(|text| ByteArray::from(text.into_bytes()));
                to.write_batch(&known.collect::<Vec<_>>(), Some(&levels), None)?;
            }
            (Values::Count(values), ColumnWriter::Int64ColumnWriter(to)) => {
                to.write_batch(&known(&values), Some(&levels(&values)), None)?;
            }
            (Values::Number(values), ColumnWriter::DoubleColumnWriter(to)) => {
                to.write_batch(&known(&values), Some(&levels(&values)), None)?;
            }
            _ => return Err(ParquetError::General(format!("{name} is not of its column's type"))),
        }
        place.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

/// For each row, whether its value is known.
fn levels<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|value| value.is_some().into()).collect()
}

fn known<T: Copy>(values: &[Option<T>]) -> Vec<T> {
    values.iter().copied().flatten().collect()
}
