//! What a device makes of broken samples.

use ballrace_core::crc::crc32;
use ballrace_core::input_check::{FaultCounts, Quality};
use ballrace_core::model::Model;
use ballrace_core::monitor::Status;
use ballrace_firmware_sim::event::{Event, Summary};
use ballrace_firmware_sim::faults::{Injected, Injector};
use ballrace_firmware_sim::runner::{Recording, Runner, RunnerError};
use ballrace_firmware_sim::source::{Arrival, in_memory};

mod common;

const RATE_HZ: f64 = common::SAMPLE_RATE_HZ as f64;

/// Statuses in order, kinds of faults in order, totals.
struct Told {
    statuses: Vec<Status>,
    faults: Vec<Quality>,
    summary: Summary,
    injected: Injected,
    lines: Vec<String>,
}

/// Runs recordings, each with or without faults.
fn run(plan: &str, recordings: &[(&[f32], bool)]) -> Told {
    let bytes = common::model(common::SMALL, &common::signal(20_000, 4));
    let model = Model::from_bytes(&bytes).unwrap();
    let mut scratch = vec![f32::NAN; Runner::scratch_len(&model)];
    let mut runner = Runner::new(&model, &mut scratch).unwrap();
    let mut injector = Injector::new(plan.parse().unwrap(), 5);
    let (mut statuses, mut faults, mut lines) = (Vec::new(), Vec::new(), Vec::new());
    let mut on_event = |event: Event<'_>| {
        lines.push(serde_json::to_string(&event).unwrap());
        match event {
            Event::Status(change) => statuses.push(change.status),
            Event::Fault(fault) => faults.push(fault.kind),
            Event::Block(_) | Event::Summary(_) => {}
        }
    };
    for (samples, broken) in recordings {
        let recording = Recording { name: if *broken { "broken" } else { "clean" }, sample_rate_hz: RATE_HZ };
        if *broken {
            runner.run(&recording, injector.over(in_memory(samples)), &mut on_event);
        } else {
            runner.run(&recording, in_memory(samples), &mut on_event);
        }
    }
    let summary = runner.finish(&mut on_event);
    Told { statuses, faults, summary, injected: injector.injected(), lines }
}

#[test]
fn null_a_clean_signal_is_healthy_and_nothing_else() {
    let told = run("", &[(&common::signal(10_000, 9), true)]);
    assert_eq!(told.statuses, [Status::Starting, Status::Healthy]);
    assert_eq!(told.faults, []);
    let Summary { samples, evaluated, blocks, faults, alarms, first_alarm, .. } = told.summary;
    assert_eq!((samples, faults, alarms, first_alarm), (10_000, FaultCounts::default(), 0, None));
    assert!(evaluated > 9_980 && blocks == evaluated as u32 / common::BLOCK, "{evaluated} {blocks}");
}

#[test]
fn a_sensor_that_is_broken_throughout_is_never_healthy() {
    let samples = common::signal(10_000, 9);
    for plan in ["nan:1", "stuck:1x100000", "saturate:50", "gap:1x7", "nan:0.9", "gap:0.5x40", "drop:0.5", "drop:1"] {
        // Clipping needs a signal that reaches the full scale.
        let loud: Vec<f32> = samples.iter().map(|s| 1000.0 * s).collect();
        let told = run(plan, &[(if plan == "saturate:50" { &loud } else { &samples }, true)]);
        assert!(!told.statuses.contains(&Status::Healthy), "{plan}: {:?}", told.statuses);
        let expected = match plan {
            // A vibration that is beyond the sensor's range most of the time is no sensor's fault.
            "drop:0.5" | "saturate:50" => Status::Anomalous,
            "drop:1" => Status::Starting,
            _ => Status::Blind,
        };
        assert_eq!(told.summary.status, expected, "{plan}");
    }
}

#[test]
fn every_kind_is_counted_and_told() {
    let samples = common::signal(20_000, 9);
    let counted = |plan: &str| {
        let told = run(plan, &[(&samples, true)]);
        (told.summary.faults, told.injected, told.faults, told.summary)
    };
    let (faults, injected, told, _) = counted("nan:0.01");
    assert_eq!(u64::from(faults.non_finite), injected.nan);
    assert_eq!(faults.total(), faults.non_finite);
    assert!(injected.nan > 100 && told.iter().all(|kind| *kind == Quality::NonFinite));

    let (faults, injected, told, summary) = counted("gap:1e-3x20");
    assert_eq!(u64::from(faults.missing), injected.missing);
    assert_eq!(summary.samples + injected.missing, 20_000);
    assert!(!told.is_empty() && told.iter().all(|kind| *kind == Quality::Missing));

    let (faults, injected, told, _) = counted("stuck:1e-3x50");
    // The run is told from its eighth equal sample on, the first of which was a good one.
    let runs = told.len() as u64;
    assert!(runs > 5 && told.iter().all(|kind| *kind == Quality::Stuck));
    assert_eq!(u64::from(faults.stuck), injected.stuck - runs * u64::from(common::STUCK_AFTER - 2));

    let (faults, injected, _, _) = counted("saturate:4");
    assert!(injected.saturated > 1000 && faults.saturated == 0, "below full scale a device cannot tell");
    let loud: Vec<f32> = samples.iter().map(|s| 12.0 * s).collect();
    let told = run("saturate:50", &[(&loud, true)]);
    assert_eq!(u64::from(told.summary.faults.saturated + told.summary.faults.stuck), told.injected.saturated);
    assert!(told.injected.saturated > 100 && told.faults.contains(&Quality::Saturated));

    let (faults, injected, told, _) = counted("flip:0.01");
    // A flipped sign or mantissa bit leaves a plausible number.
    assert!(u64::from(faults.total()) < injected.flipped && told.contains(&Quality::Saturated));
    assert!(faults.saturated > 0 && faults.saturated == faults.total());

    let (faults, injected, told, summary) = counted("drop:0.01");
    assert_eq!((faults.total(), told.len()), (0, 0), "nobody notices");
    assert_eq!(summary.samples + injected.dropped, 20_000);
}

#[test]
fn a_clean_tail_ends_as_if_nothing_had_been() {
    let (head, tail) = (common::signal(5_000, 9), common::signal(10_000, 10));
    let clean = run("", &[(&head, true), (&tail, false)]);
    assert_eq!(clean.summary.status, Status::Healthy);
    for plan in ["nan:0.05", "stuck:1e-3x500", "saturate:2", "flip:0.05", "drop:0.05", "gap:0.01x50"] {
        let told = run(plan, &[(&head, true), (&tail, false)]);
        assert_eq!(told.summary.status, clean.summary.status, "{plan}: {:?}", told.statuses);
    }
}

#[test]
fn a_seed_gives_the_same_faults_and_a_later_fault_leaves_earlier_ones() {
    let samples = common::signal(5_000, 9);
    let arrivals = |plan: &str, seed| -> Vec<u32> {
        let mut injector = Injector::new(plan.parse().unwrap(), seed);
        let bits = |arrival| match arrival {
            Arrival::Sample(sample) => f32::to_bits(sample),
            Arrival::Missing(count) => count,
        };
        injector.over(in_memory(&samples)).map(bits).collect()
    };
    let plan = "gap:1e-3x20,flip:1e-2,drop:1e-2,stuck:1e-3x9";
    assert_eq!(arrivals(plan, 1), arrivals(plan, 1));
    assert_ne!(arrivals(plan, 1), arrivals(plan, 2));
    let nan = |plan| arrivals(plan, 1).iter().enumerate().filter(|(_, b)| **b == f32::NAN.to_bits()).count();
    assert_eq!(nan("nan:1e-2"), nan("nan:1e-2,flip:0,saturate:3"));
}

#[test]
fn golden_events_are_one_flat_json_object_each() {
    let (clean, nan) = (common::signal(1_000, 9), [f32::NAN; 200]);
    let told = run("", &[(&clean, false), (&[&clean[..100], &nan].concat(), true)]);
    let line = |event: &str| {
        let start = format!("{{\"event\":\"{event}\"");
        told.lines.iter().find(|line| line.starts_with(&start)).map_or("", |line| line.as_str())
    };
    assert_eq!(
        line("starting"),
        r#"{"event":"starting","was":null,"recording":"clean","recording_index":0,"sample":0,"time_s":0.0}"#
    );
    assert_eq!(
        line("fault"),
        r#"{"event":"fault","kind":"non-finite","value":null,"recording":"broken","recording_index":1,"sample":100,"time_s":0.00390625}"#
    );
    assert!(line("blind").contains(r#""was":"healthy","recording":"broken""#), "{}", line("blind"));
    assert!(line("blind").contains(r#""level":null,"deviation":null,"ewma":"#));
    assert!(line("summary").contains(r#""faults":{"non_finite":200,"#));
    assert!(line("summary").ends_with(r#""status":"blind","alarms":0,"first_alarm":null}"#));
}

#[test]
fn an_alarm_is_told_with_its_place_and_outlasts_blindness() {
    let (clean, nan) = (common::signal(2_000, 9), [f32::NAN; 200]);
    let loud: Vec<f32> = common::signal(2_000, 10).iter().map(|s| 3.0 * s).collect();
    let told = run("", &[(&clean, false), (&[&loud, &nan[..], &loud].concat(), true), (&clean, false)]);
    let expected =
        [Status::Starting, Status::Healthy, Status::Anomalous, Status::Blind, Status::Anomalous, Status::Healthy];
    assert_eq!(told.statuses, expected);
    assert_eq!(told.summary.alarms, 1);
    let alarm = told.summary.first_alarm.unwrap();
    assert_eq!((alarm.recording.as_str(), alarm.recording_index), ("broken", 1));
    assert!(alarm.sample < 400 && (alarm.time_s - alarm.sample as f64 / RATE_HZ).abs() < 1e-12);
}

#[test]
fn a_model_that_takes_states_is_refused() {
    let mut bytes = common::model(common::SMALL, &common::signal(5_000, 4));
    // Word 4 holds the orders, 0 for states given directly; the last one the CRC.
    let end = bytes.len() - 4;
    bytes[16..20].fill(0);
    let crc = crc32(&bytes[..end]);
    bytes[end..].copy_from_slice(&crc.to_le_bytes());
    let model = Model::from_bytes(&bytes).unwrap();
    let error = Runner::new(&model, &mut [0.0; 1000]).unwrap_err();
    assert_eq!(error, RunnerError::StatesGiven { states: common::SMALL.dimension });
    assert!(error.to_string().contains("takes 3 states directly, expected"));
}
