//! The page of a fleet in a headless browser.

use std::path::Path;
use std::process::{Command, Output};

use ballrace::fleet::store::{Received, Store};
use ballrace_core::monitor::Status;
use ballrace_core::telemetry::{Kind, MESSAGE_LEN, Message};
use serde_json::Value;

use crate::broker::program;
use crate::support::{done, text};

const RECEIVED_MS: i64 = 1_700_000_000_000;

/// A fleet of four machines: one that drifts into an anomaly, one blind, one near its limit, one healthy.
fn fleet(file: &Path) {
    let mut store = Store::open(file).unwrap();
    let machines = [
        ("fan-2", Status::Healthy, 0.1, 0.3),
        ("mill <1> & \"co\"", Status::Blind, 0.2, 0.4),
        ("pump-1", Status::Anomalous, 0.3, 9.0),
        ("gear-4", Status::Healthy, 0.5, 2.4),
    ];
    for (machine, last, first_ewma, last_ewma) in machines {
        for k in 0..200u32 {
            let ewma = first_ewma + (last_ewma - first_ewma) * (k as f32 / 199.0).powi(2);
            let status = if k == 199 { last } else { Status::Healthy };
            let kind = if k == 199 { Kind::Status { was: Some(Status::Healthy) } } else { Kind::Block };
            let deviation = ewma + 0.5 * (k as f32 * 1.7).sin();
            let message = Message {
                machine,
                session: 1,
                sequence: k,
                model_crc: 0xabc,
                unix_ms: 1_700_000_000_000,
                recording: 0,
                time_s: 0.0,
                status,
                kind,
                block: k + 1,
                level: 1.0,
                deviation,
                ewma,
                limit: 3.0,
            };
            let mut bytes = [0; MESSAGE_LEN];
            message.encode(&mut bytes).unwrap();
            store.take(&[Received::Message(Message::decode(&bytes).unwrap())], RECEIVED_MS).unwrap();
        }
    }
    store.take(&[Received::TooLong, Received::Malformed, Received::Malformed], RECEIVED_MS).unwrap();
}

/// Runs the browser on the page.
fn browser(folder: &Path, arguments: &[&str]) -> Option<Output> {
    let mut command = Command::new(program("chromium")?);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]);
    command.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
    command.args(["--hide-scrollbars", "--enable-logging=stderr", "--virtual-time-budget=2000"]);
    command.arg(format!("--user-data-dir={}", folder.join("browser").display()));
    command.args(arguments).arg(format!("file://{}", folder.join("fleet.html").display()));
    Some(command.output().unwrap())
}

#[test]
fn the_worst_machine_comes_first_in_a_browser_without_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fleet(&path.join("fleet.sqlite"));
    std::fs::create_dir_all(path.join("diagnoses/pump-1")).unwrap();
    let diagnosis = r#"{"verdict": "mismatch", "causes": [{"name": "outer-race-defect", "probability": 0.97}]}"#;
    std::fs::write(path.join("diagnoses/pump-1/diagnosis.json"), diagnosis).unwrap();
    let arguments = ["fleet", "fleet.sqlite", "--diagnoses", "diagnoses", "--report", "fleet.html", "--json"];
    let printed: Value = serde_json::from_str(&done(path, &arguments)).unwrap();
    let names: Vec<&str> =
        printed["machines"].as_array().unwrap().iter().map(|m| m["machine"].as_str().unwrap()).collect();
    assert_eq!(names, ["pump-1", "mill <1> & \"co\"", "gear-4", "fan-2"]);
    assert_eq!(printed["machines"][0]["share_of_limit"], 3.0);
    assert_eq!(printed["machines"][0]["alarms"], 1);

    let Some(output) = browser(path, &["--dump-dom"]) else { return };
    let (dom, log) = (text(&output.stdout), String::from_utf8_lossy(&output.stderr).into_owned());
    assert!(output.status.success(), "{log}");
    assert!(!log.contains("CONSOLE"), "{log}");
    let place = |what: &str| dom.find(what).unwrap_or_else(|| panic!("{what} is not on the page"));
    assert!(place("<td>pump-1</td>") < place("<td>mill &lt;1&gt; &amp; \"co\"</td>"));
    assert!(place("<td>gear-4</td>") < place("<td>fan-2</td>"));
    for expected in [
        "1 of 4 machines anomalous, 1 blind",
        "check the machine for outer-race-defect",
        "mismatch: outer-race-defect, probability 0.97",
        "check the sensor and its cable",
        "near its limit",
        "<td class=\"number\">3.00</td>",
        "<td class=\"number\">800</td>",
        "<h2>pump-1: anomalous</h2>",
    ] {
        place(expected);
    }
    assert_eq!(dom.matches("<svg").count(), 4);
    // For eyes: BALLRACE_SCREENSHOTS names a folder.
    let Some(screenshots) = std::env::var_os("BALLRACE_SCREENSHOTS") else { return };
    for (name, size, dark) in [("light", "1100,1500", false), ("dark", "1100,1500", true), ("phone", "390,1500", false)]
    {
        let file = format!("--screenshot={}", Path::new(&screenshots).join(format!("{name}.png")).display());
        let size = format!("--window-size={size}");
        let dark =
            if dark { "--blink-settings=preferredColorScheme=0" } else { "--blink-settings=preferredColorScheme=1" };
        browser(path, &[&file, &size, dark]);
    }
}
