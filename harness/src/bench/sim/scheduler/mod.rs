//! The scheduler: the state of one simulation, and the services that tasks use without waiting (time, reads, buffered
//! writes).
//!
//! | module | what it does |
//! |---|---|
//! | [`time_step`] | runs one time step after the other, each with its regions |
//! | [`edges`] | puts buffered writes, finds changed signals, wakes the tasks that wait for them |
//! | [`run_queue`] | starts, runs and ends tasks and bus models |
//! | [`waiting`] | begins and ends every other wait: timers, regions, events, locks, joins, `First`, `Combine` |
//! | [`wait_table`], [`task_state`] | the slots of waits and of tasks |
//! | [`stuck`] | reports what each task waits for |
//! | [`wall_clock`] | limits of time on the wall, and the watchdog |

use std::cell::{Cell, RefCell, RefMut};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

mod edges;
mod run_queue;
mod stuck;
mod task_state;
mod time_step;
mod wait_table;
mod waiting;
mod wall_clock;

use self::edges::SignalState;
pub(crate) use self::task_state::Body;
use self::task_state::Task;
pub(crate) use self::wait_table::WaitId;
use self::wait_table::WaitTable;
pub(crate) use self::wall_clock::WallClock;
use crate::bench::error::{Error, SimError};
use crate::bench::sim::log::{Level, Log};
use crate::bench::sim::task::TaskId;
use crate::bench::sim::{EdgeOrder, Limits, Region};
use crate::engine::error::ModelError;
use crate::engine::model::{Direction, Message, Model, SignalId, has_words, load};
use crate::engine::time::Time;
use crate::engine::wave::Waves;

/// A task, or a bus model at an edge, that is ready to run.
#[derive(Clone, Copy)]
enum Ready {
    Task(TaskId),
    Agent(u32),
}

/// A bus model that works at the edges of a clock without being a task.
pub(crate) trait Agent {
    /// Handles the edge; signals still have their values before it.
    fn edge(&mut self, core: &Core) -> Result<(), Error>;
}

/// The index of a signal that is not in the list of buffered writes.
const NONE: u32 = u32::MAX;

/// A buffered write of the bits of `mask`, in a signal of at most 64 bits. The others keep what they have when it is
/// put.
#[derive(Clone, Copy)]
struct Write {
    pub signal: u32,
    pub mask: u64,
    pub value: u64,
}

impl Write {
    /// Returns the value of a signal, `old` before the write.
    #[inline(always)]
    fn onto(self, old: u64) -> u64 {
        old & !self.mask | self.value
    }
}

/// A buffered write of another kind.
enum LargeWrite {
    Words(u32, Vec<u32>),
    /// The bits of a mask, given first, in a signal of any width.
    Bits(u32, Vec<u32>, Vec<u32>),
    /// An element of a memory, at a byte offset.
    Element(u32, usize, u64),
    /// An element of more than 64 bits, at a byte offset.
    ElementWords(u32, usize, Vec<u32>),
    /// A `string`, by its place in the list of them.
    Text(usize, Vec<u8>),
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct TimerEntry {
    pub at: Time,
    pub order: u64,
    pub wait_id: (u32, u32),
}

pub(crate) struct ClockState {
    pub signal: u32,
    pub high: Time,
    pub low: Time,
    pub next: Time,
    pub level: bool,
    pub running: bool,
}

/// The state of one simulation; shared through `Rc` by everything that waits or writes.
pub(crate) struct Core {
    pub model: RefCell<Model>,
    model_id: u32,
    signals: Vec<SignalState>,
    now: Cell<Time>,
    region: Cell<Region>,
    ended: Cell<bool>,
    writes: RefCell<Vec<Write>>,
    applying: RefCell<Vec<Write>>,
    large_writes: RefCell<Vec<LargeWrite>>,
    observed: RefCell<Vec<u32>>,
    wait_table: RefCell<WaitTable>,
    tasks: RefCell<Vec<Task>>,
    free_tasks: RefCell<Vec<u32>>,
    ready: RefCell<VecDeque<Ready>>,
    agents: RefCell<Vec<Option<Box<dyn Agent>>>>,
    timers: RefCell<BinaryHeap<Reverse<TimerEntry>>>,
    timer_order: Cell<u64>,
    /// The number of timers whose wait was cancelled.
    stale_timers: Cell<usize>,
    pub clocks: RefCell<Vec<ClockState>>,
    read_only: RefCell<Vec<WaitId>>,
    read_write: RefCell<Vec<WaitId>>,
    next_step: RefCell<Vec<WaitId>>,
    finish_waiters: RefCell<Vec<WaitId>>,
    current: Cell<Option<TaskId>>,
    /// The data pointer of the running task's own waker, to recognise it.
    current_waker: Cell<*const ()>,
    woken: Arc<Mutex<Vec<TaskId>>>,
    pub log: RefCell<Log>,
    pub limits: RefCell<Limits>,
    pub edge_order: Cell<EdgeOrder>,
    /// Whether writes at a rising edge of the only clock are put together with its falling edge.
    pub defers_writes: Cell<bool>,
    pub interrupt: RefCell<Option<Box<dyn FnMut() -> bool>>>,
    pub stop_flag: Arc<AtomicBool>,
    /// The Verilog called `$finish`, and no task waited for it.
    is_finished: Cell<bool>,
    finish: RefCell<Option<(String, u32, Time)>>,
    /// Whether `error` has the reason why the run ends.
    failed: Cell<bool>,
    error: RefCell<Option<Error>>,
    /// The task whose end ends the run.
    main: Cell<Option<TaskId>>,
    main_ended: Cell<bool>,
    max_rounds: Cell<u32>,
    warned: RefCell<Vec<u32>>,
    /// Whether a write to an output is a deposit rather than an error.
    pub deposits_on_outputs: Cell<bool>,
    /// The outputs of which a deposit was reported.
    deposited: RefCell<Vec<SignalId>>,
    pub waves: RefCell<Waves>,
    has_waves: Cell<bool>,
    evaluations: Cell<u64>,
    /// In this time step: how many clocks changed their level, and whether a timer woke a task.
    clock_writes: Cell<u32>,
    timed: Cell<bool>,
    /// The time before which nothing but the only clock can be due; 0 if that is not known.
    quiet_until: Cell<Time>,
}

impl Core {
    pub fn new(model: Model) -> Result<Rc<Core>, Error> {
        let signals = model.all_signals().iter().map(SignalState::new).collect();
        let core = Rc::new(Core {
            model_id: model.id(),
            model: RefCell::new(model),
            signals,
            now: Cell::new(Time::ZERO),
            region: Cell::new(Region::Active),
            ended: Cell::new(false),
            writes: RefCell::default(),
            applying: RefCell::default(),
            large_writes: RefCell::default(),
            observed: RefCell::default(),
            wait_table: RefCell::default(),
            tasks: RefCell::default(),
            free_tasks: RefCell::default(),
            ready: RefCell::default(),
            agents: RefCell::default(),
            timers: RefCell::default(),
            timer_order: Cell::new(0),
            stale_timers: Cell::new(0),
            clocks: RefCell::default(),
            read_only: RefCell::default(),
            read_write: RefCell::default(),
            next_step: RefCell::default(),
            finish_waiters: RefCell::default(),
            current: Cell::new(None),
            current_waker: Cell::new(std::ptr::null()),
            woken: Arc::default(),
            log: RefCell::default(),
            limits: RefCell::default(),
            edge_order: Cell::new(EdgeOrder::default()),
            defers_writes: Cell::new(false),
            interrupt: RefCell::default(),
            stop_flag: Arc::default(),
            is_finished: Cell::new(false),
            finish: RefCell::default(),
            failed: Cell::new(false),
            main: Cell::new(None),
            main_ended: Cell::new(false),
            max_rounds: Cell::new(Limits::default().rounds),
            error: RefCell::default(),
            warned: RefCell::default(),
            deposits_on_outputs: Cell::new(false),
            deposited: RefCell::default(),
            waves: RefCell::default(),
            has_waves: Cell::new(false),
            evaluations: Cell::new(0),
            clock_writes: Cell::new(0),
            timed: Cell::new(false),
            quiet_until: Cell::new(Time::ZERO),
        });
        // Runs `initial` blocks and settles, so that the first read gives a value of the design.
        core.evaluate()?;
        Ok(core)
    }

    #[inline]
    pub fn now(&self) -> Time {
        self.now.get()
    }

    pub fn region(&self) -> Region {
        self.region.get()
    }

    pub fn evaluations(&self) -> u64 {
        self.evaluations.get()
    }

    pub fn signal_name(&self, signal: u32) -> String {
        self.model.borrow().all_signals()[signal as usize].name.clone()
    }

    /// Returns an error if a bench may not write a signal. A deposit on an output is allowed if they are, and logs a
    /// warning once for each signal.
    pub fn check_written(&self, model: &Model, signal: SignalId) -> Result<(), ModelError> {
        let info = model.info(signal);
        if model.is_writable(info) {
            return Ok(());
        }
        if info.direction != Direction::Output || !self.deposits_on_outputs.get() {
            return Err(model.not_writable(info));
        }
        if !self.deposited.borrow().contains(&signal) {
            self.deposited.borrow_mut().push(signal);
            let text =
                format!("'{}' is an output: it has the value written until the design assigns it again", info.name);
            self.log.borrow_mut().put(self.now(), Level::Warning, "harness", &text);
        }
        Ok(())
    }

    /// Buffers a write of a value known to fit. A write that changes nothing is dropped, because it would cost an
    /// evaluation; unless the design may change the signal before the write is put.
    #[inline(always)]
    pub fn write(&self, signal: u32, value: u64) -> Result<(), ModelError> {
        self.write_bits(signal, u64::MAX, value)
    }

    /// Buffers a write of the bits of `mask`; `value` has no others.
    #[inline(always)]
    pub fn write_bits(&self, signal: u32, mask: u64, value: u64) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        let state = &self.signals[signal as usize];
        let mut writes = self.writes.borrow_mut();
        let at = state.pending.get();
        if at != NONE {
            let write = &mut writes[at as usize];
            (write.mask, write.value) = (write.mask | mask, write.value & !mask | value);
        // SAFETY: the model lives as long as the core.
        } else if state.is_changed_by_design() || unsafe { load(state.target, state.storage) } & mask != value {
            state.pending.set(writes.len() as u32);
            writes.push(Write { signal, mask, value });
        }
        Ok(())
    }

    /// Returns the value with the write that is buffered, if there is one.
    pub fn pending(&self, signal: u32) -> u64 {
        let state = &self.signals[signal as usize];
        // SAFETY: the model lives as long as the core; asked only of signals that are not wide.
        let old = unsafe { load(state.target, state.storage) };
        self.writes.borrow().get(state.pending.get() as usize).map_or(old, |write| write.onto(old))
    }

    /// Buffers a write of any width; words that are not given are 0.
    pub fn write_words(&self, signal: u32, words: &[u32]) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        let state = &self.signals[signal as usize];
        let mut writes = self.large_writes.borrow_mut();
        let is_needed = !writes.is_empty()
            || state.is_changed_by_design()
            // SAFETY: the model lives as long as the core.
            || !unsafe { has_words(state.target, state.storage, words) };
        if is_needed {
            self.disturb();
            writes.push(LargeWrite::Words(signal, words.to_vec()));
        }
        Ok(())
    }

    /// Buffers a write of the bits of `mask`, in a signal of any width; `words` has no others.
    pub fn write_word_bits(&self, signal: u32, mask: &[u32], words: &[u32]) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        self.disturb();
        self.large_writes.borrow_mut().push(LargeWrite::Bits(signal, mask.to_vec(), words.to_vec()));
        Ok(())
    }

    pub fn write_element(&self, signal: u32, offset: usize, value: u64) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        self.disturb();
        self.large_writes.borrow_mut().push(LargeWrite::Element(signal, offset, value));
        Ok(())
    }

    pub fn write_element_words(&self, signal: u32, offset: usize, words: &[u32]) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        self.disturb();
        self.large_writes.borrow_mut().push(LargeWrite::ElementWords(signal, offset, words.to_vec()));
        Ok(())
    }

    /// Buffers a write of a `string`, which is known by its place in the model's list of them.
    pub fn write_text(&self, index: usize, value: &[u8]) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            let name = self.model.borrow().texts()[index].0.clone();
            return Err(if self.ended.get() {
                ModelError::Ended { signal: name }
            } else {
                ModelError::WriteInReadOnly { signal: name, time: self.now() }
            });
        }
        self.disturb();
        self.large_writes.borrow_mut().push(LargeWrite::Text(index, value.to_vec()));
        Ok(())
    }

    /// Refuses all later writes: the simulation has ended.
    pub fn end(&self) {
        self.ended.set(true);
        self.region.set(Region::ReadOnly);
    }

    #[cold]
    fn write_in_read_only(&self, signal: u32) -> ModelError {
        if self.ended.get() {
            return ModelError::Ended { signal: self.signal_name(signal) };
        }
        ModelError::WriteInReadOnly { signal: self.signal_name(signal), time: self.now() }
    }

    #[inline(always)]
    fn evaluate(&self) -> Result<(), Error> {
        let mut model = self.model.borrow_mut();
        self.evaluations.set(self.evaluations.get() + 1);
        if model.time() != self.now() {
            model.set_time(self.now());
        }
        match model.eval() {
            Ok(()) if !model.has_messages() => Ok(()),
            result => self.evaluated(model, result),
        }
    }

    /// Handles the messages of the Verilog after an evaluation.
    #[cold]
    fn evaluated(&self, mut model: RefMut<'_, Model>, result: Result<(), ModelError>) -> Result<(), Error> {
        let messages = model.take_messages();
        drop(model);
        self.handle_messages(messages)?;
        Ok(result?)
    }

    /// Handles messages of the Verilog: `$display` goes to the log; `$error`, `$stop` and `$fatal` end the run;
    /// `$finish` ends it unless a task waits for it.
    #[cold]
    pub fn handle_messages(&self, messages: Vec<Message>) -> Result<(), Error> {
        let mut stop = None;
        let mut said = String::new();
        for message in messages {
            match message {
                Message::Text(line) => {
                    let level = if line.contains("%Error") || line.contains("%Fatal") {
                        said.clone_from(&line);
                        Level::Error
                    } else if line.contains("%Warning") {
                        Level::Warning
                    } else {
                        Level::Info
                    };
                    self.log.borrow_mut().put(self.now(), level, "verilog", &line);
                }
                Message::Finish { file, line } => {
                    self.log.borrow_mut().put(self.now(), Level::Info, "verilog", &format!("$finish ({file}:{line})"));
                    if self.finish_waiters.borrow().iter().any(|n| self.is_armed(*n)) {
                        self.fire_list(&self.finish_waiters);
                    } else {
                        self.is_finished.set(true);
                        self.disturb();
                        *self.finish.borrow_mut() = Some((file, line, self.now()));
                    }
                }
                Message::Stop { file, line } => {
                    let message = if said.is_empty() { "$stop".to_owned() } else { said.clone() };
                    stop.get_or_insert(SimError::Verilog { message, file, line, time: self.now() });
                }
                Message::Fatal { message, file, line } => {
                    stop.get_or_insert(SimError::Verilog { message, file, line, time: self.now() });
                }
            }
        }
        stop.map_or(Ok(()), |error| Err(error.into()))
    }

    pub fn set_waves(&self, on: bool) {
        self.disturb();
        self.has_waves.set(on);
    }

    pub fn has_waves(&self) -> bool {
        self.has_waves.get()
    }

    /// Ends the quiet steps, because something begins that they do not look for: full time steps follow until
    /// [`Core::is_quiet`] allows quiet ones again.
    #[inline(always)]
    pub fn disturb(&self) {
        self.quiet_until.set(Time::ZERO);
    }

    /// Sets a later time: bulk transfers keep clock and time themselves.
    pub fn set_now(&self, time: Time) {
        self.now.set(time);
    }
}
