//! Values of matrix elements: numbers, text and structs.

use super::element::{Bad, Elements, MATRIX, Order};

/// Value of a variable or field.
#[derive(Debug)]
pub(super) enum Value<'a> {
    /// Real numbers, column-major.
    Numbers(Numbers<'a>),
    /// A character array, read down its columns.
    Text(String),
    /// The fields of a 1×1 struct.
    Struct(Vec<(String, Value<'a>)>),
    /// Cells, sparse and complex arrays, struct arrays, objects: not read.
    Other,
}

/// An array of real numbers.
#[derive(Debug)]
pub(super) struct Numbers<'a> {
    /// Rows, and columns (the product of all further dimensions).
    pub shape: [usize; 2],
    storage: Storage,
    data: &'a [u8],
    order: Order,
}

/// Storage type of numbers, which can be narrower than the class of their array.
#[derive(Clone, Copy, Debug)]
enum Storage {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
    I64,
    U64,
}

impl Storage {
    fn new(kind: u32) -> Option<Self> {
        Some(match kind {
            1 => Self::I8,
            2 => Self::U8,
            3 => Self::I16,
            4 => Self::U16,
            5 => Self::I32,
            6 => Self::U32,
            7 => Self::F32,
            9 => Self::F64,
            12 => Self::I64,
            13 => Self::U64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }
}

impl Numbers<'_> {
    pub(super) fn len(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    /// Length of a row or column vector; rows of a matrix.
    pub(super) fn rows(&self) -> usize {
        if self.is_vector() { self.len() } else { self.shape[0] }
    }

    pub(super) fn is_vector(&self) -> bool {
        self.shape.contains(&1)
    }

    /// All numbers, column after column.
    pub(super) fn to_f64(&self) -> Vec<f64> {
        macro_rules! convert {
            ($type:ty) => {
                self.data
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&bytes| match self.order {
                        Order::Little => <$type>::from_le_bytes(bytes) as f64,
                        Order::Big => <$type>::from_be_bytes(bytes) as f64,
                    })
                    .collect()
            };
        }
        match self.storage {
            Storage::I8 => convert!(i8),
            Storage::U8 => convert!(u8),
            Storage::I16 => convert!(i16),
            Storage::U16 => convert!(u16),
            Storage::I32 => convert!(i32),
            Storage::U32 => convert!(u32),
            Storage::F32 => convert!(f32),
            Storage::F64 => convert!(f64),
            Storage::I64 => convert!(i64),
            Storage::U64 => convert!(u64),
        }
    }
}

const STRUCT: u32 = 2;
const TEXT: u32 = 4;
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;
const COMPLEX: u32 = 0x0800;
/// Greatest nesting depth: more would exhaust the stack.
const MAX_DEPTH: usize = 16;

/// Name and value of a matrix element.
pub(super) fn array(matrix: &[u8], order: Order, depth: usize) -> Result<(String, Value<'_>), Bad> {
    let mut elements = Elements::new(matrix, order);
    let flags = elements.expect("array flags")?;
    let Some(word) = flags.data.first_chunk::<4>() else {
        let found = format!("{} bytes", flags.data.len());
        return Err(Bad { offset: flags.offset, found, expected: "array flags" });
    };
    let word = order.u32(*word);
    let (class, complex) = (word & 0xff, word & COMPLEX != 0);
    // Objects of newer classes have no dimensions here.
    if !(1..=15).contains(&class) || depth > MAX_DEPTH {
        return Ok((String::new(), Value::Other));
    }
    let dimensions = elements.expect("array dimensions")?;
    let (words, _) = dimensions.data.as_chunks::<4>();
    let sizes: Vec<usize> = words.iter().map(|&w| order.u32(w) as usize).collect();
    let name = elements.expect("an array name")?;
    let name = String::from_utf8_lossy(name.data).into_owned();

    let numel = sizes.iter().try_fold(1_usize, |n, &size| n.checked_mul(size));
    let expected = "dimensions that fit the data";
    let bad = || Bad { offset: dimensions.offset, found: format!("dimensions {sizes:?}"), expected };
    let (Some(&rows), Some(numel)) = (sizes.first(), numel) else {
        return Err(bad());
    };
    let value = match class {
        class if NUMERIC.contains(&class) && !complex => {
            let data = elements.expect("array data")?;
            let Some(storage) = Storage::new(data.kind) else {
                let found = format!("data of type {}", data.kind);
                return Err(Bad { offset: data.offset, found, expected: "a numeric type" });
            };
            if numel.checked_mul(storage.size()) != Some(data.data.len()) {
                return Err(bad());
            }
            let shape = [rows, numel.checked_div(rows).unwrap_or(0)];
            Value::Numbers(Numbers { shape, storage, data: data.data, order })
        }
        TEXT => text(elements.expect("characters")?.data, numel),
        STRUCT if numel == 1 => Value::Struct(fields(&mut elements, order, depth)?),
        _ => Value::Other,
    };
    Ok((name, value))
}

/// ASCII characters of a text, whose width in bytes follows from their number and the byte count.
fn text(data: &[u8], characters: usize) -> Value<'_> {
    let width = data.len().checked_div(characters).unwrap_or(1).max(1);
    let ascii = data.chunks(width).flatten().filter(|b| (32..127).contains(*b));
    Value::Text(ascii.map(|&b| char::from(b)).collect())
}

fn fields<'a>(elements: &mut Elements<'a>, order: Order, depth: usize) -> Result<Vec<(String, Value<'a>)>, Bad> {
    let length = elements.expect("the length of field names")?;
    let width = length.data.first_chunk().map_or(0, |&w| order.u32(w) as usize);
    let names = elements.expect("field names")?;
    if width == 0 && !names.data.is_empty() {
        let found = "field names of length 0".into();
        return Err(Bad { offset: length.offset, found, expected: "a length above 0" });
    }
    let mut fields = Vec::new();
    for name in names.data.chunks(width.max(1)) {
        let end = name.iter().position(|&b| b == 0).unwrap_or(name.len());
        let element = elements.expect("a field")?;
        // An empty field is a matrix element without data.
        let value = match element.kind {
            MATRIX if !element.data.is_empty() => array(element.data, order, depth + 1)?.1,
            _ => Value::Other,
        };
        fields.push((String::from_utf8_lossy(&name[..end]).into_owned(), value));
    }
    Ok(fields)
}
