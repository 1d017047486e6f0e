//! The records that the hardware sends: features, and the trailer that ends the packet of a frame.
//!
//! A record is eight 32-bit words of designs of one or two scale pairs, ten words of designs of three.

/// A field of a record: some bits of one of its 32-bit words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordField {
    /// Index of the word, from 0.
    pub word: usize,
    /// Lowest bit in the word.
    pub low: u32,
    /// Number of bits.
    pub bits: u32,
}

impl RecordField {
    /// Returns the value of the field.
    ///
    /// # Panics
    /// If the record has no such word.
    #[inline(always)]
    pub const fn get(self, words: &[u32]) -> u32 {
        words[self.word] >> self.low & (u32::MAX >> (u32::BITS - self.bits))
    }

    /// Puts a value into a field that is 0; it must fit.
    ///
    /// # Panics
    /// If the record has no such word.
    #[inline(always)]
    pub const fn put(self, words: &mut [u32], value: u32) {
        words[self.word] |= value << self.low;
    }
}

include!(concat!(env!("OUT_DIR"), "/record.rs"));

/// Returns the number of words of a record of a design with `pairs` scale pairs.
pub const fn record_words(pairs: usize) -> usize {
    if pairs > 2 { RECORD_WORDS } else { TWO_PAIR_WORDS }
}

/// Size of a buffer for the packet of one frame, bytes.
pub const BUFFER_BYTES: usize = 64 << 10;

/// Returns the reset value of the register `record_limit` of a design with `pairs` scale pairs: one feature fewer than
/// a buffer of [`BUFFER_BYTES`] holds beside the trailer.
pub const fn default_limit(pairs: usize) -> u32 {
    (BUFFER_BYTES / (4 * record_words(pairs)) - 2) as u32
}
