//! Every way to be wrong, and what is said about it.

use ballrace::recording::{LoadOptions, ReadError};

use crate::Folder;

pub fn strict() -> LoadOptions {
    LoadOptions::default()
}

pub fn lenient() -> LoadOptions {
    LoadOptions { skip_bad: true, sample_rate_hz: Some(1000.0), ..LoadOptions::default() }
}

/// What is said about a single file of these contents, without the folder.
fn said(name: &str, text: &str) -> String {
    let folder = Folder::new(&[(name, text)]);
    let error = folder.load(name, &strict()).unwrap_err().to_string();
    error.replace(&format!("{}/", folder.path("").display()).replace("//", "/"), "")
}

const ROW: &str = "9,10,39,1.1879e+05,0.338,-0.263\n";

#[test]
fn femto_rows() {
    let third = |row: &str| said("acc_00001.csv", &format!("{ROW}{ROW}{row}"));
    // The row is complete, ragged, cut, or not a number; the last line needs no end.
    assert_eq!(third("9,10,39,1.1879e+05,0.338\n"), "acc_00001.csv, row 3: found 5 columns, expected 6");
    assert_eq!(third("9,10,39"), "acc_00001.csv, row 3: found 3 columns, expected 6");
    assert_eq!(third("9,10,39,1.1879e+05,0.338,-0.263,1\n"), "acc_00001.csv, row 3: found 7 columns, expected 6");
    for (field, cut) in [("", "9,10,39,1e5,0.3,"), ("-", "9,10,39,1e5,0.3,-"), ("2.1e+", "9,10,39,1e5,0.3,2.1e+")] {
        assert_eq!(third(cut), format!("acc_00001.csv, row 3, column `vertical`: found `{field}`, expected a number"));
    }
    assert_eq!(
        third("9,x,39,1.1879e+05,0.338,-0.263\n"),
        "acc_00001.csv, row 3, column `minute`: found `x`, expected a number"
    );
    for text in ["NaN", "nan", "inf", "-Infinity", "1e999"] {
        assert_eq!(
            third(&format!("9,10,39,1e5,{text},0.1\n")),
            format!("acc_00001.csv, row 3, column `horizontal`: found {text}, expected a finite number")
        );
    }
    assert_eq!(third(&format!("\n{ROW}")), "acc_00001.csv, row 3: found 0 columns, expected 6");
}

#[test]
fn a_bad_column_is_found_though_another_is_wanted() {
    let options = LoadOptions { channels: Some(vec!["vertical".into()]), ..strict() };
    let folder = Folder::new(&[("acc_1.csv", "9,10,39,1e5,oops,0.1\n"), ("acc_2.csv", ROW)]);
    let error = folder.load("", &options).unwrap_err().to_string();
    assert!(error.ends_with("acc_1.csv, row 1, column `horizontal`: found `oops`, expected a number"), "{error}");
}

#[test]
fn the_first_bad_file_is_named() {
    let folder = Folder::new(&[("acc_1.csv", ROW), ("acc_2.csv", "1,2\n"), ("acc_3.csv", "x\n")]);
    let error = folder.load("", &strict()).unwrap_err().to_string();
    assert!(error.ends_with("acc_2.csv, row 1: found 2 columns, expected 6"), "{error}");
}

#[test]
fn skipping_counts_rows_and_recordings() {
    let bad = format!("{ROW}9,10,39\n{ROW}9,10,39,1e5,nan,0\n9,10,39,1e5,0,x");
    let folder = Folder::new(&[("acc_1.csv", &bad), ("acc_2.csv", ""), ("acc_3.csv", ROW)]);
    let loaded = folder.load("", &lenient()).unwrap();
    let skipped: Vec<usize> = loaded.recordings.iter().map(|r| r.skipped_rows).collect();
    assert_eq!(skipped, [3, 0]);
    assert_eq!(loaded.recordings[0].len(), 2);
    assert_eq!(loaded.skipped.len(), 1);
    assert!(loaded.skipped[0].to_string().contains("acc_2.csv"), "{}", loaded.skipped[0]);
}

#[test]
fn nothing_readable_is_an_error_even_when_skipping() {
    let folder = Folder::new(&[("acc_1.csv", "x\n"), ("acc_2.csv", "")]);
    assert_variant!(folder.load("", &lenient()).unwrap_err(), Empty);
}

#[test]
fn empty_files() {
    for name in ["acc_00001.csv", "r.csv", "r.mat", "r.npy", "r.parquet"] {
        assert_eq!(said(name, ""), format!("{name}: found no samples, expected at least one row"));
    }
    assert_eq!(said("r.csv", "ax,ay\n"), "r.csv: found no samples, expected at least one row");
    assert_eq!(said("r.csv", "# a\n\n"), "r.csv: found no samples, expected at least one row");
}

#[test]
fn headed_csv() {
    assert_eq!(said("r.csv", "1,2\n3,4\n"), "r.csv, row 1: found `1,2`, expected a header with column names");
    assert_eq!(said("r.csv", "#\nax,ax\n3,4\n"), "r.csv, row 2: found column `ax` twice, expected each name once");
    assert_eq!(
        said("r.csv", "ax,ay\n1,2\n"),
        "r.csv, sample_rate_hz: found none stated and no time column, expected a sample rate in Hz"
    );
    assert_eq!(
        said("r.csv", "t,ax\n0,1\n1,1\n1,1\n"),
        "r.csv, row 4, column `t`: found 1 s after 1 s, expected time to increase"
    );
}

#[test]
fn channels_and_variables() {
    let folder = Folder::new(&[("r.csv", "t,ax,ay\n0,1,2\n1,3,4\n")]);
    let options = LoadOptions { channels: Some(vec!["ay".into(), "az".into()]), ..strict() };
    let error = folder.load("r.csv", &options).unwrap_err().to_string();
    assert!(error.ends_with("r.csv: found channels `ax`, `ay`, expected `az` among them"), "{error}");
}

#[test]
fn paths_and_endings() {
    let folder = Folder::new(&[("r.wav", "x"), ("notes.txt", "x")]);
    assert_variant!(folder.load("none.csv", &strict()).unwrap_err(), NotFound);
    assert_variant!(folder.load("", &strict()).unwrap_err(), NoRecordings);
    let error = folder.load("r.wav", &strict()).unwrap_err().to_string();
    assert!(error.ends_with("r.wav: found ending `wav`, expected .csv, .mat, .npy, .parquet or .toml"), "{error}");
    // A folder in the place of a file is found, and cannot be read.
    folder.write("recordings.toml", b"[[recording]]\nfile = \"d.csv\"\nsample_rate_hz = 1");
    folder.write("d.csv/x", b"");
    assert_variant!(folder.load("", &strict()).unwrap_err(), Io);
}

#[test]
fn options() {
    let folder = Folder::new(&[("acc_1.csv", ROW)]);
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = LoadOptions { sample_rate_hz: Some(rate), ..strict() };
        let error = folder.load("", &options).unwrap_err().to_string();
        let rate = rate.to_string();
        assert_eq!(error, format!("sample_rate_hz: found {rate}, expected 0.01 to 1e8 Hz"));
    }
    let options = LoadOptions { recordings: Some(1..4), ..strict() };
    let error = folder.load("", &options).unwrap_err().to_string();
    assert_eq!(error, "recordings: found 1..4, expected a range within 0..1");
}

#[test]
fn manifests() {
    let said = |text: &str| said("recordings.toml", text);
    for (text, expected) in [
        (
            "[[recording]]\nfile = \"r.csv\"\nrpm = 3",
            "recording[1].rpm: found an unknown key, expected one of file, sample_rate_hz, unit, variable, shaft_hz, shaft_hz_std, load_n, channels, resample_hz",
        ),
        (
            "[defaults]\nfile = \"a\"",
            "defaults.file: found an unknown key, expected one of sample_rate_hz, unit, variable, shaft_hz, shaft_hz_std, load_n, channels, resample_hz",
        ),
        ("[default]\n", "default: found an unknown key, expected one of defaults, recording"),
        ("[defaults]\nunit = \"g\"", "recording: found nothing, expected at least one [[recording]]"),
        ("[[recording]]\nshaft_hz = 3", "recording[1].file: found nothing, expected the name of a file"),
        (
            "[[recording]]\nfile=\"a.csv\"\n[[recording]]\nfile=\"b.csv\"\nunit=\"mg\"",
            "recording[2].unit: found \\\"mg\\\", expected \"m/s^2\" or \"g\"",
        ),
        ("[defaults]\nsample_rate_hz = 0", "defaults.sample_rate_hz: found 0, expected 0.01 to 1e8 Hz"),
        ("[defaults]\nshaft_hz = nan", "defaults.shaft_hz: found nan, expected 0 to 17000 Hz, turns a second"),
        ("[defaults]\nchannels = { ax = 3 }", "defaults.channels.ax: found 3, expected the name of a location"),
        ("recording = 3", "recording: found 3, expected at least one [[recording]]"),
    ] {
        assert_eq!(said(text), format!("recordings.toml, {expected}"));
    }
    let syntax = said("[defaults]\nunit = m");
    assert!(syntax.starts_with("recordings.toml, row 2: found "), "{syntax}");
    assert!(syntax.ends_with(", expected TOML"), "{syntax}");
}

#[test]
fn a_manifest_cannot_locate_a_channel_that_is_not_there() {
    let entry = "[[recording]]\nfile = \"r.csv\"\nsample_rate_hz = 10\n";
    let folder = Folder::new(&[("r.csv", "ax\n1\n")]);
    folder.write("recordings.toml", format!("{entry}channels = {{ ay = \"top\" }}").as_bytes());
    assert_variant!(folder.load("", &strict()).unwrap_err(), UnknownChannel);
    // In the defaults it may be meant for other files.
    folder.write("recordings.toml", format!("defaults.channels.ay = \"top\"\n{entry}").as_bytes());
    assert!(folder.load("", &strict()).is_ok());
}
