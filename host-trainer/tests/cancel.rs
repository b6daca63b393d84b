//! Cancelled work ends within the stage in which it was cancelled.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use ballrace::identify::calibrate::bearing::Options;
use ballrace::rig::{OperatingCondition, Start};
use ballrace::stats::cancel::Token;
use ballrace::{Recording, Rig, Task, calibrate, diagnose, simulate};

fn rig() -> Rig {
    let demo = include_str!("../src/cli/demo/rig.toml");
    let unknown = "unknown = [\"inner.stiffness_n_per_m\", \"outer.damping_n_s_per_m\"]\n";
    Rig::parse(&format!("{unknown}{demo}"), Path::new("rig.toml")).unwrap()
}

fn recordings(rig: &Rig) -> Vec<Recording> {
    let made = (0..4u32).map(|n| {
        let condition = OperatingCondition {
            shaft_hz: 20.0 + f64::from(n),
            load_n: 400.0,
            sample_rate_hz: 25_600.0,
            samples: 25_600,
        };
        simulate(rig, &condition, &Start::seeded(n.into()))
    });
    made.collect::<Result<_, _>>().unwrap()
}

/// Stages that began, if work is cancelled as stage `cancelled` begins; `None` if it ran to its end.
fn begun(cancelled: usize, work: impl FnOnce(&dyn Fn(&str)) + Send) -> Option<usize> {
    let (token, stages) = (Token::default(), AtomicUsize::new(0));
    let progress = |_: &str| {
        if 1 + stages.fetch_add(1, Ordering::Relaxed) == cancelled {
            token.cancel();
        }
    };
    match token.run(|| work(&progress)).unwrap() {
        Some(()) => None,
        None => Some(stages.into_inner()),
    }
}

#[test]
fn invariant_cancelled_work_begins_no_further_stage() {
    let rig = rig();
    let recordings = recordings(&rig);
    let task = Task { rig: &rig, baseline: None, recordings: &recordings, seed: 0 };
    for stage in 1..=2 {
        let calibration = begun(stage, |progress| {
            let _ = calibrate(&rig, &recordings, &Options::default(), progress);
        });
        assert_eq!(calibration, Some(stage), "calibration");
        let diagnosis = begun(stage, |progress| {
            let _ = diagnose(&task, progress);
        });
        assert_eq!(diagnosis, Some(stage), "diagnosis");
    }
}
