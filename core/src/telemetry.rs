//! Messages from a device to the broker of a fleet: fixed length, little-endian, with a CRC-32.
//!
//! | bytes | content |
//! |---|---|
//! | 0…3 | magic `BRTM` |
//! | 4 | format version, 1 |
//! | 5 | kind: 1 status change, 2 block, 3 fault, 4 summary |
//! | 6 | status: 0 starting, 1 healthy, 2 anomalous, 3 blind |
//! | 7 | status change: status before, 255 none; fault: 1 non-finite, 2 saturated, 3 stuck, 4 missing; else 0 |
//! | 8…39 | name of the machine, UTF-8, filled up with zeros |
//! | 40…47 | session (u64): greater after every start of the device |
//! | 48…51 | sequence number within the session, from 0 |
//! | 52…55 | CRC-32 of the model's binary form |
//! | 56…63 | clock, ms since 1970-01-01 UTC (u64); 0 on a device without one |
//! | 64…67 | index of the recording |
//! | 68…75 | time since the start of the recording, s (f64) |
//! | 76…79 | blocks so far |
//! | 80…95 | level, deviation, EWMA, limit of the EWMA (f32) |
//! | 96…99 | fault: value of the sample, m/s² (f32), NaN if it is missing; else 0 |
//! | 100…115 | summary: samples that are non-finite, saturated, stuck, missing; else 0 |
//! | 116…119 | summary: alarms; else 0 |
//! | 120…123 | CRC-32 (IEEE 802.3) of all bytes before it |

use core::fmt;

use crate::crc::crc32;
use crate::input_check::{FaultCounts, Quality};
use crate::monitor::Status;

/// First four bytes of a message.
pub const MAGIC: [u8; 4] = *b"BRTM";
/// Version of the layout.
pub const FORMAT_VERSION: u8 = 1;
/// Length of a message, bytes.
pub const MESSAGE_LEN: usize = 124;
/// Greatest length of a machine's name, bytes.
pub const MAX_NAME: usize = 32;
const NO_STATUS: u8 = 255;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Change of the status; the status before, `None` at the start.
    Status {
        /// Status before.
        was: Option<Status>,
    },
    /// End of a block of the monitor.
    Block,
    /// First broken sample of a run of one kind.
    Fault {
        /// Kind of the fault, not [`Quality::Good`].
        quality: Quality,
        /// Value of the sample, m/s²; NaN if it is missing.
        value: f32,
    },
    /// Totals, the last message of a session.
    Summary {
        /// Broken samples by kind.
        faults: FaultCounts,
        /// Number of anomalies raised.
        alarms: u32,
    },
}

/// Message of a device. Machine, session and sequence number together are unique.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message<'a> {
    /// Name of the machine: 1 to 32 bytes, one level of a topic ([`is_name`]).
    pub machine: &'a str,
    /// Number of the session, greater after every start of the device.
    pub session: u64,
    /// Number of the message within the session, from 0.
    pub sequence: u32,
    /// CRC-32 of the model's binary form, its last word.
    pub model_crc: u32,
    /// Clock, ms since 1970-01-01 UTC; 0 without one.
    pub unix_ms: u64,
    /// Index of the recording.
    pub recording: u32,
    /// Time since the start of the recording, s.
    pub time_s: f64,
    /// Status now.
    pub status: Status,
    /// What happened.
    pub kind: Kind,
    /// Blocks so far.
    pub block: u32,
    /// Mean squared normalised residual of the last block; NaN for a blind one.
    pub level: f32,
    /// Distance of the level's logarithm from its healthy centre in healthy spreads; NaN for a blind block.
    pub deviation: f32,
    /// EWMA of the running median of the deviation.
    pub ewma: f32,
    /// Limit of the EWMA to both sides.
    pub limit: f32,
}

/// Reason why bytes are no message, or a message cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TelemetryError {
    /// Another length, bytes.
    Length {
        /// Length found.
        found: usize,
    },
    /// Other bytes than the magic.
    Magic,
    /// Another version of the layout.
    Version {
        /// Version found.
        found: u8,
    },
    /// Another CRC-32 than the message carries.
    Checksum {
        /// CRC-32 of the bytes.
        expected: u32,
        /// CRC-32 in the message.
        found: u32,
    },
    /// Name that is no level of a topic, or is not filled up with zeros.
    Name,
    /// Code that is not in the table of the module.
    Code {
        /// Byte at which the code is.
        byte: usize,
        /// Code found.
        found: u8,
    },
    /// Field that the kind of message does not use and that is not zero.
    Unused,
    /// Statistic that cannot come from a monitor: limit or EWMA not finite, or a limit that is not positive.
    Statistic,
}

impl fmt::Display for TelemetryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { found } => write!(f, "found {found} bytes, expected {MESSAGE_LEN}"),
            Self::Magic => write!(f, "bytes 0 to 3: expected `BRTM`"),
            Self::Version { found } => write!(f, "byte 4: found version {found}, expected {FORMAT_VERSION}"),
            Self::Checksum { expected, found } => write!(f, "CRC-32: found {found:08x}, expected {expected:08x}"),
            Self::Name => write!(f, "machine: expected {NAME_RULE}"),
            Self::Code { byte, found } => write!(f, "byte {byte}: found code {found}, which means nothing there"),
            Self::Unused => write!(f, "expected zeros in the fields that the kind of message does not use"),
            Self::Statistic => write!(f, "EWMA and limit: expected finite numbers, the limit positive"),
        }
    }
}

impl core::error::Error for TelemetryError {}

const _: () = assert!(MAX_NAME == 32, "NAME_RULE says so");

/// What [`is_name`] asks of a name, in words.
pub const NAME_RULE: &str = "1 to 32 bytes of UTF-8 without control characters, /, + and #, that do not begin with $";

/// Whether a text can be a machine's name, one level of an MQTT topic: by [`NAME_RULE`].
pub fn is_name(text: &str) -> bool {
    let refused = |c: char| c.is_control() || matches!(c, '/' | '+' | '#');
    !text.is_empty() && text.len() <= MAX_NAME && !text.starts_with('$') && !text.contains(refused)
}

/// Sequential writer and reader of the fields; `None` past the end.
struct Fields<T>(T);

impl Fields<&mut [u8]> {
    fn put<const N: usize>(&mut self, bytes: [u8; N]) -> Option<()> {
        let (head, rest) = core::mem::take(&mut self.0).split_first_chunk_mut()?;
        *head = bytes;
        self.0 = rest;
        Some(())
    }
}

impl<'a> Fields<&'a [u8]> {
    fn take<const N: usize>(&mut self) -> Option<&'a [u8; N]> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(head)
    }

    fn word(&mut self) -> Option<u32> {
        self.take().map(|bytes| u32::from_le_bytes(*bytes))
    }

    fn float(&mut self) -> Option<f32> {
        self.word().map(f32::from_bits)
    }
}

impl<'a> Message<'a> {
    /// Writes the message to the first [`MESSAGE_LEN`] bytes; returns that number.
    ///
    /// # Errors
    /// Too little room, a name that is none, statistics that no monitor gives.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, TelemetryError> {
        let room = TelemetryError::Length { found: out.len() };
        let out = out.get_mut(..MESSAGE_LEN).ok_or(room)?;
        self.check()?;
        let (content, crc) = out.split_last_chunk_mut::<4>().ok_or(room)?;
        self.write(&mut Fields(&mut *content)).ok_or(room)?;
        *crc = crc32(content).to_le_bytes();
        Ok(MESSAGE_LEN)
    }

    fn write(&self, out: &mut Fields<&mut [u8]>) -> Option<()> {
        let (kind, detail) = match self.kind {
            Kind::Status { was } => (1, was.map_or(NO_STATUS, status_code)),
            Kind::Block => (2, 0),
            Kind::Fault { quality, .. } => (3, quality_code(quality)),
            Kind::Summary { .. } => (4, 0),
        };
        let (faults, alarms) = match self.kind {
            Kind::Summary { faults, alarms } => (faults, alarms),
            _ => (FaultCounts::default(), 0),
        };
        let value = if let Kind::Fault { value, .. } = self.kind { value } else { 0.0 };
        out.put(MAGIC)?;
        out.put([FORMAT_VERSION, kind, status_code(self.status), detail])?;
        let mut name = [0; MAX_NAME];
        name.iter_mut().zip(self.machine.bytes()).for_each(|(to, from)| *to = from);
        out.put(name)?;
        out.put(self.session.to_le_bytes())?;
        out.put(self.sequence.to_le_bytes())?;
        out.put(self.model_crc.to_le_bytes())?;
        out.put(self.unix_ms.to_le_bytes())?;
        out.put(self.recording.to_le_bytes())?;
        out.put(self.time_s.to_le_bytes())?;
        out.put(self.block.to_le_bytes())?;
        for float in [self.level, self.deviation, self.ewma, self.limit, value] {
            out.put(float.to_le_bytes())?;
        }
        for count in [faults.non_finite, faults.saturated, faults.stuck, faults.missing, alarms] {
            out.put(count.to_le_bytes())?;
        }
        Some(())
    }

    /// Message that the bytes are.
    ///
    /// # Errors
    /// Another length, magic, version or CRC-32, and every field that [`Message::encode`] never writes.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, TelemetryError> {
        let length = TelemetryError::Length { found: bytes.len() };
        if bytes.len() != MESSAGE_LEN {
            return Err(length);
        }
        let (content, crc) = bytes.split_last_chunk::<4>().ok_or(length)?;
        let mut fields = Fields(content);
        if *fields.take().ok_or(length)? != MAGIC {
            return Err(TelemetryError::Magic);
        }
        let [version, kind, status, detail] = *fields.take().ok_or(length)?;
        if version != FORMAT_VERSION {
            return Err(TelemetryError::Version { found: version });
        }
        let (expected, found) = (crc32(content), u32::from_le_bytes(*crc));
        if expected != found {
            return Err(TelemetryError::Checksum { expected, found });
        }
        let message = Self::read(&mut fields, [kind, status, detail]).ok_or(length)??;
        message.check()?;
        Ok(message)
    }

    /// Fields from the name on; `None` where they end too early.
    fn read(fields: &mut Fields<&'a [u8]>, codes: [u8; 3]) -> Option<Result<Self, TelemetryError>> {
        let name = fields.take::<MAX_NAME>()?;
        let session = u64::from_le_bytes(*fields.take()?);
        let (sequence, model_crc) = (fields.word()?, fields.word()?);
        let unix_ms = u64::from_le_bytes(*fields.take()?);
        let (recording, time_s) = (fields.word()?, f64::from_le_bytes(*fields.take()?));
        let block = fields.word()?;
        let (level, deviation, ewma, limit) = (fields.float()?, fields.float()?, fields.float()?, fields.float()?);
        let value = fields.float()?;
        let (non_finite, saturated, stuck, missing) = (fields.word()?, fields.word()?, fields.word()?, fields.word()?);
        let faults = FaultCounts { non_finite, saturated, stuck, missing };
        let alarms = fields.word()?;
        let parts = || {
            let machine = machine(name).ok_or(TelemetryError::Name)?;
            let (status, kind) = (status(6, codes[1])?, kind(codes, value, faults, alarms)?);
            Ok(Self {
                machine,
                session,
                sequence,
                model_crc,
                unix_ms,
                recording,
                time_s,
                status,
                kind,
                block,
                level,
                deviation,
                ewma,
                limit,
            })
        };
        Some(parts())
    }

    fn check(&self) -> Result<(), TelemetryError> {
        if !is_name(self.machine) {
            return Err(TelemetryError::Name);
        }
        if let Kind::Fault { quality: Quality::Good, .. } = self.kind {
            return Err(TelemetryError::Code { byte: 7, found: 0 });
        }
        let usable = self.ewma.is_finite() && self.limit.is_finite() && self.limit > 0.0 && self.time_s.is_finite();
        if usable { Ok(()) } else { Err(TelemetryError::Statistic) }
    }
}

/// Name without the zeros that fill it up.
fn machine(name: &[u8; MAX_NAME]) -> Option<&str> {
    let end = name.iter().position(|byte| *byte == 0).unwrap_or(MAX_NAME);
    let (name, rest) = name.split_at_checked(end)?;
    if rest.iter().any(|byte| *byte != 0) {
        return None;
    }
    core::str::from_utf8(name).ok()
}

fn kind(codes: [u8; 3], value: f32, faults: FaultCounts, alarms: u32) -> Result<Kind, TelemetryError> {
    let [kind, _, detail] = codes;
    let no_value = value.to_bits() == 0;
    let no_totals = faults == FaultCounts::default() && alarms == 0;
    let (kind, canonical) = match kind {
        1 if detail == NO_STATUS => (Kind::Status { was: None }, no_value && no_totals),
        1 => (Kind::Status { was: Some(status(7, detail)?) }, no_value && no_totals),
        2 => (Kind::Block, detail == 0 && no_value && no_totals),
        3 => (Kind::Fault { quality: quality(detail)?, value }, no_totals),
        4 => (Kind::Summary { faults, alarms }, detail == 0 && no_value),
        found => return Err(TelemetryError::Code { byte: 5, found }),
    };
    if canonical { Ok(kind) } else { Err(TelemetryError::Unused) }
}

const fn status_code(status: Status) -> u8 {
    match status {
        Status::Starting => 0,
        Status::Healthy => 1,
        Status::Anomalous => 2,
        Status::Blind => 3,
    }
}

fn status(byte: usize, code: u8) -> Result<Status, TelemetryError> {
    match code {
        0 => Ok(Status::Starting),
        1 => Ok(Status::Healthy),
        2 => Ok(Status::Anomalous),
        3 => Ok(Status::Blind),
        found => Err(TelemetryError::Code { byte, found }),
    }
}

const fn quality_code(quality: Quality) -> u8 {
    match quality {
        Quality::Good => 0,
        Quality::NonFinite => 1,
        Quality::Saturated => 2,
        Quality::Stuck => 3,
        Quality::Missing => 4,
    }
}

fn quality(code: u8) -> Result<Quality, TelemetryError> {
    match code {
        1 => Ok(Quality::NonFinite),
        2 => Ok(Quality::Saturated),
        3 => Ok(Quality::Stuck),
        4 => Ok(Quality::Missing),
        found => Err(TelemetryError::Code { byte: 7, found }),
    }
}

#[cfg(test)]
#[path = "telemetry_tests.rs"]
mod tests;
