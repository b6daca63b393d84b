//! Reader of CSV with a header: one column for each channel, and at most one time column.
//!
//! Lines that begin with `#` may precede the header. If the first other line holds numbers, the last `#` line is the
//! header (as numpy's `savetxt` writes it). A column without a name, such as the index that pandas writes, is left out.

use std::path::Path;

use crate::recording::{
    ReadError,
    assemble::{Column, Raw, Selection, TimeColumn},
    error::shown,
    parse_number,
    table::{self, ColumnSpec, Layout, Role},
    time_axis,
};

struct Header {
    separator: u8,
    names: Vec<String>,
    /// Line of the header, from 1.
    row: usize,
    /// Line and offset of the first row of numbers.
    body_row: usize,
    body: usize,
}

/// Reads one file; with `wants_time` its time column too, if there is one.
pub(crate) fn read(
    bytes: &[u8],
    path: &Path,
    selection: &Selection,
    wants_time: bool,
    skip_bad: bool,
) -> Result<Raw, ReadError> {
    let header = header(bytes, path)?;
    let channels: Vec<&str> =
        header.names.iter().map(String::as_str).filter(|name| !name.is_empty() && !time_axis::is_time(name)).collect();
    selection.check(path, &channels)?;

    let role = |name: &str| {
        let wanted = if time_axis::is_time(name) { wants_time } else { selection.takes(name) };
        if wanted && !name.is_empty() { Role::Value } else { Role::Ignored }
    };
    let columns: Vec<ColumnSpec> =
        header.names.iter().map(|name| ColumnSpec { name: name.clone(), role: role(name) }).collect();
    if channels.is_empty() {
        return Err(ReadError::Empty { path: path.into() });
    }
    let layout = Layout { path, separator: header.separator, columns: &columns, first_row: header.body_row, skip_bad };
    let table = table::parse(&bytes[header.body..], &layout)?;

    let mut raw = Raw { first_row: header.body_row, dropped: table.dropped, ..Raw::default() };
    let names = columns.into_iter().filter(|c| c.role == Role::Value).map(|c| c.name);
    for (name, samples) in names.zip(table.columns) {
        if time_axis::is_time(&name) {
            raw.time = Some(TimeColumn { name, time_s: samples });
        } else {
            raw.columns.push(Column { name, samples });
        }
    }
    Ok(raw)
}

fn header(bytes: &[u8], path: &Path) -> Result<Header, ReadError> {
    const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
    let mut at = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    let mut row = 1;
    let mut comment: Option<&[u8]> = None;
    while at < bytes.len() {
        let (line, length) = table::first_line(&bytes[at..]);
        if let Some(text) = line.trim_ascii_start().strip_prefix(b"#") {
            comment = Some(text);
        } else if !line.is_empty() {
            let separator = table::separator(line);
            let fields = table::split(line, separator);
            let is_header = fields.iter().any(|f| !f.is_empty() && parse_number::parse(f).is_none());
            let (names, row, body_row, body) = match comment {
                _ if is_header => (fields, row, row + 1, at + length),
                Some(text) => (table::split(text, separator), row - 1, row, at),
                None => {
                    let found = shown(line);
                    return Err(ReadError::MissingHeader { path: path.into(), row, found });
                }
            };
            let names: Vec<String> = names.iter().map(|f| String::from_utf8_lossy(f).into_owned()).collect();
            return unique(Header { separator, names, row, body_row, body }, path);
        }
        at += length;
        row += 1;
    }
    Err(ReadError::Empty { path: path.into() })
}

fn unique(header: Header, path: &Path) -> Result<Header, ReadError> {
    for (index, name) in header.names.iter().enumerate() {
        if !name.is_empty() && header.names[..index].contains(name) {
            let (row, column) = (header.row, name.clone());
            return Err(ReadError::DuplicateColumn { path: path.into(), row, column });
        }
    }
    Ok(header)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Raw, ReadError> {
        read(text.as_bytes(), Path::new("t.csv"), &Selection::default(), true, false)
    }

    #[test]
    fn a_header_may_be_plain_quoted_commented_or_behind_an_index() {
        for text in [
            "ax,ay\n1,2\n3,4\n",
            "\u{feff}\"ax\";\"ay\"\r\n1;2\r\n3;4\r\n",
            "# rig A, load 3, no noise\n# ax,ay\n1,2\n3,4\n",
            "# made by hand\n\nax\tay\n1\t2\n3\t4",
            ",ax,ay\n0,1,2\n1,3,4\n",
        ] {
            let raw = read_text(text).expect(text);
            assert_eq!(raw.columns[0], Column { name: "ax".into(), samples: vec![1.0, 3.0] });
            assert_eq!(raw.columns[1], Column { name: "ay".into(), samples: vec![2.0, 4.0] });
        }
    }

    #[test]
    fn time_is_no_channel() {
        let raw = read_text("time_s,ax\n0,1\n0.5,2\n").unwrap();
        assert_eq!(raw.columns.len(), 1);
        assert_eq!(raw.time.unwrap().time_s, [0.0, 0.5]);
    }

    #[test]
    fn rows_count_as_lines_of_the_file() {
        let error = read_text("# note\nax,ay\n1,2\n3,x\n").unwrap_err();
        assert_eq!(error.to_string(), "t.csv, row 4, column `ay`: found `x`, expected a number");
        let error = read_text("# note\n# ax,ay\n1,2\n3\n").unwrap_err();
        assert_eq!(error.to_string(), "t.csv, row 4: found 1 columns, expected 2");
    }
}
