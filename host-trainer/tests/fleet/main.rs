//! Telemetry through a real broker, and the page of a fleet in a real browser.
#![cfg(feature = "fleet")]

mod broker;
mod message;
mod page;
#[path = "../support/mod.rs"]
mod support;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use ballrace::fleet::link::Link;
use ballrace::fleet::publish::Publisher;
use ballrace_core::telemetry::MESSAGE_LEN;
use broker::{Broker, program};
use message::block;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use rumqttc::{Client, Event, MqttOptions, Packet, QoS};
use serde_json::Value;
use support::{ballrace, done, refused, text};

fn stored(file: &Path) -> Vec<(String, u32)> {
    let connection = rusqlite::Connection::open(file).unwrap();
    let mut query = connection.prepare("SELECT machine, sequence FROM messages ORDER BY machine, sequence").unwrap();
    query.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).unwrap().map(Result::unwrap).collect()
}

/// Sequence numbers in all Parquet files of a folder `machine=NAME`, and the number of files.
fn in_parquet(folder: &Path) -> (Vec<u32>, usize) {
    let days = fs::read_dir(folder).unwrap().map(|day| day.unwrap().path());
    let files: Vec<_> = days.flat_map(|day| fs::read_dir(day).unwrap()).map(|file| file.unwrap().path()).collect();
    let mut sequences = Vec::new();
    for file in &files {
        let reader = SerializedFileReader::new(fs::File::open(file).unwrap()).unwrap();
        for row in reader.get_row_iter(None).unwrap() {
            sequences.push(u32::try_from(row.unwrap().get_long(1).unwrap()).unwrap());
        }
    }
    sequences.sort_unstable();
    (sequences, files.len())
}

/// A collector without an end, once it is connected.
fn collector(folder: &Path, address: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ballrace"));
    command.current_dir(folder).args(["collect", address, "--out", "fleet.sqlite", "--parquet", "parts"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    assert!(line.starts_with("connected"), "{line}");
    // Its later lines are read so that it never waits for room.
    std::thread::spawn(move || std::io::copy(&mut errors, &mut std::io::sink()));
    child
}

/// Publishes payloads as they are, and waits for their acknowledgements.
fn publish_raw(port: u16, messages: &[(&str, &[u8])]) {
    let mut options = MqttOptions::new("raw", "127.0.0.1", port);
    options.set_max_packet_size(1 << 20, 1 << 20);
    let (client, mut connection) = Client::new(options, 100);
    for (topic, payload) in messages {
        client.publish(*topic, QoS::AtLeastOnce, false, payload.to_vec()).unwrap();
    }
    let events = connection.iter().map(|event| event.expect("a connection that stays"));
    let acknowledged = events.filter(|event| matches!(event, Event::Incoming(Packet::PubAck(_))));
    assert_eq!(acknowledged.take(messages.len()).count(), messages.len());
}

#[test]
fn invariant_each_message_once_though_collector_and_broker_are_killed() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut broker) = Broker::start(folder.path(), "allow_anonymous true") else { return };
    let address = format!("mqtt://127.0.0.1:{}/plant", broker.port);
    let mut child = collector(folder.path(), &address);
    let link = Link::new(&address, None, None, None).unwrap();
    let publisher = Publisher::connect(&link, "pump").unwrap();
    let count = 3000;
    for sequence in 0..count {
        publisher.send(block("pump", sequence));
        std::thread::sleep(Duration::from_micros(300));
        match sequence {
            700 => {
                child.kill().unwrap();
                child.wait().unwrap();
            }
            1200 => child = collector(folder.path(), &address),
            1700 => broker.stop(),
            1900 => broker.restart(),
            // Killed while the messages of the broker's stop are under way.
            2200 => {
                child.kill().unwrap();
                child.wait().unwrap();
            }
            _ => {}
        }
    }
    assert_eq!(publisher.finish().unwrap(), count as usize);
    // The second run wrote, as it began, what the first had stored.
    let (before, files) = in_parquet(&folder.path().join("parts/machine=pump"));
    assert!(!before.is_empty() && before.len() < count as usize && files <= 2, "{} in {files}", before.len());
    let arguments = ["collect", &address, "--out", "fleet.sqlite", "--parquet", "parts", "--until-idle", "1", "--json"];
    let collected: Value = serde_json::from_str(&done(folder.path(), &arguments)).unwrap();
    let expected: Vec<_> = (0..count).map(|sequence| ("pump".to_owned(), sequence)).collect();
    assert_eq!(stored(&folder.path().join("fleet.sqlite")), expected);
    assert_eq!(collected["in_all"]["accepted"], count, "{collected}");
    let (sequences, files) = in_parquet(&folder.path().join("parts/machine=pump"));
    assert!(sequences.into_iter().eq(0..count) && files <= 2, "{files} files");
    // What was stored before the first kill was not sent for nothing.
    assert!(collected["counts"]["accepted"].as_u64().unwrap() < u64::from(count), "{collected}");
}

#[test]
fn what_is_no_message_of_a_known_machine_is_counted_and_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let Some(broker) = Broker::start(folder.path(), "allow_anonymous true") else { return };
    let address = format!("mqtt://127.0.0.1:{}/plant", broker.port);
    fs::write(folder.path().join("machines.txt"), "# known\npump\nfan\n").unwrap();
    let arguments =
        ["collect", &address, "--out", "fleet.sqlite", "--machines", "machines.txt", "--until-idle", "0.5", "--json"];
    // The first run makes the session.
    done(folder.path(), &arguments);
    let (good, fan, stranger) = (block("pump", 0), block("fan", 0), block("stranger", 0));
    let mut flipped = block("pump", 1);
    flipped[60] ^= 4;
    let long = [&good[..], &[0; 300_000]].concat();
    publish_raw(
        broker.port,
        &[
            ("plant/pump", &good),
            ("plant/fan", &fan),
            ("plant/pump", &good),
            ("plant/pump", &long),
            ("plant/pump", &good[..MESSAGE_LEN - 1]),
            ("plant/pump", &flipped),
            ("plant/pump", b""),
            ("plant/fan", &good),
            ("plant/pump/deeper", &good),
            ("plant/stranger", &stranger),
            ("elsewhere/pump", &block("pump", 5)),
            ("plant/pump", &block("pump", 2)),
        ],
    );
    let collected: Value = serde_json::from_str(&done(folder.path(), &arguments)).unwrap();
    let counts = &collected["counts"];
    let count = |name: &str| counts[name].as_u64().unwrap();
    assert_eq!([count("accepted"), count("duplicates")], [3, 1], "{counts}");
    assert_eq!([count("too_long"), count("malformed"), count("unknown_machine")], [1, 5, 1], "{counts}");
    let file = folder.path().join("fleet.sqlite");
    assert_eq!(stored(&file), [("fan".into(), 0), ("pump".into(), 0), ("pump".into(), 2)]);
}

fn openssl(folder: &Path, arguments: &str) {
    let output = Command::new("openssl").current_dir(folder).args(arguments.split(' ')).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// A recording whose second half is louder, and the least model as `model.json`.
fn machine(folder: &Path) {
    let rows: String = (0..25_600u32)
        .map(|k| format!("{}\n", f64::from(k * 7919 % 1009 / 10) * if k < 12_800 { 0.01 } else { 1.0 }))
        .collect();
    fs::write(folder.join("r01.csv"), format!("ay\n{rows}")).unwrap();
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/examples/least.json");
    fs::copy(model, folder.join("model.json")).unwrap();
}

#[test]
fn tls_and_a_password_carry_the_events_of_monitor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let (Some(passwords), Some(_)) = (program("mosquitto_passwd"), program("openssl")) else { return };
    openssl(
        path,
        "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout ca.key -out ca.pem -subj /CN=test-ca -days 2",
    );
    openssl(
        path,
        "req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout server.key -out server.csr -subj /CN=broker",
    );
    fs::write(path.join("names"), "subjectAltName=IP:127.0.0.1\nbasicConstraints=CA:FALSE\n").unwrap();
    openssl(
        path,
        "x509 -req -in server.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out server.pem -days 2 -extfile names",
    );
    let status = Command::new(passwords).current_dir(path).args(["-b", "-c", "users", "plant", "secret"]).status();
    assert!(status.unwrap().success());
    let folder_name = path.display();
    let settings = format!(
        "allow_anonymous false\npassword_file {folder_name}/users\n\
         cafile {folder_name}/ca.pem\ncertfile {folder_name}/server.pem\nkeyfile {folder_name}/server.key"
    );
    let Some(broker) = Broker::start(path, &settings) else { return };
    let address = format!("mqtts://127.0.0.1:{}/plant", broker.port);
    machine(path);
    fs::write(path.join("password"), "secret\n").unwrap();
    fs::write(path.join("wrong"), "guess\n").unwrap();
    let credentials = |file| ["--ca", "ca.pem", "--user", "plant", "--password-file", file];
    let collect = ["collect", &address, "--out", "fleet.sqlite", "--until-idle", "0.5"];
    let monitor = ["monitor", "--model", "model.json", "r01.csv", "--sample-rate", "25600", "--unit", "m/s^2"];
    let publish = ["--publish", &address, "--machine", "pump", "--blocks"];

    let error = refused(path, &[&collect[..], &credentials("wrong")].concat());
    assert!(error.contains("127.0.0.1") && error.contains("user or password"), "{error}");
    let error = refused(path, &[&monitor[..], &publish, &credentials("wrong")].concat());
    assert!(error.contains("127.0.0.1") && error.contains("user or password"), "{error}");
    assert!(!error.contains("guess"), "{error}");
    // An authority that did not sign the broker's certificate.
    openssl(
        path,
        "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout x.key -out other.pem -subj /CN=x -days 2",
    );
    let error = refused(
        path,
        &[&collect[..], &["--ca", "other.pem", "--user", "plant", "--password-file", "password"]].concat(),
    );
    assert!(error.contains("TLS"), "{error}");

    done(path, &[&collect[..], &credentials("password")].concat());
    let printed = done(path, &[&monitor[..], &publish, &credentials("password")].concat());
    done(path, &[&collect[..], &credentials("password")].concat());
    let connection = rusqlite::Connection::open(path.join("fleet.sqlite")).unwrap();
    let mut query = connection.prepare("SELECT kind, status, block, ewma FROM messages ORDER BY sequence").unwrap();
    let rows: Vec<(String, String, u32, f64)> = query
        .query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?)))
        .unwrap()
        .map(Result::unwrap)
        .collect();
    // The rows are the events that `monitor` printed, in order and to the bit.
    let events: Vec<Value> = printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let events: Vec<&Value> = events.iter().filter(|event| event["event"] != "recording").collect();
    assert_eq!(rows.len(), events.len());
    assert!(rows.iter().any(|row| row.1 == "anomalous"), "{rows:?}");
    for ((kind, status, block, ewma), event) in rows.iter().zip(events) {
        let named = event["event"].as_str().unwrap();
        assert_eq!(if kind == "status" { status } else { kind }, named);
        if kind == "block" {
            assert_eq!(
                (event["block"].as_u64(), event["ewma"].as_f64().map(|e| e as f32)),
                (Some((*block).into()), Some(*ewma as f32))
            );
        }
    }
}

#[test]
fn bad_input_says_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let error = refused(path, &["collect", "http://broker", "--out", "fleet.sqlite"]);
    assert!(error.contains("mqtt://HOST"), "{error}");
    let error = refused(path, &["collect", "mqtt://broker", "--out", "fleet.sqlite", "--user", "me"]);
    assert!(error.contains("--password-file"), "{error}");
    fs::write(path.join("file"), "").unwrap();
    let error = refused(path, &["collect", "mqtt://broker", "--out", "f.sqlite", "--parquet", "file"]);
    assert!(error.contains("--parquet: found file, expected a folder"), "{error}");
    let error = refused(path, &["collect", "mqtt://broker", "--out", "f.sqlite", "--until-idle=-1"]);
    assert!(error.contains("--until-idle"), "{error}");
    fs::write(path.join("other.sqlite"), "text, not a database, of more than a hundred bytes. ".repeat(20)).unwrap();
    for arguments in [&["fleet", "other.sqlite"][..], &["collect", "mqtt://127.0.0.1:1", "--out", "other.sqlite"]] {
        let error = refused(path, arguments);
        assert!(error.contains("other.sqlite") && error.contains("no SQLite file"), "{error}");
    }
    assert!(refused(path, &["fleet", "absent.sqlite"]).contains("no file"));
    assert!(!path.join("absent.sqlite").exists());
    let unreachable = ballrace(path, &["collect", "mqtt://127.0.0.1:1", "--out", "fleet.sqlite"]);
    assert_eq!(unreachable.status.code(), Some(1));
    assert!(text(&unreachable.stderr).contains("127.0.0.1:1: no connection"), "{}", text(&unreachable.stderr));
}
