//! State of each machine of a fleet, worst first.

use std::path::Path;

use rusqlite::params;
use serde::Serialize;
use serde_json::Value;

use super::settings::FleetSettings;
use super::store::{Store, StoreError};

const SETTINGS: FleetSettings = FleetSettings::DEFAULT;
/// Greatest `diagnosis.json` that is read, bytes.
const MAX_DIAGNOSIS: u64 = 64 << 20;

/// Point of a machine's trend.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Deviation of the block; `None` for a blind one.
    pub deviation: Option<f64>,
    /// EWMA, which the limit judges.
    pub ewma: f64,
}

/// Last diagnosis of a machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// `mismatch`, `no-mismatch` or `unexplained`.
    pub verdict: String,
    /// First cause.
    pub cause: Option<String>,
    /// Its probability.
    pub probability: Option<f64>,
}

/// State of a machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Name.
    pub machine: String,
    /// Status in its last message.
    pub status: String,
    /// EWMA in its last message.
    pub ewma: f64,
    /// Limit of the EWMA to both sides.
    pub ewma_limit: f64,
    /// |EWMA| over its limit.
    pub share_of_limit: f64,
    /// Least-squares slope of the EWMA over the trend, limits per 100 blocks; `None` for fewer than 3 blocks.
    pub slope_per_100_blocks: Option<f64>,
    /// Blocks stored.
    pub blocks: u64,
    /// Changes to `anomalous` stored.
    pub alarms: u64,
    /// Runs of broken samples stored.
    pub faults: u64,
    /// Number of messages missing between the first and last of its sessions.
    pub lost: u64,
    /// CRC-32 of its model, hexadecimal.
    pub model: String,
    /// Last message, UTC.
    pub last_heard: String,
    /// Time between its last message and the fleet's, s.
    pub silent_s: f64,
    /// Last diagnosis.
    pub diagnosis: Option<Verdict>,
    /// What to look at next.
    pub look_at: String,
    /// Newest blocks, oldest first.
    pub trend: Vec<Point>,
}

const MACHINES: &str = "
SELECT m.machine, m.status, m.ewma, m.ewma_limit, m.model_crc, a.blocks, a.alarms, a.faults, a.lost,
  strftime('%Y-%m-%d %H:%M', a.received_ms / 1000, 'unixepoch'),
  ((SELECT max(received_ms) FROM messages) - a.received_ms) / 1000.0
FROM (SELECT machine, max(session) AS session, sum(blocks) AS blocks, sum(alarms) AS alarms, sum(faults) AS faults,
    sum(lost) AS lost, max(received_ms) AS received_ms
  FROM (SELECT machine, session, sum(kind = 'block') AS blocks, sum(kind = 'status' AND status = 'anomalous') AS alarms,
      sum(kind = 'fault') AS faults, max(sequence) + 1 - count(*) AS lost, max(received_ms) AS received_ms
    FROM messages GROUP BY machine, session)
  GROUP BY machine) AS a
JOIN messages AS m ON m.machine = a.machine AND m.session = a.session
  AND m.sequence = (SELECT max(sequence) FROM messages WHERE machine = a.machine AND session = a.session)";
const TREND: &str = "
SELECT deviation, ewma FROM messages WHERE machine = ?1 AND kind = 'block' ORDER BY session DESC, sequence DESC LIMIT ?2";

/// Machines of the file, worst first: anomalous, blind, silent, then by share of the limit. `diagnoses` holds
/// `MACHINE/diagnosis.json`, where there is one.
///
/// # Errors
/// Errors of SQLite.
pub fn machines(store: &Store, diagnoses: Option<&Path>) -> Result<Vec<Machine>, StoreError> {
    let mut found = read(store).map_err(|error| store.failed(error))?;
    for machine in &mut found {
        // No name for `..`, which would lead out of the folder.
        let name = Path::new(&machine.machine).file_name();
        machine.diagnosis =
            diagnoses.zip(name).and_then(|(folder, name)| diagnosis(&folder.join(name).join("diagnosis.json")));
        machine.slope_per_100_blocks = slope(&machine.trend).map(|slope| 100.0 * slope / machine.ewma_limit);
        machine.look_at = look_at(machine);
    }
    found.sort_by(|a, b| {
        let key = |m: &Machine| (rank(m), -m.share_of_limit);
        key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal).then_with(|| a.machine.cmp(&b.machine))
    });
    Ok(found)
}

fn read(store: &Store) -> rusqlite::Result<Vec<Machine>> {
    let mut query = store.connection.prepare(MACHINES)?;
    let mut trend = store.connection.prepare(TREND)?;
    let rows = query.query_map([], |row| {
        let (machine, ewma, ewma_limit): (String, f64, f64) = (row.get(0)?, row.get(2)?, row.get(3)?);
        let points = trend.query_map(params![machine, SETTINGS.trend_blocks], |row| {
            Ok(Point { deviation: row.get(0)?, ewma: row.get(1)? })
        })?;
        let mut points = points.collect::<rusqlite::Result<Vec<_>>>()?;
        points.reverse();
        Ok(Machine {
            machine,
            status: row.get(1)?,
            ewma,
            ewma_limit,
            share_of_limit: ewma.abs() / ewma_limit,
            slope_per_100_blocks: None,
            blocks: row.get(5)?,
            alarms: row.get(6)?,
            faults: row.get(7)?,
            lost: row.get(8)?,
            model: format!("{:08x}", row.get::<_, u32>(4)?),
            last_heard: row.get(9)?,
            silent_s: row.get(10)?,
            diagnosis: None,
            look_at: String::new(),
            trend: points,
        })
    })?;
    rows.collect()
}

/// First cause of a diagnosis; `None` where there is none that can be read.
fn diagnosis(path: &Path) -> Option<Verdict> {
    if std::fs::metadata(path).ok()?.len() > MAX_DIAGNOSIS {
        return None;
    }
    let document: Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    let cause = &document["causes"][0];
    Some(Verdict {
        verdict: document["verdict"].as_str()?.to_owned(),
        cause: cause["name"].as_str().map(str::to_owned),
        probability: cause["probability"].as_f64(),
    })
}

/// Least-squares slope of the EWMA, a block.
fn slope(trend: &[Point]) -> Option<f64> {
    let n = trend.len() as f64;
    if trend.len() < 3 {
        return None;
    }
    let centre = (n - 1.0) / 2.0;
    let sum: f64 = trend.iter().enumerate().map(|(k, point)| (k as f64 - centre) * point.ewma).sum();
    Some(sum / (n * (n * n - 1.0) / 12.0))
}

fn is_silent(machine: &Machine) -> bool {
    machine.silent_s > SETTINGS.silent_after.as_secs_f64()
}

/// Rank of the status, the worst 0.
fn rank(machine: &Machine) -> u8 {
    match machine.status.as_str() {
        "anomalous" => 0,
        "blind" => 1,
        _ if is_silent(machine) => 2,
        _ => 3,
    }
}

/// What to look at next, in a sentence.
fn look_at(machine: &Machine) -> String {
    let cause = machine.diagnosis.as_ref().and_then(|diagnosis| diagnosis.cause.as_deref());
    match (machine.status.as_str(), cause) {
        ("anomalous", Some(cause)) => format!("check the machine for {cause}"),
        ("anomalous", None) if machine.ewma < 0.0 => {
            "the residual is below the healthy one: check the sensor, its mounting and its gain".into()
        }
        ("anomalous", None) => "record the machine and run `ballrace diagnose`".into(),
        ("blind", _) => "check the sensor and its cable: too many samples are broken".into(),
        _ if is_silent(machine) => "check power and network of the device: it is silent".into(),
        _ if machine.share_of_limit >= SETTINGS.watch_share => "near its limit: look at the next blocks".into(),
        _ if machine.lost > 0 => "messages are missing: check that the device publishes at QoS 1".into(),
        ("starting", _) => "too few blocks so far".into(),
        _ => "nothing".into(),
    }
}
