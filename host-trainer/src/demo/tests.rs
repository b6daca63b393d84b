use super::*;
use crate::report::html::tests::assert_well_formed;

/// The same job, in a few seconds.
fn small(depth_m: f64) -> Config {
    let config = Config::new(5);
    let train = TrainConfig { max_steps: 150, batch: 256, ..TrainConfig::default() };
    Config {
        plan: Plan { recordings: 30, seconds: 0.2, depth_m, ..config.plan },
        healthy: 12,
        fit: FitConfig {
            spec: StateSpec { dimension: 4, ..config.fit.spec },
            solver: Solver::SindyNn { hidden: vec![16], train },
            null_fits: 2,
            ..config.fit
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

fn ran(config: &Config) -> (Outcome, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(config, folder.path(), &|_, _| ()).unwrap();
    (outcome, folder)
}

#[test]
fn the_alarm_comes_after_the_fault_and_not_before() {
    let (outcome, folder) = ran(&small(6e-6));
    let first = outcome.truth.first_affected.unwrap();
    let alarm = outcome.first_alarm.as_ref().expect("an alarm").recording_index as usize;
    assert!(alarm >= first && !outcome.false_alarm, "{alarm} {first}");

    let files = files(folder.path());
    let names: Vec<_> = files.iter().map(|(path, _)| path.to_str().unwrap()).collect();
    for name in ["model.json", "model.bin", "model.h", "model.rs", "events.jsonl", "recordings/recordings.toml"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert_eq!(names.iter().filter(|name| name.ends_with(".csv")).count(), 30);
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert_well_formed(&page);
    assert_eq!(page.matches("<svg").count(), 5);
    assert!(page.contains("fault put in") && page.contains(&outcome.raised()));
    let events = std::fs::read_to_string(folder.path().join("events.jsonl")).unwrap();
    assert!(events.lines().all(|line| serde_json::from_str::<serde_json::Value>(line).is_ok()));
    assert!(events.contains("\"anomalous\""));
    // The exported model is the one that watched.
    let (model, _) = model_file::read(&folder.path().join("model.bin")).unwrap();
    assert_eq!(model.bytes().len(), outcome.sizes.flash_bytes);
}

#[test]
fn null_a_machine_that_stays_healthy_raises_no_alarm() {
    for seed in 5..8 {
        let config = small(0.0);
        let config =
            Config { plan: Plan { seed, ..config.plan }, fit: FitConfig { null_fits: 0, ..config.fit }, ..config };
        let (outcome, folder) = ran(&config);
        assert_eq!(
            (outcome.first_alarm.as_ref(), outcome.alarms, outcome.false_alarm),
            (None, 0, false),
            "seed {seed}"
        );
        let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
        assert_well_formed(&page);
        assert!(page.contains("rightly so") && !page.contains("fault put in"));
    }
}

#[test]
fn same_seed_same_bytes() {
    let config = small(6e-6);
    let ((one, a), (two, b)) = (ran(&config), ran(&config));
    assert_eq!(one, two);
    for (left, right) in files(a.path()).iter().zip(files(b.path())) {
        assert!(*left == right, "{} differs", left.0.display());
    }
}

#[test]
fn too_many_healthy_recordings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let config = Config { healthy: 31, ..small(0.0) };
    let error = run(&config, folder.path(), &|_, _| ()).unwrap_err();
    assert_eq!(error.to_string(), "healthy recordings: found 31, expected 1 to 30");
}
