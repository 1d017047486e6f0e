//! Handles of signals: of at most 64 bits, wider ones, memories.

use std::rc::Rc;

use super::future::Wait;
use super::scheduler::Core;
use super::trigger::{Edge, Trigger};
use crate::bench::error::{Error, SimError};
use crate::engine::error::ModelError;
use crate::engine::model::{SignalId, SignalInfo, Storage, load, load_array, load_words};

/// A signal of at most 64 bits.
#[derive(Clone)]
pub struct Signal {
    pub(crate) core: Rc<Core>,
    id: SignalId,
    data: *mut u8,
    storage: Storage,
    mask: u64,
    writable: bool,
}

impl Signal {
    pub(crate) fn new(core: &Rc<Core>, id: SignalId) -> Result<Signal, ModelError> {
        let model = core.model.borrow();
        let info = model.info(id);
        check_bits(info)?;
        Signal::of_bits(core, id, info)
    }

    /// Returns a signal without regard to what its bits mean.
    fn of_bits(core: &Rc<Core>, id: SignalId, info: &SignalInfo) -> Result<Signal, ModelError> {
        if let Storage::Wide(_) = info.storage {
            return Err(ModelError::TooWide { signal: info.name.clone(), width: info.width });
        }
        Ok(Signal {
            core: core.clone(),
            id,
            data: info.data,
            storage: info.storage,
            mask: info.mask(),
            writable: core.model.borrow().is_writable(info),
        })
    }

    /// Returns the value now, unsigned. A buffered write is read back only after it was put.
    #[inline(always)]
    pub fn get(&self) -> u64 {
        // SAFETY: `core` keeps the model alive; its storage is not wide.
        unsafe { load(self.data, self.storage) }
    }

    /// Returns the value with the writes that are buffered so far: what it will have, unless the design changes it
    /// before.
    pub fn get_pending(&self) -> u64 {
        self.core.pending(self.id.index() as u32)
    }

    /// Returns the value in two's complement.
    #[inline]
    pub fn get_signed(&self) -> i64 {
        let unused = self.mask.leading_zeros();
        ((self.get() << unused) as i64) >> unused
    }

    /// Returns `true` if the signal is not 0.
    #[inline(always)]
    pub fn is_high(&self) -> bool {
        self.get() != 0
    }

    /// Buffers a write. It is put when all tasks of this round have run.
    ///
    /// # Errors
    /// If the value does not fit, the signal is an output, or the region is `ReadOnly`.
    #[inline(always)]
    pub fn set(&self, value: u64) -> Result<(), ModelError> {
        if value & !self.mask != 0 || !self.writable {
            self.check_unusual(value)?;
        }
        self.core.write(self.id.index() as u32, value)
    }

    /// Buffers a write of the bits of `mask`. The others have what they have when the write is put, after the
    /// evaluation of the edge that the task may have waited for.
    ///
    /// # Errors
    /// As [`Signal::set`], of `value` and of `mask`. Bits of `value` outside of `mask` are refused too.
    pub fn set_bits(&self, mask: u64, value: u64) -> Result<(), ModelError> {
        if (mask | value) & !self.mask != 0 || !self.writable {
            self.check_unusual(mask | value)?;
        }
        if value & !mask != 0 {
            return Err(ModelError::OutsideOfMask { signal: self.core.signal_name(self.id.index() as u32) });
        }
        self.core.write_bits(self.id.index() as u32, mask, value)
    }

    /// Buffers a write of a signed number: from `-2^(w-1)` to `2^w - 1`.
    ///
    /// # Errors
    /// As [`Signal::set`].
    pub fn set_signed(&self, value: i64) -> Result<(), ModelError> {
        let encoded = self.core.model.borrow().info(self.id).encode_signed(value)?;
        self.set(encoded)
    }

    /// Buffers a write of an enumeration item, by its name.
    ///
    /// # Errors
    /// As [`Signal::set`], and if the type has no item of that name.
    pub fn set_named(&self, item: &str) -> Result<(), ModelError> {
        let value = self.core.model.borrow().info(self.id).value_of(item)?;
        self.set(value)
    }

    /// Returns the name of the value, if the type is an enumeration that has it.
    pub fn get_named(&self) -> Option<String> {
        self.core.model.borrow().info(self.id).item(self.get()).map(str::to_owned)
    }

    /// Returns the error of a write of a value that does not fit, or to a signal that a bench may not write.
    #[cold]
    fn check_unusual(&self, value: u64) -> Result<(), ModelError> {
        let model = self.core.model.borrow();
        let info = model.info(self.id);
        if !self.writable {
            self.core.check_written(&model, self.id)?;
        }
        if value & !self.mask != 0 {
            info.check_unsigned(value)?;
            return Err(ModelError::TooWide { signal: info.name.clone(), width: info.width });
        }
        Ok(())
    }

    /// Waits for the change from 0 to 1.
    #[inline]
    pub fn rising_edge(&self) -> Wait {
        self.edge(Edge::Rising)
    }

    /// Waits for the change from 1 to 0.
    #[inline]
    pub fn falling_edge(&self) -> Wait {
        self.edge(Edge::Falling)
    }

    /// Waits for any change.
    #[inline]
    pub fn value_change(&self) -> Wait {
        self.edge(Edge::Any)
    }

    /// Waits for the change that `edge` names.
    #[inline]
    pub fn edge(&self, edge: Edge) -> Wait {
        Wait::new(&self.core, Trigger::Edge(self.id, edge))
    }

    /// Waits for the `count`-th rising edge from now.
    #[inline]
    pub fn cycles(&self, count: u64) -> Wait {
        Wait::new(&self.core, Trigger::Edges(self.id, Edge::Rising, count))
    }

    /// Waits for the first rising edge at which a condition holds, evaluated with the values before that edge, and
    /// returns how many edges that took: 1 if it holds at the next one.
    ///
    /// ```no_run
    /// # use hoverlock_harness::{Error, sim::Dut};
    /// # async fn example(dut: Dut) -> Result<(), Error> {
    /// let (clk, busy) = (dut.signal("clk")?, dut.signal("busy")?);
    /// clk.cycles_until(10_000, || !busy.is_high()).await?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`SimError::TooManyCycles`] if it does not hold at any of the next `limit` edges.
    pub async fn cycles_until(&self, limit: u64, mut condition: impl FnMut() -> bool) -> Result<u64, SimError> {
        for cycle in 1..=limit {
            self.rising_edge().await;
            if condition() {
                return Ok(cycle);
            }
        }
        let clock = self.core.model.borrow().info(self.id).name.clone();
        Err(SimError::TooManyCycles { clock, limit, time: self.core.now() })
    }

    /// Returns the id of the signal in its model.
    pub fn id(&self) -> SignalId {
        self.id
    }

    /// Returns the name, direction, width and type.
    pub fn info(&self) -> SignalInfo {
        self.core.model.borrow().info(self.id).clone()
    }

    pub(crate) fn data(&self) -> *mut u8 {
        self.data
    }

    pub(crate) fn storage(&self) -> Storage {
        self.storage
    }

    pub(crate) fn mask(&self) -> u64 {
        self.mask
    }

    pub(crate) fn width(&self) -> u32 {
        self.mask.count_ones()
    }
}

/// A signal of any width, as 32-bit words, lowest first.
#[derive(Clone)]
pub struct Wide {
    core: Rc<Core>,
    id: SignalId,
    data: *mut u8,
    storage: Storage,
    width: u32,
}

impl Wide {
    pub(crate) fn new(core: &Rc<Core>, id: SignalId) -> Result<Wide, ModelError> {
        let model = core.model.borrow();
        let info = model.info(id);
        check_bits(info)?;
        Ok(Wide { core: core.clone(), id, data: info.data, storage: info.storage, width: info.width })
    }

    /// Returns the 32-bit words of the value now, lowest first.
    pub fn get(&self) -> Vec<u32> {
        // SAFETY: `core` keeps the model alive.
        unsafe { load_words(self.data, self.storage) }
    }

    /// Returns the lowest `N` words of the value without an allocation, for reads in every cycle; words that the signal
    /// does not have are 0.
    ///
    /// ```
    /// # use hoverlock_harness::{Error, build::Build, sim::Sim};
    /// # let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/designs/wide.v");
    /// # let mut sim = Sim::new(Build::new("wide").source(source).compile()?.instance()?)?;
    /// let dut = sim.dut();
    /// let (b, swapped) = (dut.wide("b")?, dut.wide("b_swapped")?);
    /// sim.run(async {
    ///     b.set(&[1, 2, 3])?;
    ///     dut.read_only().await;
    ///     assert_eq!(swapped.get_array(), [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 0]);
    ///     Ok::<(), Error>(())
    /// })?;
    /// # Ok::<(), Error>(())
    /// ```
    #[inline]
    pub fn get_array<const N: usize>(&self) -> [u32; N] {
        // SAFETY: `core` keeps the model alive.
        unsafe { load_array(self.data, self.storage) }
    }

    /// Returns the `width` bits from bit `low` on, at most 64.
    pub fn get_bits(&self, low: u32, width: u32) -> u64 {
        let words = self.get();
        (0..width.min(64))
            .filter(|b| {
                let at = low + b;
                words.get((at / 32) as usize).is_some_and(|w| w >> (at % 32) & 1 == 1)
            })
            .fold(0, |value, b| value | 1 << b)
    }

    /// Buffers a write of 32-bit words, lowest first; words that are not given are 0.
    ///
    /// # Errors
    /// As [`Signal::set`].
    pub fn set(&self, words: &[u32]) -> Result<(), ModelError> {
        let model = self.core.model.borrow();
        self.core.check_written(&model, self.id)?;
        model.info(self.id).check_words(words)?;
        drop(model);
        self.core.write_words(self.id.index() as u32, words)
    }

    /// Buffers a write of the bits of `mask`, as 32-bit words, lowest first. The others have what they have when the
    /// write is put, after the evaluation of the edge that the task may have waited for.
    ///
    /// # Errors
    /// As [`Wide::set`], of `words` and of `mask`. Bits of `words` outside of `mask` are refused too.
    pub fn set_bits(&self, mask: &[u32], words: &[u32]) -> Result<(), ModelError> {
        let model = self.core.model.borrow();
        self.core.check_written(&model, self.id)?;
        let info = model.info(self.id);
        info.check_words(mask)?;
        info.check_words(words)?;
        let masks = mask.iter().copied().chain(std::iter::repeat(0));
        if words.iter().zip(masks).any(|(word, mask)| word & !mask != 0) {
            return Err(ModelError::OutsideOfMask { signal: info.name.clone() });
        }
        drop(model);
        self.core.write_word_bits(self.id.index() as u32, mask, words)
    }

    /// Waits for any change.
    pub fn value_change(&self) -> Wait {
        Wait::new(&self.core, Trigger::Edge(self.id, Edge::Any))
    }

    /// Returns the width in bits.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the name, direction, width and type.
    pub fn info(&self) -> SignalInfo {
        self.core.model.borrow().info(self.id).clone()
    }

    /// Returns the id of the signal in its model.
    pub fn id(&self) -> SignalId {
        self.id
    }
}

/// A `real`.
#[derive(Clone)]
pub struct Real(Signal);

impl Real {
    pub(crate) fn new(core: &Rc<Core>, id: SignalId) -> Result<Real, ModelError> {
        let model = core.model.borrow();
        let info = model.info(id);
        if !info.real || info.range.is_some() {
            return Err(wrong_shape(info, "is no `real`", "signal"));
        }
        Signal::of_bits(core, id, info).map(Real)
    }

    /// Returns the value now.
    pub fn get(&self) -> f64 {
        f64::from_bits(self.0.get())
    }

    /// Buffers a write.
    ///
    /// # Errors
    /// As [`Signal::set`].
    pub fn set(&self, value: f64) -> Result<(), ModelError> {
        self.0.set(value.to_bits())
    }

    /// Waits for any change.
    pub fn value_change(&self) -> Wait {
        self.0.value_change()
    }

    /// Returns the name, direction and type.
    pub fn info(&self) -> SignalInfo {
        self.0.info()
    }
}

/// A `string` inside the design.
#[derive(Clone)]
pub struct Text {
    core: Rc<Core>,
    index: usize,
    name: String,
}

impl Text {
    pub(crate) fn new(core: &Rc<Core>, name: &str) -> Result<Text, ModelError> {
        let model = core.model.borrow();
        match model.texts().iter().position(|(of, _)| of == name) {
            Some(index) => Ok(Text { core: core.clone(), index, name: name.to_owned() }),
            None => Err(match model.find(name) {
                Ok(id) => wrong_shape(model.info(id), "is no `string`", "signal"),
                Err(error) => error,
            }),
        }
    }

    /// Returns the bytes now.
    pub fn get(&self) -> Vec<u8> {
        self.core.model.borrow().text(self.index)
    }

    /// Buffers a write.
    ///
    /// # Errors
    /// If the region is `ReadOnly`.
    pub fn set(&self, value: &[u8]) -> Result<(), ModelError> {
        self.core.write_text(self.index, value)
    }

    /// Returns the name below the top module.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// A memory made public, or a port that is an array.
#[derive(Clone)]
pub struct Memory {
    core: Rc<Core>,
    id: SignalId,
    info: SignalInfo,
}

impl Memory {
    pub(crate) fn new(core: &Rc<Core>, id: SignalId) -> Result<Memory, ModelError> {
        let info = core.model.borrow().info(id).clone();
        if info.range.is_none() {
            return Err(wrong_shape(&info, "is not a memory", "signal"));
        }
        Ok(Memory { core: core.clone(), id, info })
    }

    /// Returns the number of elements.
    #[allow(clippy::len_without_is_empty, reason = "a memory of no elements cannot be declared")]
    pub fn len(&self) -> usize {
        self.info.elements()
    }

    /// Converts one index for each dimension, as declared, to the index that the other functions take.
    ///
    /// # Errors
    /// If their number is not that of the dimensions, or one is outside of its dimension.
    pub fn index(&self, indices: &[i64]) -> Result<i64, ModelError> {
        let dimensions = &self.info.dimensions;
        if indices.len() != dimensions.len() {
            return Err(wrong_shape(&self.info, "has another number of dimensions", "one index for each"));
        }
        if let [only] = indices {
            self.info.element_offset(*only)?;
            return Ok(*only);
        }
        indices.iter().zip(dimensions).try_fold(0, |flat, (index, (left, right))| {
            let (low, high) = ((*left).min(*right), (*left).max(*right));
            if *index < low || *index > high {
                let memory = self.info.name.clone();
                return Err(ModelError::Address { memory, index: *index, first: low, last: high });
            }
            Ok(flat * (high - low + 1) + index - low)
        })
    }

    /// Returns the element at an index, as declared in the Verilog.
    ///
    /// # Errors
    /// If the index is outside of the memory, or its elements are wider than 64 bits or `real`.
    pub fn get(&self, index: i64) -> Result<u64, ModelError> {
        self.check_narrow()?;
        let offset = self.info.element_offset(index)?;
        // SAFETY: `core` keeps the model alive; the offset was checked.
        Ok(unsafe { self.info.load(offset) })
    }

    /// Buffers a write of the element at an index, as declared in the Verilog.
    ///
    /// # Errors
    /// If the index is outside of the memory, the value does not fit, the memory is an output or has elements wider
    /// than 64 bits or `real`, or the region is `ReadOnly`.
    pub fn set(&self, index: i64, value: u64) -> Result<(), ModelError> {
        self.check_narrow()?;
        self.check_writable()?;
        let offset = self.info.element_offset(index)?;
        self.info.check_unsigned(value)?;
        self.core.write_element(self.id.index() as u32, offset, value)
    }

    /// Returns the `real` at an index, as declared in the Verilog.
    ///
    /// # Errors
    /// If the index is outside of the memory, or its elements are no `real`.
    pub fn get_real(&self, index: i64) -> Result<f64, ModelError> {
        self.check_real()?;
        let offset = self.info.element_offset(index)?;
        // SAFETY: `core` keeps the model alive; the offset was checked.
        Ok(f64::from_bits(unsafe { self.info.load(offset) }))
    }

    /// Buffers a write of the `real` at an index, as declared in the Verilog.
    ///
    /// # Errors
    /// If the index is outside of the memory, its elements are no `real`, the memory is an output, or the region is
    /// `ReadOnly`.
    pub fn set_real(&self, index: i64, value: f64) -> Result<(), ModelError> {
        self.check_real()?;
        self.check_writable()?;
        let offset = self.info.element_offset(index)?;
        self.core.write_element(self.id.index() as u32, offset, value.to_bits())
    }

    /// Returns the element at an index, of any width, as 32-bit words, lowest first.
    ///
    /// # Errors
    /// If the index is outside of the memory.
    pub fn get_words(&self, index: i64) -> Result<Vec<u32>, ModelError> {
        let offset = self.info.element_offset(index)?;
        // SAFETY: `core` keeps the model alive; the offset was checked.
        Ok(unsafe { load_words(self.info.data.add(offset), self.info.storage) })
    }

    /// Buffers a write of the element at an index, of any width, as 32-bit words, lowest first.
    ///
    /// # Errors
    /// If the index is outside of the memory, the value does not fit, the memory is an output, or the region is
    /// `ReadOnly`.
    pub fn set_words(&self, index: i64, words: &[u32]) -> Result<(), ModelError> {
        self.check_writable()?;
        let offset = self.info.element_offset(index)?;
        self.info.check_words(words)?;
        self.core.write_element_words(self.id.index() as u32, offset, words)
    }

    fn check_real(&self) -> Result<(), ModelError> {
        if self.info.real {
            Ok(())
        } else {
            Err(wrong_shape(&self.info, "has elements that are no `real`", "get and set"))
        }
    }

    fn check_narrow(&self) -> Result<(), ModelError> {
        if self.info.real {
            return Err(wrong_shape(&self.info, "has elements that are `real`", "get_real and set_real"));
        }
        match self.info.storage {
            Storage::Wide(_) => {
                Err(wrong_shape(&self.info, "has elements wider than 64 bits", "get_words and set_words"))
            }
            _ => Ok(()),
        }
    }

    fn check_writable(&self) -> Result<(), ModelError> {
        self.core.check_written(&self.core.model.borrow(), self.id)
    }

    /// Returns all elements of at most 64 bits, lowest index first; of wider ones, their lowest 32 bits; of `real`s,
    /// the bits of each `f64`.
    pub fn to_vec(&self) -> Vec<u64> {
        let bytes = self.info.storage.bytes();
        // SAFETY: the offsets run over the memory's own elements.
        (0..self.len()).map(|at| unsafe { self.info.load(at * bytes) }).collect()
    }

    /// Buffers writes of elements from the lowest index on, such as a program.
    ///
    /// # Errors
    /// As [`Memory::set`]; elements before the one refused are written.
    pub fn fill(&self, values: impl IntoIterator<Item = u64>) -> Result<(), ModelError> {
        let low = self.info.range.map_or(0, |(a, b)| a.min(b));
        values.into_iter().zip(low..).try_for_each(|(value, index)| self.set(index, value))
    }
}

/// Returns an error for a memory or a `real`.
fn check_bits(info: &SignalInfo) -> Result<(), ModelError> {
    if info.range.is_some() {
        return Err(wrong_shape(info, "is a memory", "memory"));
    }
    if info.real {
        return Err(wrong_shape(info, "is a `real`", "real"));
    }
    Ok(())
}

fn wrong_shape(info: &SignalInfo, is: &'static str, instead: &'static str) -> ModelError {
    ModelError::WrongShape { signal: info.name.clone(), is, instead }
}

/// Returns an error if two values differ, for benches that return errors rather than panic.
///
/// # Errors
/// [`Error::Bench`] if they differ.
pub fn expect_equal<T: PartialEq + std::fmt::Debug>(what: &str, found: T, expected: T) -> Result<(), Error> {
    if found == expected { Ok(()) } else { Err(Error::Bench(format!("{what} is {found:?}, expected {expected:?}"))) }
}
