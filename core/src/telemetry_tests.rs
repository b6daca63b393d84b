extern crate std;
use std::vec::Vec;

use super::*;

fn block() -> Message<'static> {
    Message {
        machine: "pump-7 ä",
        session: 0x0102_0304_0506_0708,
        sequence: 9,
        model_crc: 0xdead_beef,
        unix_ms: 1_700_000_000_123,
        recording: 3,
        time_s: 0.25,
        status: Status::Anomalous,
        kind: Kind::Block,
        block: 17,
        level: 2.5,
        deviation: -1.5,
        ewma: 3.25,
        limit: 3.0,
    }
}

fn every_kind() -> Vec<Message<'static>> {
    let faults = FaultCounts { non_finite: 1, saturated: 2, stuck: 3, missing: u32::MAX };
    let qualities = [Quality::NonFinite, Quality::Saturated, Quality::Stuck, Quality::Missing];
    let statuses = [Status::Starting, Status::Healthy, Status::Anomalous, Status::Blind];
    let mut kinds = std::vec![Kind::Block, Kind::Status { was: None }, Kind::Summary { faults, alarms: 5 }];
    kinds.extend(qualities.map(|quality| Kind::Fault { quality, value: -4.5 }));
    kinds.extend(statuses.map(|status| Kind::Status { was: Some(status) }));
    let messages = kinds.into_iter().flat_map(|kind| statuses.map(|status| Message { kind, status, ..block() }));
    messages.collect()
}

fn encoded(message: &Message<'_>) -> [u8; MESSAGE_LEN] {
    let mut bytes = [0; MESSAGE_LEN];
    assert_eq!(message.encode(&mut bytes), Ok(MESSAGE_LEN));
    bytes
}

/// Puts the CRC right.
fn sealed(mut bytes: [u8; MESSAGE_LEN]) -> [u8; MESSAGE_LEN] {
    let crc = crc32(&bytes[..MESSAGE_LEN - 4]);
    bytes[MESSAGE_LEN - 4..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

#[test]
fn golden_bytes_of_a_block() {
    let bytes = encoded(&block());
    let mut expected: Vec<u8> = Vec::new();
    expected.extend(b"BRTM\x01\x02\x02\x00pump-7 \xc3\xa4");
    expected.extend([0; 23]);
    expected.extend([8, 7, 6, 5, 4, 3, 2, 1, 9, 0, 0, 0, 0xef, 0xbe, 0xad, 0xde]);
    expected.extend([0x7b, 0x68, 0xe5, 0xcf, 0x8b, 0x01, 0, 0, 3, 0, 0, 0]);
    expected.extend([0, 0, 0, 0, 0, 0, 0xd0, 0x3f, 17, 0, 0, 0]);
    expected.extend([0, 0, 0x20, 0x40, 0, 0, 0xc0, 0xbf, 0, 0, 0x50, 0x40, 0, 0, 0x40, 0x40]);
    expected.extend([0; 24]);
    assert_eq!(bytes[..120], expected[..]);
    assert_eq!(bytes[120..], crc32(&expected).to_le_bytes());
}

#[test]
fn invariant_every_kind_reads_back() {
    for message in every_kind() {
        assert_eq!(Message::decode(&encoded(&message)), Ok(message));
    }
    let blind = Message { level: f32::NAN, deviation: f32::NAN, ..block() };
    let bytes = encoded(&blind);
    let read = Message::decode(&bytes).unwrap();
    assert!(read.level.is_nan() && read.deviation.is_nan());
    assert_eq!(encoded(&read), bytes);
}

#[test]
fn every_flipped_bit_and_every_other_length_is_refused() {
    for message in every_kind() {
        let bytes = encoded(&message);
        for bit in 0..8 * MESSAGE_LEN {
            let mut flipped = bytes;
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(Message::decode(&flipped).is_err(), "bit {bit}");
        }
        for end in 0..MESSAGE_LEN {
            assert_eq!(Message::decode(&bytes[..end]), Err(TelemetryError::Length { found: end }));
        }
    }
    let mut long = encoded(&block()).to_vec();
    long.push(0);
    assert_eq!(Message::decode(&long), Err(TelemetryError::Length { found: MESSAGE_LEN + 1 }));
}

#[test]
fn what_no_device_writes_is_refused_whatever_its_checksum() {
    let with = |at: usize, byte: u8| {
        let mut bytes = encoded(&block());
        bytes[at] = byte;
        Message::decode(&sealed(bytes)).map(|message| message.kind)
    };
    assert_eq!(with(5, 5), Err(TelemetryError::Code { byte: 5, found: 5 }));
    assert_eq!(with(6, 4), Err(TelemetryError::Code { byte: 6, found: 4 }));
    assert_eq!(with(7, 1), Err(TelemetryError::Unused));
    assert_eq!(with(100, 1), Err(TelemetryError::Unused));
    assert_eq!(with(4, 2), Err(TelemetryError::Version { found: 2 }));
    for (at, byte) in [(8, 0), (8, b'/'), (8, 0xff), (9, 7), (39, 1)] {
        assert_eq!(with(at, byte), Err(TelemetryError::Name), "{at} {byte}");
    }
    // A negative limit.
    assert_eq!(with(95, 0xc0), Err(TelemetryError::Statistic));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let mut bytes = [0; MESSAGE_LEN + 8];
    for machine in ["", "a/b", "+", "a#", "\n", "$SYS", "0123456789012345678901234567890123"] {
        assert_eq!(Message { machine, ..block() }.encode(&mut bytes), Err(TelemetryError::Name), "{machine}");
    }
    assert_eq!(bytes, [0; MESSAGE_LEN + 8], "nothing half-written");
    let found = MESSAGE_LEN - 1;
    assert_eq!(block().encode(&mut bytes[..found]), Err(TelemetryError::Length { found }));
    for limit in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(Message { limit, ..block() }.encode(&mut bytes), Err(TelemetryError::Statistic));
    }
    let kind = Kind::Fault { quality: Quality::Good, value: 0.0 };
    assert!(Message { kind, ..block() }.encode(&mut bytes).is_err());
}
