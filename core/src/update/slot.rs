//! A slot as it lies in flash: record and model.

use super::Flash;
use crate::Word;
use crate::crc::crc32;
use crate::device::Device;
use crate::model::{Model, ModelError};

/// Starts of a model on trial before it is given up.
pub const ATTEMPTS: usize = 3;
/// Bytes of a slot before its model.
pub const RECORD_LEN: usize = 32;
/// First four bytes of a slot.
const MAGIC: Word = *b"BRSL";
/// Word of the first attempt's mark.
pub(super) const ATTEMPT_WORD: usize = 3;
/// Word of the confirmation's mark.
pub(super) const CONFIRMATION_WORD: usize = ATTEMPT_WORD + ATTEMPTS;
/// A mark: no bit is left to be programmed.
pub(super) const MARK: Word = [0; 4];
const ERASED: Word = [0xff; 4];

/// What a slot with a valid record and model says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    /// Sequence number.
    pub sequence: u32,
    /// State of the model.
    pub state: State,
}

/// State of a valid model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// Not confirmed; attempts used.
    Trial {
        /// Attempts used, at most [`ATTEMPTS`].
        used: usize,
    },
    /// Confirmed.
    Confirmed,
}

/// Reason why a slot holds nothing to run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// No valid record.
    Record,
    /// No valid model.
    Model(ModelError),
    /// A model that needs more scratch than the device has.
    Scratch {
        /// Floats needed.
        needed: usize,
        /// Floats of the device.
        found: usize,
    },
}

impl Slot {
    /// Reads a slot and checks record, model and the scratch that it needs.
    pub(super) fn read(region: &impl Flash, scratch_len: usize) -> Result<Self, Refused> {
        let sequence = Self::sequence(region).ok_or(Refused::Record)?;
        check_model(region, scratch_len)?;
        let confirmed = words(region.bytes()).get(CONFIRMATION_WORD) == Some(&MARK);
        let used = attempts_used(region.bytes());
        Ok(Self { sequence, state: if confirmed { State::Confirmed } else { State::Trial { used } } })
    }

    /// Sequence number of a valid record.
    fn sequence(region: &impl Flash) -> Option<u32> {
        let [magic, sequence, crc, ..] = words(region.bytes()) else { return None };
        (record(u32::from_le_bytes(*sequence)) == [*magic, *sequence, *crc]).then_some(u32::from_le_bytes(*sequence))
    }

    /// Whether the slot is newer than a sequence number, modulo 2³².
    pub(super) fn is_newer(&self, sequence: u32) -> bool {
        (self.sequence.wrapping_sub(sequence) as i32) > 0
    }
}

/// Words of a record before its marks.
pub(super) fn record(sequence: u32) -> [Word; ATTEMPT_WORD] {
    let sequence = sequence.to_le_bytes();
    let crc = crc32([MAGIC, sequence].as_flattened());
    [MAGIC, sequence, crc.to_le_bytes()]
}

/// Model of a slot, used in place.
pub(super) fn model(region: &impl Flash) -> Result<Model<'_>, ModelError> {
    Model::from_bytes(region.bytes().get(RECORD_LEN..).unwrap_or(&[]))
}

/// Checks that a slot's model is valid and can run with this many floats of scratch.
pub(super) fn check_model(region: &impl Flash, scratch_len: usize) -> Result<(), Refused> {
    let (needed, found) = (Device::scratch_len(&model(region).map_err(Refused::Model)?), scratch_len);
    if needed > found { Err(Refused::Scratch { needed, found }) } else { Ok(()) }
}

/// Attempts whose marks are not erased, torn ones included.
pub(super) fn attempts_used(bytes: &[u8]) -> usize {
    let marks = words(bytes).get(ATTEMPT_WORD..CONFIRMATION_WORD).unwrap_or(&[]);
    marks.iter().filter(|mark| **mark != ERASED).count()
}

fn words(bytes: &[u8]) -> &[Word] {
    bytes.as_chunks().0
}
