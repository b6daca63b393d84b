//! NumPy and Parquet: one recording is the same in each, and damage is an error.

use std::sync::Arc;

use ballrace::recording::{LoadOptions, ReadError};
use parquet::{
    basic::{Compression, Encoding},
    column::writer::ColumnWriter,
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::parser::parse_message_type,
};

use crate::{
    Folder,
    error::{lenient, strict},
};

/// A version-1 header with these keys, then `data`.
fn npy(keys: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((keys.len() as u16).to_le_bytes());
    bytes.extend(keys.as_bytes());
    bytes.extend(data);
    bytes
}

/// Writes two columns, one of floats and one of nullable integers, in two row groups.
fn write_parquet(folder: &Folder, ax: [f32; 4], ay: [Option<i32>; 4], compression: Compression) {
    let schema = "message m { REQUIRED FLOAT ax; REQUIRED BYTE_ARRAY note (UTF8); OPTIONAL INT32 ay; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder().set_compression(compression).set_encoding(Encoding::PLAIN);
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties.build())).unwrap();
    for half in [0..2, 2..4] {
        let mut group = writer.next_row_group().unwrap();
        while let Some(mut column) = group.next_column().unwrap() {
            match column.untyped() {
                ColumnWriter::FloatColumnWriter(c) => {
                    c.write_batch(&ax[half.clone()], None, None).unwrap();
                }
                ColumnWriter::Int32ColumnWriter(c) => {
                    let values: Vec<i32> = ay[half.clone()].iter().flatten().copied().collect();
                    let levels: Vec<i16> = ay[half.clone()].iter().map(|v| v.is_some().into()).collect();
                    c.write_batch(&values, Some(&levels), None).unwrap();
                }
                ColumnWriter::ByteArrayColumnWriter(c) => {
                    c.write_batch(&["x".into(), "y".into()], None, None).unwrap();
                }
                _ => unreachable!("the schema has no other column"),
            };
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    folder.write("r.parquet", &bytes);
}

#[test]
fn parquet_with_each_codec() {
    let folder = Folder::new(&[]);
    let options = LoadOptions { sample_rate_hz: Some(10.0), ..LoadOptions::default() };
    let codecs = [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::LZ4_RAW];
    for codec in codecs {
        write_parquet(&folder, [1.5, 2.0, 3.0, 4.0], [1, 2, 3, -4].map(Some), codec);
        let recording = folder.load("", &options).unwrap().recordings.remove(0);
        assert_eq!(recording.channels.len(), 2, "the text column is no channel");
        assert_eq!(recording.channel("ax").unwrap().samples, [1.5, 2.0, 3.0, 4.0], "{codec:?}");
        assert_eq!(recording.channel("ay").unwrap().samples, [1.0, 2.0, 3.0, -4.0], "{codec:?}");
    }
}

#[test]
fn parquet_nulls_are_bad_rows() {
    let folder = Folder::new(&[]);
    let ay = [Some(1), Some(2), None, Some(4)];
    write_parquet(&folder, [1.0, 2.0, 3.0, 4.0], ay, Compression::UNCOMPRESSED);
    let options = LoadOptions { sample_rate_hz: Some(10.0), ..LoadOptions::default() };
    let error = folder.load("", &options).unwrap_err().to_string();
    assert!(error.ends_with("row 3, column `ay`: found NaN, expected a finite number"), "{error}");
    let recording = folder.load("", &LoadOptions { skip_bad: true, ..options }).unwrap().recordings.remove(0);
    assert_eq!(recording.channel("ax").unwrap().samples, [1.0, 2.0, 4.0]);
    assert_eq!(recording.skipped_rows, 1);
}

#[test]
fn damaged_parquet_does_no_harm() {
    let folder = Folder::new(&[]);
    write_parquet(&folder, [1.0, 2.0, 3.0, 4.0], [1, 2, 3, 4].map(Some), Compression::SNAPPY);
    let whole = std::fs::read(folder.path("r.parquet")).unwrap();
    let options = LoadOptions { sample_rate_hz: Some(10.0), ..LoadOptions::default() };
    let mut refused = 0;
    for at in (0..whole.len()).step_by(3) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        folder.write("r.parquet", &bytes);
        refused += usize::from(folder.load("", &options).is_err());
        folder.write("r.parquet", &whole[..at]);
        assert!(folder.load("", &options).is_err(), "cut at {at}");
    }
    assert!(refused > 10, "{refused} of {} damaged files refused", whole.len() / 3);
}

#[test]
fn numpy_of_either_order() {
    let folder = Folder::new(&[]);
    let options = LoadOptions { sample_rate_hz: Some(10.0), ..LoadOptions::default() };
    // Three samples of two channels, whichever way they lie.
    for (shape, fortran, data) in [
        ("(3, 2)", "False", [1, 4, 2, 5, 3, 6]),
        ("(3, 2)", "True", [1, 2, 3, 4, 5, 6]),
        ("(2, 3)", "False", [1, 2, 3, 4, 5, 6]),
        ("(2, 3)", "True", [1, 4, 2, 5, 3, 6]),
    ] {
        for (descr, bytes) in [
            ("<i2", data.map(i16::to_le_bytes).concat()),
            (">i4", data.map(|v| i32::from(v).to_be_bytes()).concat()),
            ("<f4", data.map(|v| f32::from(v).to_le_bytes()).concat()),
            ("<f8", data.map(|v| f64::from(v).to_le_bytes()).concat()),
        ] {
            let keys = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}  \n");
            folder.write("r.npy", &npy(&keys, &bytes));
            let recording = folder.load("", &options).unwrap().recordings.remove(0);
            assert_eq!(recording.channel("ch1").unwrap().samples, [1.0, 2.0, 3.0], "{keys}");
            assert_eq!(recording.channel("ch2").unwrap().samples, [4.0, 5.0, 6.0], "{keys}");
        }
    }
}

#[test]
fn numpy() {
    let folder = Folder::new(&[]);
    let said = |bytes: &[u8]| {
        folder.write("r.npy", bytes);
        let error = folder.load("", &strict()).unwrap_err().to_string();
        error.rsplit_once("r.npy, ").unwrap().1.to_owned()
    };
    let keys = |descr: &str, shape: &str| format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    assert_eq!(said(b"oops"), "magic: found oops, expected a NumPy array, version 1 to 3");
    assert_eq!(said(b"\x93NUMPY\x01\x00\xff\xff"), "header: found a file of 10 bytes, expected a whole header");
    assert_eq!(
        said(&npy(&keys("<c16", "(1,)"), &[0; 16])),
        "descr: found <c16, expected f4, f8, i1, i2, i4, i8, u1, u2 or u4"
    );
    assert_eq!(
        said(&npy(&keys("<f8", "(3,)"), &[0; 16])),
        "data: found 16 bytes for shape [3], expected as many bytes as the shape needs"
    );
    let huge = "(18446744073709551615, 2)";
    assert!(said(&npy(&keys("<f8", huge), &[0; 16])).starts_with("data: found 16 bytes"));
    assert_eq!(said(&npy(&keys("<i2", "(1, 2, 1)"), &[0; 4])), "shape: found 3 dimensions, expected 1 or 2 dimensions");
    let nan = [1.0_f32, f32::NAN].map(f32::to_le_bytes).concat();
    assert_eq!(said(&npy(&keys("<f4", "(2,)"), &nan)), "row 2, column `ch1`: found NaN, expected a finite number");
}

#[test]
fn other_binaries() {
    let folder = Folder::new(&[("r.parquet", "PAR1 but not really PAR1")]);
    assert_variant!(folder.load("r.parquet", &strict()).unwrap_err(), BadParquet);
    folder.write("r.mat", &[b' '; 200]);
    assert_variant!(folder.load("r.mat", &strict()).unwrap_err(), BadMat);
    // Unreadable files are skipped like any other content.
    folder.write("r2.npy", &npy("{'descr': '<i2', 'fortran_order': False, 'shape': (2,)}", &[1, 0, 2, 0]));
    let loaded = folder.load("", &lenient()).unwrap();
    assert_eq!((loaded.recordings.len(), loaded.skipped.len()), (1, 2));
}
