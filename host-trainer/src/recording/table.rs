//! Parser of rows of numbers in text, one pass over the bytes.
//!
//! A row is first read on a fast path for plain decimals between separators. Any other row goes to `careful_row`, so
//! that errors are found in one place and the fast path needs no error handling.

use std::path::Path;

use super::{
    ReadError,
    assemble::is_sample,
    error::shown,
    parse_number::{self, number},
    settings::SizeSettings,
};

const SETTINGS: SizeSettings = SizeSettings::DEFAULT;

/// Use of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Numbers that are read.
    Value,
    /// Numbers that are checked only.
    Number,
    /// Any text, not read.
    Ignored,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub(super) struct ColumnSpec {
    pub name: String,
    pub role: Role,
}

/// Layout of a table.
pub(super) struct Layout<'a> {
    pub path: &'a Path,
    pub separator: u8,
    pub columns: &'a [ColumnSpec],
    /// Line number of the first row, from 1.
    pub first_row: usize,
    pub skip_bad: bool,
}

/// Numbers of the columns with [`Role::Value`], in their order.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub columns: Vec<Vec<f64>>,
    /// Number of rows kept before each bad row that was dropped.
    pub dropped: Vec<usize>,
}

/// Reads `bytes`, which begin at the first row. Blank lines may follow the last row.
pub(super) fn parse(bytes: &[u8], layout: &Layout) -> Result<Table, ReadError> {
    let wanted = layout.columns.iter().filter(|c| c.role == Role::Value).count();
    // An estimate of the number of rows from the length of the first.
    let row_length = bytes.iter().position(|&b| b == b'\n').unwrap_or(bytes.len()).max(1);
    let rows = (bytes.len() / row_length + 1).min(SETTINGS.samples / wanted.max(1));
    let mut table = Table { columns: (0..wanted).map(|_| Vec::with_capacity(rows)).collect(), dropped: Vec::new() };

    let mut at = 0;
    let mut row = layout.first_row;
    let mut kept = 0;
    let most = SETTINGS.samples / wanted.max(1);
    while at < bytes.len() {
        if kept >= most {
            return Err(ReadError::TooMany { path: layout.path.into(), most: SETTINGS.samples });
        }
        if let Some(next) = quick_row(bytes, at, layout, &mut table.columns) {
            at = next;
            kept += 1;
        } else {
            // The fast path may have stopped in the middle of the row.
            table.columns.iter_mut().for_each(|c| c.truncate(kept));
            let line = &bytes[at..];
            let end = line.iter().position(|&b| b == b'\n');
            let line = &line[..end.unwrap_or(line.len())];
            if line.trim_ascii().is_empty() && bytes[at..].trim_ascii().is_empty() {
                break;
            }
            match careful_row(line, row, layout) {
                Ok(values) => {
                    table.columns.iter_mut().zip(values).for_each(|(c, v)| c.push(v));
                    kept += 1;
                }
                Err(_) if layout.skip_bad => table.dropped.push(kept),
                Err(error) => return Err(error),
            }
            at += line.len() + 1;
        }
        row += 1;
    }
    if kept == 0 {
        return Err(ReadError::Empty { path: layout.path.into() });
    }
    Ok(table)
}

/// Reads the row at `at` and returns the start of the next; `None` for a row not of plain numbers, of which the columns
/// may then hold a part.
#[inline]
fn quick_row(bytes: &[u8], mut at: usize, layout: &Layout, columns: &mut [Vec<f64>]) -> Option<usize> {
    let last = layout.columns.len() - 1;
    let mut slot = 0;
    for (index, column) in layout.columns.iter().enumerate() {
        if column.role == Role::Value {
            let (value, end) = number(bytes, at)?;
            if !is_sample(value) {
                return None;
            }
            columns[slot].push(value);
            slot += 1;
            at = end;
        } else {
            let start = at;
            let mask = if column.role == Role::Number { NUMERIC } else { PLAIN };
            while let Some(&byte) = bytes.get(at)
                && CLASS[usize::from(byte)] & mask != 0
                && byte != layout.separator
            {
                at += 1;
            }
            if at == start {
                return None;
            }
        }
        if index < last {
            if *bytes.get(at)? != layout.separator {
                return None;
            }
            at += 1;
        }
    }
    match bytes.get(at) {
        None => Some(at),
        Some(b'\n') => Some(at + 1),
        Some(b'\r') if bytes.get(at + 1) == Some(&b'\n') => Some(at + 2),
        Some(_) => None,
    }
}

/// Class of the bytes of a number.
const NUMERIC: u8 = 1;
/// Class of the bytes of a field without quotes.
const PLAIN: u8 = 2;

/// Classes of each byte; a table, because more than half of a FEMTO file is classified.
const CLASS: [u8; 256] = {
    let mut class = [PLAIN; 256];
    let mut byte = 0;
    while byte < 256 {
        class[byte] = match byte as u8 {
            b'0'..=b'9' | b'.' | b'-' | b'+' | b'e' | b'E' => NUMERIC | PLAIN,
            b'\n' | b'\r' | b'"' => 0,
            _ => PLAIN,
        };
        byte += 1;
    }
    class
};

/// Values of a row's [`Role::Value`] columns, or the row's error.
fn careful_row(line: &[u8], row: usize, layout: &Layout) -> Result<Vec<f64>, ReadError> {
    let path = layout.path;
    let fields = split(line, layout.separator);
    let expected = layout.columns.len();
    if fields.len() != expected {
        // A blank line has no column; splitting it gives one empty field.
        let found = if line.trim_ascii().is_empty() { 0 } else { fields.len() };
        return Err(ReadError::RowWidth { path: path.into(), row, found, expected });
    }
    let mut values = Vec::new();
    for (field, column) in fields.iter().zip(layout.columns) {
        if column.role == Role::Ignored {
            continue;
        }
        let name = || column.name.clone();
        let Some(value) = parse_number::parse(field) else {
            let found = shown(field);
            return Err(ReadError::NotANumber { path: path.into(), row, column: name(), found });
        };
        if !is_sample(value) {
            return Err(ReadError::not_a_sample(path, row, name(), value, shown(field)));
        }
        if column.role == Role::Value {
            values.push(value);
        }
    }
    Ok(values)
}

/// Fields of a line, without the blanks and quotes around them; separators between quotes do not count.
pub(super) fn split(line: &[u8], separator: u8) -> Vec<&[u8]> {
    let mut quoted = false;
    line.split(|&byte| {
        quoted ^= byte == b'"';
        byte == separator && !quoted
    })
    .map(|field| {
        let field = field.trim_ascii();
        field.strip_prefix(b"\"").and_then(|f| f.strip_suffix(b"\"")).unwrap_or(field)
    })
    .collect()
}

/// Separator of a line: semicolon or tab if there is one, else comma.
pub(super) fn separator(line: &[u8]) -> u8 {
    *[b';', b'\t'].iter().find(|s| line.contains(s)).unwrap_or(&b',')
}

/// First line, without its end, and the offset of the next.
pub(super) fn first_line(bytes: &[u8]) -> (&[u8], usize) {
    let end = bytes.iter().position(|&b| b == b'\n').unwrap_or(bytes.len());
    (bytes[..end].trim_ascii_end(), (end + 1).min(bytes.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str, skip_bad: bool) -> Result<Table, ReadError> {
        let column = |name: &str| ColumnSpec { name: name.into(), role: Role::Value };
        parse(
            text.as_bytes(),
            &Layout {
                path: Path::new("t.csv"),
                separator: b',',
                columns: &[column("a"), column("b")],
                first_row: 1,
                skip_bad,
            },
        )
    }

    #[test]
    fn line_ends_blanks_and_quotes_do_not_matter() {
        let expected = parse_text("1,2\n3,4\n", false).unwrap().columns;
        assert_eq!(expected, [[1.0, 3.0], [2.0, 4.0]]);
        for text in ["1,2\r\n3,4\r\n", "1,2\n3,4", " 1, 2 \n3 ,\"4\"\n\n \n", "+1,2\n3,4\r\n\r\n"] {
            assert_eq!(parse_text(text, false).unwrap().columns, expected, "{text:?}");
        }
    }

    #[test]
    fn a_bad_row_leaves_no_part_of_itself_behind() {
        let table = parse_text("1,2\n3\n5,x\n\n7,inf\n9,10\n11,1e", true).unwrap();
        assert_eq!(table.columns, [[1.0, 9.0], [2.0, 10.0]]);
        assert_eq!(table.dropped.len(), 5);
    }
}
