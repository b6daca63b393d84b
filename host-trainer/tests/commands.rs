//! The commands as a user meets them: files, exit statuses, what is on stdout and what on stderr.

use std::fmt::Write;
use std::path::Path;

mod support;
use support::{done, refused};

/// Recordings of a resonance driven by noise; the last ones rattle.
fn recordings(folder: &Path) {
    let mut state = 1u64;
    let mut noise = || {
        let mut sum = 0.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        }
        sum
    };
    std::fs::create_dir_all(folder).expect("a folder");
    let mut manifest = String::from("[defaults]\nsample_rate_hz = 10000.0\nunit = \"m/s^2\"\n");
    for n in 1..=16 {
        let (mut a, mut b) = (0.0, 0.0);
        let mut csv = String::from("ax\n");
        for i in 0..2000 {
            let rattle = if n > 10 && i % 100 == 0 { 30.0 } else { 0.0 };
            (b, a) = (a, 1.5 * a - 0.9 * b + noise() + rattle);
            let _ = writeln!(csv, "{a}");
        }
        std::fs::write(folder.join(format!("r{n:02}.csv")), csv).expect("a file");
        let _ = write!(manifest, "[[recording]]\nfile = \"r{n:02}.csv\"\n");
    }
    std::fs::write(folder.join("recordings.toml"), manifest).expect("a file");
}

const FIT: [&str; 14] = [
    "fit",
    "data",
    "--out",
    "model.json",
    "--solver",
    "stlsq",
    "--healthy",
    "10",
    "--nmd",
    "3",
    "--nd",
    "1",
    "--nf",
    "0",
];

#[test]
fn from_recordings_to_the_same_events_from_every_form_of_the_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let told = done(folder, &FIT);
    for expected in
        ["10 of 16 recordings", "in sample", "held out", "null", "verdict: ", "a^(1) = ", "condition number"]
    {
        assert!(told.contains(expected), "{expected:?} in {told}");
    }
    let mut events = vec![done(folder, &["monitor", "--model", "model.json", "data"])];
    for (format, file) in [("bin", "model.bin"), ("json", "device.json")] {
        done(folder, &["export", "model.json", "--format", format, "--out", file]);
        events.push(done(folder, &["monitor", "--model", file, "data"]));
    }
    assert!(events.iter().all(|e| *e == events[0]));
    let lines: Vec<serde_json::Value> =
        events[0].lines().map(|line| serde_json::from_str(line).expect("a JSON line an event")).collect();
    let alarm = lines.iter().find(|e| e["event"] == "anomalous").expect("the rattle is noticed");
    assert!((10..15).contains(&alarm["recording_index"].as_u64().expect("an index")), "{alarm}");
    assert_eq!(lines.last().expect("a summary")["event"], "summary");
    let document = done(folder, &["monitor", "--model", "model.bin", "data", "--json", "--iso-class", "2-rigid"]);
    let all: Vec<serde_json::Value> = serde_json::from_str(&document).expect("one document");
    let (indicators, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|e| e["event"] == "recording");
    assert_eq!(others, lines);
    assert_eq!(indicators.len(), 16);
    assert!(indicators[15]["kurtosis"].as_f64() > indicators[0]["kurtosis"].as_f64(), "{indicators:?}");
    // 0.2 s hold two periods of 10 Hz.
    assert!(indicators.iter().all(|e| e["velocity_mm_per_s"].is_null() && e["zone"].is_null()));
    assert!(indicators[0]["no_velocity"].as_str().expect("a reason").contains("at least 0.5 s"));
}

#[test]
fn what_a_diagnosis_names_enters_the_library() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let diagnosis = |causes: &str| {
        let text = format!(r#"{{"schema": "ballrace-diagnosis/1", "causes": [{causes}]}}"#);
        std::fs::write(folder.join("diagnosis.json"), text).expect("written");
    };
    let arguments = [&FIT[..], &["--null", "0", "--diagnosis", "diagnosis.json"]].concat();
    diagnosis(r#"{"name": "structural-resonance"}, {"name": "hardening-stiffness"}, {"name": "unbalance"}"#);
    let told = done(folder, &arguments);
    for expected in [
        "n_MD 4, even orders",
        "for structural-resonance: the terms of one more state enter, n_MD 3 becomes 4",
        "for hardening-stiffness: products of three states enter, n_D 1 becomes 3",
        "for unbalance: the library stays as it is",
    ] {
        assert!(told.contains(expected), "{expected:?} in {told}");
    }
    let report = done(folder, &[&arguments[..], &["--json"]].concat());
    let report: serde_json::Value = serde_json::from_str(&report).expect("one document");
    assert_eq!(report["training"]["entered"][1]["cause"], "hardening-stiffness");
    assert_eq!(report["training"]["functions"], 35);
    diagnosis("");
    assert!(done(folder, &arguments).contains("the diagnosis names no cause, so the library is unchanged"));
    diagnosis(r#"{"name": "gremlins"}"#);
    let error = refused(folder, &arguments);
    assert!(error.contains("diagnosis.json, key `causes[0].name`: found \"gremlins\", expected one of"), "{error}");
    diagnosis(r#"{"name": "structural-resonance"}"#);
    let full: Vec<&str> = arguments.iter().map(|a| if *a == "3" { "16" } else { *a }).collect();
    let error = refused(folder, &full);
    assert!(error.contains("structural-resonance: with it n_MD would be 17, expected at most 16"), "{error}");
}

#[test]
fn exported_c_and_rust_hold_the_bytes_of_the_binary_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let report = done(folder, &[&FIT[..], &["--null", "0", "--lambda", "0.5,0.01,0.01", "--json"]].concat());
    assert!(serde_json::from_str::<serde_json::Value>(&report).expect("one document")["scores"].is_object());
    done(folder, &["export", "model.json", "--format", "bin", "--out", "m.bin"]);
    let bytes = std::fs::read(folder.join("m.bin")).expect("written");
    for (format, file) in [("c", "m.h"), ("rust", "m.rs")] {
        done(folder, &["export", "model.json", "--format", format, "--out", file]);
        let source = std::fs::read_to_string(folder.join(file)).expect("written");
        let literals = source.split("0x").skip(1).filter_map(|s| s.get(..3)?.strip_suffix(','));
        let written: Vec<u8> = literals.filter_map(|hex| u8::from_str_radix(hex, 16).ok()).collect();
        assert_eq!(written, bytes, "{format}");
        // Of all bytes it would be the same for every model.
        let own = u32::from_le_bytes(*bytes.last_chunk().expect("a word"));
        assert!(source.contains(&format!("0x{own:08x}")), "{format}");
    }
    let error = refused(folder, &["export", "model.json", "--format", "c", "--out", "x.h", "--max-ram", "8"]);
    assert!(error.contains("RAM limit") && error.contains("at most 8"), "{error}");
    let over =
        ["export", "model.json", "--format", "c", "--out", "x.h", "--target", "cortex-m4f", "--budget-cycles", "9"];
    let error = refused(folder, &over);
    assert!(error.contains("cycle limit") && error.contains("cycles a sample, expected at most 9"), "{error}");
    assert!(!folder.join("x.h").exists());
}

#[test]
fn a_fit_and_an_export_keep_to_a_budget_of_cycles() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let networks = FIT.into_iter().filter(|argument| !["--solver", "stlsq"].contains(argument));
    let short = ["--null", "0", "--trainings", "1", "--max-steps", "50", "--hidden", "64"];
    let fit: Vec<_> = networks.chain(short).collect();
    let fitted = |more: &[&str]| done(folder, &[&fit[..], more].concat());
    let worst = || {
        let json = done(folder, &["budget", "--model", "model.json", "--json"]);
        let json: serde_json::Value = serde_json::from_str(&json).expect("one document");
        json["worst_cycles"].as_f64().expect("a number")
    };
    fitted(&[]);
    let float = worst();
    done(folder, &["export", "model.json", "--format", "bin", "--out", "m.bin", "--budget-cycles", "12000"]);
    assert!(float > 12000.0 && std::fs::metadata(folder.join("m.bin")).expect("written").len() > 0, "{float}");
    let text = fitted(&["--budget-cycles", "4000"]);
    assert!(worst() <= 4000.0 && worst() > 3500.0, "{} {text}", worst());
    assert!(text.contains(" of 4000 cycles for the most expensive sample, with "), "{text}");
    let error = refused(folder, &[&fit[..], &["--budget-cycles", "100"]].concat());
    assert!(error.contains("cycle limit") && error.contains("hidden units in fixed point"), "{error}");
}

#[test]
fn a_budget_is_predicted_from_the_model_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    done(folder, &[&FIT[..], &["--null", "0"]].concat());
    let arguments = ["budget", "--model", "model.json", "--target", "cortex-m4f", "--clock-hz", "1e6"];
    let text = done(folder, &arguments);
    let json = done(folder, &[&arguments[..], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json).expect("one document");
    // The recordings have 10 kHz.
    assert_eq!(json["period_cycles"], 100.0);
    let share = json["share"].as_f64().expect("a number");
    assert!((share - json["cycles"].as_f64().expect("a number") / 100.0).abs() < 1e-9);
    assert_eq!(json["target"], "cortex-m4f");
    for name in ["encoder", "xi", "total", "flash", "static RAM", "stack"] {
        assert!(text.contains(name), "{name} in {text}");
    }
    std::fs::copy(folder.join("model.json"), folder.join("again.json")).expect("copied");
    let table = done(folder, &["budget", "--model", "model.json", "again.json", "--plot", "frontier.svg"]);
    assert!(table.contains("| model | R² held out") && table.contains("\n| again | "), "{table}");
    assert!(std::fs::read_to_string(folder.join("frontier.svg")).expect("written").contains("<svg"));
    let manifest = folder.join("data/recordings.toml");
    let text = std::fs::read_to_string(&manifest).expect("a manifest");
    std::fs::write(&manifest, text.replace("10000.0", "20000.0")).expect("written");
    std::fs::rename(folder.join("model.json"), folder.join("slow.json")).expect("renamed");
    done(folder, &[&FIT[..], &["--null", "0"]].concat());
    std::fs::rename(folder.join("model.json"), folder.join("fast.json")).expect("renamed");
    std::fs::rename(folder.join("slow.json"), folder.join("model.json")).expect("renamed");
    let error = refused(folder, &["budget", "--model", "model.json", "fast.json", "--plot", "rates.svg"]);
    assert!(error.contains("found fast.json of 20000 Hz, expected 10000 Hz") && !folder.join("rates.svg").exists());
    for lost in ["again.json", "data/r01.csv"] {
        let error = refused(folder, &["budget", "--model", "model.json", "again.json", "--plot", lost]);
        assert!(error.contains("--plot: found"), "{error}");
    }
    done(folder, &["export", "model.json", "--format", "bin", "--out", "m.bin"]);
    let error = refused(folder, &["budget", "--model", "model.json", "m.bin"]);
    assert!(error.contains("m.bin: found a model without scores"), "{error}");
    let error = refused(folder, &["budget", "--model", "model.json", "--clock-hz", "0"]);
    assert!(error.contains("--clock-hz: found 0, expected a positive frequency"), "{error}");
    assert!(refused(folder, &["budget", "--model", "model.json", "--target", "z80"]).contains("cortex-m4f"));
}

#[test]
fn bad_input_says_where_what_and_what_was_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    done(folder, &[&FIT[..], &["--null", "0"]].concat());
    let fit = |data: &str, more: &[&str]| refused(folder, &[&["fit", data, "--out", "x.json"], more].concat());

    std::fs::write(folder.join("bad.csv"), "ax\n1.0\nwrong\n2.0\n").expect("written");
    let error = fit("bad.csv", &["--sample-rate", "1000"]);
    assert!(error.contains("bad.csv") && error.contains("row 3") && error.contains("wrong"), "{error}");
    assert!(fit("nowhere", &[]).contains("nowhere"));
    assert!(fit("data", &["--nmd", "17"]).contains("expected 1 to 16"));
    assert!(fit("data", &["--estimator", "kalman"]).contains("expected --alignment causal"));
    assert!(fit("data", &["--cutoff", "0.2"]).contains("--cutoff: found --estimator differences"));
    let causal = ["--alignment", "causal", "--estimator", "savitzky-golay"];
    assert!(fit("data", &[&causal[..], &["--nmd", "9"]].concat()).contains("states of order 16"));
    assert!(fit("data", &[&causal[..], &["--stretch", "0.5"]].concat()).contains("expected 1 to 8"));
    assert!(fit("data", &["--healthy", "99"]).contains("expected 1 to 16 recordings"));
    assert!(fit("data", &["--channel", "ay"]).contains("ay"));
    assert!(fit("data", &["--unit", "furlong"]).contains("expected g or m/s^2"));
    assert!(fit("data", &["--lambda", "0.5,0.1"]).contains("--lambda: found"));
    assert!(fit("data", &["--ridge=-1"]).contains("--ridge: found -1"));
    assert!(fit("data", &["--solver", "stlsq", "--threshold", "NaN"]).contains("--threshold: found NaN"));
    assert!(fit("data", &["--block", "0"]).contains("block: found 0"));
    assert!(!folder.join("x.json").exists(), "nothing is left of a failed fit");
    let error = refused(folder, &["fit", "data", "--out", "nowhere/x.json"]);
    assert!(error.contains("--out: found nowhere"), "{error}");

    let model = std::fs::read_to_string(folder.join("model.json")).expect("written");
    std::fs::write(folder.join("changed.json"), model.replacen("\"variables\":3", "\"variables\":4", 1))
        .expect("written");
    let error = refused(folder, &["monitor", "--model", "changed.json", "data"]);
    assert!(error.contains("checksum"), "{error}");
    std::fs::write(folder.join("noise.bin"), [7; 300]).expect("written");
    assert!(refused(folder, &["monitor", "--model", "noise.bin", "data"]).contains("expected"));
    let error = refused(folder, &["monitor", "--model", "model.json", "data", "--fault", "nan:2"]);
    assert!(error.contains("--fault"), "{error}");
    let error = refused(folder, &["monitor", "--model", "model.json", "data", "--resample", "5000"]);
    assert!(error.contains("5000") && error.contains("10000"), "{error}");
    assert!(refused(folder, &["fit"]).contains("RECORDING"));
}

#[test]
fn what_a_recording_lacks_is_missing_to_the_device_and_a_break_to_the_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    done(folder, &[&FIT[..], &["--null", "0"]].concat());
    // A row that is no number, and rows that the time column skips.
    let rows = std::fs::read_to_string(folder.join("data/r02.csv")).expect("written");
    let values: Vec<&str> = rows.lines().skip(1).collect();
    let bad: String =
        values.iter().enumerate().fold("ax\n".into(), |text, (i, v)| text + if i == 700 { "nan" } else { v } + "\n");
    std::fs::write(folder.join("bad.csv"), bad).expect("written");
    let timed = values.iter().enumerate().filter(|(i, _)| !(900..950).contains(i));
    let timed: String = timed.fold("time_s,ax\n".into(), |text, (i, v)| text + &format!("{:.4},{v}\n", i as f64 / 1e4));
    std::fs::write(folder.join("gap.csv"), timed).expect("written");
    for (file, options) in [("bad.csv", &["--skip-bad", "--sample-rate", "10000"][..]), ("gap.csv", &[])] {
        let events = done(folder, &[&["monitor", "--model", "model.json", file], options].concat());
        let summary: serde_json::Value =
            serde_json::from_str(events.lines().last().expect("a summary")).expect("a JSON line");
        assert_eq!(summary["faults"]["missing"], 1, "{file}: {summary}");
        let report = done(
            folder,
            &[
                &["fit", file, "--solver", "stlsq", "--nmd", "3", "--null", "0", "--json"],
                &["--out", "x.json"][..],
                options,
            ]
            .concat(),
        );
        let report: serde_json::Value = serde_json::from_str(&report).expect("one document");
        let parts =
            [&report["training"]["recordings"], &report["training"]["held_out"]].map(|v| v.to_string()).concat();
        assert!(parts.contains("part 1") && parts.contains("part 2"), "{parts}");
    }
}

#[test]
fn phases_says_when_a_machine_began_to_age() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let json = done(folder, &["phases", "data", "--wavelet", "sym5", "--out", "phases.html", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let raw = &found["machines"][0]["channels"][0];
    assert_eq!((raw["aging"]["name"].as_str(), raw["aging_recordings"].as_u64()), (Some("r11"), Some(6)), "{json}");
    let page = std::fs::read_to_string(folder.join("phases.html")).expect("written");
    assert!(page.contains("ax ages from r11"));
    assert!(done(folder, &["phases", "data"]).contains("r11"));

    assert!(refused(folder, &["phases", "data/r01.csv", "--sample-rate", "1000"]).contains("found 1 recordings"));
    assert!(refused(folder, &["phases", "data", "--wavelet", "coif1"]).contains("--wavelet: found `coif1`"));
    assert!(refused(folder, &["phases", "data", "--healthy", "3"]).contains("--healthy: found 3"));
    assert!(refused(folder, &["phases", "data", "--healthy", "16"]).contains("expected more than 16"));
    assert!(refused(folder, &["phases", "data", "--sigmas", "NaN"]).contains("--sigmas: found NaN"));
    assert!(refused(folder, &["phases", "data", "--compare"]).contains("--compare"));
}

#[test]
fn every_command_has_a_worked_example() {
    let folder = tempfile::tempdir().expect("a folder");
    for command in [
        "demo",
        "fit",
        "export",
        "budget",
        "monitor",
        "simulate",
        "predict",
        "calibrate",
        "diagnose",
        "spectra",
        "phases",
        "sweep",
        #[cfg(feature = "fleet")]
        "collect",
        #[cfg(feature = "fleet")]
        "fleet",
    ] {
        let help = done(folder.path(), &[command, "--help"]);
        assert!(help.contains(&format!("Example:\n  ballrace {command} ")), "{command}: {help}");
    }
}

const RIG: &str = include_str!("../src/cli/demo/rig.toml");
const CONDITIONS: &str =
    "[defaults]\nsample_rate_hz = 25600.0\n[[recording]]\nfile = \"r01.csv\"\nshaft_hz = 30.0\nload_n = 400.0\n";

#[test]
fn a_rig_is_simulated_and_its_recordings_predicted() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let file = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    file("rig.toml", RIG);
    file("conditions.toml", CONDITIONS);
    let simulate = ["simulate", "--rig", "rig.toml", "--manifest", "conditions.toml", "--seconds", "0.2", "--out"];
    done(folder, &[&simulate[..], &["a", "--seed", "3"]].concat());
    done(folder, &[&simulate[..], &["b", "--seed", "3"]].concat());
    let csv = |name: &str| std::fs::read_to_string(folder.join(name).join("r01.csv")).expect("written");
    assert_eq!(csv("a"), csv("b"), "same seed, same bits");
    assert_eq!(csv("a").lines().count(), 1 + 5120);

    // The same condition with other angles and noise; with an unbalance added, more of it.
    let effect = "[[effect]]\nname = \"unbalance\"\nunbalance_kg_m = 0.02\n";
    file("corrected.toml", &format!("{RIG}{effect}"));
    let power = |rig: &str, out: &str| {
        done(folder, &["predict", "--rig", rig, "--recordings", "a", "--out", out]);
        let column = |line: &str| line.split(',').next().and_then(|v| v.parse::<f64>().ok());
        csv(out).lines().filter_map(column).map(|v| v * v).sum::<f64>()
    };
    assert!(power("corrected.toml", "d") > 10.0 * power("rig.toml", "c"));

    file("typo.toml", &RIG.replace("mass_kg = 1.2\n", "mas_kg = 1.2\n"));
    let error = refused(folder, &["simulate", "--rig", "typo.toml", "--manifest", "conditions.toml", "--out", "x"]);
    assert!(error.contains("typo.toml") && error.contains("mas_kg"), "{error}");
    file("no-load.toml", &CONDITIONS.replace("load_n = 400.0\n", ""));
    let error = refused(folder, &["simulate", "--rig", "rig.toml", "--manifest", "no-load.toml", "--out", "x"]);
    assert!(error.contains("load_n"), "{error}");
}

#[test]
fn spectra_shows_a_pit_where_it_is_and_tells_what_it_cannot_use() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let file = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    let effect = "[[effect]]\nname = \"outer-race-defect\"\ndepth_m = 1e-5\nwidth_rad = 0.05\nangle_rad = 1.5\n";
    file("rig.toml", RIG);
    file("pitted.toml", &format!("{RIG}{effect}"));
    file("conditions.toml", CONDITIONS);
    done(folder, &["simulate", "--rig", "pitted.toml", "--manifest", "conditions.toml", "--out", "data"]);
    let spectra = ["spectra", "data", "--rig", "rig.toml", "--channel", "ay"];
    let told = done(folder, &[&spectra[..], &["--out", "page.html", "--json"]].concat());
    let document: serde_json::Value = serde_json::from_str(&told).expect("one document");
    let first = &document["recordings"][0];
    let line = |name: &str| {
        let lines = first["lines"].as_array().expect("lines");
        lines.iter().find(|l| l["name"] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    let ratio = |name: &str| line(name)["signal_to_background"].as_f64().expect("a number");
    assert!(ratio("BPFO") > 100.0 && ratio("BPFO") > 10.0 * ratio("BPFI"), "{first}");
    assert!(
        (line("BPFO")["frequency_hz"].as_f64().expect("a number")
            / line("BPFO")["expected_hz"].as_f64().expect("a number")
            - 1.0)
            .abs()
            < 0.01
    );
    assert!((first["speed"]["tachometer_hz"].as_f64().expect("a number") - 30.0).abs() < 0.01, "{first}");
    assert_eq!(first["band"]["chosen_by"]["lines"], "outer", "{first}");
    assert!(first["synchronous"]["turns"].as_u64().expect("a number") > 25);
    let page = std::fs::read_to_string(folder.join("page.html")).expect("written");
    for heading in ["Kurtogram", "Envelope", "Orders of the shaft", "Synchronous average"] {
        assert!(page.contains(heading), "{heading}");
    }
    assert!(!page.contains("NaN") && page.matches("<svg").count() >= 6);
    let stated = done(folder, &[&spectra[..], &["--out", "page.html", "--json", "--band", "2000:4000"]].concat());
    let stated: serde_json::Value = serde_json::from_str(&stated).expect("one document");
    assert_eq!(stated["recordings"][0]["band"]["low_hz"], 2000.0);

    let refused = |more: &[&str]| refused(folder, &[&spectra[..], &["--out", "x.html"], more].concat());
    assert!(refused(&["--band", "4000:2000"]).contains("--band: found 4000:2000"));
    assert!(refused(&["--band", "2000:40000"]).contains("Nyquist"));
    assert!(refused(&["--shaft-hz=-3"]).contains("--shaft-hz: found -3"));
    assert!(!folder.join("x.html").exists(), "nothing is left of a refusal");
    let error = self::refused(folder, &["spectra", "data", "--channel", "az", "--out", "x.html"]);
    assert!(error.contains("expected `az`") && error.contains("tacho"), "{error}");
}

#[test]
fn a_sweep_goes_on_after_a_kill_without_doing_anything_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("data"));
    let config = "recordings = [\"data\"]\nrange = [0, 3]\nsolver = \"stlsq\"\nnd = 1\nnmd = [2, 3]\nnf = [0, 1]\n";
    std::fs::write(folder.join("sweep.toml"), config).expect("written");
    let sweep = || {
        let json = done(folder, &["sweep", "--config", "sweep.toml", "--out", "out", "--json"]);
        serde_json::from_str::<serde_json::Value>(&json).expect("JSON")["rows"].as_array().expect("rows").clone()
    };
    let all = sweep();
    assert_eq!(all.len(), 2 * 2 * 3);
    assert!(all.iter().all(|row| row["r2"].as_f64().is_some_and(|r2| r2 > 0.2) && row["error"].is_null()), "{all:?}");
    let journal = folder.join("out/rows.jsonl");
    let lines = std::fs::read_to_string(&journal).expect("written");
    // Killed while the sixth row was written.
    let cut: usize = lines.lines().take(5).map(|line| line.len() + 1).sum::<usize>() + 20;
    std::fs::write(&journal, &lines[..cut]).expect("written");
    let again = sweep();
    let without_times =
        |rows: &[serde_json::Value]| rows.iter().map(|row| (row["job"].clone(), row["r2"].clone())).collect::<Vec<_>>();
    assert_eq!(without_times(&again), without_times(&all));
    let kept: Vec<String> = std::fs::read_to_string(&journal).expect("written").lines().map(String::from).collect();
    assert_eq!(kept.len(), all.len());
    assert!(lines.lines().take(5).zip(&kept).all(|(before, after)| before == after), "five rows as they were");

    let csv = std::fs::read_to_string(folder.join("out/sweep.csv")).expect("written");
    assert_eq!(csv.lines().count(), 1 + all.len());
    assert!(csv.starts_with("name,recording,nd,nmd,nf,powers,solver,"));

    std::fs::write(folder.join("bad.toml"), "recordings = [\"data\"]\ndegree = 2\n").expect("written");
    assert!(refused(folder, &["sweep", "--config", "bad.toml"]).contains("degree"));
    std::fs::write(folder.join("bad.toml"), "recordings = [\"data\"]\nfilter = \"coif1\"\n").expect("written");
    assert!(refused(folder, &["sweep", "--config", "bad.toml"]).contains("filter: found `coif1`"));
    std::fs::write(folder.join("bad.toml"), "recordings = [\"data\"]\nrange = [0, 99]\n").expect("written");
    assert!(refused(folder, &["sweep", "--config", "bad.toml"]).contains("expected within 0 to 16"));
}

#[test]
fn the_paper_s_tables_come_from_one_command_and_a_library_from_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    recordings(&folder.join("machine"));
    // The machine of `recordings` rattles from its eleventh recording on: its kurtosis says that it ages.
    let table = ["sweep", "--preset", "fig11", "machine", "--channel", "ax", "--out", "paper"];
    let told = done(folder, &table);
    assert!(told.contains("wrote paper/paper.html"), "{told}");
    let csv = std::fs::read_to_string(folder.join("paper/sweep.csv")).expect("written");
    assert_eq!(csv.lines().count(), 1 + 5 * 7);
    let page = std::fs::read_to_string(folder.join("paper/paper.html")).expect("written");
    for part in ["Figure 8", "Figure 11", "Figure 13", "on their surrogates", "machine: ax ages from r11"] {
        assert!(page.contains(part), "{part}");
    }
    assert_eq!(page.matches("<svg").count(), 2 + 3 + 1);
    let done_before = std::fs::read_to_string(folder.join("paper/rows.jsonl")).expect("written");
    done(folder, &table);
    assert_eq!(std::fs::read_to_string(folder.join("paper/rows.jsonl")).expect("written"), done_before);
    assert!(refused(folder, &["sweep", "--preset", "fig11", "machine", "--channel", "nowhere"]).contains("nowhere"));
    assert!(
        refused(folder, &["sweep", "--preset", "fig11", "machine", "--channel", "ax", "--count", "0"])
            .contains("--count")
    );

    let few = ["library", "machine", "--max-nd", "2", "--max-nmd", "3", "--max-nf", "1", "--target", "0.5"];
    let told = done(folder, &few);
    for part in ["step 1: degrees n_D", "step 3: harmonics n_F", "chosen: n_D ", "R² in sample "] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(refused(folder, &["library", "machine", "--seconds", "0"]).contains("--seconds"));
}

#[test]
fn features_leaves_each_bearing_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for name in ["a", "b", "c"] {
        recordings(&folder.join(name));
    }
    // Without the CWRU records, which may lie beside the workspace.
    let features = |arguments: &[&str]| {
        let command = [&["features", "--channel", "ax"], arguments].concat();
        let binary = env!("CARGO_BIN_EXE_ballrace");
        let output =
            std::process::Command::new(binary).current_dir(folder).env("BALLRACE_DATA", folder).args(command).output();
        let output = output.expect("the binary runs");
        (output.status.code(), support::text(&output.stdout), support::text(&output.stderr))
    };
    let all = ["a", "b", "c", "--json", "--out", "features.html"];
    let (status, json, error) = features(&all);
    assert_eq!(status, Some(0), "{error}");
    let found: serde_json::Value = serde_json::from_str(&json).expect("one document");
    assert_eq!((found["bearings"][0]["aging"].as_u64(), found["faults"].is_null()), (Some(10), true));
    let phase = &found["lives"][0];
    assert_eq!((&phase["question"], &phase["reference"]), (&"phase".into(), &"absolute".into()));
    assert_eq!((phase["sets"].as_array().map(Vec::len), phase["gains"].as_array().map(Vec::len)), (Some(13), Some(14)));
    // The three machines are one, and the rattle is in its kurtosis.
    assert_eq!(phase["sets"][0]["set"], "RMS, kurtosis");
    assert_eq!(phase["sets"][0]["scores"], serde_json::json!([1.0, 1.0, 1.0]));
    let page = std::fs::read_to_string(folder.join("features.html")).expect("written");
    assert_eq!(page.matches("<svg").count(), 6 + 3);
    assert_eq!(features(&all).1, json);
    let (status, told, _) = features(&["a", "b", "c"]);
    assert!(status == Some(0) && told.contains("Added to RMS and kurtosis"), "{told}");
    assert_eq!(features(&["a", "b"]).0, Some(2));
    assert!(features(&["a", "b"]).2.contains("found 2 folders with an aging phase, expected at least 3"));
    assert!(features(&["a", "b", "c", "--cwru", "nowhere"]).2.contains("105_0.mat"));
}
