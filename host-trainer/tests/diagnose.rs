//! `ballrace diagnose` and `calibrate` as a user meets them, on a rig of one degree of freedom.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

mod support;
use support::{done, refused};

const RATE_HZ: f64 = 500.0;
const SAMPLES: usize = 2000;
const RIG: &str = "kind = \"sdof\"\nmass_kg = 2.0\ndamping_n_s_per_m = 4.0\nstiffness_n_per_m = 800.0 # measured\n\
                   input_gain_n_per_unit = 3.0\nrestoring = \"linear\"\ngravity_n = 0.0\n";
const FRICTION: &str = "\n[[effect]]\nname = \"coulomb-friction\"\nforce_n = 0.5\n";

fn document(told: &str) -> Value {
    serde_json::from_str(told).expect("one document")
}

/// Numbers that look random, the same each time.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Four recordings of a rig: `input` holds what drives it, `out` what `simulate` makes of it, with sensor noise of one
/// part in a hundred on q.
fn record(folder: &Path, rig: &str, out: &str, seed: u64) {
    let mut noise = Noise(seed);
    let input = folder.join(format!("{out}-input"));
    std::fs::create_dir_all(&input).expect("a folder");
    let mut manifest = format!("[defaults]\nsample_rate_hz = {RATE_HZ:?}\n");
    for n in 1..=4 {
        let tones: Vec<[f64; 2]> = (0..40).map(|_| [0.3 + 11.7 * noise.uniform(), TAU * noise.uniform()]).collect();
        let mut csv = String::from("u\n");
        for k in 0..SAMPLES {
            let t = k as f64 / RATE_HZ;
            let u: f64 = tones.iter().map(|[hz, phase]| (TAU * hz * t + phase).sin()).sum::<f64>() * 0.22;
            let _ = writeln!(csv, "{u}");
        }
        std::fs::write(input.join(format!("r{n:02}.csv")), csv).expect("written");
        let _ = write!(manifest, "[[recording]]\nfile = \"r{n:02}.csv\"\n");
    }
    std::fs::write(input.join("recordings.toml"), &manifest).expect("written");
    let input = input.join("recordings.toml");
    done(folder, &["simulate", "--rig", rig, "--manifest", input.to_str().expect("UTF-8"), "--out", out]);
    for n in 1..=4 {
        let path = folder.join(out).join(format!("r{n:02}.csv"));
        let rows = std::fs::read_to_string(&path).expect("written");
        let rows: Vec<[f64; 2]> = rows
            .lines()
            .skip(1)
            .map(|row| {
                let mut columns = row.split(',').map(|c| c.parse().expect("a number"));
                [(); 2].map(|()| columns.next().expect("u and q"))
            })
            .collect();
        let rms = (rows.iter().map(|[_, q]| q * q).sum::<f64>() / SAMPLES as f64).sqrt();
        let noisy = rows.iter().map(|[u, q]| format!("{u:?},{:?}\n", q + 0.01 * rms * noise.normal()));
        std::fs::write(&path, String::from("u,q\n") + &noisy.collect::<String>()).expect("written");
    }
    std::fs::write(folder.join(out).join("recordings.toml"), manifest).expect("written");
}

/// Root mean square of measured less before, and less after, from a file anyone can read.
fn errors(path: &Path) -> [f64; 2] {
    let csv = std::fs::read_to_string(path).expect("written");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("time_s,measured,before,after"));
    let mut sums = [0.0; 2];
    for (k, row) in lines.enumerate() {
        let row: Vec<f64> = row.split(',').map(|c| c.parse().expect("a number")).collect();
        assert!((row[0] - k as f64 / RATE_HZ).abs() < 1e-9 && row.len() == 4, "{row:?}");
        sums[0] += (row[1] - row[2]).powi(2);
        sums[1] += (row[1] - row[3]).powi(2);
    }
    sums.map(f64::sqrt)
}

#[test]
fn friction_is_named_and_the_corrected_rig_simulates_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("rig.toml"), RIG).expect("written");
    std::fs::write(folder.join("truth.toml"), format!("{RIG}{FRICTION}")).expect("written");
    record(folder, "truth.toml", "data", 7);
    let diagnose = ["diagnose", "--rig", "rig.toml", "--recordings", "data", "--out", "out", "--seed", "3"];
    let told = done(folder, &[&diagnose[..], &["--json"]].concat());
    let found = document(&told);
    assert_eq!(std::fs::read_to_string(folder.join("out/diagnosis.json")).expect("written"), told);
    assert_eq!((&found["schema"], &found["verdict"]), (&"ballrace-diagnosis/1".into(), &"mismatch".into()), "{found}");
    assert_eq!(found["causes"].as_array().map(Vec::len), Some(1), "{found}");
    let cause = &found["causes"][0];
    assert_eq!((&cause["name"], &cause["parameters"]["component"]), (&"coulomb-friction".into(), &"mass".into()));
    let (force, interval) = (&cause["parameters"]["force_n"], &cause["interval95"]["force_n"]);
    assert!((force.as_f64().expect("a number") - 0.5).abs() < 0.05, "{cause}");
    assert!(interval[0].as_f64() < force.as_f64() && force.as_f64() < interval[1].as_f64(), "{cause}");
    assert!(found["fit"]["after"].as_f64() < found["fit"]["before"].as_f64(), "{found}");
    let [before, after] = errors(&folder.join("out/heldout/r04.csv"));
    assert!(after < 0.2 * before, "{before} {after}");

    let page = std::fs::read_to_string(folder.join("out/report.html")).expect("written");
    for expected in ["differs from the rig by coulomb-friction", "95 % interval", "Rejected causes", "tanh"] {
        assert!(page.contains(expected), "{expected}");
    }
    for unwanted in ["NaN", "http:", "https:", "<script"] {
        assert!(!page.contains(unwanted), "{unwanted}");
    }
    let corrected = std::fs::read_to_string(folder.join("out/rig.corrected.toml")).expect("written");
    assert!(corrected.contains("coulomb-friction") && corrected.contains("# measured"), "{corrected}");
    let simulate = ["simulate", "--manifest", "data-input/recordings.toml", "--rig", "out/rig.corrected.toml", "--out"];
    done(folder, &[&simulate[..], &["again"]].concat());
    done(folder, &["predict", "--rig", "out/rig.corrected.toml", "--recordings", "data", "--out", "predicted"]);

    // Again into the same folder: what it wrote is replaced, what it did not write stays, and the bits are the same.
    std::fs::write(folder.join("out/heldout/mine.csv"), "time_s,measured,before,after\n").expect("written");
    std::fs::write(folder.join("out/notes.txt"), "mine").expect("written");
    let listed = told.replace("heldout/r04.csv", "heldout/r99.csv");
    std::fs::write(folder.join("out/diagnosis.json"), listed).expect("written");
    std::fs::rename(folder.join("out/heldout/r04.csv"), folder.join("out/heldout/r99.csv")).expect("renamed");
    let words = done(folder, &diagnose);
    for expected in
        ["differs from the rig by coulomb-friction", "  force 5", " mN (95 %: ", "held out: ", "out/report.html"]
    {
        assert!(words.contains(expected), "{expected:?} in {words}");
    }
    assert_eq!(std::fs::read_to_string(folder.join("out/diagnosis.json")).expect("written"), told);
    let mut there: Vec<String> = std::fs::read_dir(folder.join("out"))
        .expect("a folder")
        .chain(std::fs::read_dir(folder.join("out/heldout")).expect("a folder"))
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    there.sort();
    let expected = ["diagnosis.json", "heldout", "mine.csv", "notes.txt", "report.html", "rig.corrected.toml"];
    let written = ["r01.csv", "r02.csv", "r03.csv", "r04.csv"];
    let mut expected: Vec<&str> = expected.into_iter().chain(written).collect();
    expected.sort_unstable();
    assert_eq!(there, expected);
}

#[test]
fn a_healthy_machine_is_quiet_and_calibrates() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let guess = RIG.replace("mass_kg = 2.0", "mass_kg = 1.7") + "unknown = [\"mass_kg\"]\n";
    std::fs::write(folder.join("rig.toml"), guess).expect("written");
    std::fs::write(folder.join("truth.toml"), RIG).expect("written");
    record(folder, "truth.toml", "data", 11);
    let told = done(folder, &["diagnose", "--rig", "rig.toml", "--recordings", "data", "--out", "out", "--json"]);
    let found = document(&told);
    assert_eq!((&found["verdict"], &found["causes"]), (&"no-mismatch".into(), &Value::Array(vec![])), "{found}");
    assert!((found["fitted"][0]["value"].as_f64().expect("a number") - 2.0).abs() < 0.02, "{found}");
    assert!(std::fs::read_to_string(folder.join("out/report.html")).expect("written").contains("No mismatch"));

    let calibrate = ["calibrate", "--rig", "rig.toml", "--recordings", "data", "--out", "calibrated.toml"];
    let words = done(folder, &[&calibrate[..], &["--report", "page.html"]].concat());
    assert!(words.contains("mass, kg") && words.contains("held out: r04"), "{words}");
    let page = std::fs::read_to_string(folder.join("page.html")).expect("written");
    assert!(page.matches("<svg").count() >= 2 && !page.contains("NaN"));
    let calibrated = document(&done(folder, &[&calibrate[..], &["--json"]].concat()));
    let mass = &calibrated["estimates"][0];
    let [low, high] = [0, 1].map(|k| mass["interval95"][k].as_f64().expect("a number"));
    assert!(mass["key"] == "mass_kg" && 1.98 < low && low < high && high < 2.02, "{mass}");
    let error = refused(folder, &[&calibrate[..], &["--path", "all-pole"]].concat());
    assert!(error.contains("--path: found all-pole"), "{error}");
}

#[test]
fn bad_input_is_told_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let file = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    file("rig.toml", RIG);
    std::fs::create_dir(folder.join("data")).expect("a folder");
    file("data/r01.csv", &("p\n".to_owned() + &"0.1\n".repeat(300)));
    file("data/recordings.toml", "[[recording]]\nfile = \"r01.csv\"\nsample_rate_hz = 500.0\n");
    let refused = |rig: &str, data: &str, more: &[&str]| {
        refused(folder, &[&["diagnose", "--rig", rig, "--recordings", data, "--out", "out"], more].concat())
    };
    let error = refused("rig.toml", "data", &[]);
    assert!(error.contains("r01.csv") && error.contains("no channel q"), "{error}");
    assert!(refused("nowhere.toml", "data", &[]).contains("nowhere.toml"));
    assert!(refused("rig.toml", "nowhere", &[]).contains("nowhere"));
    assert!(refused("rig.toml", "data", &["--baseline", "absent"]).contains("absent"));
    file("typo.toml", &RIG.replace("mass_kg", "mas_kg"));
    let error = refused("typo.toml", "data", &[]);
    assert!(error.contains("typo.toml") && error.contains("mas_kg"), "{error}");
    assert!(!folder.join("out").exists(), "nothing is left of a refusal");
    file("out", "a file");
    assert!(refused("rig.toml", "data", &[]).contains("expected a folder"));
    let help = done(folder, &["diagnose", "--help"]);
    assert!(help.contains("Example:\n  ballrace diagnose "), "{help}");
}

/// A fault of the sensor shows in held-out recordings that anyone can measure, though no force is behind it.
#[test]
fn a_clipping_sensor_is_named_and_simulated() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("rig.toml"), RIG).expect("written");
    record(folder, "rig.toml", "data", 5);
    for n in 1..=4 {
        let path = folder.join(format!("data/r{n:02}.csv"));
        let csv = std::fs::read_to_string(&path).expect("written");
        let clipped = csv.lines().skip(1).map(|row| {
            let (u, q) = row.split_once(',').expect("u and q");
            format!("{u},{:?}\n", q.parse::<f64>().expect("a number").clamp(-0.006, 0.006))
        });
        std::fs::write(&path, String::from("u,q\n") + &clipped.collect::<String>()).expect("written");
    }
    let told = done(folder, &["diagnose", "--rig", "rig.toml", "--recordings", "data", "--out", "out", "--json"]);
    let found = document(&told);
    assert_eq!(found["causes"][0]["name"], "sensor-clipping", "{found}");
    assert_eq!(found["causes"][0]["parameters"]["value"], 0.006, "{found}");
    let fit = |key: &str| found["fit"][key].as_f64().expect("a number");
    assert!(fit("after") < 0.2 * fit("before") && fit("p_value") < 0.05, "{found}");
    let [before, after] = errors(&folder.join("out/heldout/r04.csv"));
    assert!(after < 0.2 * before, "{before} {after}");
}
