//! An in-memory flash whose power is cut at every operation, and whose every bit is flipped.

extern crate std;
use core::cell::Cell;
use std::rc::Rc;
use std::vec::Vec;

use super::*;
use crate::Word;
use crate::device::Device;
use crate::states::{Alignment, Estimator, Orders, StateSpec};
use crate::testing::{Parts, samples};

const PAGE: usize = 256;
const SCRATCH: usize = 512;
/// Bits that an operation has not reached when the power goes: none of its work, all, and some.
const TEARS: [u8; 6] = [0xff, 0x00, 0xf0, 0x0f, 0xaa, 0x81];

#[derive(Debug, PartialEq)]
struct PowerCut;
type Failure = UpdateError<PowerCut>;
/// Bytes of both slots.
type Images = [Vec<u8>; 2];

/// Power of a device, until it is cut in one of its operations.
#[derive(Debug, Default)]
struct Power {
    operations: Cell<usize>,
    cut: Option<(usize, u8)>,
}

impl Power {
    /// Bits that the next operation does not reach; an error once the power is off.
    fn missed(&self) -> Result<u8, PowerCut> {
        let now = self.operations.replace(self.operations.get() + 1);
        match self.cut {
            Some((at, _)) if now > at => Err(PowerCut),
            Some((at, missed)) if now == at => Ok(missed),
            _ => Ok(0),
        }
    }

    fn after(&self) -> Result<(), PowerCut> {
        if self.cut.is_some_and(|(at, _)| self.operations.get() > at) { Err(PowerCut) } else { Ok(()) }
    }
}

#[derive(Debug)]
struct Memory {
    bytes: Vec<u8>,
    power: Rc<Power>,
}

impl Flash for Memory {
    type Error = PowerCut;

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn page_len(&self) -> usize {
        PAGE
    }

    fn erase(&mut self, page: usize) -> Result<(), PowerCut> {
        let missed = self.power.missed()?;
        for (i, cell) in self.bytes[page * PAGE..][..PAGE].iter_mut().enumerate() {
            // The second half is reached later, and no two neighbours alike.
            let missed = if i < PAGE / 2 { missed & 0x7e } else { missed };
            *cell |= !missed.rotate_left(i as u32);
        }
        self.power.after()
    }

    fn program(&mut self, word: usize, value: Word) -> Result<(), PowerCut> {
        let missed = self.power.missed()?;
        let cells = &mut self.bytes[4 * word..][..4];
        assert!(value == [0; 4] || cells == [0xff; 4], "word {word} is not erased");
        for (i, (cell, value)) in cells.iter_mut().zip(value).enumerate() {
            *cell &= value | missed.rotate_left(i as u32);
        }
        self.power.after()
    }
}

/// Binary form of a small model; `which` makes them differ.
fn blob(which: u8) -> Vec<u8> {
    let spec = StateSpec {
        dimension: 2,
        orders: Orders::Even,
        alignment: Alignment::Causal,
        estimator: Estimator::Differences,
    };
    let parts = Parts::new(spec);
    let model = Model { sample_rate_hz: 1000.0 + f32::from(which), ..parts.model() };
    let mut bytes = std::vec![0; model.byte_len()];
    model.to_bytes(&mut bytes).unwrap();
    bytes
}

fn blank() -> Images {
    let pages = (blob(0).len() + RECORD_LEN).div_ceil(PAGE);
    [std::vec![0xff; pages * PAGE], std::vec![0xff; pages * PAGE]]
}

/// Device that was switched on, with its power.
fn powered(images: &Images, cut: Option<(usize, u8)>) -> (Slots<Memory>, Rc<Power>) {
    let power = Rc::new(Power { cut, ..Power::default() });
    let regions = images.clone().map(|bytes| Memory { bytes, power: power.clone() });
    (Slots::new(regions, SCRATCH), power)
}

fn images(slots: Slots<Memory>) -> Images {
    slots.into_regions().map(|memory| memory.bytes)
}

/// Writes a model to the spare slot, in pieces that no word ends with.
fn install(slots: &mut Slots<Memory>, bytes: &[u8]) -> Result<u32, Failure> {
    let mut update = slots.split().1.begin()?;
    bytes.chunks(7).try_for_each(|piece| update.write(piece))?;
    update.finish()
}

/// Starts; what was found, and the bytes of the model that runs, which evaluates samples.
fn start(slots: &mut Slots<Memory>) -> Result<(Start, Vec<u8>), Failure> {
    let start = slots.start().map_err(|error| match error {
        StartError::Flash(error) => Failure::Flash(error),
        StartError::NoModel => panic!("no model"),
    })?;
    let model = slots.split().0.unwrap();
    let mut scratch = [0.0; SCRATCH];
    let mut device = Device::new(&model, &mut scratch).unwrap();
    assert!(samples(20).into_iter().filter(|sample| device.push(*sample).step.is_some()).count() > 5);
    let mut bytes = std::vec![0; model.byte_len()];
    model.to_bytes(&mut bytes).unwrap();
    Ok((start, bytes))
}

fn start_and_confirm(slots: &mut Slots<Memory>) -> Result<Vec<u8>, Failure> {
    let (_, bytes) = start(slots)?;
    slots.confirm().map_err(Failure::Flash)?;
    Ok(bytes)
}

/// Images after these models were confirmed one after the other.
fn after(models: &[Vec<u8>]) -> Images {
    models.iter().fold(blank(), |images_before, model| {
        let (mut slots, _) = powered(&images_before, None);
        if slots.start().is_ok() {
            slots.confirm().unwrap();
        }
        install(&mut slots, model).unwrap();
        assert_eq!(start_and_confirm(&mut slots).unwrap(), *model);
        images(slots)
    })
}

/// Update from start to confirmation, with restarts between.
fn update(images_before: &Images, new: &[u8], cut: Option<(usize, u8)>) -> (Result<Vec<u8>, Failure>, Images, usize) {
    let (mut slots, power) = powered(images_before, cut);
    let mut life = || {
        start_and_confirm(&mut slots)?;
        install(&mut slots, new)?;
        start_and_confirm(&mut slots)
    };
    let found = life();
    (found, images(slots), power.operations.get())
}

/// Slots before an update: a blank spare one, one with an older model, one with a model that was given up.
fn before_updates(old: &[u8]) -> [Images; 3] {
    let rejected = {
        let (mut slots, _) = powered(&after(&[old.to_vec()]), None);
        start(&mut slots).unwrap();
        install(&mut slots, &blob(9)).unwrap();
        assert_eq!(start(&mut slots).unwrap().0.standing, Standing::Trial);
        slots.reject().unwrap();
        let (found, bytes) = start(&mut slots).unwrap();
        assert!(found.fell_back && bytes == old);
        images(slots)
    };
    [after(&[old.to_vec()]), after(&[blob(8), old.to_vec()]), rejected]
}

#[test]
fn invariant_a_power_cut_at_any_operation_leaves_a_valid_model() {
    let (old, new) = (blob(1), blob(2));
    for before in before_updates(&old) {
        let (done, confirmed, operations) = update(&before, &new, None);
        assert_eq!(done, Ok(new.clone()));
        assert_eq!(start(&mut powered(&confirmed, None).0).unwrap().1, new);
        let (mut kept, mut replaced) = (0, 0);
        for cut in (0..operations).flat_map(|at| TEARS.map(|missed| (at, missed))) {
            let (interrupted, left, _) = update(&before, &new, Some(cut));
            assert_eq!(interrupted, Err(UpdateError::Flash(PowerCut)));
            let (mut slots, power) = powered(&left, None);
            let (found, runs) = start(&mut slots).unwrap();
            assert!(runs == old || runs == new, "cut {cut:?}");
            assert!(runs == new || found.standing == Standing::Confirmed, "cut {cut:?}");
            if runs == old {
                kept += 1
            } else {
                replaced += 1
            }
            // The power goes again in any operation of that start.
            for again in (0..power.operations.get()).flat_map(|at| TEARS.map(|missed| (at, missed))) {
                let (mut slots, _) = powered(&left, Some(again));
                assert!(start(&mut slots).is_err());
                let (_, runs) = start(&mut powered(&images(slots), None).0).unwrap();
                assert!(runs == old || runs == new, "cuts {cut:?}, {again:?}");
            }
            // And nothing is in the way of the update once there is power.
            let (mut slots, _) = powered(&left, None);
            start_and_confirm(&mut slots).unwrap();
            install(&mut slots, &new).unwrap();
            assert_eq!(start_and_confirm(&mut slots), Ok(new.clone()), "cut {cut:?}");
        }
        // The new model runs from its record on: the record's last bits, the attempt, the confirmation.
        assert!(kept > operations && (6..20).contains(&replaced), "{kept} {replaced} of {operations}");
    }
}

#[test]
fn invariant_no_flipped_bit_is_run() {
    let (old, new) = (blob(1), blob(2));
    let confirmed = after(&[old.clone(), new.clone()]);
    let on_trial = {
        let (mut slots, _) = powered(&after(core::slice::from_ref(&old)), None);
        start(&mut slots).unwrap();
        install(&mut slots, &new).unwrap();
        images(slots)
    };
    for before in [confirmed, on_trial] {
        let (mut kept, mut replaced) = (0, 0);
        for (slot, bit) in (0..2).flat_map(|slot| (0..8 * before[slot].len()).map(move |bit| (slot, bit))) {
            let mut flipped = before.clone();
            flipped[slot][bit / 8] ^= 1 << (bit % 8);
            let (_, runs) = start(&mut powered(&flipped, None).0).unwrap();
            assert!(runs == old || runs == new, "slot {slot}, bit {bit}");
            if runs == old { kept += 1 } else { replaced += 1 }
        }
        // Every bit of the new model and of its record's first three words counts.
        assert!(kept >= 8 * (new.len() + 12) && replaced >= 8 * old.len(), "{kept} {replaced}");
    }
}

#[test]
fn invariant_no_flipped_bit_is_taken() {
    let (old, new) = (blob(1), blob(2));
    let before = after(core::slice::from_ref(&old));
    for bit in 0..8 * new.len() {
        let mut flipped = new.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let (mut slots, _) = powered(&before, None);
        start(&mut slots).unwrap();
        assert!(matches!(install(&mut slots, &flipped), Err(UpdateError::Refused(Refused::Model(_)))), "bit {bit}");
        assert_eq!(start(&mut slots).unwrap().1, old);
    }
}

#[test]
fn a_trial_is_given_up_after_its_attempts_and_what_it_falls_back_to_is_kept() {
    let (old, new) = (blob(1), blob(2));
    let (mut slots, _) = powered(&after(core::slice::from_ref(&old)), None);
    start(&mut slots).unwrap();
    install(&mut slots, &new).unwrap();
    for _ in 0..ATTEMPTS {
        let (found, runs) = start(&mut slots).unwrap();
        assert_eq!((found.standing, found.fell_back, runs == new), (Standing::Trial, false, true));
        assert_eq!(install(&mut slots, &new), Err(UpdateError::OnTrial));
    }
    let (found, runs) = start(&mut slots).unwrap();
    assert_eq!((found.standing, found.fell_back, runs == old), (Standing::Confirmed, true, true));
    install(&mut slots, &new).unwrap();
    start(&mut slots).unwrap();
    slots.confirm().unwrap();
    assert_eq!(start(&mut slots).unwrap(), (Start { standing: Standing::Confirmed, ..slots.running().unwrap() }, new));
}

#[test]
fn the_first_model_has_nothing_to_fall_back_to() {
    let (mut slots, _) = powered(&blank(), None);
    assert_eq!(slots.start(), Err(StartError::NoModel));
    assert!(slots.split().0.is_none());
    assert_eq!(install(&mut slots, &blob(1)), Ok(0));
    for attempt in 0..ATTEMPTS + 2 {
        let expected = if attempt < ATTEMPTS { Standing::Trial } else { Standing::LastResort };
        assert_eq!(start(&mut slots).unwrap().0.standing, expected);
    }
    slots.confirm().unwrap();
    assert_eq!(start(&mut slots).unwrap().0.standing, Standing::Confirmed);
}

#[test]
fn what_the_device_cannot_run_or_hold_is_refused() {
    let before = after(&[blob(1)]);
    let regions = before.clone().map(|bytes| Memory { bytes, power: Rc::default() });
    let mut slots = Slots::new(regions, 3);
    assert_eq!(slots.start(), Err(StartError::NoModel));
    let refused = install(&mut slots, &blob(2));
    assert!(matches!(refused, Err(UpdateError::Refused(Refused::Scratch { found: 3, .. }))), "{refused:?}");
    let (mut slots, _) = powered(&before, None);
    start(&mut slots).unwrap();
    let capacity = before[0].len() - RECORD_LEN;
    assert_eq!(install(&mut slots, &std::vec![0; capacity + 4]), Err(UpdateError::TooLong { capacity }));
    assert_eq!(start(&mut slots).unwrap().1, blob(1));
}

#[test]
fn sequence_numbers_wrap() {
    let newest = Slot { sequence: 1, state: State::Confirmed };
    assert!(newest.is_newer(0) && newest.is_newer(u32::MAX) && !newest.is_newer(1) && !newest.is_newer(2));
}
