//! Invariants: what goes out comes back, and whoever states more is heard.

use std::sync::{Arc, Mutex};

use ballrace::recording::{
    Channel, LoadOptions, Progress, Recording, STANDARD_GRAVITY, Unit, load,
    manifest::Manifest,
    write::{self, WriteError},
};

use crate::Folder;

fn channel(name: &str, location: Option<&str>, samples: &[f64]) -> Channel {
    Channel { name: name.into(), location: location.map(String::from), samples: samples.to_vec() }
}

fn recordings() -> Vec<Recording> {
    let hard = [0.1 + 0.2, -0.0, 5e-324, -1e30, -1.0 / 3.0, 1e-7];
    let one = Recording {
        channels: vec![
            channel("ax", Some("outer-x"), &hard),
            channel("ay", Some("bench \"top\""), &hard),
            channel("tacho", None, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ],
        sample_rate_hz: 48_828.125,
        shaft_hz: Some(24.67),
        shaft_hz_std: Some(0.05),
        load_n: Some(1390.7),
        ..Recording::default()
    };
    let mut two = one.clone();
    (two.shaft_hz, two.shaft_hz_std, two.load_n) = (None, None, None);
    vec![one, two]
}

#[test]
fn written_recordings_read_back_to_the_bit() {
    let folder = Folder::new(&[]);
    let written = recordings();
    let manifest = write::folder(&folder.path("out"), &written).unwrap();
    let read = load(&[manifest], &LoadOptions::default()).unwrap().recordings;
    assert_eq!(read.len(), written.len());
    for (read, mut written) in read.into_iter().zip(written) {
        written.source = read.source.clone();
        // `==` would take −0 for 0.
        let bits =
            |r: &Recording| -> Vec<u64> { r.channels.iter().flat_map(|c| &c.samples).map(|s| s.to_bits()).collect() };
        assert_eq!(bits(&read), bits(&written));
        assert_eq!(read, written);
    }
    let left: Vec<_> = std::fs::read_dir(folder.path("out")).unwrap().map(|f| f.unwrap().file_name()).collect();
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
    assert!(matches!(error, WriteError::NotASample { row: 4, .. }), "{error}");
    let error = with(|r| r.channels[1].samples[2] = 1e31);
    assert!(matches!(error, WriteError::NotASample { row: 4, .. }), "{error}");
    let error = with(|r| _ = r.channels[2].samples.pop());
    assert!(matches!(error, WriteError::UnequalLengths { found: 5, expected: 6, .. }), "{error}");
    for name in ["", "ax", "a,b", " a", "#a", "1.5", "nan"] {
        let mut recording = recordings().remove(0);
        recording.channels[1].name = name.into();
        let error = write::csv(&path, &recording).unwrap_err();
        assert!(matches!(error, WriteError::BadName { .. }), "{name}: {error}");
    }
    assert!(!path.exists());
    let error = write::csv(&folder.path("none/r.csv"), &recordings()[0]).unwrap_err();
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
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
    assert_eq!(*samples(0, "outer-x"), [STANDARD_GRAVITY, 2.0 * STANDARD_GRAVITY]);
    assert_eq!(*samples(0, "u"), [1.0, 2.0]);
    assert_eq!(*samples(0, "tacho"), [1.0, 0.0]);
    assert_eq!(*samples(1, "resonator-y"), [4.0]);
    assert_eq!((read[0].shaft_hz, read[0].load_n), (Some(2.5), Some(7.0)));
    assert_eq!((read[1].shaft_hz, read[1].load_n), (None, Some(8.0)));
    let options =
        LoadOptions { unit: Some(Unit::MetrePerSecondSquared), sample_rate_hz: Some(20.0), ..LoadOptions::default() };
    let read = folder.load("", &options).unwrap().recordings;
    assert_eq!(read[0].channels[0].samples, [1.0, 2.0]);
    assert_eq!(read[0].sample_rate_hz, 20.0);
    assert_eq!(Manifest::read(&folder.path("recordings.toml")).unwrap().entries.len(), 2);
}

#[test]
fn resampling_keeps_length_and_condition() {
    let rows: String = (0..25_600).map(|n| format!("{}\n", (n as f64 * 0.01).sin())).collect();
    let folder = Folder::new(&[
        ("r.csv", &format!("ax\n{rows}")),
        (
            "recordings.toml",
            "[[recording]]\nfile = \"r.csv\"\nsample_rate_hz = 25600.0\nresample_hz = 12000.0\nshaft_hz = 3",
        ),
    ]);
    let recording = folder.load("", &LoadOptions::default()).unwrap().recordings.remove(0);
    assert_eq!((recording.len(), recording.sample_rate_hz), (12_000, 12_000.0));
    assert_eq!((recording.duration_s(), recording.shaft_hz), (1.0, Some(3.0)));
    let expected = |n: usize| (n as f64 * 25_600.0 / 12_000.0 * 0.01).sin();
    let samples = &recording.channels[0].samples;
    assert!((1000..11_000).all(|n| (samples[n] - expected(n)).abs() < 2e-5));
}

#[test]
fn folders_prefer_a_manifest_then_femto_then_csv() {
    let row = "9,10,39,1.1879e+05,1,2\n";
    let folder = Folder::new(&[("r10.csv", "t,ax\n0,1\n1,1\n"), ("r9.csv", "t,ax\n0,1\n1,1\n")]);
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
    let read = folder.load("odd.csv", &LoadOptions::default()).unwrap().recordings;
    assert_eq!(read[0].channel("vertical").unwrap().samples, [2.0 * STANDARD_GRAVITY]);
}

#[test]
fn midnight_and_the_operating_condition() {
    let folder =
        Folder::new(&[("Bearing2_1/acc_1.csv", "23,59,55,5e5,0,0\n"), ("Bearing2_1/acc_2.csv", "0,0,5,0,0,0\n")]);
    let seen = Arc::new(Mutex::new(Vec::new()));
    let progress = {
        let seen = seen.clone();
        Arc::new(move |progress: Progress| seen.lock().unwrap().push(progress))
    };
    let options = LoadOptions { progress: Some(progress), ..LoadOptions::default() };
    let read = folder.load("Bearing2_1", &options).unwrap().recordings;
    assert_eq!(read[0].start_s, Some(86_395.5));
    assert_eq!(read[1].start_s, Some(86_405.0));
    assert_eq!((read[0].shaft_hz, read[0].load_n), (Some(27.5), Some(4200.0)));
    let mut done: Vec<usize> = seen.lock().unwrap().iter().map(|p| p.done).collect();
    done.sort_unstable();
    assert_eq!(done, [1, 2]);
}
