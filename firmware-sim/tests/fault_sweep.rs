//! `firmware-sim/fault-sweep.md`: what every fault does to the device, swept in rate and length. `BALLRACE_BLESS=1` writes it
//! anew.

use std::fmt::Write;
use std::path::Path;

use ballrace_core::model::Model;
use ballrace_core::monitor::Status;
use ballrace_firmware_sim::event::Event;
use ballrace_firmware_sim::faults::{FaultPlan, Injector};
use ballrace_firmware_sim::runner::{Recording, Runner};
use ballrace_firmware_sim::source::in_memory;

mod common;

const HEAD: &str = "\
# What faults do to the device

Made by `BALLRACE_BLESS=1 cargo test --release -p ballrace-firmware-sim --test fault_sweep`; the test holds it.

A small random network (3 states, 12 units), made-up vibration, blocks of 64 samples, `stuck_after` 8, full scale as the fit
derives it, 64 times the greatest healthy magnitude. Each row is 10 runs of a healthy machine, and 10 of one whose vibration
doubles while the fault lasts. A run: 100 blocks without the fault, 400 with it, 100 with it after the change, 100 without.

- **seen**: share of the injected samples that the input check counts (of `flip` the bits that matter are few; of `stuck` the
  first seven equal samples are plausible).
- **blind**: share of the blocks during the fault that have no level.
- **false alarms**: runs of the healthy machine with an alarm during the fault.
- **kept**: changes that raise the alarm within 100 blocks. **delay**: blocks from the change to the alarm, median of these; 0: it was up.
- **recovery**: blocks from the end of the fault until the healthy machine is healthy and stays so, median and greatest; –
  where a run does not recover within 100.

| fault | seen | blind | false alarms | kept | delay | recovery |
|---|---|---|---|---|---|---|
";

/// Rates a sample, and lengths in samples, of every fault.
const PLANS: &[&str] = &[
    "",
    "nan:1e-4",
    "nan:1e-3",
    "nan:1e-2",
    "nan:0.1",
    "gap:1e-4x1",
    "gap:1e-4x20",
    "gap:1e-4x1000",
    "gap:1e-2x1",
    "gap:1e-2x20",
    "gap:1e-2x1000",
    "stuck:1e-4x4",
    "stuck:1e-4x20",
    "stuck:1e-4x1000",
    "stuck:1e-2x4",
    "stuck:1e-2x20",
    "stuck:1e-2x1000",
    "flip:1e-5",
    "flip:1e-4",
    "flip:1e-3",
    "flip:1e-2",
    "flip:0.1",
    "drop:1e-4",
    "drop:1e-3",
    "drop:1e-2",
    "drop:0.1",
    "saturate:5",
    "saturate:4",
    "saturate:2",
    "saturate:0.5",
];
const RUNS: u32 = 10;
const BEFORE: usize = 100;
const DURING: usize = 400;
const AFTER: usize = 100;

/// What one run shows.
struct Outcome {
    injected: u64,
    seen: u64,
    blind: usize,
    blocks: usize,
    alarm: bool,
    /// Blocks from the change to the alarm.
    delay: Option<usize>,
    /// Blocks from the end of the fault to a lasting healthy status.
    recovery: Option<usize>,
}

fn samples(blocks: usize, seed: u32, gain: f32) -> Vec<f32> {
    common::signal(blocks * common::BLOCK as usize, seed).iter().map(|s| gain * s).collect()
}

fn run(model: &Model<'_>, plan: &FaultPlan, seed: u32, changes: bool) -> Outcome {
    let mut scratch = vec![0.0; Runner::scratch_len(model)];
    let mut runner = Runner::new(model, &mut scratch).unwrap();
    let mut injector = Injector::new(plan.clone(), seed.into());
    let mut part = |runner: &mut Runner<'_, '_>, samples: &[f32], broken: bool| {
        let (mut statuses, recording) = (Vec::new(), Recording { name: "", sample_rate_hz: 25_600.0 });
        let on_event = |event: Event<'_>| {
            if let Event::Block(block) = event {
                statuses.push(block.status);
            }
        };
        if broken {
            runner.run(&recording, injector.over(in_memory(samples)), on_event);
        } else {
            runner.run(&recording, in_memory(samples), on_event);
        }
        statuses
    };
    let gain = if changes { 2.0 } else { 1.0 };
    part(&mut runner, &samples(BEFORE, 4 * seed, 1.0), false);
    let during = part(&mut runner, &samples(DURING, 4 * seed + 1, 1.0), true);
    let changed = part(&mut runner, &samples(AFTER, 4 * seed + 2, gain), true);
    let after = part(&mut runner, &samples(AFTER, 4 * seed + 3, 1.0), false);
    let faults = runner.finish(|_| ()).faults;
    let injected = injector.injected();
    let is = |wanted: Status| move |status: &Status| *status == wanted;
    let healthy_from = after.iter().rposition(|status| *status != Status::Healthy).map_or(0, |last| last + 1);
    Outcome {
        injected: injected.missing
            + injected.stuck
            + injected.saturated
            + injected.nan
            + injected.flipped
            + injected.dropped,
        seen: faults.total().into(),
        blind: during.iter().filter(|status| is(Status::Blind)(status)).count(),
        blocks: during.len(),
        alarm: during.iter().chain(&changed).any(is(Status::Anomalous)),
        delay: changed.iter().position(is(Status::Anomalous)),
        recovery: (healthy_from < after.len()).then_some(healthy_from),
    }
}

fn median(mut values: Vec<usize>) -> String {
    values.sort_unstable();
    values.get(values.len() / 2).map_or("–".into(), |median| median.to_string())
}

fn row(model: &Model<'_>, text: &str) -> String {
    let plan: FaultPlan = text.parse().unwrap();
    let outcomes = |changes| -> Vec<_> { (0..RUNS).map(|seed| run(model, &plan, seed, changes)).collect() };
    let (healthy, changed) = (outcomes(false), outcomes(true));
    let share = |part: u64, whole: u64| match whole {
        0 => "–".into(),
        _ => format!("{:.1} %", 100.0 * part as f64 / whole as f64),
    };
    let sum = |of: fn(&Outcome) -> u64| healthy.iter().map(of).sum::<u64>();
    let recoveries: Option<Vec<_>> = healthy.iter().map(|outcome| outcome.recovery).collect();
    let recovery = recoveries.map_or("–".into(), |all| {
        let greatest = all.iter().max().copied().unwrap_or(0);
        format!("{}, {greatest}", median(all))
    });
    let delays: Vec<_> = changed.iter().filter_map(|outcome| outcome.delay).collect();
    format!(
        "| {} | {} | {} | {} | {} | {} | {recovery} |\n",
        if text.is_empty() { "none".into() } else { format!("`{text}`") },
        share(sum(|outcome| outcome.seen), sum(|outcome| outcome.injected)),
        share(sum(|outcome| outcome.blind as u64), sum(|outcome| outcome.blocks as u64)),
        healthy.iter().filter(|outcome| outcome.alarm).count(),
        delays.len(),
        median(delays.clone()),
    )
}

#[test]
fn golden_faults_swept_in_rate_and_length() {
    let healthy = common::signal(20_000, 4);
    let greatest = healthy.iter().fold(0.0f32, |greatest, sample| greatest.max(sample.abs()));
    let bytes = common::model(common::Sizes { full_scale: 64.0 * greatest, ..common::SMALL }, &healthy);
    let model = Model::from_bytes(&bytes).unwrap();
    let mut table = String::from(HEAD);
    let rows: Vec<_> = std::thread::scope(|scope| {
        let halves = PLANS.chunks(PLANS.len().div_ceil(2)).map(|half| {
            let model = &model;
            scope.spawn(move || half.iter().map(|plan| row(model, plan)).collect::<String>())
        });
        halves.collect::<Vec<_>>().into_iter().map(|half| half.join().unwrap()).collect()
    });
    rows.iter().for_each(|rows| table.write_str(rows).unwrap());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fault-sweep.md");
    if std::env::var_os("BALLRACE_BLESS").is_some() {
        std::fs::write(&path, &table).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    for (stored, found) in stored.lines().zip(table.lines()) {
        assert_eq!(stored, found);
    }
    assert_eq!(stored, table);
}
