//! The words of a memory model, at numbers that count words or at any addresses: 0 where nothing was written.

use std::collections::HashMap;

/// Words of up to 64 bits by their numbers.
#[derive(Debug, Default)]
pub(super) struct Words(HashMap<u64, u64>);

impl Words {
    /// The word of a number.
    pub fn get(&self, number: u64) -> u64 {
        self.0.get(&number).copied().unwrap_or(0)
    }

    /// Sets the whole word of a number.
    pub fn set(&mut self, number: u64, word: u64) {
        self.0.insert(number, word);
    }

    /// Sets the bytes of a word that are 1 in `strobe`.
    pub fn write(&mut self, number: u64, data: u64, strobe: u64) {
        let mask = bits_of(strobe);
        let word = self.0.entry(number).or_insert(0);
        *word = *word & !mask | data & mask;
    }
}

/// The bits of the bytes that a strobe selects.
fn bits_of(strobe: u64) -> u64 {
    (0..8).filter(|b| strobe >> b & 1 == 1).fold(0, |mask, b| mask | 0xff << (8 * b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strobe_writes_its_bytes_alone() {
        let mut words = Words::default();
        assert_eq!(words.get(7), 0);
        words.set(7, 0x1122_3344_5566_7788);
        words.write(7, u64::MAX, 0b1000_0001);
        assert_eq!(words.get(7), 0xff22_3344_5566_77ff);
        words.write(8, 0xabcd, 0);
        assert_eq!(words.get(8), 0);
    }
}
