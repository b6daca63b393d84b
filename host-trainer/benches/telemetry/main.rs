//! Messages a second from a broker into SQLite: `collect` beside paho-mqtt and sqlite3, each from a session at the same
//! mosquitto that holds the same messages. `BALLRACE_PYTHON` names a Python with paho-mqtt 2.

#[path = "../../tests/fleet/message.rs"]
mod message;

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use ballrace::fleet::collect::{Notice, Options, collect};
use ballrace::fleet::link::Link;
use ballrace::fleet::publish::Publisher;
use ballrace::fleet::store::Store;

const MESSAGES: u32 = 3_000;
const PORT: u16 = 18_830;

/// Seconds from the first to the last message in the file of `collect`.
fn ours(link: &Link, file: &Path) -> f64 {
    let mut store = Store::open(file).expect("a file");
    let options = Options { until_idle: Some(Duration::from_millis(500)), ..Options::default() };
    let (mut first, mut last) = (None, Instant::now());
    collect(link, &mut store, &options, &mut |notice| match notice {
        Notice::Connected { .. } => first = Some(Instant::now()),
        Notice::Stored(_) => last = Instant::now(),
        Notice::Lost { error, .. } => panic!("{error}"),
    })
    .expect("a broker");
    last.saturating_duration_since(first.expect("a connection")).as_secs_f64()
}

fn peer(python: &str, file: &Path, count: u32) -> f64 {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/telemetry/peer.py");
    let output = Command::new(python).arg(script).arg(file).arg(PORT.to_string()).arg(count.to_string()).output();
    let output = output.expect("BALLRACE_PYTHON runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().parse().expect("seconds")
}

struct Broker(Child);

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("mosquitto.conf");
    let limits = "max_queued_messages 0\nmax_inflight_messages 1000\nallow_anonymous true";
    std::fs::write(&config, format!("user root\nlistener {PORT} 127.0.0.1\n{limits}\n")).expect("a file");
    let mut command = Command::new("mosquitto");
    let broker = command.arg("-c").arg(&config).stderr(Stdio::null()).spawn().expect("mosquitto in PATH");
    let _broker = Broker(broker);
    std::thread::sleep(Duration::from_secs(1));

    let python = std::env::var("BALLRACE_PYTHON").ok();
    let link = Link::new(&format!("mqtt://127.0.0.1:{PORT}/plant"), None, None, None).expect("an address");
    let (our_file, peer_file) = (folder.path().join("ours.sqlite"), folder.path().join("peer.sqlite"));
    // Both make their sessions; then the broker holds every message for each.
    ours(&link, &our_file);
    if let Some(python) = &python {
        peer(python, &peer_file, 0);
    }
    let mut ratios = Vec::new();
    for round in 0..3 {
        let publisher = Publisher::connect(&link, "pump").expect("a broker");
        (0..MESSAGES).for_each(|k| publisher.send(message::block("pump", round * MESSAGES + k)));
        publisher.finish().expect("acknowledgements");
        let ours = f64::from(MESSAGES) / ours(&link, &our_file);
        print!("collect {ours:.0} messages/s");
        if let Some(python) = &python {
            let peer = f64::from(MESSAGES) / peer(python, &peer_file, MESSAGES);
            ratios.push(ours / peer);
            print!(", paho-mqtt and sqlite3 {peer:.0} messages/s, ratio {:.2}", ours / peer);
        }
        println!();
    }
    let stored = Store::read(&our_file).and_then(|store| store.counts()).expect("a file").accepted;
    assert_eq!(stored, u64::from(3 * MESSAGES));
    ratios.sort_by(f64::total_cmp);
    if let Some(median) = ratios.get(1) {
        println!("median ratio {median:.2}");
    }
}
