//! Arrays of a JSON document, read into a caller's storage.

use core::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, SeqAccess, Visitor};

use crate::Word;

/// Allocator over the caller's storage.
pub(super) struct Arena<'a> {
    pub(super) free: &'a mut [Word],
    /// Whether the storage was too small.
    pub(super) full: bool,
}

impl<'a> Arena<'a> {
    /// Stores words for as long as `next` gives any, and returns them.
    fn fill<E>(
        &mut self,
        mut next: impl FnMut() -> Result<Option<Word>, E>,
        error: impl Fn(&str) -> E,
    ) -> Result<&'a [Word], E> {
        let mut length = 0;
        while let Some(word) = next()? {
            let Some(slot) = self.free.get_mut(length) else {
                self.full = true;
                return Err(error("storage too small"));
            };
            *slot = word;
            length += 1;
        }
        let free = core::mem::take(&mut self.free);
        let (taken, rest) = free.split_at_mut_checked(length).ok_or_else(|| error("storage too small"))?;
        self.free = rest;
        Ok(taken)
    }
}

/// An array of `f32` or `u32` into the arena.
pub(super) struct Words<'r, 'a> {
    pub(super) arena: &'r mut Arena<'a>,
    pub(super) integers: bool,
}

impl<'de, 'a> DeserializeSeed<'de> for Words<'_, 'a> {
    type Value = &'a [Word];
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'a [Word], D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, 'a> Visitor<'de> for Words<'_, 'a> {
    type Value = &'a [Word];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<&'a [Word], A::Error> {
        use serde::de::Error;
        let integers = self.integers;
        let next = || {
            Ok(if integers {
                seq.next_element::<u32>()?.map(u32::to_le_bytes)
            } else {
                seq.next_element::<f32>()?.map(f32::to_le_bytes)
            })
        };
        self.arena.fill(next, |why| A::Error::custom(why))
    }
}
