//! Data elements of a MATLAB v5 file (MAT-File Format, MathWorks, chapter 1).
//!
//! An element is a tag (type, byte count) and its data, padded to eight bytes. Every length is
//! checked against the available bytes before any allocation.

use std::{borrow::Cow, io::Read};

use crate::recording::settings::SizeSettings;

/// Error with its offset; the caller adds the file.
#[derive(Debug)]
pub(super) struct Bad {
    pub offset: usize,
    pub found: String,
    pub expected: &'static str,
}

pub(super) const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const HEADER: usize = 128;

/// Byte order of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

impl Order {
    pub(super) fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            Self::Little => u32::from_le_bytes(bytes),
            Self::Big => u32::from_be_bytes(bytes),
        }
    }
}

/// One data element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element<'a> {
    pub kind: u32,
    pub data: &'a [u8],
    /// Offset of the tag.
    pub offset: usize,
}

/// Walks the elements of a buffer.
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    at: usize,
    order: Order,
}

impl<'a> Elements<'a> {
    pub(super) fn new(bytes: &'a [u8], order: Order) -> Self {
        Self { bytes, at: 0, order }
    }

    /// Next element; `None` at the end of the buffer.
    pub(super) fn next(&mut self) -> Result<Option<Element<'a>>, Bad> {
        let offset = self.at;
        let rest = &self.bytes[offset.min(self.bytes.len())..];
        if rest.is_empty() {
            return Ok(None);
        }
        let expected = "an element that ends within the file";
        let Some((tag, rest)) = rest.split_first_chunk::<8>() else {
            return Err(Bad { offset, found: format!("{} bytes", rest.len()), expected });
        };
        let word = |i: usize| self.order.u32([tag[i], tag[i + 1], tag[i + 2], tag[i + 3]]);
        let (first, second) = (word(0), word(4));
        // A nonzero upper half of the first word is the size of a small element, whose data is
        // in the second word.
        if first >> 16 != 0 {
            let (kind, size) = (first & 0xffff, (first >> 16) as usize);
            let Some(data) = self.bytes[offset + 4..offset + 8].get(..size) else {
                let found = format!("a small element of {size} bytes");
                return Err(Bad { offset, found, expected: "at most 4 bytes" });
            };
            self.at = offset + 8;
            return Ok(Some(Element { kind, data, offset }));
        }
        let size = second as usize;
        let Some(data) = rest.get(..size) else {
            let found = format!("an element of {size} bytes with {} left", rest.len());
            return Err(Bad { offset, found, expected });
        };
        // Compressed elements are not padded, and the padding of the last may be missing.
        let padding = if first == COMPRESSED { 0 } else { size.wrapping_neg() % 8 };
        self.at = offset + 8 + size + padding;
        Ok(Some(Element { kind: first, data, offset }))
    }

    /// Next element, or an error at the end of the buffer.
    pub(super) fn expect(&mut self, expected: &'static str) -> Result<Element<'a>, Bad> {
        let offset = self.at;
        self.next()?.ok_or_else(|| Bad { offset, found: "the end".into(), expected })
    }
}

/// Byte order of a file, and the unpacked data of its matrix elements.
type Matrices<'a> = (Order, Vec<Cow<'a, [u8]>>);

/// Matrix elements of a file.
pub(super) fn matrices(file: &[u8]) -> Result<Matrices<'_>, Bad> {
    let order = order(file)?;
    let mut matrices = Vec::new();
    // Bytes that compressed elements may still take: a small file can unpack to any size.
    let mut left = SizeSettings::DEFAULT.recording_bytes;
    let mut elements = Elements::new(&file[HEADER..], order);
    while let Some(element) = elements.next().map_err(|bad| bad.moved(HEADER))? {
        match element.kind {
            MATRIX => matrices.push(Cow::Borrowed(element.data)),
            COMPRESSED => {
                let matrix = inflate(element, order, left).map_err(|bad| bad.moved(HEADER))?;
                left -= matrix.len() as u64;
                matrices.push(Cow::Owned(matrix));
            }
            // The format reserves other types at this level; they hold no variable.
            _ => {}
        }
    }
    Ok((order, matrices))
}

impl Bad {
    fn moved(self, by: usize) -> Self {
        Self { offset: self.offset + by, ..self }
    }
}

fn order(file: &[u8]) -> Result<Order, Bad> {
    let expected = "a MATLAB v5 file (as `save -v7` writes)";
    if file.starts_with(b"\x89HDF") || file.starts_with(b"MATLAB 7.3") {
        return Err(Bad { offset: 0, found: "MATLAB v7.3 (HDF5)".into(), expected });
    }
    match file.get(HEADER - 2..HEADER) {
        Some(b"IM") => Ok(Order::Little),
        Some(b"MI") => Ok(Order::Big),
        Some(mark) => {
            let found = format!("byte-order mark `{}`", mark.escape_ascii());
            Err(Bad { offset: HEADER - 2, found, expected })
        }
        None => {
            let found = format!("a file of {} bytes", file.len());
            Err(Bad { offset: 0, found, expected })
        }
    }
}

/// Unpacks a compressed element, which must hold one matrix, and returns the matrix's data.
fn inflate(element: Element, order: Order, most: u64) -> Result<Vec<u8>, Bad> {
    let Element { data, offset, .. } = element;
    let expected = "an intact compressed matrix";
    let bad = |found: String| Bad { offset, found, expected };
    let mut stream = flate2::read::ZlibDecoder::new(data);
    let mut tag = [0; 8];
    stream.read_exact(&mut tag).map_err(|e| bad(e.to_string()))?;
    let word = |i: usize| order.u32([tag[i], tag[i + 1], tag[i + 2], tag[i + 3]]);
    let (kind, size) = (word(0), word(4) as usize);
    if kind != MATRIX {
        return Err(bad(format!("an element of type {kind}")));
    }
    if size as u64 > most {
        return Err(Bad { offset, found: format!("{size} bytes unpacked"), expected: "less data in one file" });
    }
    // The vector grows with the stream (deflate packs 1032 to 1 at most), not to the size that the tag claims. Reading
    // to the end makes the decoder verify its checksum.
    let mut matrix = Vec::new();
    let limit = size as u64 + 8;
    stream.take(limit).read_to_end(&mut matrix).map_err(|e| bad(e.to_string()))?;
    if matrix.len() < size {
        return Err(bad(format!("{} bytes of {size}", matrix.len())));
    }
    matrix.truncate(size);
    Ok(matrix)
}
