use std::io::Write;

use super::*;

/// The bytes of small `.mat` files, little-endian.
mod build {
    use super::*;

    pub fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    /// A name of up to four bytes is a small element.
    fn name(name: &str) -> Vec<u8> {
        if name.is_empty() || name.len() > 4 {
            return element(1, name.as_bytes());
        }
        let mut bytes = ((name.len() as u32) << 16 | 1).to_le_bytes().to_vec();
        bytes.extend(name.as_bytes());
        bytes.resize(8, 0);
        bytes
    }

    pub fn matrix(class: u32, shape: [u32; 2], label: &str, content: &[u8]) -> Vec<u8> {
        let flags = element(6, &[class.to_le_bytes(), [0; 4]].concat());
        let shape = element(5, &shape.map(u32::to_le_bytes).concat());
        element(14, &[flags, shape, name(label), content.to_vec()].concat())
    }

    pub fn doubles(label: &str, shape: [u32; 2], values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        matrix(6, shape, label, &element(9, &data))
    }

    pub fn structure(label: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut content = [(4_u32 << 16 | 5).to_le_bytes(), 8_u32.to_le_bytes()].concat();
        let names = fields.iter().flat_map(|(name, _)| format!("{name:\0<8}").into_bytes());
        content.extend(element(1, &names.collect::<Vec<_>>()));
        fields.iter().for_each(|(_, value)| content.extend(value));
        matrix(2, [1, 1], label, &content)
    }

    pub fn compressed(matrix: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(matrix).unwrap();
        let data = encoder.finish().unwrap();
        let mut bytes = [15_u32.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes
    }

    pub fn file(elements: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
        bytes.resize(124, b' ');
        bytes.extend([0, 1, b'I', b'M']);
        bytes.extend(elements.concat());
        bytes
    }
}
use build::{compressed, doubles, file, matrix, structure};

fn read_bytes(bytes: &[u8], variable: Option<&str>, skip_bad: bool) -> Result<Raw, ReadError> {
    read(bytes, Path::new("t.mat"), variable, &Selection::default(), skip_bad)
}

/// A file of the MFPT kind: a compressed struct, and a plain scalar.
fn mfpt_like() -> Vec<u8> {
    let load = matrix(4, [1, 3], "", &build::element(4, &[b'2', 0, b'7', 0, b'0', 0]));
    let rate = matrix(9, [1, 1], "", &build::element(2, &[25]));
    let sr = matrix(11, [1, 1], "", &build::element(4, &48_828_u16.to_le_bytes()));
    let gs = doubles("", [4, 1], &[0.5, -1.0, 2.0, 4.0]);
    let bearing = structure("bearing", &[("rate", rate), ("load", load), ("gs", gs), ("sr", sr)]);
    file(&[compressed(&bearing), doubles("FTF", [1, 1], &[14.8375])])
}

#[test]
fn structs_compressed_elements_and_small_ones() {
    let raw = read_bytes(&mfpt_like(), None, false).unwrap();
    assert_eq!(raw, read_bytes(&mfpt_like(), Some("bearing.gs"), false).unwrap());
    let expected = Column { name: "bearing.gs".into(), samples: vec![0.5, -1.0, 2.0, 4.0] };
    assert_eq!(raw.columns, [expected]);
    assert_eq!(raw.sample_rate_hz, Some(48_828.0));
    assert_eq!(raw.shaft_hz, Some(25.0));
    assert!((raw.load_n.unwrap() - 1201.02).abs() < 0.01, "{:?}", raw.load_n);
    assert_eq!(raw.unit, Some(Unit::StandardGravity));
}

#[test]
fn structs_in_structs() {
    let inner = structure("", &[("x", doubles("", [1, 3], &[1.0, 2.0, 3.0]))]);
    let bytes = file(&[structure("run", &[("one", inner)])]);
    let raw = read_bytes(&bytes, Some("run.one.x"), false).unwrap();
    assert_eq!(raw.columns[0].samples, [1.0, 2.0, 3.0]);
}

#[test]
fn a_matrix_gives_a_channel_a_column_and_time_gives_none() {
    let time = doubles("t", [3, 1], &[0.0, 0.1, 0.2]);
    let signals = doubles("acc", [3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let raw = read_bytes(&file(&[time, signals]), None, false).unwrap();
    let names: Vec<&str> = raw.columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["acc[1]", "acc[2]"]);
    assert_eq!(raw.columns[1].samples, [4.0, 5.0, 6.0]);
    assert_eq!(raw.time.unwrap().time_s, [0.0, 0.1, 0.2]);
}

#[test]
fn every_number_type_and_byte_order() {
    let types: [(u32, &[u8]); 4] = [
        (1, &[0xff, 2]),
        (3, &[0xff, 0xff, 2, 0]),
        (5, &[0xff, 0xff, 0xff, 0xff, 2, 0, 0, 0]),
        (7, &[0, 0, 0x80, 0xbf, 0, 0, 0, 0x40]),
    ];
    for (kind, data) in types {
        let bytes = file(&[matrix(6, [2, 1], "long_name", &build::element(kind, data))]);
        let raw = read_bytes(&bytes, None, false).unwrap();
        assert_eq!(raw.columns[0].samples, [-1.0, 2.0], "type {kind}");
    }
    let mut big = file(&[])[..126].to_vec();
    big.extend(b"MI");
    let word = |w: u32| w.to_be_bytes();
    for w in [14, 56, 6, 8, 6, 0, 5, 8, 2, 1, (1 << 16) | 1] {
        big.extend(word(w));
    }
    big.extend(*b"x\0\0\0");
    for w in [3, 4, 0xffff_0002, 0] {
        big.extend(word(w));
    }
    assert_eq!(read_bytes(&big, None, false).unwrap().columns[0].samples, [-1.0, 2.0]);
}

#[test]
fn errors_say_what_is_there() {
    let message = |bytes: &[u8], variable| read_bytes(bytes, variable, false).unwrap_err().to_string();
    assert_eq!(
        message(&mfpt_like(), Some("bearing.x")),
        "t.mat: found variables `bearing.rate`, `bearing.gs`, `bearing.sr`, `FTF`, expected `bearing.x` among them"
    );
    let nan = file(&[doubles("x", [3, 1], &[1.0, f64::NAN, 3.0])]);
    assert_eq!(message(&nan, None), "t.mat, row 2, column `x`: found NaN, expected a finite number");
    let skipped = read_bytes(&nan, None, true).unwrap();
    assert_eq!((skipped.columns[0].samples.as_slice(), skipped.dropped.as_slice()), (&[1.0, 3.0][..], &[1][..]));
    assert_eq!(
        message(b"\x89HDF\r\n\x1a\n", None),
        "t.mat, byte 0: found MATLAB v7.3 (HDF5), expected a MATLAB v5 file (as `save -v7` writes)"
    );
    assert_eq!(message(b"", None), "t.mat: found no samples, expected at least one row");
    let cut = &file(&[doubles("x", [3, 1], &[1.0, 2.0, 3.0])])[..200];
    assert_eq!(
        message(cut, None),
        "t.mat, byte 128: found an element of 72 bytes with 64 left, expected an element that ends within the file"
    );
}

/// Invariant: whatever the bytes, the reader returns, with no more than there can be in them.
#[test]
fn damaged_files_do_no_harm() {
    let time = doubles("t", [3, 1], &[0.0, 0.1, 0.2]);
    let signals = doubles("acc", [3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    for whole in [mfpt_like(), file(&[time, compressed(&signals), signals])] {
        // A deflate stream expands its bytes by 1032 at most.
        let limit = 1032 * whole.len();
        let check = |bytes: &[u8]| {
            for variable in [None, Some("bearing.gs")] {
                if let Ok(raw) = read_bytes(bytes, variable, true) {
                    let held: usize = raw.columns.iter().map(|c| 8 * c.samples.len()).sum();
                    assert!(held <= limit, "{held} bytes");
                }
            }
        };
        let mut refused = 0;
        for length in 0..whole.len() {
            check(&whole[..length]);
            refused += usize::from(read_bytes(&whole[..length], None, false).is_err());
        }
        assert!(refused > whole.len() / 2, "{refused} of {} cuts refused", whole.len());
        let mut state = 1_u64;
        for _ in 0..20_000 {
            let mut bytes = whole.clone();
            for _ in 0..1 + (state >> 62) {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let at = (state >> 33) as usize % bytes.len();
                bytes[at] = (state >> 25) as u8;
            }
            check(&bytes);
        }
    }
}
