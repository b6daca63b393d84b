use super::*;
use crate::diagnose::result::Verdict;
use crate::model::export::Format;
use crate::model::file;
use crate::model::stlsq::StlsqConfig;
use crate::report::html::tests::assert_well_formed;

/// A smaller job: least squares instead of a network, and fewer recordings, for a rate of false alarms that so few can state.
fn small(gain: f64) -> Config {
    let config = Config::new(5);
    Config {
        scenario: Scenario { recordings: 24, seconds: 0.2, gain, ..config.scenario },
        job: Job {
            diagnosed: 3,
            fit: FitConfig {
                solver: Solver::Stlsq(StlsqConfig::default()),
                null_fits: 2,
                false_alarms_per_day: 100.0,
                ..config.job.fit
            },
        },
    }
}

/// Every file of a folder with its bytes, in order.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out.extend(files(&path).into_iter().map(|(p, b)| (Path::new(path.file_name().unwrap()).join(p), b)));
        } else {
            out.push((path.file_name().unwrap().into(), std::fs::read(&path).unwrap()));
        }
    }
    out.sort();
    out
}

fn ran(config: &Config) -> (DemoResult, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(config, folder.path(), &|_, _| ()).unwrap();
    (outcome, folder)
}

#[test]
fn the_loop_is_closed_and_the_same_seed_gives_the_same_bytes() {
    let config = small(4.0);
    let (outcome, folder) = ran(&config);
    let first = outcome.truth.first_affected.unwrap();
    let alarm = outcome.first_alarm.as_ref().expect("an alarm").recording_index as usize;
    assert!(alarm >= first && !outcome.false_alarm, "{alarm} {first}");
    assert!(outcome.rightly_named && outcome.causes.len() == 1, "{:?}", outcome.causes);
    let r = &outcome.residual;
    assert!(r.before > 1.3 * r.own && r.lower_in + 1 >= r.recordings, "{r:?}");
    assert!(r.after < 0.8 * r.before && r.after < 1.1 * r.floor, "{r:?}");
    assert!(r.after < 0.9 * r.without_terms.unwrap(), "the terms themselves help: {r:?}");
    assert_eq!((outcome.alarms_after, outcome.entered.len()), (0, 1));

    let left = files(folder.path());
    let names: Vec<_> = left.iter().map(|(path, _)| path.to_str().unwrap()).collect();
    for name in [
        "before.bin",
        "before.json",
        "diagnosis/diagnosis.json",
        "diagnosis/report.html",
        "diagnosis/rig.corrected.toml",
        "events.jsonl",
        "model.bin",
        "model.h",
        "model.json",
        "model.rs",
        "recordings/recordings.toml",
        "rig.toml",
    ] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert_well_formed(&page);
    assert_eq!(page.matches("<svg").count(), 4);
    assert!(page.contains(&outcome.raised()) && page.contains("structural-resonance"));
    let events = std::fs::read_to_string(folder.path().join("events.jsonl")).unwrap();
    assert!(events.lines().all(|line| serde_json::from_str::<serde_json::Value>(line).is_ok()));
    assert!(events.contains("\"anomalous\""));
    // The exported model is the reported one, and its file lists the added terms.
    let (model, _) = file::read(&folder.path().join("model.bin")).unwrap();
    assert_eq!(model.bytes().len(), outcome.sizes.flash_bytes);
    let (same, report) = file::read(&folder.path().join("model.json")).unwrap();
    assert_eq!(crate::model::export::export(&same, Format::Bin).unwrap(), model.bytes());
    assert_eq!(report.unwrap().training.entered, outcome.entered);

    let (again, other) = ran(&config);
    assert_eq!(again, outcome);
    for (left, right) in left.iter().zip(files(other.path())) {
        assert!(*left == right, "{} differs", left.0.display());
    }
}

#[test]
fn null_where_nothing_was_put_in_nothing_is_found_and_nothing_falls() {
    let (outcome, folder) = ran(&small(0.0));
    assert_eq!((outcome.first_alarm.as_ref(), outcome.alarms, outcome.false_alarm), (None, 0, false));
    assert_eq!((outcome.diagnosis, outcome.causes.len()), (Verdict::NoMismatch, 0));
    assert!(outcome.rightly_named && outcome.entered.is_empty());
    let r = &outcome.residual;
    assert!(r.without_terms.is_none() && (r.after / r.before - 1.0).abs() < 0.02, "{r:?}");
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert_well_formed(&page);
    assert!(page.contains("which is correct") && !page.contains("hidden effect</text>"));
}

#[test]
fn null_a_machine_as_drawn_raises_no_alarm_whatever_the_seed() {
    for seed in 6..9 {
        let config = small(0.0);
        let made = generator::make(&Scenario { seed, ..config.scenario }).unwrap();
        let fit = FitConfig { seed, null_fits: 0, ..config.job.fit };
        let model = job::model_of(&generator::nominal().unwrap(), &made.recordings, 77, &fit, &|_| ()).unwrap().model;
        let input = crate::recording::input::Input::from_recordings(&made.recordings, Some(job::CHANNEL)).unwrap();
        let watched =
            crate::model::replay::replay(&model, &input, &crate::model::replay::Options::default(), &mut |_, _| ())
                .unwrap();
        assert_eq!(watched.summary.alarms, 0, "seed {seed}");
    }
}

#[test]
fn too_few_recordings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let config = small(0.0);
    let config = Config { scenario: Scenario { recordings: 11, ..config.scenario }, ..config };
    let error = run(&config, folder.path(), &|_, _| ()).unwrap_err();
    assert_eq!(error.to_string(), "recordings: found 11, expected at least 12");
}
