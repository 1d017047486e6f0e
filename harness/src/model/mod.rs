//! One instance of a model: its ports and public signals by name, `eval`, and what the Verilog said.
//!
//! A [`Model`] may be sent to another thread but not shared between threads; each has a Verilator context of its own,
//! so any number of instances of any number of models live side by side.
//!
//! Values are unsigned words of at most 64 bits; wider signals are little-endian lists of 32-bit words. Verilator has
//! two states: there is no X and no Z. What is not reset starts as zero, or random with
//! [`Initial::Random`](crate::build::Initial::Random).

mod library;

use std::cell::Cell;
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char};
use std::marker::PhantomData;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

pub use library::Library;
use library::{Functions, Instance, RawPort, RawVariable};

use crate::build::{EnumItems, Initial, Trace};
use crate::error::{Error, ModelError, nearest};
use crate::time::Time;

/// How an instance begins.
#[derive(Debug, Clone, Default)]
pub struct InstanceOptions {
    /// Seed of random initial values and of `$random`.
    pub seed: u64,
    /// Arguments such as `+verbose` that `$test$plusargs` and `$value$plusargs` see.
    pub plusargs: Vec<String>,
}

/// Which way a signal goes.
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

/// How Verilator stores a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// Up to 8 bits.
    U8,
    /// Up to 16 bits.
    U16,
    /// Up to 32 bits.
    U32,
    /// Up to 64 bits.
    U64,
    /// More, in so many 32-bit words.
    Wide(u32),
}

impl Storage {
    fn of(width: u32) -> Storage {
        match width {
            0..=8 => Storage::U8,
            9..=16 => Storage::U16,
            17..=32 => Storage::U32,
            33..=64 => Storage::U64,
            _ => Storage::Wide(width.div_ceil(32)),
        }
    }

    pub(crate) fn bytes(self) -> usize {
        match self {
            Storage::U8 => 1,
            Storage::U16 => 2,
            Storage::U32 => 4,
            Storage::U64 => 8,
            Storage::Wide(words) => 4 * words as usize,
        }
    }
}

/// A port, or an internal signal or memory made public.
#[derive(Debug, Clone)]
pub struct SignalInfo {
    /// Its name below the top module, as written in the Verilog.
    pub name: String,
    /// Which way it goes.
    pub direction: Direction,
    /// Bits of a value (of one element, if it is a memory).
    pub width: u32,
    /// Whether the Verilog type is signed.
    pub signed: bool,
    /// How it is stored.
    pub storage: Storage,
    /// First and last index if it is a memory (unpacked array), as declared.
    pub range: Option<(i64, i64)>,
    /// The names of its values if its type is an enumeration.
    pub items: EnumItems,
    pub(crate) data: *mut u8,
}

impl SignalInfo {
    /// A one for every bit, of up to 64.
    pub fn mask(&self) -> u64 {
        if self.width >= 64 { u64::MAX } else { (1 << self.width) - 1 }
    }

    /// The name of a value, if the type is an enumeration that has it.
    pub fn item(&self, value: u64) -> Option<&str> {
        self.items.iter().find(|(_, v)| *v == value).map(|(name, _)| name.as_str())
    }

    /// The value of a name.
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

    /// The offset in bytes of the element at a declared index.
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

    /// A value of this signal as a signed number.
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

    /// The stored value of the element at an offset.
    ///
    /// # Safety
    /// The instance must be alive, the offset inside the signal, and its storage not wide.
    #[inline(always)]
    pub(crate) unsafe fn load(&self, offset: usize) -> u64 {
        // SAFETY: as the caller promises.
        unsafe { load(self.data.add(offset), self.storage) }
    }
}

/// Reads a word of at most 64 bits.
///
/// # Safety
/// `data` must point to a live value of that storage, which must not be wide.
#[inline(always)]
pub(crate) unsafe fn load(data: *const u8, storage: Storage) -> u64 {
    // SAFETY: as the caller promises; Verilator aligns its variables.
    unsafe {
        match storage {
            Storage::U8 => u64::from(*data),
            Storage::U16 => u64::from(*data.cast::<u16>()),
            Storage::U32 | Storage::Wide(_) => u64::from(*data.cast::<u32>()),
            Storage::U64 => *data.cast::<u64>(),
        }
    }
}

/// Writes a word of at most 64 bits; bits above the storage are lost.
///
/// # Safety
/// As [`load`], and nobody may be reading.
#[inline(always)]
pub(crate) unsafe fn store(data: *mut u8, storage: Storage, value: u64) {
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::U8 => *data = value as u8,
            Storage::U16 => *data.cast::<u16>() = value as u16,
            Storage::U32 | Storage::Wide(_) => *data.cast::<u32>() = value as u32,
            Storage::U64 => *data.cast::<u64>() = value,
        }
    }
}

/// What the Verilog said during an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// A line of `$display` and its kin, `$error` and `$warning` included.
    Text(String),
    /// `$finish`.
    Finish {
        /// The Verilog file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// `$stop`, `$error`, `$fatal` or a failed assertion; what it said is in the text before it.
    Stop {
        /// The Verilog file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// The model cannot go on, for instance because it does not settle.
    Fatal {
        /// What it says.
        message: String,
        /// The file.
        file: String,
        /// The line in it.
        line: u32,
    },
}

/// A signal of one model, found by name once and then used without names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SignalId {
    index: u32,
    model: u32,
}

impl SignalId {
    pub(crate) fn index(self) -> usize {
        self.index as usize
    }

    pub(crate) fn model(self) -> u32 {
        self.model
    }
}

/// A type Verilator stores values in.
pub trait Word: Copy + sealed::Sealed {
    /// The widest signal it holds.
    const BITS: u32;
    /// Whether it holds signals wider than 64 bits, as 32-bit words, the lowest first.
    const WIDE: bool = false;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
    impl Sealed for u64 {}
    impl<const N: usize> Sealed for [u32; N] {}
}

impl Word for u8 {
    const BITS: u32 = 8;
}
impl Word for u16 {
    const BITS: u32 = 16;
}
impl Word for u32 {
    const BITS: u32 = 32;
}
impl Word for u64 {
    const BITS: u32 = 64;
}
impl<const N: usize> Word for [u32; N] {
    const BITS: u32 = 32 * N as u32;
    const WIDE: bool = true;
}

/// A signal by its bare address, for loops that must be as fast as C++.
#[derive(Debug, Clone, Copy)]
pub struct RawSignal<T: Word> {
    data: *mut T,
}

impl<T: Word> RawSignal<T> {
    /// Reads the stored word.
    ///
    /// # Safety
    /// The model must be alive and on this thread.
    #[inline(always)]
    pub unsafe fn get(self) -> T {
        // SAFETY: the pointer was taken from the model with this word's size.
        unsafe { *self.data }
    }

    /// Writes the stored word; bits above the signal's width corrupt the model's arithmetic.
    ///
    /// # Safety
    /// The model must be alive and on this thread, and the value within the signal's width.
    #[inline(always)]
    pub unsafe fn set(self, value: T) {
        // SAFETY: as above.
        unsafe { *self.data = value }
    }
}

static NEXT_MODEL: AtomicU32 = AtomicU32::new(1);

thread_local! {
    /// The model whose context the runtime has on this thread, so that it is set only when it changes.
    static BOUND: Cell<u32> = const { Cell::new(0) };
}

/// What an access needs to know of a signal, and no more.
#[derive(Clone, Copy)]
struct Slot {
    data: *mut u8,
    mask: u64,
    storage: Storage,
    writable: bool,
}

/// One instance of a built model.
pub struct Model {
    raw: Instance,
    functions: Functions,
    pending: *const u8,
    library: Library,
    id: u32,
    signals: Vec<SignalInfo>,
    slots: Vec<Slot>,
    by_name: HashMap<String, u32>,
    femtoseconds_per_tick: u64,
    time: Time,
    /// `time` in ticks, what is left of it in femtoseconds, and the last span with its quotient and remainder.
    ticks: u64,
    rest: u64,
    last_span: (u64, u64, u64),
    messages: Vec<Message>,
    partial_line: String,
    dead: Option<ModelError>,
    initial_done: bool,
    /// May move to another thread, may not be shared.
    _not_sync: PhantomData<std::cell::Cell<()>>,
}

// SAFETY: the instance is owned alone, and the runtime's thread-local context is set before every call into it.
unsafe impl Send for Model {}

impl Model {
    fn new(library: Library, options: &InstanceOptions) -> Result<Model, ModelError> {
        let functions = *library.functions();
        let failed = |reason: &str| ModelError::Instance { top: library.top().to_owned(), reason: reason.into() };
        let mut arguments = vec![c"hoverlock".to_owned()];
        for argument in &options.plusargs {
            arguments.push(CString::new(argument.as_str()).map_err(|_| failed("a plusarg holds a zero byte"))?);
        }
        let pointers: Vec<*const c_char> = arguments.iter().map(|a| a.as_ptr()).collect();
        let random_reset = if library.record().initial == Initial::Random { 2 } else { 0 };
        BOUND.set(0);
        // SAFETY: the pointers are valid for the call; the runtime copies what it keeps.
        let raw = unsafe { (functions.hv_new)(options.seed, random_reset, pointers.len() as i32, pointers.as_ptr()) };
        if raw.is_null() {
            return Err(failed("out of memory"));
        }
        // SAFETY: the instance is alive until drop.
        let (pending, precision) = unsafe { ((functions.hv_pending)(raw), (functions.hv_precision)(raw)) };
        let mut model = Model {
            raw,
            functions,
            pending,
            id: NEXT_MODEL.fetch_add(1, Ordering::Relaxed),
            signals: Vec::new(),
            slots: Vec::new(),
            by_name: HashMap::new(),
            femtoseconds_per_tick: 10u64.pow((15 + precision.clamp(-15, 0)) as u32),
            time: Time::ZERO,
            ticks: 0,
            rest: 0,
            last_span: (0, 0, 0),
            messages: Vec::new(),
            partial_line: String::new(),
            dead: None,
            initial_done: false,
            library,
            _not_sync: PhantomData,
        };
        model.fetch()?;
        model.find_ports();
        model.find_internals();
        Ok(model)
    }

    fn find_ports(&mut self) {
        let mut list: *const RawPort = std::ptr::null();
        // SAFETY: the shim gives its own table, which lives as long as the instance.
        let ports = unsafe {
            let count = (self.functions.hv_ports)(self.raw, &mut list) as usize;
            if count == 0 { &[] } else { std::slice::from_raw_parts(list, count) }
        };
        for port in ports {
            // SAFETY: a literal of the generated table.
            let name = unsafe { CStr::from_ptr(port.name) }.to_string_lossy().into_owned();
            let record = self.library.record().ports.iter().find(|p| p.name == name);
            let direction = match port.direction {
                0 => Direction::Input,
                1 => Direction::Output,
                _ => Direction::Inout,
            };
            // A wide value is an array of words to C++, as is a port that is an array.
            let storage = Storage::of(port.width);
            let total = (port.element_bytes * port.elements) as usize;
            let elements = (total / storage.bytes()) as u64;
            let declared = record.and_then(|r| r.range).filter(|(a, b)| a.abs_diff(*b) + 1 == elements);
            let range = (elements > 1).then(|| declared.unwrap_or((0, elements as i64 - 1)));
            let (signed, items) = record.map_or((false, Vec::new()), |r| (r.signed, r.items.clone()));
            self.add(SignalInfo { name, direction, width: port.width, signed, storage, range, items, data: port.data });
        }
    }

    fn find_internals(&mut self) {
        let internals = self.library.record().internals.clone();
        for variable in internals {
            let scope = CString::new(format!("TOP.{}", variable.scope));
            let name = CString::new(variable.name.as_str());
            let (Ok(scope), Ok(name)) = (scope, name) else { continue };
            let mut raw = RawVariable {
                data: std::ptr::null_mut(),
                packed_left: 0,
                packed_right: 0,
                dimensions: 0,
                left: 0,
                right: 0,
                element_bytes: 0,
                kind: 0,
            };
            // SAFETY: strings and the result live through the call.
            let found = unsafe { (self.functions.hv_variable)(self.raw, scope.as_ptr(), name.as_ptr(), &mut raw) };
            let width = raw.packed_left.abs_diff(raw.packed_right) + 1;
            // A `real` or a string calls itself one bit wide, and is stored in more than that takes.
            let vector = raw.element_bytes as usize == Storage::of(width).bytes();
            if found == 0 || !vector || raw.dimensions > 1 {
                continue;
            }
            self.add(SignalInfo {
                name: variable.path,
                direction: Direction::Internal,
                width,
                signed: variable.signed,
                storage: Storage::of(width),
                range: (raw.dimensions == 1).then_some((i64::from(raw.left), i64::from(raw.right))),
                items: variable.items,
                data: raw.data,
            });
        }
    }

    fn add(&mut self, signal: SignalInfo) {
        self.by_name.insert(signal.name.clone(), self.signals.len() as u32);
        self.slots.push(Slot {
            data: signal.data,
            mask: signal.mask(),
            storage: signal.storage,
            writable: signal.direction != Direction::Output && !matches!(signal.storage, Storage::Wide(_)),
        });
        self.signals.push(signal);
    }

    /// The library it was made from.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// All ports, in the order of the Verilog, then the public internals.
    pub fn signals(&self) -> &[SignalInfo] {
        &self.signals
    }

    /// The signal of that name; `a.b` also finds a port written `a$b`.
    pub fn find(&self, name: &str) -> Result<SignalId, ModelError> {
        let index = self.by_name.get(name).or_else(|| self.by_name.get(&name.replace('.', "$")));
        index.map(|index| SignalId { index: *index, model: self.id }).ok_or_else(|| {
            let record = self.library.record();
            if record.internals.iter().any(|v| v.path == name) || record.odd_ports.iter().any(|port| port == name) {
                return ModelError::NotReachable { name: name.to_owned(), top: self.library.top().to_owned() };
            }
            let mut near = nearest(name, self.signals.iter().map(|s| s.name.as_str()));
            let hidden: Vec<String> = nearest(name, self.library.record().names.iter().map(String::as_str));
            for other in hidden {
                if !self.by_name.contains_key(&other) && near.len() < 8 {
                    let asked_for = self.library.record().internals.iter().any(|v| v.path == other);
                    near.push(if asked_for {
                        format!("{other} (of a shape that is not reachable)")
                    } else {
                        format!("{other} (not public: add .internal(\"{other}\") to the build)")
                    });
                }
            }
            ModelError::NoSuchSignal { name: name.to_owned(), top: self.library.top().to_owned(), nearest: near }
        })
    }

    /// What is known of a signal.
    ///
    /// # Panics
    /// If the signal is of another model.
    pub fn info(&self, signal: SignalId) -> &SignalInfo {
        assert_eq!(signal.model, self.id, "a signal of one model was used on another");
        &self.signals[signal.index()]
    }

    /// The value of a signal of at most 64 bits (of a wider one, its lowest 32).
    #[inline]
    pub fn get(&self, signal: SignalId) -> u64 {
        let slot = self.slot(signal);
        // SAFETY: the signal is of this live model.
        unsafe { load(slot.data, slot.storage) }
    }

    /// Sets an input (or a public internal) at once, without an evaluation.
    #[inline]
    pub fn set(&mut self, signal: SignalId, value: u64) -> Result<(), ModelError> {
        let slot = self.slot(signal);
        if value & !slot.mask != 0 || !slot.writable {
            return Err(self.refused(self.info(signal), value));
        }
        // SAFETY: the signal is of this live model, borrowed alone.
        unsafe { store(slot.data, slot.storage, value) };
        Ok(())
    }

    #[inline(always)]
    fn slot(&self, signal: SignalId) -> Slot {
        assert!(signal.model == self.id, "a signal of one model was used on another");
        self.slots[signal.index()]
    }

    #[cold]
    fn refused(&self, info: &SignalInfo, value: u64) -> ModelError {
        if info.direction == Direction::Output {
            return ModelError::NotWritable { signal: info.name.clone(), top: self.library.top().to_owned() };
        }
        match info.check_unsigned(value) {
            Err(error) => error,
            Ok(()) => ModelError::TooWide { signal: info.name.clone(), width: info.width },
        }
    }

    /// The words of a signal of any width, lowest first.
    pub fn get_words(&self, signal: SignalId) -> Vec<u32> {
        let info = self.info(signal);
        // SAFETY: the signal is of this live model and has so many bytes.
        unsafe { load_words(info.data, info.storage) }
    }

    /// Sets an input of any width from 32-bit words, lowest first.
    pub fn set_words(&mut self, signal: SignalId, words: &[u32]) -> Result<(), ModelError> {
        let info = self.info(signal);
        if info.direction == Direction::Output {
            return Err(self.refused(info, 0));
        }
        info.check_words(words)?;
        // SAFETY: as in `set`.
        unsafe { store_words(info.data, info.storage, words) };
        Ok(())
    }

    /// The element of a memory.
    pub fn get_element(&self, memory: SignalId, index: i64) -> Result<u64, ModelError> {
        let info = self.info(memory);
        let offset = info.element_offset(index)?;
        // SAFETY: the offset was checked.
        Ok(unsafe { info.load(offset) })
    }

    /// Sets the element of a memory.
    pub fn set_element(&mut self, memory: SignalId, index: i64, value: u64) -> Result<(), ModelError> {
        let info = self.info(memory);
        let offset = info.element_offset(index)?;
        info.check_unsigned(value)?;
        if info.direction == Direction::Output {
            return Err(self.refused(info, value));
        }
        // SAFETY: the offset was checked.
        unsafe { store(info.data.add(offset), info.storage, value) };
        Ok(())
    }

    /// A signal by its address; `T` must be the type Verilator stores it in.
    pub fn raw<T: Word>(&self, name: &str) -> Result<RawSignal<T>, ModelError> {
        let info = self.info(self.find(name)?);
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
            return Err(ModelError::WrongShape { signal: name.to_owned(), is: "is stored in another word", instead });
        }
        Ok(RawSignal { data: info.data.cast() })
    }

    pub(crate) fn id(&self) -> u32 {
        self.id
    }

    /// Evaluates the model for the values of its inputs.
    #[inline]
    pub fn eval(&mut self) -> Result<(), ModelError> {
        if self.dead.is_some() {
            return self.fetch();
        }
        if BOUND.get() != self.id {
            self.bind();
        }
        // SAFETY: the instance is alive and has this thread's context.
        unsafe { (self.functions.hv_eval_bound)(self.raw) };
        self.initial_done = true;
        // SAFETY: the byte lives in the instance.
        if unsafe { *self.pending } == 0 { Ok(()) } else { self.fetch() }
    }

    /// Makes this the instance that [`Model::eval_bound`] evaluates on this thread.
    pub fn bind(&mut self) {
        BOUND.set(self.id);
        // SAFETY: the instance is alive.
        unsafe { (self.functions.hv_bind)(self.raw) };
    }

    /// Evaluates without setting the thread's context and without looking whether the Verilog said something: a later
    /// [`Model::eval`] or [`Model::take_messages`] does.
    ///
    /// # Safety
    /// [`Model::bind`] must have been called on this thread, no other instance bound, made or dropped on it since, and
    /// no earlier evaluation may have ended in an error.
    #[inline(always)]
    pub unsafe fn eval_bound(&mut self) {
        // SAFETY: as the caller promises.
        unsafe { (self.functions.hv_eval_bound)(self.raw) };
    }

    /// Whether the Verilog said something since it was last asked.
    #[inline(always)]
    pub(crate) fn has_messages(&self) -> bool {
        // SAFETY: the byte lives in the instance.
        unsafe { *self.pending != 0 || !self.messages.is_empty() }
    }

    /// Sets what `$time` says.
    #[inline]
    pub fn set_time(&mut self, time: Time) {
        // A clock repeats its spans: the last one's quotient is kept, a division costs as much as a small evaluation.
        if time >= self.time && (time - self.time).as_fs() == self.last_span.0 {
            self.ticks += self.last_span.1;
            self.rest += self.last_span.2;
            if self.rest >= self.femtoseconds_per_tick {
                self.ticks += 1;
                self.rest -= self.femtoseconds_per_tick;
            }
        } else {
            let split = |fs: u64| (fs / self.femtoseconds_per_tick, fs % self.femtoseconds_per_tick);
            let span = (time - self.time).as_fs();
            self.last_span = (span, split(span).0, split(span).1);
            (self.ticks, self.rest) = split(time.as_fs());
        }
        self.time = time;
        // SAFETY: the instance is alive.
        unsafe { (self.functions.hv_time)(self.raw, self.ticks) };
    }

    /// What `$time` says.
    pub fn time(&self) -> Time {
        self.time
    }

    /// The finest step of time the Verilog can tell apart.
    pub fn precision(&self) -> Time {
        Time::fs(self.femtoseconds_per_tick)
    }

    /// What the Verilog said since last asked, in order.
    pub fn take_messages(&mut self) -> Vec<Message> {
        // A death is told by `eval`; here only its message counts.
        let _ = self.fetch();
        std::mem::take(&mut self.messages)
    }

    /// Collects text and events from the shim; an error if the model can no longer be evaluated.
    #[cold]
    fn fetch(&mut self) -> Result<(), ModelError> {
        // SAFETY: the instance is alive; the strings given live until the next call.
        unsafe {
            if *self.pending & 1 != 0 {
                let mut length = 0;
                let text = (self.functions.hv_take_text)(self.raw, &mut length);
                let bytes =
                    if length == 0 { &[] } else { std::slice::from_raw_parts(text.cast::<u8>(), length as usize) };
                self.partial_line.push_str(&String::from_utf8_lossy(bytes));
                while let Some(end) = self.partial_line.find('\n') {
                    let line: String = self.partial_line.drain(..=end).collect();
                    self.messages.push(Message::Text(line.trim_end().to_owned()));
                }
                let (mut kind, mut line, mut file, mut message) = (0, 0, std::ptr::null(), std::ptr::null());
                while (self.functions.hv_take_event)(self.raw, &mut kind, &mut line, &mut file, &mut message) != 0 {
                    let file = CStr::from_ptr(file).to_string_lossy().into_owned();
                    let message = CStr::from_ptr(message).to_string_lossy().into_owned();
                    self.messages.push(match kind {
                        0 => Message::Finish { file, line },
                        1 => Message::Stop { file, line },
                        2 => Message::Fatal { message, file, line },
                        _ => Message::Text(format!("%Warning: {file}:{line}: {message}")),
                    });
                }
            }
            if *self.pending & 2 != 0 && self.dead.is_none() {
                let (message, file, line) = self
                    .messages
                    .iter()
                    .rev()
                    .find_map(|m| match m {
                        Message::Fatal { message, file, line } => Some((message.clone(), file.clone(), *line)),
                        _ => None,
                    })
                    .unwrap_or(("it threw an exception".into(), String::new(), 0));
                self.dead = Some(ModelError::Dead { top: self.library.top().to_owned(), message, file, line });
            }
        }
        self.dead.clone().map_or(Ok(()), Err)
    }

    /// Runs the Verilog's `final` blocks.
    pub fn finish(&mut self) {
        if self.dead.is_none() && self.initial_done {
            self.bind();
            // SAFETY: the instance is alive.
            unsafe { (self.functions.hv_final)(self.raw) };
        }
    }

    /// Begins to write waves of everything below a scope (empty: all), so many levels deep (0: all).
    pub fn trace_open(&mut self, path: &Path, level: u32, scope: &str) -> Result<(), Error> {
        let not_built =
            ModelError::NotBuiltIn { what: "a wave file", with: ".trace(Trace::Vcd) or .trace(Trace::Fst)" };
        if self.library.trace() == Trace::None {
            return Err(not_built.into());
        }
        let invalid = |text: &str| Error::File {
            path: path.to_owned(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidInput, text.to_owned()),
        };
        let name = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| invalid("zero byte in the name"))?;
        let scope = CString::new(scope).map_err(|_| invalid("zero byte in the scope"))?;
        self.bind();
        // SAFETY: the strings live through the call.
        match unsafe { (self.functions.hv_trace_open)(self.raw, name.as_ptr(), level as i32, scope.as_ptr()) } {
            1 => Ok(()),
            0 => Err(not_built.into()),
            _ => Err(Error::File { path: path.to_owned(), source: std::io::Error::last_os_error() }),
        }
    }

    /// Writes the values of this moment into the open waves; times must grow.
    pub fn trace_dump(&mut self, time: Time) {
        self.bind();
        // SAFETY: the instance is alive; does nothing without an open file.
        unsafe { (self.functions.hv_trace_dump)(self.raw, time.as_fs() / self.femtoseconds_per_tick) };
    }

    pub(crate) fn trace_flush(&mut self) {
        self.bind();
        // SAFETY: the instance is alive; does nothing without an open file.
        unsafe { (self.functions.hv_trace_flush)(self.raw) };
    }

    /// Ends the waves; their file is whole then.
    pub fn trace_close(&mut self) {
        self.bind();
        // SAFETY: as above.
        unsafe { (self.functions.hv_trace_close)(self.raw) };
    }

    /// Writes the coverage counted so far in Verilator's form.
    pub fn write_coverage(&mut self, path: &Path) -> Result<(), Error> {
        let name = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| Error::File {
            path: path.to_owned(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidInput, "zero byte in the name"),
        })?;
        self.bind();
        // SAFETY: the string lives through the call.
        if unsafe { (self.functions.hv_coverage_write)(self.raw, name.as_ptr()) } == 0 {
            return Err(ModelError::NotBuiltIn { what: "coverage", with: ".coverage(Coverage::ALL)" }.into());
        }
        std::fs::metadata(path).map(|_| ()).map_err(|source| Error::File { path: path.to_owned(), source })
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        BOUND.set(0);
        // SAFETY: made by `hv_new` and freed only here.
        unsafe { (self.functions.hv_delete)(self.raw) };
    }
}

impl std::fmt::Debug for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Model").field("top", &self.library.top()).field("time", &self.time).finish_non_exhaustive()
    }
}

/// Reads a value of any width as 32-bit words, lowest first.
///
/// # Safety
/// `data` must point to a live value of that storage.
pub(crate) unsafe fn load_words(data: *const u8, storage: Storage) -> Vec<u32> {
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::Wide(words) => std::slice::from_raw_parts(data.cast::<u32>(), words as usize).to_vec(),
            Storage::U64 => {
                let value = load(data, storage);
                vec![value as u32, (value >> 32) as u32]
            }
            _ => vec![load(data, storage) as u32],
        }
    }
}

/// Whether a value of any width is that of some words; words that are not given are zero.
///
/// # Safety
/// As [`load_words`].
pub(crate) unsafe fn has_words(data: *const u8, storage: Storage, words: &[u32]) -> bool {
    let word = |at: usize| words.get(at).copied().unwrap_or(0);
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::Wide(count) => (0..count as usize).all(|at| *data.cast::<u32>().add(at) == word(at)),
            _ => load(data, storage) == u64::from(word(0)) | u64::from(word(1)) << 32,
        }
    }
}

/// Writes a value of any width; words that are not given are zero.
///
/// # Safety
/// As [`load_words`], and nobody may be reading. The words must fit the signal's width.
pub(crate) unsafe fn store_words(data: *mut u8, storage: Storage, words: &[u32]) {
    let word = |at: usize| words.get(at).copied().unwrap_or(0);
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::Wide(count) => {
                (0..count as usize).for_each(|at| *data.cast::<u32>().add(at) = word(at));
            }
            _ => store(data, storage, u64::from(word(0)) | u64::from(word(1)) << 32),
        }
    }
}
