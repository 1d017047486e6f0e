//! The instance of a model: finds, reads and writes signals, evaluates, collects messages.

use std::cell::Cell;
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char};
use std::marker::PhantomData;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use super::library::{Functions, Instance, Library, RawSlot};
use super::message::Message;
use super::signal::{Direction, Force, SignalId, SignalInfo};
use super::storage::Storage;
use super::values::Slot;
use crate::engine::build::{Initial, Kind, PortDirection, Variable};
use crate::engine::error::{ModelError, nearest};
use crate::engine::time::Time;

/// The options of an instance.
#[derive(Debug, Clone, Default)]
pub struct InstanceOptions {
    /// Seed of random initial values and of `$random`.
    pub seed: u64,
    /// Arguments such as `+verbose` that `$test$plusargs` and `$value$plusargs` see.
    pub plusargs: Vec<String>,
}

static NEXT_MODEL: AtomicU32 = AtomicU32::new(1);

thread_local! {
    /// The model whose context is set on this thread, so that it is set only when it changes.
    static BOUND: Cell<u32> = const { Cell::new(0) };
}

/// Returns a signal as the design describes it and the C++ stores it, or `None` if the two do not agree.
fn describe(variable: &Variable, slot: &RawSlot) -> Option<SignalInfo> {
    const BITS: u32 = 0;
    const REAL: u32 = 1;
    let (width, real) = match (variable.kind, slot.kind) {
        (Kind::Bits { width }, BITS) => (width, false),
        (Kind::Real, REAL) => (64, true),
        _ => return None,
    };
    let storage = Storage::of(width);
    let extents = slot.extents.get(..slot.dimensions as usize)?;
    let declared = variable.dimensions.iter().map(|(left, right)| left.abs_diff(*right) + 1);
    if slot.element_bytes as usize != storage.bytes() || !declared.eq(extents.iter().map(|e| u64::from(*e))) {
        return None;
    }
    Some(SignalInfo {
        name: variable.path.clone(),
        direction: match variable.port.filter(|_| !variable.path.contains('.')) {
            Some(PortDirection::Input) => Direction::Input,
            Some(PortDirection::Output) => Direction::Output,
            Some(PortDirection::Inout) => Direction::Inout,
            None => Direction::Internal,
        },
        width,
        bits: variable.bits,
        signed: variable.signed,
        real,
        register: variable.register,
        module: variable.module.clone(),
        storage,
        range: match variable.dimensions[..] {
            [] => None,
            [only] => Some(only),
            _ => Some((0, i64::try_from(extents.iter().map(|e| u64::from(*e)).product::<u64>()).ok()? - 1)),
        },
        dimensions: variable.dimensions.clone(),
        items: variable.items.clone(),
        fields: variable.fields.clone(),
        data: slot.data,
        target: slot.target,
        force: None,
    })
}

/// One instance of a built model.
pub struct Model {
    pub(super) raw: Instance,
    pub(super) functions: Functions,
    pending: *const u8,
    pub(super) library: Library,
    pub(super) id: u32,
    /// Those that have names, then those by which others are forced.
    pub(super) signals: Vec<SignalInfo>,
    named: usize,
    pub(super) slots: Vec<Slot>,
    by_name: HashMap<String, u32>,
    /// Names and addresses of the `string`s.
    pub(super) texts: Vec<(String, *mut u8)>,
    pub(super) femtoseconds_per_tick: u64,
    time: Time,
    /// `time` in ticks, what is left of it in femtoseconds, and the last span with its quotient and remainder.
    ticks: u64,
    rest: u64,
    last_span: (u64, u64, u64),
    messages: Vec<Message>,
    partial_line: String,
    dead: Option<ModelError>,
    initial_done: bool,
    /// The open wave file.
    pub(super) trace_path: PathBuf,
    /// The model may move to another thread, but not be shared.
    _not_sync: PhantomData<std::cell::Cell<()>>,
}

// SAFETY: the instance is owned alone, and the runtime's thread-local context is set before every call into it.
unsafe impl Send for Model {}

impl Model {
    pub(super) fn new(library: Library, options: &InstanceOptions) -> Result<Model, ModelError> {
        let functions = *library.functions();
        let failed = |reason: &str| ModelError::Instance { top: library.top().to_owned(), reason: reason.into() };
        let mut arguments = vec![c"hoverlock".to_owned()];
        for argument in &options.plusargs {
            arguments.push(CString::new(argument.as_str()).map_err(|_| failed("a plusarg contains a zero byte"))?);
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
            named: 0,
            slots: Vec::new(),
            by_name: HashMap::new(),
            texts: Vec::new(),
            femtoseconds_per_tick: 10u64.pow((15 + precision.clamp(-15, 0)) as u32),
            time: Time::ZERO,
            ticks: 0,
            rest: 0,
            last_span: (0, 0, 0),
            messages: Vec::new(),
            partial_line: String::new(),
            dead: None,
            initial_done: false,
            trace_path: PathBuf::new(),
            library,
            _not_sync: PhantomData,
        };
        model.fetch()?;
        model.find_signals();
        Ok(model)
    }

    /// Adds the signals of the shim's table whose C++ type agrees with the description of the design.
    fn find_signals(&mut self) {
        let mut list: *const RawSlot = std::ptr::null();
        // SAFETY: the shim gives its own table, which lives as long as the instance.
        let slots = unsafe {
            let count = (self.functions.hv_signals)(self.raw, &mut list) as usize;
            if count == 0 { &[] } else { std::slice::from_raw_parts(list, count) }
        };
        let library = self.library.clone();
        let mut forceable = Vec::new();
        for (variable, slot) in library.record().signals.iter().zip(slots) {
            if let Some(signal) = describe(variable, slot) {
                self.by_name.insert(signal.name.clone(), self.signals.len() as u32);
                if !slot.force_enable.is_null() {
                    forceable.push((self.signals.len(), *slot));
                }
                self.add(signal);
            } else if variable.kind == Kind::Text && (slot.kind, slot.dimensions) == (2, 0) {
                self.texts.push((variable.path.clone(), slot.data));
            }
        }
        self.named = self.signals.len();
        for (at, slot) in forceable {
            let place = self.signals.len() as u32;
            for (what, data) in [("force enable", slot.force_enable), ("force value", slot.force_value)] {
                let of = &self.signals[at];
                let name = format!("{} ({what})", of.name);
                let (items, fields) = (Vec::new(), Vec::new());
                self.add(SignalInfo {
                    name,
                    direction: Direction::Internal,
                    items,
                    fields,
                    data,
                    target: data,
                    ..of.clone()
                });
            }
            self.signals[at].force = Some(Force { enable: place, value: place + 1 });
        }
    }

    fn add(&mut self, signal: SignalInfo) {
        self.slots.push(Slot {
            data: signal.data,
            target: signal.target,
            mask: signal.mask(),
            storage: signal.storage,
            writable: self.is_writable(&signal) && !matches!(signal.storage, Storage::Wide(_)),
        });
        self.signals.push(signal);
    }

    /// Returns the library it was made from.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// Returns all ports, in the order of the Verilog, then the public internals.
    pub fn signals(&self) -> &[SignalInfo] {
        &self.signals[..self.named]
    }

    /// Returns the signals with names, then those by which others are forced.
    pub(crate) fn all_signals(&self) -> &[SignalInfo] {
        &self.signals
    }

    /// Returns the ids of the two signals by which another is forced: its enable and its value.
    ///
    /// # Errors
    /// If it was not made forceable.
    pub(crate) fn force_of(&self, signal: SignalId) -> Result<(SignalId, SignalId), ModelError> {
        let info = self.info(signal);
        let Some(force) = info.force else {
            return Err(ModelError::NotForceable {
                signal: info.name.clone(),
                is_port: info.direction != Direction::Internal,
            });
        };
        let id = |index| SignalId { index, model: self.id };
        Ok((id(force.enable), id(force.value)))
    }

    /// Returns `true` if a bench may write a signal.
    pub(crate) fn is_writable(&self, info: &SignalInfo) -> bool {
        match info.direction {
            Direction::Output => false,
            Direction::Inout => self.library.record().drivable_inouts,
            Direction::Input | Direction::Internal => true,
        }
    }

    /// Returns the error of a write to a signal that a bench may not write.
    pub(crate) fn not_writable(&self, info: &SignalInfo) -> ModelError {
        let signal = info.name.clone();
        match info.direction {
            Direction::Inout => ModelError::InoutNotDrivable { signal },
            _ => ModelError::NotWritable { signal, top: self.library.top().to_owned() },
        }
    }

    /// Returns the signal of that name, or `None`: for optional ports, whose absence needs no list of nearest names.
    pub fn find_if_any(&self, name: &str) -> Option<SignalId> {
        let index = self.by_name.get(name).or_else(|| self.by_name.get(&name.replace('.', "$")));
        index.map(|index| SignalId { index: *index, model: self.id })
    }

    /// Returns the signal of that name; `a.b` also finds a port that is written `a$b`.
    ///
    /// # Errors
    /// If there is no port or public internal of that name: the error lists the nearest names.
    pub fn find(&self, name: &str) -> Result<SignalId, ModelError> {
        self.find_if_any(name).ok_or_else(|| {
            let record = self.library.record();
            let listed = |name: &str| {
                record.signals.iter().any(|v| v.path == name) || record.unreachable.iter().any(|v| v == name)
            };
            if listed(name) {
                return ModelError::NotReachable { name: name.to_owned(), top: self.library.top().to_owned() };
            }
            let mut near = nearest(name, self.signals.iter().map(|s| s.name.as_str()));
            let hidden: Vec<String> = nearest(name, self.library.record().names.iter().map(String::as_str));
            for other in hidden {
                if !self.by_name.contains_key(&other) && near.len() < 8 {
                    near.push(if listed(&other) {
                        format!("{other} (of a shape that is not reachable)")
                    } else {
                        format!("{other} (not public: add .internal(\"{other}\") to the build)")
                    });
                }
            }
            ModelError::NoSuchSignal { name: name.to_owned(), top: self.library.top().to_owned(), nearest: near }
        })
    }

    pub(crate) fn id(&self) -> u32 {
        self.id
    }

    /// Evaluates the model for the values of its inputs.
    ///
    /// # Errors
    /// If the model cannot be evaluated any more, for instance because it did not settle. What `$error`, `$stop` and
    /// `$finish` said is in [`Model::take_messages`].
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

    /// Evaluates without setting the thread's context and without checking for messages of the Verilog: a later
    /// [`Model::eval`] or [`Model::take_messages`] checks.
    ///
    /// # Safety
    /// [`Model::bind`] must have been called on this thread, no other instance bound, made or dropped on it since, and
    /// no earlier evaluation may have ended in an error.
    #[inline(always)]
    pub unsafe fn eval_bound(&mut self) {
        // SAFETY: as the caller promises.
        unsafe { (self.functions.hv_eval_bound)(self.raw) };
    }

    /// Returns `true` if there are messages of the Verilog that were not taken.
    #[inline(always)]
    pub(crate) fn has_messages(&self) -> bool {
        // SAFETY: the byte lives in the instance.
        unsafe { *self.pending != 0 || !self.messages.is_empty() }
    }

    /// Sets `$time`.
    #[inline(always)]
    pub fn set_time(&mut self, time: Time) {
        // A clock repeats its spans: the quotient of the last one is kept. A division costs as much as a small
        // evaluation.
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

    /// Returns the value of `$time`.
    pub fn time(&self) -> Time {
        self.time
    }

    /// Returns the time precision of the Verilog: one tick of `$time` or a fraction of it.
    pub fn precision(&self) -> Time {
        Time::fs(self.femtoseconds_per_tick)
    }

    /// Returns the messages of the Verilog since the last call, in order.
    pub fn take_messages(&mut self) -> Vec<Message> {
        // `eval` reports a model that cannot go on; here only its message counts.
        let _ = self.fetch();
        std::mem::take(&mut self.messages)
    }

    /// Returns the text of the last fatal message, which is removed.
    #[cold]
    pub(super) fn take_fatal(&mut self) -> Option<String> {
        let _ = self.fetch();
        let at = self.messages.iter().rposition(|m| matches!(m, Message::Fatal { .. }))?;
        match self.messages.remove(at) {
            Message::Fatal { message, .. } => Some(message),
            _ => None,
        }
    }

    /// Collects text and events from the shim; an error if the model cannot be evaluated any more.
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
