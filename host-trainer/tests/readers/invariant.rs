//! Invariants: what goes out comes back, and one recording is the same in every format.

use std::sync::{Arc, Mutex};

use ballrace::recording::{
    Channel, LoadOptions, Progress, Recording, STANDARD_GRAVITY, Unit, load,
    manifest::Manifest,
    write::{self, WriteError},
};
use parquet::{
    basic::{Compression, Encoding},
    column::writer::ColumnWriter,
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::parser::parse_message_type,
};

use crate::{Folder, error::npy};

fn channel(name: &str, location: Option<&str>, samples: &[f64]) -> Channel {
    Channel {
        name: name.into(),
        location: location.map(String::from),
        samples: samples.to_vec(),
    }
}

fn recordings() -> Vec<Recording> {
    let hard = [0.1 + 0.2, -0.0, 5e-324, f64::MAX, -1.0 / 3.0, 1e-7];
    let one = Recording {
        channels: vec![
            channel("ax", Some("outer-x"), &hard),
            channel("ay", Some("bench \"top\""), &hard),
            channel("tacho", None, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ],
        sample_rate_hz: 48_828.125,
        shaft_hz: Some(24.67),
        load_n: Some(1390.7),
        ..Recording::default()
    };
    let mut two = one.clone();
    (two.shaft_hz, two.load_n) = (None, None);
    vec![one, two]
}

#[test]
fn written_recordings_read_back_to_the_bit() {
    let folder = Folder::new(&[]);
    let written = recordings();
    let manifest = write::folder(&folder.path("out"), &written).unwrap();
    let read = load(&[manifest], &LoadOptions::default())
        .unwrap()
        .recordings;
    assert_eq!(read.len(), written.len());
    for (read, mut written) in read.into_iter().zip(written) {
        written.source = read.source.clone();
        // `==` would take −0 for 0.
        let bits = |r: &Recording| -> Vec<u64> {
            r.channels
                .iter()
                .flat_map(|c| &c.samples)
                .map(|s| s.to_bits())
                .collect()
        };
        assert_eq!(bits(&read), bits(&written));
        assert_eq!(read, written);
    }
    let left: Vec<_> = std::fs::read_dir(folder.path("out"))
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 3, "no temporary file is left: {left:?}");
}

#[test]
fn what_could_not_be_read_back_is_not_written() {
    let folder = Folder::new(&[]);
    let path = folder.path("r.csv");
    let with = |change: fn(&mut Recording)| {
        let mut recording = recordings().remove(0);
        change(&mut recording);
        write::csv(&path, &recording).unwrap_err()
    };
    let error = with(|r| r.channels[1].samples[2] = f64::NAN);
    assert!(
        matches!(error, WriteError::NotFinite { row: 4, .. }),
        "{error}"
    );
    let error = with(|r| _ = r.channels[2].samples.pop());
    assert!(
        matches!(
            error,
            WriteError::UnequalLengths {
                found: 5,
                expected: 6,
                ..
            }
        ),
        "{error}"
    );
    for name in ["", "ax", "a,b", " a", "#a", "1.5", "nan"] {
        let mut recording = recordings().remove(0);
        recording.channels[1].name = name.into();
        let error = write::csv(&path, &recording).unwrap_err();
        assert!(
            matches!(error, WriteError::BadName { .. }),
            "{name}: {error}"
        );
    }
    assert!(!path.exists());
    let error = write::csv(&folder.path("none/r.csv"), &recordings()[0]).unwrap_err();
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
}

/// Writes two columns, one of floats and one of nullable integers, in two row groups.
fn write_parquet(folder: &Folder, ax: [f32; 4], ay: [Option<i32>; 4], compression: Compression) {
    let schema =
        "message m { REQUIRED FLOAT ax; REQUIRED BYTE_ARRAY note (UTF8); OPTIONAL INT32 ay; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .set_encoding(Encoding::PLAIN);
    let mut bytes = Vec::new();
    let mut writer =
        SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties.build())).unwrap();
    for half in [0..2, 2..4] {
        let mut group = writer.next_row_group().unwrap();
        while let Some(mut column) = group.next_column().unwrap() {
            match column.untyped() {
                ColumnWriter::FloatColumnWriter(c) => {
                    c.write_batch(&ax[half.clone()], None, None).unwrap();
                }
                ColumnWriter::Int32ColumnWriter(c) => {
                    let values: Vec<i32> = ay[half.clone()].iter().flatten().copied().collect();
                    let levels: Vec<i16> = ay[half.clone()]
                        .iter()
                        .map(|v| v.is_some().into())
                        .collect();
                    c.write_batch(&values, Some(&levels), None).unwrap();
                }
                ColumnWriter::ByteArrayColumnWriter(c) => {
                    c.write_batch(&["x".into(), "y".into()], None, None)
                        .unwrap();
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
    let options = LoadOptions {
        sample_rate_hz: Some(10.0),
        ..LoadOptions::default()
    };
    let codecs = [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::LZ4_RAW,
    ];
    for codec in codecs {
        write_parquet(
            &folder,
            [1.5, 2.0, 3.0, 4.0],
            [1, 2, 3, -4].map(Some),
            codec,
        );
        let recording = folder.load("", &options).unwrap().recordings.remove(0);
        assert_eq!(recording.channels.len(), 2, "the text column is no channel");
        assert_eq!(
            recording.channel("ax").unwrap().samples,
            [1.5, 2.0, 3.0, 4.0],
            "{codec:?}"
        );
        assert_eq!(
            recording.channel("ay").unwrap().samples,
            [1.0, 2.0, 3.0, -4.0],
            "{codec:?}"
        );
    }
}

#[test]
fn parquet_nulls_are_bad_rows() {
    let folder = Folder::new(&[]);
    let ay = [Some(1), Some(2), None, Some(4)];
    write_parquet(&folder, [1.0, 2.0, 3.0, 4.0], ay, Compression::UNCOMPRESSED);
    let options = LoadOptions {
        sample_rate_hz: Some(10.0),
        ..LoadOptions::default()
    };
    let error = folder.load("", &options).unwrap_err().to_string();
    assert!(
        error.ends_with("row 3, column `ay`: found NaN, expected a finite number"),
        "{error}"
    );
    let recording = folder
        .load(
            "",
            &LoadOptions {
                skip_bad: true,
                ..options
            },
        )
        .unwrap()
        .recordings
        .remove(0);
    assert_eq!(recording.channel("ax").unwrap().samples, [1.0, 2.0, 4.0]);
    assert_eq!(recording.skipped_rows, 1);
}

#[test]
fn damaged_parquet_does_no_harm() {
    let folder = Folder::new(&[]);
    write_parquet(
        &folder,
        [1.0, 2.0, 3.0, 4.0],
        [1, 2, 3, 4].map(Some),
        Compression::SNAPPY,
    );
    let whole = std::fs::read(folder.path("r.parquet")).unwrap();
    let options = LoadOptions {
        sample_rate_hz: Some(10.0),
        ..LoadOptions::default()
    };
    let mut refused = 0;
    for at in (0..whole.len()).step_by(3) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        folder.write("r.parquet", &bytes);
        refused += usize::from(folder.load("", &options).is_err());
        folder.write("r.parquet", &whole[..at]);
        assert!(folder.load("", &options).is_err(), "cut at {at}");
    }
    assert!(
        refused > 10,
        "{refused} of {} damaged files refused",
        whole.len() / 3
    );
}

#[test]
fn numpy_of_either_order() {
    let folder = Folder::new(&[]);
    let options = LoadOptions {
        sample_rate_hz: Some(10.0),
        ..LoadOptions::default()
    };
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
            let keys = format!(
                "{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}  \n"
            );
            folder.write("r.npy", &npy(&keys, &bytes));
            let recording = folder.load("", &options).unwrap().recordings.remove(0);
            assert_eq!(
                recording.channel("ch1").unwrap().samples,
                [1.0, 2.0, 3.0],
                "{keys}"
            );
            assert_eq!(
                recording.channel("ch2").unwrap().samples,
                [4.0, 5.0, 6.0],
                "{keys}"
            );
        }
    }
}

#[test]
fn a_manifest_says_what_the_file_does_not() {
    let folder = Folder::new(&[
        ("b.csv", "ax,u,tacho\n1,1,1\n2,2,0\n"),
        ("a.csv", "ax;up\n3;4\n"),
        (
            "recordings.toml",
            "[defaults]\nsample_rate_hz = 10\nunit = \"g\"\nload_n = 7\n\
             [[recording]]\nfile = \"b.csv\"\nshaft_hz = 2.5\n\
             [[recording]]\nfile = \"a.csv\"\nunit = \"m/s^2\"\nload_n = 8\n\
             channels = { up = \"resonator-y\" }\n",
        ),
    ]);
    let read = folder.load("", &LoadOptions::default()).unwrap().recordings;
    assert_eq!([read[0].name(), read[1].name()], ["b", "a"]);
    let samples = |recording: usize, name: &str| &read[recording].channel(name).unwrap().samples;
    // Only accelerations are converted.
    assert_eq!(
        *samples(0, "outer-x"),
        [STANDARD_GRAVITY, 2.0 * STANDARD_GRAVITY]
    );
    assert_eq!(*samples(0, "u"), [1.0, 2.0]);
    assert_eq!(*samples(0, "tacho"), [1.0, 0.0]);
    assert_eq!(*samples(1, "resonator-y"), [4.0]);
    assert_eq!((read[0].shaft_hz, read[0].load_n), (Some(2.5), Some(7.0)));
    assert_eq!((read[1].shaft_hz, read[1].load_n), (None, Some(8.0)));
    let options = LoadOptions {
        unit: Some(Unit::MetrePerSecondSquared),
        sample_rate_hz: Some(20.0),
        ..LoadOptions::default()
    };
    let read = folder.load("", &options).unwrap().recordings;
    assert_eq!(read[0].channels[0].samples, [1.0, 2.0]);
    assert_eq!(read[0].sample_rate_hz, 20.0);
    assert_eq!(
        Manifest::read(&folder.path("recordings.toml"))
            .unwrap()
            .entries
            .len(),
        2
    );
}

#[test]
fn resampling_keeps_length_and_condition() {
    let rows: String = (0..25_600)
        .map(|n| format!("{}\n", (n as f64 * 0.01).sin()))
        .collect();
    let folder = Folder::new(&[
        ("r.csv", &format!("ax\n{rows}")),
        (
            "recordings.toml",
            "[[recording]]\nfile = \"r.csv\"\nsample_rate_hz = 25600.0\nresample_hz = 12000.0\nshaft_hz = 3",
        ),
    ]);
    let recording = folder
        .load("", &LoadOptions::default())
        .unwrap()
        .recordings
        .remove(0);
    assert_eq!(
        (recording.len(), recording.sample_rate_hz),
        (12_000, 12_000.0)
    );
    assert_eq!(
        (recording.duration_s(), recording.shaft_hz),
        (1.0, Some(3.0))
    );
    let expected = |n: usize| (n as f64 * 25_600.0 / 12_000.0 * 0.01).sin();
    let samples = &recording.channels[0].samples;
    assert!((1000..11_000).all(|n| (samples[n] - expected(n)).abs() < 2e-5));
}

#[test]
fn folders_prefer_a_manifest_then_femto_then_csv() {
    let row = "9,10,39,1.1879e+05,1,2\n";
    let folder = Folder::new(&[
        ("r10.csv", "t,ax\n0,1\n1,1\n"),
        ("r9.csv", "t,ax\n0,1\n1,1\n"),
    ]);
    folder.write("x.npy", b"never read");
    let names = || -> Vec<String> {
        let read = folder.load("", &LoadOptions::default()).unwrap().recordings;
        read.iter().map(Recording::name).collect()
    };
    assert_eq!(names(), ["r9", "r10"]);
    folder.write("acc_00002.csv", row.as_bytes());
    folder.write("acc_00001.csv", row.replace(',', ";").as_bytes());
    assert_eq!(names(), ["acc_00001", "acc_00002"]);
    folder.write("recordings.toml", b"[[recording]]\nfile = \"r10.csv\"");
    assert_eq!(names(), ["r10"]);
    // A file of another name is known by its contents.
    folder.write("odd.csv", row.as_bytes());
    let read = folder
        .load("odd.csv", &LoadOptions::default())
        .unwrap()
        .recordings;
    assert_eq!(
        read[0].channel("vertical").unwrap().samples,
        [2.0 * STANDARD_GRAVITY]
    );
}

#[test]
fn midnight_and_the_operating_condition() {
    let folder = Folder::new(&[
        ("Bearing2_1/acc_1.csv", "23,59,55,5e5,0,0\n"),
        ("Bearing2_1/acc_2.csv", "0,0,5,0,0,0\n"),
    ]);
    let seen = Arc::new(Mutex::new(Vec::new()));
    let progress = {
        let seen = seen.clone();
        Arc::new(move |progress: Progress| seen.lock().unwrap().push(progress))
    };
    let options = LoadOptions {
        progress: Some(progress),
        ..LoadOptions::default()
    };
    let read = folder.load("Bearing2_1", &options).unwrap().recordings;
    assert_eq!(read[0].start_s, Some(86_395.5));
    assert_eq!(read[1].start_s, Some(86_405.0));
    assert_eq!(
        (read[0].shaft_hz, read[0].load_n),
        (Some(27.5), Some(4200.0))
    );
    let mut done: Vec<usize> = seen.lock().unwrap().iter().map(|p| p.done).collect();
    done.sort_unstable();
    assert_eq!(done, [1, 2]);
}
