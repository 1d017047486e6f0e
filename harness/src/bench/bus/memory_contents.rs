//! The contents of a memory model.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

/// A memory of words of up to 64 bits by address, 0 if never written, with a count of accesses. Clones share it.
#[derive(Debug, Clone)]
pub struct MemoryContents {
    words: Rc<RefCell<HashMap<u64, u64>>>,
    accesses: Rc<Cell<u64>>,
    /// The number of addresses that a word has.
    step: u64,
}

impl MemoryContents {
    /// Creates a memory of zeros with a word at every `step` addresses.
    pub(super) fn new(step: u64) -> MemoryContents {
        MemoryContents { words: Rc::default(), accesses: Rc::default(), step }
    }

    /// Returns the word at an address.
    pub fn get(&self, address: u64) -> u64 {
        self.words.borrow().get(&(address / self.step)).copied().unwrap_or(0)
    }

    /// Sets the word at an address.
    pub fn set(&self, address: u64, word: u64) {
        self.words.borrow_mut().insert(address / self.step, word);
    }

    /// Returns how many words the design has read and written so far.
    pub fn accesses(&self) -> u64 {
        self.accesses.get()
    }

    /// Sets the bytes of a word that are 1 in `strobe`.
    pub(super) fn write(&self, address: u64, data: u64, strobe: u64) {
        let mask = bits_of(strobe);
        let mut words = self.words.borrow_mut();
        let word = words.entry(address / self.step).or_insert(0);
        *word = *word & !mask | data & mask;
    }

    /// Counts an access.
    pub(super) fn count(&self) {
        self.accesses.set(self.accesses.get() + 1);
    }
}

/// Returns the bits of the bytes that a strobe selects.
fn bits_of(strobe: u64) -> u64 {
    (0..8).filter(|b| strobe >> b & 1 == 1).fold(0, |mask, b| mask | 0xff << (8 * b))
}

/// Gives a memory model the methods of its contents.
macro_rules! has_contents {
    ($memory:ty) => {
        impl std::ops::Deref for $memory {
            type Target = $crate::bench::bus::MemoryContents;

            fn deref(&self) -> &Self::Target {
                &self.contents
            }
        }
    };
}
pub(super) use has_contents;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strobe_writes_its_bytes_alone() {
        let words = MemoryContents::new(8);
        assert_eq!(words.get(56), 0);
        words.set(57, 0x1122_3344_5566_7788);
        words.write(56, u64::MAX, 0b1000_0001);
        assert_eq!((words.get(56), words.get(63)), (0xff22_3344_5566_77ff, 0xff22_3344_5566_77ff));
        words.write(64, 0xabcd, 0);
        assert_eq!((words.get(64), words.accesses()), (0, 0));
        words.clone().count();
        assert_eq!(words.accesses(), 1);
    }
}
