//! Update of the model in the field: two slots in flash, of which one holds a valid model whatever happens to the power.
//!
//! An update goes word by word to the slot that is not running, is validated where it lies, and gets its record last. The
//! next start puts it on trial, [`ATTEMPTS`] times at most, until the application confirms it; one that is not confirmed
//! falls back to the confirmed model. A slot begins with a record of [`RECORD_LEN`] bytes, in words:
//!
//! | word | content |
//! |---|---|
//! | 0 | `BRSL` |
//! | 1 | sequence number, little-endian; the newer of two is greater modulo 2³² |
//! | 2 | CRC-32 of both |
//! | 3 to 5 | one mark for each attempt of the trial |
//! | 6 | mark of the confirmation |
//! | 7 | unused |
//!
//! A mark is a word programmed to 0. That of an attempt counts as soon as it is not erased, that of the confirmation only
//! whole, so that a power cut between its bits never confirms. The model's [binary form](crate::model) follows, with a CRC-32
//! of its own. Every start checks both slots from the bytes in flash.
//!
//! Not covered: cells that read differently from one time to the next after a torn write, and errors in both slots.

mod flash;
mod slot;
mod write;

#[cfg(test)]
mod tests;

pub use flash::Flash;
pub use slot::{ATTEMPTS, RECORD_LEN, Refused};
pub use write::{Update, UpdateError};

use crate::model::Model;
use slot::{MARK, Slot, State};

/// Two slots of flash and what runs from them.
///
/// # Examples
///
/// A round of an application, for any flash:
///
/// ```
/// use ballrace_core::device::Device;
/// use ballrace_core::update::{Flash, Slots, Standing, StartError};
///
/// fn round<F: Flash>(slots: &mut Slots<F>, scratch: &mut [f32], samples: &[f32]) -> Result<(), StartError<F::Error>> {
///     let standing = slots.start()?.standing;
///     let (running, _spare) = slots.split();
///     if let Some(model) = running
///         && let Ok(mut device) = Device::new(&model, scratch)
///     {
///         for sample in samples {
///             device.push(*sample);
///         }
///     }
///     // A new model that arrives meanwhile would go to `_spare.begin()`.
///     if standing == Standing::Trial {
///         slots.confirm().map_err(StartError::Flash)?;
///     }
///     Ok(())
/// }
/// ```
#[derive(Debug)]
pub struct Slots<F> {
    regions: [F; 2],
    scratch_len: usize,
    running: Option<Start>,
}

/// What a start found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Start {
    /// Slot that runs, 0 or 1.
    pub slot: usize,
    /// Sequence number of its model.
    pub sequence: u32,
    /// Standing of its model.
    pub standing: Standing,
    /// Whether the other slot holds a newer model that used up its trial.
    pub fell_back: bool,
}

/// Standing of the model that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Standing {
    /// Confirmed.
    Confirmed,
    /// On trial: unless it is confirmed before its attempts are used up, the confirmed one runs again.
    Trial,
    /// Trial used up, and no other model to fall back to.
    LastResort,
}

/// Error of a start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartError<E> {
    /// Neither slot holds a model that this device can run.
    NoModel,
    /// The flash refused the mark of an attempt.
    Flash(E),
}

impl<F: Flash> Slots<F> {
    /// Slots in two regions of flash, of a device with this many floats of scratch for its model.
    pub fn new(regions: [F; 2], scratch_len: usize) -> Self {
        Self { regions, scratch_len, running: None }
    }

    /// Regions of flash.
    pub fn into_regions(self) -> [F; 2] {
        self.regions
    }

    /// Chooses the model to run: a newer one on trial, else the newest confirmed one, else any valid one. The attempt of a
    /// trial is marked before anything runs.
    ///
    /// # Errors
    /// [`StartError::NoModel`], as before the first update; of the flash.
    pub fn start(&mut self) -> Result<Start, StartError<F::Error>> {
        self.running = None;
        let [first, second] = &mut self.regions;
        let slots = [&*first, &*second].map(|region| Slot::read(region, self.scratch_len).ok());
        let mut start = choose(slots).ok_or(StartError::NoModel)?;
        let (region, chosen, other) = match (start.slot, slots) {
            (0, [chosen, other]) => (first, chosen, other),
            (_, [other, chosen]) => (second, chosen, other),
        };
        if let Some(Slot { state: State::Trial { used }, .. }) = chosen
            && used < ATTEMPTS
        {
            region.program(slot::ATTEMPT_WORD + used, MARK).map_err(StartError::Flash)?;
        }
        start.fell_back = other.is_some_and(|other| other.state != State::Confirmed && other.is_newer(start.sequence));
        self.running = Some(start);
        Ok(start)
    }

    /// What the last start found; `None` before it.
    pub fn running(&self) -> Option<Start> {
        self.running
    }

    /// Model that runs, used in place, and the other slot, to which an update may go meanwhile.
    pub fn split(&mut self) -> (Option<Model<'_>>, Spare<'_, F>) {
        let [first, second] = &mut self.regions;
        let (running, region) = match self.running {
            Some(Start { slot: 0, .. }) => (first, second),
            // Before a start nothing runs.
            _ => (second, first),
        };
        let old = Slot::read(&*region, self.scratch_len).ok();
        let on_trial = self.running.is_some_and(|start| start.standing == Standing::Trial);
        let before = self.running.map(|start| start.sequence).or(old.map(|old| old.sequence));
        let spare = Spare {
            sequence: before.map_or(0, |sequence| sequence.wrapping_add(1)),
            scratch_len: self.scratch_len,
            // What a trial would fall back to.
            needed: on_trial && old.is_some_and(|old| old.state == State::Confirmed),
            region,
        };
        let model = if self.running.is_some() { slot::model(&*running).ok() } else { None };
        (model, spare)
    }

    /// Confirms the model on trial, once it is seen to work; nothing to do for one that is confirmed.
    ///
    /// # Errors
    /// Of the flash.
    pub fn confirm(&mut self) -> Result<(), F::Error> {
        let [first, second] = &mut self.regions;
        if let Some(start) = &mut self.running
            && start.standing != Standing::Confirmed
        {
            let region = if start.slot == 0 { first } else { second };
            region.program(slot::CONFIRMATION_WORD, MARK)?;
            start.standing = Standing::Confirmed;
        }
        Ok(())
    }

    /// Ends the trial of the running model: the next start falls back. Nothing to do for one that is confirmed.
    ///
    /// # Errors
    /// Of the flash.
    pub fn reject(&mut self) -> Result<(), F::Error> {
        let [first, second] = &mut self.regions;
        let Some(Start { slot, standing: Standing::Trial, .. }) = self.running else { return Ok(()) };
        let region = if slot == 0 { first } else { second };
        let used = slot::attempts_used(region.bytes());
        (used..ATTEMPTS).try_for_each(|attempt| region.program(slot::ATTEMPT_WORD + attempt, MARK))
    }
}

/// The slot that is not running.
#[derive(Debug)]
pub struct Spare<'f, F> {
    region: &'f mut F,
    sequence: u32,
    scratch_len: usize,
    needed: bool,
}

impl<'f, F: Flash> Spare<'f, F> {
    /// Erases the slot and begins an update.
    ///
    /// # Errors
    /// [`UpdateError::OnTrial`] while the slot holds what a trial would fall back to; of the flash.
    pub fn begin(self) -> Result<Update<'f, F>, UpdateError<F::Error>> {
        if self.needed {
            return Err(UpdateError::OnTrial);
        }
        Update::begin(self.region, self.sequence, self.scratch_len)
    }
}

/// Slot to run and its standing.
fn choose(slots: [Option<Slot>; 2]) -> Option<Start> {
    let newest = |wanted: fn(State) -> bool| {
        let found = slots.into_iter().enumerate().filter_map(|(i, slot)| Some((i, slot.filter(|s| wanted(s.state))?)));
        found.reduce(|a, b| if b.1.is_newer(a.1.sequence) { b } else { a })
    };
    let start = |(slot, Slot { sequence, .. }), standing| Some(Start { slot, sequence, standing, fell_back: false });
    let confirmed = newest(|state| state == State::Confirmed);
    let on_trial = newest(|state| matches!(state, State::Trial { used } if used < ATTEMPTS));
    match (on_trial, confirmed) {
        (Some(new), None) => start(new, Standing::Trial),
        (Some(new), Some(old)) if new.1.is_newer(old.1.sequence) => start(new, Standing::Trial),
        (_, Some(old)) => start(old, Standing::Confirmed),
        (None, None) => newest(|_| true).and_then(|slot| start(slot, Standing::LastResort)),
    }
}
