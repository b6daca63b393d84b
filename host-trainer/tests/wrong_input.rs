//! Wrong input: nothing is lost, nothing is accepted in silence, nothing takes more than the machine has.

use std::fs;
use std::path::Path;

mod support;
use support::{ballrace, done, refused, text};

const RIG: &str = include_str!("../src/cli/demo/rig.toml");
const MANIFEST: &str = "[defaults]\nsample_rate_hz = 25600.0\n\
                        [[recording]]\nfile = \"r01.csv\"\nshaft_hz = 30.0\nload_n = 400.0\n\
                        [[recording]]\nfile = \"r02.csv\"\nshaft_hz = 31.0\nload_n = 400.0\n";

/// Numbers that look like noise.
fn noise(seed: u64, count: usize) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..count).map(|_| next() + next() + next()).collect()
}

fn csv(columns: &[(&str, Vec<f64>)]) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let row = |k: usize| columns.iter().map(|(_, v)| v[k].to_string()).collect::<Vec<_>>().join(",") + "\n";
    names.join(",") + "\n" + &(0..columns[0].1.len()).map(row).collect::<String>()
}

/// A folder with a rig, and in `data` two measured recordings with their manifest.
fn measured() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("data")).expect("a folder");
    fs::write(folder.path().join("rig.toml"), RIG).expect("written");
    fs::write(folder.path().join("data/recordings.toml"), MANIFEST).expect("written");
    for seed in [1, 2] {
        let columns = [("ax", noise(seed, 3000)), ("ay", noise(seed + 9, 3000))];
        fs::write(folder.path().join(format!("data/r0{seed}.csv")), csv(&columns)).expect("written");
    }
    folder
}

/// Contents of all files of a folder.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_file())
        .map(|path| (path.display().to_string(), fs::read(&path).expect("a file")))
        .collect();
    files.sort();
    files
}

#[test]
fn measurements_are_never_replaced() {
    let folder = measured();
    let folder = folder.path();
    done(folder, &["fit", "data", "--solver", "stlsq", "--nmd", "3", "--null", "0", "--out", "model.json"]);
    fs::create_dir(folder.join("other")).expect("a folder");
    fs::write(folder.join("other/conditions.toml"), MANIFEST).expect("written");
    fs::hard_link(folder.join("data/r01.csv"), folder.join("same.html")).expect("a link");
    let before = contents(&folder.join("data"));
    let spectra = ["spectra", "data/r01.csv", "--sample-rate", "25600", "--out"];
    let monitor = ["monitor", "--model", "model.json", "data"];
    let fit = ["fit", "data", "--solver", "stlsq", "--nmd", "3", "--null", "0", "--out"];
    for force in [&[][..], &["--force"]] {
        for command in [
            &["predict", "--rig", "rig.toml", "--recordings", "data", "--out", "data"][..],
            &["simulate", "--rig", "rig.toml", "--manifest", "data/recordings.toml", "--out", "data"],
            &["simulate", "--rig", "rig.toml", "--manifest", "other/conditions.toml", "--out", "data"],
            &["simulate", "--rig", "rig.toml", "--manifest", "data/recordings.toml", "--out", "other/../data"],
            &[&spectra[..], &["data/r01.csv"]].concat(),
            &[&spectra[..], &["same.html"]].concat(),
            &[&spectra[..], &["data/r02.csv"]].concat(),
            &[&fit[..], &["data/r01.csv"]].concat(),
            &[&fit[..], &["data/recordings.toml"]].concat(),
            &[&fit[..], &["rig.toml"]].concat(),
            &[&fit[..], &["x.json", "--report", "x.json"]].concat(),
            &[&monitor[..], &["--samples-out", "data/r01.csv"]].concat(),
            &[&monitor[..], &["--plot", "model.json"]].concat()[..if force.is_empty() { 6 } else { 0 }],
            &["calibrate", "--rig", "rig.toml", "--recordings", "data", "--out", "data/r01.csv"],
        ] {
            if command.is_empty() {
                continue;
            }
            let error = refused(folder, &[command, force].concat());
            assert!(error.starts_with("error: --"), "{command:?}: {error}");
        }
    }
    assert!(contents(&folder.join("data")) == before);
    assert_eq!(fs::read_to_string(folder.join("rig.toml")).expect("a file"), RIG);
}

#[test]
fn what_ballrace_wrote_is_replaced_until_somebody_changes_it() {
    let folder = measured();
    let folder = folder.path();
    let simulate = ["simulate", "--rig", "rig.toml", "--seconds", "0.1", "--manifest"];
    let first = [&simulate[..], &["data/recordings.toml", "--out", "made"]].concat();
    done(folder, &first);
    let before = contents(&folder.join("made"));
    done(folder, &first);
    assert!(contents(&folder.join("made")) == before, "the same again");
    let within = [&simulate[..], &["made/recordings.toml", "--out", "made"]].concat();
    let error = refused(folder, &within);
    assert!(error.contains("which this command reads") && error.contains("--force"), "{error}");
    done(folder, &[&within[..], &["--force", "--seed", "3"]].concat());
    assert!(contents(&folder.join("made")) != before);
    let changed = fs::read_to_string(folder.join("made/r02.csv")).expect("a file") + "0,0,0\n";
    fs::write(folder.join("made/r02.csv"), &changed).expect("written");
    for force in [&[][..], &["--force"]] {
        let error = refused(folder, &[&first[..], force].concat());
        assert!(error.contains("r02.csv, which ballrace did not write or which was changed since"), "{error}");
    }
    assert_eq!(fs::read_to_string(folder.join("made/r02.csv")).expect("a file"), changed);

    done(folder, &["fit", "data", "--solver", "stlsq", "--nmd", "3", "--null", "0", "--out", "model.json"]);
    let export = ["export", "model.json", "--format", "bin", "--out", "model.json"];
    assert!(refused(folder, &export).contains("--force, since ballrace wrote it"));
    done(folder, &[&export[..], &["--force"]].concat());
    assert!(fs::read(folder.join("model.json")).expect("a file").starts_with(b"BRMD"));
}

#[cfg(unix)]
#[test]
fn endless_input_is_refused_at_once() {
    let folder = measured();
    let folder = folder.path();
    let pipe = folder.join("x.csv");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    for name in ["z.csv", "z.npy", "z.mat", "z.parquet", "z.toml"] {
        std::os::unix::fs::symlink("/dev/zero", folder.join(name)).expect("a link");
    }
    for file in ["x.csv", "z.csv", "z.npy", "z.mat", "z.parquet", "z.toml"] {
        let error = refused(folder, &["spectra", file, "--sample-rate", "1000", "--out", "o.html"]);
        assert!(error.contains(file) && error.contains("a device or a pipe"), "{error}");
    }
    for rig in ["z.toml", "x.csv"] {
        let error = refused(folder, &["predict", "--rig", rig, "--recordings", "data", "--out", "out"]);
        assert!(error.contains(rig) && error.contains("a device or a pipe"), "{error}");
        let error = refused(folder, &["monitor", "--model", rig, "data"]);
        assert!(error.contains("a device or a pipe"), "{error}");
    }
}

#[test]
fn sizes_and_conditions_beyond_any_machine_name_their_key() {
    let folder = measured();
    let folder = folder.path();
    let with = |from: &str, to: &str| {
        fs::write(folder.join("data/recordings.toml"), MANIFEST.replacen(from, to, 1)).expect("written");
        refused(folder, &["predict", "--rig", "rig.toml", "--recordings", "data", "--out", "out"])
    };
    for (from, to, key) in [
        ("= 25600.0", "= 1e18", "defaults.sample_rate_hz: found 1000000000000000000.0"),
        ("= 25600.0", "= 0.001", "defaults.sample_rate_hz: found 0.001"),
        ("= 30.0", "= 1e9", "recording[1].shaft_hz: found 1000000000.0"),
        ("= 30.0", "= 1800.0", "r01.csv, shaft_hz: found 1800, expected turns a second"),
        ("= 400.0", "= 1e30", "recording[1].load_n: found 1000000000000000000000000000000.0"),
        (
            "load_n = 400.0",
            "resample_hz = 1e7",
            "r01.csv, resample_hz: found 10000000 Hz, expected at most the sample rate",
        ),
        ("load_n = 400.0", "resample_hz = 0.1", "r01.csv, resample_hz: found 0.1 Hz, expected within a factor"),
        ("load_n = 400.0\n", "", "r01.csv, load_n: found none stated"),
    ] {
        let error = with(from, to);
        assert!(error.contains(key), "{to}: {error}");
    }
    fs::write(folder.join("data/recordings.toml"), MANIFEST).expect("written");
    let simulate = ["simulate", "--rig", "rig.toml", "--manifest", "data/recordings.toml", "--out", "out"];
    for seconds in ["--seconds=1e12", "--seconds=1e-9"] {
        let error = refused(folder, &[&simulate[..], &[seconds]].concat());
        assert!(error.contains("seconds of data/r01.csv: found "), "{error}");
    }
    let spectra = |option: &str| refused(folder, &["spectra", "data", "--out", "o.html", option]);
    assert!(spectra("--shaft-hz=1e9").contains("shaft_hz: found 1000000000"));
    assert!(spectra("--resample=1e12").contains("resample_hz: found 1000000000000"));
    let fit =
        |options: &[&str]| refused(folder, &[&["fit", "data", "--null", "0", "--out", "m.json"], options].concat());
    assert!(fit(&["--latent=17"]).contains("latent: found 17"));
    assert!(fit(&["--full-scale=1e-9"]).contains("of 6000 samples at or beyond it"));
    assert!(fit(&["--nd=11", "--nmd=16", "--solver=stlsq"]).contains("functions"));
    assert!(fit(&["--nd=5", "--nmd=16", "--solver=stlsq"]).contains("functions"));
}

#[test]
fn flat_channels_and_numbers_beyond_samples_are_said() {
    let folder = measured();
    let folder = folder.path();
    let spectra = ["spectra", "x.csv", "--sample-rate", "25600", "--out", "o.html"];
    fs::write(folder.join("x.csv"), csv(&[("ax", vec![3.25; 1000])])).expect("written");
    let error = refused(folder, &spectra);
    assert!(error.contains("x.csv, channel `ax`: found 3.25 in all samples"), "{error}");
    fs::write(folder.join("x.csv"), "ax\n0.1\n1e300\n").expect("written");
    let error = refused(folder, &spectra);
    assert!(error.contains("x.csv, row 3, column `ax`: found 1e300, expected a number within ±1e30"), "{error}");
    fs::write(folder.join("data/r02.csv"), csv(&[("ax", vec![0.0; 3000]), ("ay", noise(3, 3000))])).expect("written");
    for command in [
        &["calibrate", "--rig", "rig.toml", "--recordings", "data", "--out", "c.toml"][..],
        &["diagnose", "--rig", "rig.toml", "--recordings", "data", "--out", "out"],
    ] {
        let error = refused(folder, command);
        assert!(error.contains("r02.csv, channel `ax`: found 0 in all 3000 samples"), "{error}");
    }
}

#[test]
fn spectra_says_whose_speed_it_uses_and_looks_at_nothing_that_resampling_made() {
    let folder = measured();
    let folder = folder.path();
    let pulses: Vec<f64> = (0..25_600).map(|k| f64::from(u8::from(k % 1024 == 5))).collect();
    let with = |tacho: Vec<f64>| {
        fs::write(folder.join("x.csv"), csv(&[("ay", noise(4, 25_600)), ("tacho", tacho)])).expect("written");
    };
    let spectra =
        ["spectra", "x.csv", "--rig", "rig.toml", "--sample-rate", "25600", "--shaft-hz", "24.6", "--out", "o.html"];
    with(pulses);
    let told = done(folder, &spectra);
    assert!(told.contains("speed used: 25.0000 Hz by the channel tacho (nominal 24.600 Hz)"), "{told}");
    let up = done(folder, &[&spectra[..], &["--resample", "51200"]].concat());
    let band = |told: &str| told.lines().next().map(String::from);
    assert_eq!(band(&told), band(&up), "resampling up adds nothing to see");
    with(vec![1.0; 25_600]);
    let told = done(folder, &spectra);
    assert!(
        told.contains("the channel tacho is not used: tacho: found 0 pulses") && told.contains("24.6000 Hz"),
        "{told}"
    );
}

#[test]
fn a_model_says_what_channel_and_rate_it_is_of() {
    let folder = measured();
    let folder = folder.path();
    let fit =
        ["fit", "data", "--channel", "ay", "--solver", "stlsq", "--nmd", "3", "--null", "0", "--out", "model.json"];
    done(folder, &fit);
    done(folder, &["export", "model.json", "--format", "bin", "--out", "model.bin"]);
    let stderr = |arguments: &[&str]| text(&ballrace(folder, arguments).stderr);
    let said = stderr(&["monitor", "--model", "model.json", "data", "--channel", "ax"]);
    assert!(said.contains("the model is of channel ay, the recordings' is ax"), "{said}");
    let said = stderr(&["monitor", "--model", "model.json", "data"]);
    assert!(!said.contains("the model is of"), "{said}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_fit_leaves_nothing_and_says_so() {
    use std::io::{BufRead, BufReader};
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, Stdio};

    let folder = measured();
    let folder = folder.path();
    let before = contents(folder);
    let mut fit = Command::new(env!("CARGO_BIN_EXE_ballrace"))
        .current_dir(folder)
        .args(["fit", "data", "--max-steps", "100000000", "--out", "model.json"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut said = BufReader::new(fit.stderr.take().expect("stderr")).lines().map(|line| line.expect("UTF-8"));
    // The first line of progress: the fit is under way.
    assert!(said.any(|line| line.contains("fit")));
    let killed = Command::new("kill").args(["-INT", &fit.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
    assert!(said.any(|line| line.contains("begins anew")));
    assert_eq!(fit.wait().expect("ended").signal(), Some(2));
    assert_eq!(contents(folder), before);
}
