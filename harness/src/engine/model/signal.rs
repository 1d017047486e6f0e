//! The description of a signal: name, direction, width, sign, and the values it takes.

use super::storage::{Storage, load};
use crate::engine::build::{EnumItems, Field};
use crate::engine::error::ModelError;

/// The direction of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Driven by the bench.
    Input,
    /// Driven by the design.
    Output,
    /// Both.
    Inout,
    /// Inside the design.
    Internal,
}

/// A port, or an internal signal or memory made public.
#[derive(Debug, Clone)]
pub struct SignalInfo {
    /// The name below the top module, as written in the Verilog.
    pub name: String,
    /// The direction.
    pub direction: Direction,
    /// The width of a value in bits (of one element, if it is a memory).
    pub width: u32,
    /// The indices of the leftmost and the rightmost bit, as declared.
    pub bits: (i64, i64),
    /// Whether the Verilog type is signed.
    pub signed: bool,
    /// How Verilator stores it.
    pub storage: Storage,
    /// Whether it is a `real`, or an array of `real`, whose 64 bits are those of an `f64`.
    pub real: bool,
    /// Whether it is a register, or a memory that a clock writes: see [`Build::registers`].
    ///
    /// [`Build::registers`]: crate::build::Build::registers
    pub register: bool,
    /// The module in which it is declared, as written in the source.
    pub module: String,
    /// First and last index if it is a memory (unpacked array), as declared. Of several dimensions: the elements
    /// counted from 0, row by row, each dimension from its lowest index.
    pub range: Option<(i64, i64)>,
    /// The indices on the left and on the right of each unpacked dimension, outermost first, as declared.
    pub dimensions: Vec<(i64, i64)>,
    /// The items, if the type is an enumeration.
    pub items: EnumItems,
    /// The fields, if the type is a packed structure or union.
    pub fields: Vec<Field>,
    /// What is read.
    pub(crate) data: *mut u8,
    /// What is written: the same, except of signals that can be forced and of `inout`s, whose value the evaluation
    /// decides.
    pub(crate) target: *mut u8,
    pub(crate) force: Option<Force>,
}

/// The two signals by which another is forced, as places in the model's list.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Force {
    /// The bits that are forced.
    pub enable: u32,
    /// Their values.
    pub value: u32,
}

impl SignalInfo {
    /// Returns `true` if the bench's writes are only one part of the value.
    pub(crate) fn is_overridden(&self) -> bool {
        self.data != self.target
    }

    /// Returns a mask of the signal's bits, of up to 64.
    pub fn mask(&self) -> u64 {
        if self.width >= 64 { u64::MAX } else { (1 << self.width) - 1 }
    }

    /// Returns the name of a value, if the type is an enumeration that has it.
    pub fn item(&self, value: u64) -> Option<&str> {
        self.items.iter().find(|(_, v)| *v == value).map(|(name, _)| name.as_str())
    }

    /// Returns the value of an enumeration item.
    ///
    /// # Errors
    /// If the type has no item of that name: the error lists the items.
    pub fn value_of(&self, name: &str) -> Result<u64, ModelError> {
        self.items.iter().find(|(n, _)| n == name).map(|(_, v)| *v).ok_or_else(|| ModelError::NoSuchEnumItem {
            signal: self.name.clone(),
            name: name.to_owned(),
            nearest: self.items.iter().map(|(n, _)| n.clone()).take(8).collect(),
        })
    }

    pub(crate) fn elements(&self) -> usize {
        self.range.map_or(1, |(a, b)| a.abs_diff(b) as usize + 1)
    }

    /// Returns the number of bytes in which Verilator stores it, all elements together.
    pub(crate) fn stored_bytes(&self) -> usize {
        self.elements() * self.storage.bytes()
    }

    /// Returns the offset in bytes of the element at a declared index.
    pub(crate) fn element_offset(&self, index: i64) -> Result<usize, ModelError> {
        let (left, right) = self.range.unwrap_or((0, 0));
        let (low, high) = (left.min(right), left.max(right));
        if index < low || index > high {
            return Err(ModelError::Address { memory: self.name.clone(), index, first: low, last: high });
        }
        Ok((index - low) as usize * self.storage.bytes())
    }

    pub(crate) fn check_unsigned(&self, value: u64) -> Result<(), ModelError> {
        if value & !self.mask() == 0 { Ok(()) } else { Err(self.out_of_range(value.to_string(), false)) }
    }

    pub(crate) fn encode_signed(&self, value: i64) -> Result<u64, ModelError> {
        let fits = self.width >= 64 || (value >= -(1i64 << (self.width - 1)) && (value as i128) < 1i128 << self.width);
        if fits { Ok(value as u64 & self.mask()) } else { Err(self.out_of_range(value.to_string(), true)) }
    }

    /// Converts a value of this signal to a signed number.
    pub fn to_signed(&self, value: u64) -> i64 {
        let unused = 64 - self.width.min(64);
        ((value << unused) as i64) >> unused
    }

    pub(crate) fn check_words(&self, words: &[u32]) -> Result<(), ModelError> {
        let needed = self.width.div_ceil(32) as usize;
        let beyond = words.iter().skip(needed).any(|w| *w != 0);
        let top_bits = self.width % 32;
        let top = words.get(needed - 1).copied().unwrap_or(0);
        if beyond || (top_bits != 0 && top >> top_bits != 0) {
            let text: String = words.iter().rev().map(|w| format!("{w:08x}")).collect();
            return Err(self.out_of_range(format!("0x{}", text.trim_start_matches('0')), false));
        }
        Ok(())
    }

    fn out_of_range(&self, value: String, signed: bool) -> ModelError {
        let high = if self.width < 64 { self.mask().to_string() } else { format!("2^{} - 1", self.width) };
        let low = match (signed, self.width) {
            (true, 1..=63) => (-(1i64 << (self.width - 1))).to_string(),
            _ => "0".into(),
        };
        ModelError::OutOfRange { signal: self.name.clone(), value, width: self.width, low, high }
    }

    /// Returns the stored value of the element at an offset.
    ///
    /// # Safety
    /// The instance must be alive, the offset inside the signal, and its storage not wide.
    #[inline(always)]
    pub(crate) unsafe fn load(&self, offset: usize) -> u64 {
        // SAFETY: as the caller promises.
        unsafe { load(self.data.add(offset), self.storage) }
    }
}

/// A signal of one model, found by name once and then used without names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SignalId {
    pub(super) index: u32,
    pub(super) model: u32,
}

impl SignalId {
    pub(crate) fn index(self) -> usize {
        self.index as usize
    }

    pub(crate) fn model(self) -> u32 {
        self.model
    }
}
