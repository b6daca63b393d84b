//! Reader of NumPy arrays (`.npy`, format versions 1 to 3): one dimension, or two of which the longer is
//! time.
//!
//! Channels are `ch1`, `ch2`, …. Not a crate's, which needs a parser generator and arbitrary-precision integers for a
//! header of three keys.

use std::path::Path;

use crate::recording::{
    ReadError,
    assemble::{Column, Raw, Selection},
    error::shown,
};

struct Array<'a> {
    /// Kind (`f`, `i` or `u`) and bytes per number.
    number: (u8, usize),
    big_endian: bool,
    fortran_order: bool,
    shape: Vec<usize>,
    data: &'a [u8],
}

/// Reads one file.
pub(crate) fn read(bytes: &[u8], path: &Path, selection: &Selection, skip_bad: bool) -> Result<Raw, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty { path: path.into() });
    }
    let bad = |(part, found, expected): Bad| ReadError::BadNpy { path: path.into(), part, found, expected };
    let array = parse(bytes).map_err(bad)?;
    let mut values = array.to_f64().map_err(bad)?;
    let (first, second) = match array.shape[..] {
        [samples] => (samples, 1),
        [first, second] => (first, second),
        _ => {
            let found = format!("{} dimensions", array.shape.len());
            return Err(bad(("shape", found, "1 or 2 dimensions")));
        }
    };
    if values.is_empty() {
        return Err(ReadError::Empty { path: path.into() });
    }
    let (samples, channels) = (first.max(second), first.min(second));
    // Strides in `values` of a sample and of a channel.
    let contiguous_first = array.fortran_order;
    let (first_step, second_step) = if contiguous_first { (1, first) } else { (second, 1) };
    let (step, channel_step) = if first >= second { (first_step, second_step) } else { (second_step, first_step) };

    let names: Vec<String> = (1..=channels).map(|channel| format!("ch{channel}")).collect();
    selection.check(path, &names.iter().map(String::as_str).collect::<Vec<_>>())?;
    let mut raw = Raw::default();
    for (channel, name) in names.into_iter().enumerate().filter(|(_, n)| selection.takes(n)) {
        // One channel is all values in their order, which need no second copy.
        let samples = match channels {
            1 => std::mem::take(&mut values),
            _ => (0..samples).map(|i| values[channel * channel_step + i * step]).collect(),
        };
        raw.columns.push(Column { name, samples });
    }
    raw.drop_non_finite(path, skip_bad)?;
    Ok(raw)
}

/// Error: part of the file, found, expected.
type Bad = (&'static str, String, &'static str);

fn parse(bytes: &[u8]) -> Result<Array<'_>, Bad> {
    let magic = || ("magic", shown(&bytes[..bytes.len().min(8)]), "a NumPy array, version 1 to 3");
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(magic)?;
    let cut = || ("header", format!("a file of {} bytes", bytes.len()), "a whole header");
    let (version, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
    let (length, rest) = match version[0] {
        1 => {
            let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(cut)?;
            (u32::from_le_bytes(*length) as usize, rest)
        }
        _ => return Err(magic()),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = String::from_utf8_lossy(header);
    let value = |key: &'static str| {
        let at = header.find(&format!("'{key}'")).map(|at| at + key.len() + 2);
        let text = at.and_then(|at| header[at..].trim_start().strip_prefix(':'));
        text.map(str::trim_start).ok_or((key, "nothing".to_owned(), "the key in the header"))
    };

    let descr = value("descr")?;
    let descr = descr.trim_start_matches('\'').split('\'').next().unwrap_or_default();
    let (order, number) = descr.split_at_checked(1).unwrap_or_default();
    let number = match number {
        "f4" => (b'f', 4),
        "f8" => (b'f', 8),
        "i1" => (b'i', 1),
        "i2" => (b'i', 2),
        "i4" => (b'i', 4),
        "i8" => (b'i', 8),
        "u1" => (b'u', 1),
        "u2" => (b'u', 2),
        "u4" => (b'u', 4),
        _ => {
            let found = shown(descr.as_bytes());
            return Err(("descr", found, "f4, f8, i1, i2, i4, i8, u1, u2 or u4"));
        }
    };
    let shape = value("shape")?;
    let bad_shape = || ("shape", shown(shape.as_bytes()), "a tuple of sizes");
    let inside = shape.strip_prefix('(').and_then(|s| s.split_once(')')).ok_or_else(bad_shape)?.0;
    let sizes = inside.split(',').map(str::trim).filter(|size| !size.is_empty());
    let shape = sizes.map(str::parse).collect::<Result<Vec<usize>, _>>().map_err(|_| bad_shape())?;
    Ok(Array {
        number,
        big_endian: order == ">",
        fortran_order: value("fortran_order")?.starts_with("True"),
        shape,
        data,
    })
}

impl Array<'_> {
    fn to_f64(&self) -> Result<Vec<f64>, Bad> {
        let count = self.shape.iter().try_fold(1_usize, |n, &size| n.checked_mul(size));
        let length = count.and_then(|n| n.checked_mul(self.number.1));
        if length != Some(self.data.len()) {
            let found = format!("{} bytes for shape {:?}", self.data.len(), self.shape);
            return Err(("data", found, "as many bytes as the shape needs"));
        }
        macro_rules! convert {
            ($type:ty) => {
                self.data
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&bytes| match self.big_endian {
                        true => <$type>::from_be_bytes(bytes) as f64,
                        false => <$type>::from_le_bytes(bytes) as f64,
                    })
                    .collect()
            };
        }
        Ok(match self.number {
            (b'f', 4) => convert!(f32),
            (b'i', 1) => convert!(i8),
            (b'i', 2) => convert!(i16),
            (b'i', 4) => convert!(i32),
            (b'i', _) => convert!(i64),
            (b'u', 1) => convert!(u8),
            (b'u', 2) => convert!(u16),
            (b'u', _) => convert!(u32),
            _ => convert!(f64),
        })
    }
}
