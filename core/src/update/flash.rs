//! Flash memory as an update needs it.

use crate::Word;

/// A region of flash memory that holds one slot: erased to ones page by page, programmed word by word.
pub trait Flash {
    /// Error of an operation.
    type Error;

    /// All bytes of the region, as they read now; at the alignment of a word a model runs faster.
    fn bytes(&self) -> &[u8];

    /// Bytes of a page. The region is whole pages.
    fn page_len(&self) -> usize;

    /// Erases page `page` of the region to ones.
    ///
    /// # Errors
    /// Where the flash could not.
    fn erase(&mut self, page: usize) -> Result<(), Self::Error>;

    /// Programs word `word` of the region. It is erased, or `value` is 0.
    ///
    /// # Errors
    /// Where the flash could not.
    fn program(&mut self, word: usize, value: Word) -> Result<(), Self::Error>;
}
