//! A message of a healthy machine, for the tests and the benchmark.

use ballrace_core::monitor::Status;
use ballrace_core::telemetry::{Kind, MESSAGE_LEN, Message};

/// Block `sequence` of a machine.
pub fn block(machine: &str, sequence: u32) -> [u8; MESSAGE_LEN] {
    let message = Message {
        machine,
        session: 1,
        sequence,
        model_crc: 7,
        unix_ms: 1_700_000_000_000,
        recording: 0,
        time_s: 0.5,
        status: Status::Healthy,
        kind: Kind::Block,
        block: sequence + 1,
        level: 1.0,
        deviation: 0.1,
        ewma: 0.2,
        limit: 3.0,
    };
    let mut bytes = [0; MESSAGE_LEN];
    message.encode(&mut bytes).unwrap();
    bytes
}
