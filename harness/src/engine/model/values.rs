//! Reads and writes of a model's signals: at once, without a scheduler.

use super::Model;
use super::raw::{RawSignal, Word};
use super::signal::{SignalId, SignalInfo};
use super::storage::{Storage, load, load_words, store, store_words};
use crate::engine::error::ModelError;

/// The data of a signal that a read or write needs.
#[derive(Clone, Copy)]
pub(super) struct Slot {
    pub data: *mut u8,
    pub target: *mut u8,
    pub mask: u64,
    pub storage: Storage,
    pub writable: bool,
}

impl Model {
    /// Returns names and addresses of the public variables of type `string`.
    pub(crate) fn texts(&self) -> &[(String, *mut u8)] {
        &self.texts
    }

    /// Returns the bytes of a `string`, by its place in [`Model::texts`].
    pub(crate) fn text(&self, index: usize) -> Vec<u8> {
        let mut length = 0;
        // SAFETY: the address is of a string of this live model, whose bytes are copied at once.
        unsafe {
            let bytes = (self.functions.hv_text_get)(self.texts[index].1, &mut length);
            if length == 0 { Vec::new() } else { std::slice::from_raw_parts(bytes.cast(), length as usize).to_vec() }
        }
    }

    /// Sets a `string`, by its place in [`Model::texts`].
    pub(crate) fn set_text(&mut self, index: usize, value: &[u8]) {
        // SAFETY: the address is of a string of this live model; the bytes are copied.
        unsafe { (self.functions.hv_text_set)(self.texts[index].1, value.as_ptr().cast(), value.len() as u64) };
    }

    /// Returns the name, direction, width and type of a signal.
    ///
    /// # Panics
    /// If the signal is of another model.
    pub fn info(&self, signal: SignalId) -> &SignalInfo {
        assert_eq!(signal.model, self.id, "a signal of one model was used on another");
        &self.signals[signal.index()]
    }

    /// Returns the value of a signal of at most 64 bits; the lowest 32 bits of a wider one.
    #[inline]
    pub fn get(&self, signal: SignalId) -> u64 {
        let slot = self.slot(signal);
        // SAFETY: the signal is of this live model.
        unsafe { load(slot.data, slot.storage) }
    }

    /// Sets an input (or a public internal) at once, without an evaluation.
    ///
    /// # Errors
    /// If the value does not fit, or the signal is an output or wider than 64 bits.
    #[inline]
    pub fn set(&mut self, signal: SignalId, value: u64) -> Result<(), ModelError> {
        let slot = self.slot(signal);
        if value & !slot.mask != 0 || !slot.writable {
            return Err(self.refused(self.info(signal), value));
        }
        // SAFETY: the signal is of this live model, borrowed alone.
        unsafe { store(slot.target, slot.storage, value) };
        Ok(())
    }

    #[inline(always)]
    fn slot(&self, signal: SignalId) -> Slot {
        assert!(signal.model == self.id, "a signal of one model was used on another");
        self.slots[signal.index()]
    }

    #[cold]
    fn refused(&self, info: &SignalInfo, value: u64) -> ModelError {
        if !self.is_writable(info) {
            return self.not_writable(info);
        }
        match info.check_unsigned(value) {
            Err(error) => error,
            Ok(()) => ModelError::TooWide { signal: info.name.clone(), width: info.width },
        }
    }

    /// Returns the value of a signal of any width as 32-bit words, lowest first.
    pub fn get_words(&self, signal: SignalId) -> Vec<u32> {
        let info = self.info(signal);
        // SAFETY: the signal is of this live model, and its storage says how many bytes it has.
        unsafe { load_words(info.data, info.storage) }
    }

    /// Sets an input of any width from 32-bit words, lowest first.
    ///
    /// # Errors
    /// If the value does not fit, or the signal is an output.
    pub fn set_words(&mut self, signal: SignalId, words: &[u32]) -> Result<(), ModelError> {
        let info = self.info(signal);
        if !self.is_writable(info) {
            return Err(self.refused(info, 0));
        }
        info.check_words(words)?;
        // SAFETY: as in `set`.
        unsafe { store_words(info.target, info.storage, words) };
        Ok(())
    }

    /// Returns the element of a memory.
    ///
    /// # Errors
    /// If the index is outside of the memory.
    pub fn get_element(&self, memory: SignalId, index: i64) -> Result<u64, ModelError> {
        let info = self.info(memory);
        let offset = info.element_offset(index)?;
        // SAFETY: the offset was checked.
        Ok(unsafe { info.load(offset) })
    }

    /// Returns the element of a memory of any width as 32-bit words, lowest first.
    ///
    /// # Errors
    /// If the index is outside of the memory.
    pub fn get_element_words(&self, memory: SignalId, index: i64) -> Result<Vec<u32>, ModelError> {
        let info = self.info(memory);
        let offset = info.element_offset(index)?;
        // SAFETY: the offset was checked.
        Ok(unsafe { load_words(info.data.add(offset), info.storage) })
    }

    /// Sets the element of a memory.
    ///
    /// # Errors
    /// If the index is outside of the memory, the value does not fit, or the memory is an output.
    pub fn set_element(&mut self, memory: SignalId, index: i64, value: u64) -> Result<(), ModelError> {
        let info = self.info(memory);
        let offset = info.element_offset(index)?;
        info.check_unsigned(value)?;
        if !self.is_writable(info) {
            return Err(self.refused(info, value));
        }
        // SAFETY: the offset was checked.
        unsafe { store(info.data.add(offset), info.storage, value) };
        Ok(())
    }

    /// Returns a bit of a register, or of a word of a memory: `word` counts from the lowest index, 0 for a register.
    ///
    /// # Errors
    /// If there is no such word or bit.
    pub fn bit(&self, register: SignalId, word: usize, bit: u32) -> Result<bool, ModelError> {
        let info = self.info(register);
        let (byte, mask) = place_of(info, word, bit)?;
        // SAFETY: the place was checked.
        Ok(unsafe { *info.data.add(byte) } & mask != 0)
    }

    /// Writes a bit of a register, or of a word of a memory, at once and without an evaluation, as a particle does.
    /// The next evaluation sees it. Unlike the other writes this one also works on an output of the top that is a
    /// register. The model must be built with [`Build::registers`](crate::engine::build::Build::registers): without it,
    /// logic may keep what it computed from the old value.
    ///
    /// # Errors
    /// If there is no such word or bit, or the signal is no register.
    pub fn set_bit(&mut self, register: SignalId, word: usize, bit: u32, value: bool) -> Result<(), ModelError> {
        let info = self.info(register);
        let (byte, mask) = place_of(info, word, bit)?;
        if !info.register {
            return Err(ModelError::NotRegister { signal: info.name.clone() });
        }
        // SAFETY: the place was checked, and the model is borrowed alone.
        unsafe {
            let byte = info.data.add(byte);
            *byte = if value { *byte | mask } else { *byte & !mask };
        }
        Ok(())
    }

    /// Replaces `into` by the stored bytes of all registers and memories: with the levels of the inputs the whole state
    /// of a model without latches that was built with [`Build::registers`](crate::engine::build::Build::registers).
    pub fn save_registers(&self, into: &mut Vec<u8>) {
        into.clear();
        for info in self.signals().iter().filter(|signal| signal.register) {
            // SAFETY: the signal is of this live model, and has that many bytes.
            into.extend(unsafe { std::slice::from_raw_parts(info.data, info.stored_bytes()) });
        }
    }

    /// Writes what [`Model::save_registers`] of an instance of the same library gave. The next evaluation sees it.
    ///
    /// # Errors
    /// If the bytes are of another model.
    pub fn load_registers(&mut self, from: &[u8]) -> Result<(), ModelError> {
        let registers = || self.signals().iter().filter(|signal| signal.register);
        if registers().map(SignalInfo::stored_bytes).sum::<usize>() != from.len() {
            return Err(ModelError::OtherRegisters { top: self.library().top().to_owned(), bytes: from.len() });
        }
        let mut rest = from;
        for info in registers() {
            let (bytes, after) = rest.split_at(info.stored_bytes());
            // SAFETY: the model is borrowed alone, and the signal has that many bytes.
            unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), info.data, bytes.len()) };
            rest = after;
        }
        Ok(())
    }

    /// Returns a signal by its address; `T` must be the type Verilator stores it in.
    ///
    /// # Errors
    /// If there is no such signal, it is a memory, or Verilator stores it in another type than `T`.
    pub fn raw<T: Word>(&self, name: &str) -> Result<RawSignal<T>, ModelError> {
        let info = self.info(self.find(name)?);
        if info.is_overridden() {
            let is = "is an `inout`, or can be forced: its value is decided in each evaluation";
            return Err(ModelError::WrongShape { signal: name.to_owned(), is, instead: "get and set" });
        }
        if info.range.is_some()
            || info.storage.bytes() * 8 != T::BITS as usize
            || matches!(info.storage, Storage::Wide(_)) != T::WIDE
        {
            let instead = match info.storage {
                Storage::U8 => "raw::<u8>",
                Storage::U16 => "raw::<u16>",
                Storage::U32 => "raw::<u32>",
                Storage::U64 => "raw::<u64>",
                Storage::Wide(_) => "raw::<[u32; N]>, N 32-bit words",
            };
            return Err(ModelError::WrongShape { signal: name.to_owned(), is: "is stored in another type", instead });
        }
        Ok(RawSignal { data: info.data.cast() })
    }
}

/// Returns the byte of a bit in the stored value, and its mask. Verilator stores values as words of the machine, which
/// has its lowest byte first, and wide values as 32-bit words, the lowest first.
fn place_of(info: &SignalInfo, word: usize, bit: u32) -> Result<(usize, u8), ModelError> {
    if word >= info.elements() {
        let (first, last) = (0, info.elements() as i64 - 1);
        return Err(ModelError::Address { memory: info.name.clone(), index: word as i64, first, last });
    }
    if bit >= info.width {
        return Err(ModelError::NoSuchBit { signal: info.name.clone(), bit, width: info.width });
    }
    Ok((word * info.storage.bytes() + bit as usize / 8, 1 << (bit % 8)))
}
