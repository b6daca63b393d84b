//! Writing of an update into a slot, piece by piece as it arrives.

use super::Flash;
use super::slot::{RECORD_LEN, Refused, Slot, check_model, record};
use crate::Word;

/// Error of an update. The slot that runs is untouched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UpdateError<E> {
    /// The running model is on trial and the other slot holds what it would fall back to: confirm or reject it first.
    OnTrial,
    /// More bytes than the slot has room for.
    TooLong {
        /// Bytes that a model may have.
        capacity: usize,
    },
    /// Nothing to run, as it lies in flash.
    Refused(Refused),
    /// The flash refused an operation.
    Flash(E),
}

/// An update that is being written. Dropped before [`finish`](Self::finish) it leaves a slot without a record, which no
/// start takes.
#[derive(Debug)]
pub struct Update<'f, F> {
    region: &'f mut F,
    sequence: u32,
    scratch_len: usize,
    /// Word of the region that is written next.
    word: usize,
    /// Bytes of that word so far.
    held: heapless::Vec<u8, 4>,
}

impl<'f, F: Flash> Update<'f, F> {
    /// Erases a region, the page with the record first.
    pub(super) fn begin(region: &'f mut F, sequence: u32, scratch_len: usize) -> Result<Self, UpdateError<F::Error>> {
        let pages = region.bytes().len().checked_div(region.page_len()).unwrap_or(0);
        (0..pages).try_for_each(|page| region.erase(page)).map_err(UpdateError::Flash)?;
        Ok(Self { region, sequence, scratch_len, word: RECORD_LEN / 4, held: heapless::Vec::new() })
    }

    /// Bytes that a model may have.
    pub fn capacity(&self) -> usize {
        self.region.bytes().len().saturating_sub(RECORD_LEN) / 4 * 4
    }

    /// Writes the next bytes of the model's binary form, any number of them.
    ///
    /// # Errors
    /// [`UpdateError::TooLong`]; of the flash.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), UpdateError<F::Error>> {
        for byte in bytes {
            // There is room: a full word is written at once.
            let _ = self.held.push(*byte);
            if let Ok(word) = self.held.as_slice().try_into() {
                self.put(word)?;
            }
        }
        Ok(())
    }

    fn put(&mut self, word: Word) -> Result<(), UpdateError<F::Error>> {
        let capacity = self.capacity();
        if 4 * self.word + 4 > RECORD_LEN + capacity {
            return Err(UpdateError::TooLong { capacity });
        }
        self.region.program(self.word, word).map_err(UpdateError::Flash)?;
        self.word += 1;
        self.held.clear();
        Ok(())
    }

    /// Validates the model in flash and writes its record: the next start puts it on trial. Returns its sequence number.
    ///
    /// # Errors
    /// What is wrong with the model; of the flash.
    pub fn finish(self) -> Result<u32, UpdateError<F::Error>> {
        check_model(&*self.region, self.scratch_len).map_err(UpdateError::Refused)?;
        for (word, value) in record(self.sequence).into_iter().enumerate() {
            self.region.program(word, value).map_err(UpdateError::Flash)?;
        }
        Slot::read(&*self.region, self.scratch_len).map(|slot| slot.sequence).map_err(UpdateError::Refused)
    }
}
