//! Rows of a sweep as CSV and Parquet, the same columns in both.

use parquet::errors::ParquetError;

use super::job::Row;
use crate::recording::parquet_table::{self, Values};

/// Column: its name and its values.
enum Column {
    Text(&'static str, fn(&Row) -> Option<String>),
    Count(&'static str, fn(&Row) -> Option<i64>),
    Number(&'static str, fn(&Row) -> Option<f64>),
}

/// Name of a value that serialises as text.
pub fn text(value: impl serde::Serialize) -> Option<String> {
    serde_json::to_value(value).ok()?.as_str().map(str::to_owned)
}

const COLUMNS: [Column; 27] = [
    Column::Text("name", |row| Some(row.job.sizes.name.clone())),
    Column::Text("recording", |row| row.job.recording.clone()),
    Column::Count("nd", |row| Some(row.job.sizes.nd as i64)),
    Column::Count("nmd", |row| Some(row.job.sizes.nmd as i64)),
    Column::Count("nf", |row| Some(row.job.sizes.nf as i64)),
    Column::Count("powers", |row| Some(row.job.powers.into())),
    Column::Text("solver", |row| text(row.job.solver)),
    Column::Text("alignment", |row| text(row.job.alignment)),
    Column::Text("estimator", |row| text(row.job.estimator)),
    Column::Text("filter", |row| Some(row.job.filter.clone())),
    Column::Number("lambda1", |row| Some(row.job.lambda[0])),
    Column::Number("lambda2", |row| Some(row.job.lambda[1])),
    Column::Number("lambda3", |row| Some(row.job.lambda[2])),
    Column::Text("sparsity", |row| text(row.job.sparsity)),
    Column::Count("seed", |row| i64::try_from(row.job.seed).ok()),
    Column::Count("epochs", |row| Some(row.job.epochs as i64)),
    Column::Count("functions", |row| Some(row.functions as i64)),
    Column::Count("terms", |row| row.terms.map(|n| n as i64)),
    Column::Number("r2", |row| row.r2),
    Column::Number("r2_validation", |row| row.r2_validation),
    Column::Number("r2_held_out", |row| row.r2_held_out),
    Column::Number("r2_causal", |row| row.r2_causal),
    Column::Text("null_kind", |row| text(row.job.null_kind)),
    Column::Number("r2_causal_null", |row| row.r2_causal_null),
    Column::Number("r2_null", |row| row.r2_null),
    Column::Number("seconds", |row| Some(row.seconds)),
    Column::Text("error", |row| row.error.clone()),
];

impl Column {
    const fn name(&self) -> &'static str {
        match self {
            Self::Text(name, _) | Self::Count(name, _) | Self::Number(name, _) => name,
        }
    }
}

/// Rows as CSV with a header; what is not known is empty.
pub fn csv(rows: &[Row]) -> String {
    let quoted = |text: String| match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    };
    let cell = |column: &Column, row: &Row| match column {
        Column::Text(_, of) => of(row).map(quoted),
        Column::Count(_, of) => of(row).map(|n| n.to_string()),
        Column::Number(_, of) => of(row).map(|v| v.to_string()),
    };
    let line =
        |row: &Row| COLUMNS.iter().map(|column| cell(column, row).unwrap_or_default()).collect::<Vec<_>>().join(",");
    let head = COLUMNS.iter().map(Column::name).collect::<Vec<_>>().join(",");
    std::iter::once(head).chain(rows.iter().map(line)).map(|line| line + "\n").collect()
}

/// The same columns of a row as values by name; what is not known is null.
pub fn values(row: &Row) -> serde_json::Map<String, serde_json::Value> {
    let value = |column: &Column| match column {
        Column::Text(_, of) => of(row).into(),
        Column::Count(_, of) => of(row).into(),
        Column::Number(_, of) => of(row).into(),
    };
    COLUMNS.iter().map(|column| (column.name().to_owned(), value(column))).collect()
}

/// Rows as a Parquet file of one row group.
///
/// # Errors
/// Errors of the Parquet library.
pub fn parquet(rows: &[Row]) -> Result<Vec<u8>, ParquetError> {
    let values = |column: &Column| match column {
        Column::Text(_, of) => Values::Text(rows.iter().map(of).collect()),
        Column::Count(_, of) => Values::Count(rows.iter().map(of).collect()),
        Column::Number(_, of) => Values::Number(rows.iter().map(of).collect()),
    };
    parquet_table::encode("sweep", COLUMNS.iter().map(|column| (column.name(), values(column))).collect())
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;
    use crate::sweep::job::Job;

    #[test]
    fn invariant_both_forms_read_back_as_what_was_written() {
        let job = Job { recording: Some("a \"b\", c".into()), seed: 7, ..Job::default() };
        let good = Row { r2: Some(0.9), terms: Some(12), seconds: 1.5, ..Row::failed(&job, 77, None) };
        let failed = Row::failed(&job, 0, Some("too few rows".into()));
        let rows = [good, failed];

        let text = csv(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines[1].contains("\"a \"\"b\"\", c\"") && lines[2].ends_with(",too few rows"), "{text}");
        assert_eq!(lines[0].split(',').count(), COLUMNS.len());

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.parquet");
        std::fs::write(&path, parquet(&rows).unwrap()).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let read: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(read.len(), 2);
        let field = |row: usize, name: &str| {
            let (_, field) = read[row].get_column_iter().find(|(column, _)| *column == name).unwrap();
            field.clone()
        };
        assert_eq!(field(0, "recording"), Field::Str("a \"b\", c".into()));
        assert_eq!(field(0, "r2"), Field::Double(0.9));
        assert_eq!((field(0, "terms"), field(0, "seed")), (Field::Long(12), Field::Long(7)));
        assert_eq!((field(0, "error"), field(1, "r2")), (Field::Null, Field::Null));
        assert_eq!(field(1, "error"), Field::Str("too few rows".into()));
        let names: Vec<&str> = read[0].get_column_iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, COLUMNS.iter().map(Column::name).collect::<Vec<_>>());
    }
}
