//! Triggers: what a coroutine awaits.
//!
//! A trigger object is its own iterator: `__await__` gives it back, its first `__next__` yields it to the scheduler,
//! the second ends the wait with its result. No object is made for a wait, and an edge trigger is made once for each
//! signal.

#![allow(unsafe_op_in_unsafe_fn, reason = "what pyo3 writes for the classes made by macros; no unsafe code is here")]

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use hoverlock_harness::Time;
use hoverlock_harness::sim::{self, Edge, Outcome};
use pyo3::exceptions::{PyStopIteration, PyTypeError, PyValueError};
use pyo3::ffi::PyTypeObject;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{PyTraverseError, PyTypeInfo, PyVisit};

use crate::errors;
use crate::handle::{Bits, Handle};
use crate::on_thread::OnThread;
use crate::simulation;
use crate::task::{self, Task};

/// Whether the argument `units` of a `Timer` warns.
static UNITS_ARE_OLD: AtomicBool = AtomicBool::new(false);

/// Sets whether `Timer(units=...)` warns, as cocotb 2 does.
#[pyfunction]
pub fn advise_units(on: bool) {
    UNITS_ARE_OLD.store(on, Ordering::Relaxed);
}

/// The result of a wait.
enum Gives {
    Nothing,
    /// The task's result.
    TaskResult(Py<Task>),
    /// Of `First`: the result of the trigger that fired.
    OneOf(Vec<Py<Trigger>>),
    /// Of `Combine`: nothing; it keeps its parts, so that the engine does not forget how a task among them ended.
    #[expect(dead_code, reason = "kept, not read")]
    AllOf(Vec<Py<Trigger>>),
}

/// Something a coroutine can await. A trigger can be awaited again, also by several tasks at the same time.
///
/// >>> edge = RisingEdge(dut.clk)
/// >>> await edge
#[pyclass(subclass, frozen, module = "hoverlock")]
pub struct Trigger {
    /// Awaited, not yet yielded to the scheduler.
    fresh: AtomicBool,
    gives_result: bool,
    inner: OnThread<Inner>,
}

struct Inner {
    what: sim::Trigger,
    gives: Gives,
    result: RefCell<Option<Py<PyAny>>>,
}

/// How far a wait is.
pub enum Progress {
    /// The scheduler is to resume the coroutine when the trigger has fired.
    Waits,
    /// The trigger has fired, and this is the result, if it gives one.
    Over(Option<Py<PyAny>>),
}

impl Trigger {
    pub fn new(what: sim::Trigger) -> Trigger {
        Trigger::giving(what, Gives::Nothing)
    }

    fn giving(what: sim::Trigger, gives: Gives) -> Trigger {
        let gives_result = !matches!(gives, Gives::Nothing | Gives::AllOf(_));
        let inner = OnThread::new(Inner { what, gives, result: RefCell::default() });
        Trigger { fresh: AtomicBool::new(false), gives_result, inner }
    }

    /// The engine's trigger.
    #[inline]
    pub fn what(&self) -> PyResult<&sim::Trigger> {
        Ok(&self.inner.get()?.what)
    }

    /// The engine's trigger, and whether a wait for it has a result.
    #[inline]
    pub fn wait(&self) -> (sim::Trigger, bool) {
        (self.inner.own().what.clone(), self.gives_result)
    }

    /// Begins a wait.
    #[inline(always)]
    pub fn begin(&self) -> PyResult<()> {
        self.inner.get()?;
        self.fresh.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Goes on with a wait: to the scheduler at first, to its end when it is resumed.
    #[inline(always)]
    pub fn proceed(&self) -> PyResult<Progress> {
        // No exchange: the interpreter's lock is held.
        if self.fresh.load(Ordering::Relaxed) {
            self.fresh.store(false, Ordering::Relaxed);
            return Ok(Progress::Waits);
        }
        Ok(Progress::Over(if self.gives_result { self.inner.get()?.result.take() } else { None }))
    }

    /// Stores the result of a wait, for `__next__`.
    pub fn settle(slf: &Bound<'_, Trigger>, outcome: &Outcome) {
        let result = Trigger::result_of(slf, outcome);
        *slf.get().inner.own().result.borrow_mut() = Some(result);
    }

    fn result_of(slf: &Bound<'_, Trigger>, outcome: &Outcome) -> Py<PyAny> {
        let py = slf.py();
        match (&slf.get().inner.own().gives, outcome) {
            (Gives::TaskResult(task), _) => task.get().result_or_none(py),
            (Gives::OneOf(parts), Outcome::First(index, inner)) => Trigger::result_of(parts[*index].bind(py), inner),
            _ => slf.clone().into_any().unbind(),
        }
    }
}

#[pymethods]
impl Trigger {
    fn __await__(slf: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        slf.get().begin()?;
        Ok(slf)
    }

    fn __iter__(slf: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        Self::__await__(slf)
    }

    fn __next__<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, Self>>> {
        match slf.get().proceed()? {
            Progress::Waits => Ok(Some(slf.clone())),
            Progress::Over(None) => Ok(None),
            // In a tuple, so that a result that is a tuple is not unpacked.
            Progress::Over(Some(result)) => Err(PyStopIteration::new_err((result,))),
        }
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        if let Gives::TaskResult(task) = &slf.get().inner.get()?.gives {
            return Ok(format!("the end of {}", task.bind(slf.py()).repr()?));
        }
        Ok(format!("{}()", slf.get_type().name()?))
    }
}

fn not_a_signal(name: &str, given: &Bound<'_, PyAny>) -> PyErr {
    let shown = given.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
    PyTypeError::new_err(format!("{name} takes a signal or one bit of a signal, not {shown}"))
}

macro_rules! edge_trigger {
    ($(#[$doc:meta])* $name:ident, $edge:expr, $of_bit:expr, $cache:ident, $one_bit:expr) => {
        $(#[$doc])*
        #[pyclass(extends = Trigger, frozen, module = "hoverlock")]
        pub struct $name {
            /// The signal it watches.
            #[pyo3(get)]
            signal_name: String,
        }

        #[pymethods]
        impl $name {
            #[new]
            fn new(signal: &Bound<'_, PyAny>) -> PyResult<Py<Self>> {
                let py = signal.py();
                let Ok(signal) = signal.cast::<Handle>() else {
                    let bits = signal.cast::<Bits>().map_err(|_| not_a_signal(stringify!($name), signal))?;
                    let (handle, at) = bits.get().single(py, stringify!($name))?;
                    let handle = handle.get();
                    handle.check_thread()?;
                    let base = Trigger::new(sim::Trigger::Edge(handle.id(), $of_bit(at)));
                    let signal_name = format!("{}[{at}]", handle.name());
                    return Py::new(py, PyClassInitializer::from(base).add_subclass($name { signal_name }));
                };
                let handle = signal.get();
                handle.check_thread()?;
                let made = handle.$cache.get_or_try_init(py, || {
                    if $one_bit && handle.width() != 1 {
                        return Err(PyTypeError::new_err(format!(
                            "{} takes a signal of one bit, '{}' has {}: use ValueChange",
                            stringify!($name), handle.name(), handle.width()
                        )));
                    }
                    let base = Trigger::new(sim::Trigger::Edge(handle.id(), $edge));
                    let whole = PyClassInitializer::from(base)
                        .add_subclass($name { signal_name: handle.name().to_owned() });
                    Py::new(py, whole)
                })?;
                Ok(made.clone_ref(py))
            }

            fn __repr__(&self) -> String {
                format!("{}({})", stringify!($name), self.signal_name)
            }
        }
    };
}

edge_trigger!(
    /// The change of a one-bit signal from 0 to 1.
    ///
    /// >>> await RisingEdge(dut.clk)
    RisingEdge, Edge::Rising, Edge::RisingBit, rising, true
);
edge_trigger!(
    /// The change of a one-bit signal from 1 to 0.
    ///
    /// >>> await FallingEdge(dut.clk)
    FallingEdge, Edge::Falling, Edge::FallingBit, falling, true
);
edge_trigger!(
    /// Any change of a signal's value.
    ///
    /// >>> await ValueChange(dut.state)
    ValueChange, Edge::Any, Edge::AnyBit, change, false
);

/// The n-th rising (or falling) edge from now; the task does not run at the ones before. 0: only lets other tasks run.
///
/// >>> await ClockCycles(dut.clk, 100)
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct ClockCycles {}

#[pymethods]
impl ClockCycles {
    #[new]
    #[pyo3(signature = (signal, num_cycles, rising = None))]
    fn new(
        signal: &Bound<'_, Handle>,
        num_cycles: u64,
        rising: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let handle = signal.get();
        // cocotb 2 names the edge by its trigger, cocotb 1 by a truth value.
        let py = signal.py();
        let rising = match rising {
            None => true,
            Some(kind) if kind.is(py.get_type::<RisingEdge>()) => true,
            Some(kind) if kind.is(py.get_type::<FallingEdge>()) => false,
            Some(kind) => kind.is_truthy()?,
        };
        let edge = if rising { Edge::Rising } else { Edge::Falling };
        let base = Trigger::new(match num_cycles {
            0 => sim::Trigger::Yield,
            _ => sim::Trigger::Edges(handle.id(), edge, num_cycles),
        });
        Ok(PyClassInitializer::from(base).add_subclass(ClockCycles {}))
    }
}

/// A span of simulation time, in `fs`, `ps`, `ns`, `us`, `ms`, `sec` or `step` (1 ps).
///
/// >>> await Timer(10, "ns")
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct Timer {
    span: Time,
}

#[pymethods]
impl Timer {
    #[new]
    #[pyo3(signature = (time, unit = None, *, units = None, round_mode = None))]
    fn new(
        time: &Bound<'_, PyAny>,
        unit: Option<&str>,
        units: Option<&str>,
        round_mode: Option<&str>,
    ) -> PyResult<PyClassInitializer<Self>> {
        // Time is in femtoseconds: there is no simulator step to round to.
        let _ = round_mode;
        if units.is_some() && UNITS_ARE_OLD.load(Ordering::Relaxed) {
            time.py().import("hoverlock.deprecated")?.call_method1("advise", ("Timer(units)", 2))?;
        }
        let span = time_of(time, unit.or(units).unwrap_or("step"))?;
        if span == Time::ZERO {
            return Err(PyValueError::new_err(
                "a Timer of 0: use ReadWrite, ReadOnly or NextTimeStep to order things within a step",
            ));
        }
        Ok(PyClassInitializer::from(Trigger::new(sim::Trigger::Timer(span))).add_subclass(Timer { span }))
    }

    fn __repr__(&self) -> String {
        format!("Timer({})", self.span)
    }
}

macro_rules! plain_trigger {
    ($(#[$doc:meta])* $name:ident, $what:expr) => {
        $(#[$doc])*
        #[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
        pub struct $name {}

        #[pymethods]
        impl $name {
            #[new]
            fn new() -> PyClassInitializer<Self> {
                PyClassInitializer::from(Trigger::new($what)).add_subclass($name {})
            }
        }
    };
}

plain_trigger!(
    /// The end of this time step: all values are settled, and nothing may be written.
    ///
    /// >>> await RisingEdge(dut.clk)
    /// >>> await ReadOnly()
    /// >>> int(dut.count.value)  # the value after the edge
    ReadOnly, sim::Trigger::ReadOnly
);
plain_trigger!(
    /// All values are settled, and may still be changed in this time step.
    ///
    /// >>> await ReadWrite()
    /// >>> dut.ready.value = dut.valid.value
    ReadWrite, sim::Trigger::ReadWrite
);
plain_trigger!(
    /// The beginning of the next time step, whenever that is.
    ///
    /// >>> await NextTimeStep()
    NextTimeStep, sim::Trigger::NextTimeStep
);
plain_trigger!(
    /// Lets the other ready tasks run first.
    ///
    /// >>> await NullTrigger()
    NullTrigger, sim::Trigger::Yield
);
plain_trigger!(
    /// `$finish` in the Verilog. While a task awaits it, it is no error.
    ///
    /// >>> await with_timeout(VerilogFinish(), 1, "ms")
    VerilogFinish, sim::Trigger::Finish
);

/// The first of several triggers, tasks or coroutines; the other waits are cancelled. The result is the trigger that
/// fired, or the result of the task that ended.
///
/// >>> first = await First(RisingEdge(dut.done), Timer(1, "us"))
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct First {}

#[pymethods]
impl First {
    #[new]
    #[pyo3(signature = (*triggers))]
    fn new(triggers: &Bound<'_, PyTuple>) -> PyResult<PyClassInitializer<Self>> {
        let parts = parts("First", triggers)?;
        let py = triggers.py();
        let base = Trigger::giving(sim::Trigger::first(whats(py, &parts)?), Gives::OneOf(parts));
        Ok(PyClassInitializer::from(base).add_subclass(First {}))
    }
}

/// All of several triggers, tasks or coroutines. If a task among them fails, its error is raised at once.
///
/// >>> await Combine(RisingEdge(dut.a_done), RisingEdge(dut.b_done))
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct Combine {}

#[pymethods]
impl Combine {
    #[new]
    #[pyo3(signature = (*triggers))]
    fn new(triggers: &Bound<'_, PyTuple>) -> PyResult<PyClassInitializer<Self>> {
        let parts = parts("Combine", triggers)?;
        let py = triggers.py();
        let base = Trigger::giving(sim::Trigger::combine(whats(py, &parts)?), Gives::AllOf(parts));
        Ok(PyClassInitializer::from(base).add_subclass(Combine {}))
    }
}

/// The types of all triggers.
pub fn kinds(py: Python<'_>) -> [*mut PyTypeObject; 13] {
    [
        Trigger::type_object_raw(py),
        RisingEdge::type_object_raw(py),
        FallingEdge::type_object_raw(py),
        ValueChange::type_object_raw(py),
        ClockCycles::type_object_raw(py),
        Timer::type_object_raw(py),
        ReadOnly::type_object_raw(py),
        ReadWrite::type_object_raw(py),
        NextTimeStep::type_object_raw(py),
        NullTrigger::type_object_raw(py),
        VerilogFinish::type_object_raw(py),
        First::type_object_raw(py),
        Combine::type_object_raw(py),
    ]
}

fn whats(py: Python<'_>, parts: &[Py<Trigger>]) -> PyResult<Vec<sim::Trigger>> {
    parts.iter().map(|part| part.bind(py).get().what().cloned()).collect()
}

fn parts(name: &str, of: &Bound<'_, PyTuple>) -> PyResult<Vec<Py<Trigger>>> {
    if of.is_empty() {
        return Err(PyValueError::new_err(format!("{name} of nothing")));
    }
    of.iter().map(|item| as_trigger(&item).map(Bound::unbind)).collect()
}

/// The trigger itself, the end of a task, or the end of a coroutine, which is started.
pub fn as_trigger<'py>(item: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Trigger>> {
    if let Ok(trigger) = item.cast::<Trigger>() {
        return Ok(trigger.clone());
    }
    if let Ok(task) = item.cast::<Task>() {
        return join(task);
    }
    if task::is_coroutine(item) {
        return join(&task::start(item, None)?);
    }
    Err(PyTypeError::new_err(format!("{} is neither a trigger nor a task nor a coroutine", item.repr()?)))
}

/// The end of a task; its result is that of the task.
pub fn join<'py>(task: &Bound<'py, Task>) -> PyResult<Bound<'py, Trigger>> {
    let what = sim::Trigger::Join(task.get().joined(task)?);
    Bound::new(task.py(), Trigger::giving(what, Gives::TaskResult(task.clone().unbind())))
}

/// An event. It lives in the simulation that runs when it is used, and keeps its state from one to the next.
#[pyclass(frozen, subclass, module = "hoverlock._core", name = "RawEvent")]
pub struct RawEvent {
    /// What it was last set with.
    data: Mutex<Option<Py<PyAny>>>,
    /// Before any simulation runs: whether it is set.
    flag: OnThread<Cell<bool>>,
    event: OnThread<RefCell<Option<sim::Event>>>,
}

impl RawEvent {
    /// The event in the simulation that runs.
    fn event(slf: &Bound<'_, Self>) -> PyResult<sim::Event> {
        let this = slf.get();
        let mut slot = this.event.get()?.borrow_mut();
        if let Some(event) = slot.as_ref()
            && simulation::is_current(|dut| event.is_of(dut))
        {
            return Ok(event.clone());
        }
        let dut = simulation::current()?;
        let is_set = slot.as_ref().map_or(this.flag.get()?.get(), sim::Event::is_set);
        let name: String = slf.getattr(intern!(slf.py(), "name"))?.str()?.extract()?;
        let event = dut.event(&name);
        if is_set {
            event.set();
        }
        *slot = Some(event.clone());
        Ok(event)
    }

    /// Its state where no simulation runs.
    fn put(&self, is_set: bool) -> PyResult<()> {
        *self.event.get()?.borrow_mut() = None;
        self.flag.get()?.set(is_set);
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Option<Py<PyAny>>> {
        self.data.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl RawEvent {
    /// The arguments are those of the classes below, whose `__init__` sets `name`.
    #[new]
    #[pyo3(signature = (*_args, **_named))]
    fn new(_args: &Bound<'_, PyTuple>, _named: Option<&Bound<'_, PyDict>>) -> Self {
        RawEvent {
            data: Mutex::default(),
            flag: OnThread::new(Cell::new(false)),
            event: OnThread::new(RefCell::default()),
        }
    }

    /// Sets the event: all tasks that wait for it continue.
    #[pyo3(signature = (data = None))]
    fn set(slf: &Bound<'_, Self>, data: Option<Py<PyAny>>) -> PyResult<()> {
        if data.is_some() {
            slf.call_method0(intern!(slf.py(), "_set_with_data"))?;
        }
        // The old one is dropped when the lock is free again: to drop it may run any Python.
        let _old = std::mem::replace(&mut *slf.get().lock(), data);
        if !simulation::is_running() {
            return slf.get().put(true);
        }
        RawEvent::event(slf)?.set();
        Ok(())
    }

    /// Clears the event.
    fn clear(slf: &Bound<'_, Self>) -> PyResult<()> {
        if !simulation::is_running() {
            return slf.get().put(false);
        }
        RawEvent::event(slf)?.clear();
        Ok(())
    }

    /// Whether the event is set.
    fn is_set(&self) -> PyResult<bool> {
        let flag = self.flag.get()?.get();
        Ok(self.event.get()?.borrow().as_ref().map_or(flag, sim::Event::is_set))
    }

    /// A trigger: the event is set, or is set already.
    fn wait(slf: &Bound<'_, Self>) -> PyResult<Trigger> {
        Ok(Trigger::new(RawEvent::event(slf)?.trigger()))
    }

    /// What it was last set with, or None.
    #[getter]
    fn data(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.lock().as_ref().map(|data| data.clone_ref(py))
    }

    #[setter]
    fn set_data(&self, data: Option<Py<PyAny>>) {
        let _old = std::mem::replace(&mut *self.lock(), data);
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.lock().as_ref().map_or(Ok(()), |data| visit.call(data))
    }

    fn __clear__(&self) {
        let _old = self.lock().take();
    }
}

/// A lock. It lives in the simulation that runs when it is used, and is free at the beginning of each.
#[pyclass(frozen, module = "hoverlock._core", name = "RawLock")]
pub struct RawLock {
    name: String,
    lock: OnThread<RefCell<Option<sim::Lock>>>,
}

#[pymethods]
impl RawLock {
    #[new]
    fn new(name: String) -> Self {
        RawLock { name, lock: OnThread::new(RefCell::default()) }
    }

    fn locked(&self) -> PyResult<bool> {
        let slot = self.lock.get()?.borrow();
        Ok(match (slot.as_ref(), simulation::current()) {
            (Some(lock), Ok(dut)) => lock.is_of(&dut) && lock.is_locked(),
            _ => false,
        })
    }

    fn acquire(&self) -> PyResult<Trigger> {
        let dut = simulation::current()?;
        let mut slot = self.lock.get()?.borrow_mut();
        if let Some(lock) = slot.as_ref().filter(|lock| lock.is_of(&dut)) {
            return Ok(Trigger::new(lock.trigger()));
        }
        let lock = dut.lock(&self.name);
        let trigger = Trigger::new(lock.trigger());
        *slot = Some(lock);
        Ok(trigger)
    }

    fn release(&self) -> PyResult<()> {
        match self.lock.get()?.borrow().as_ref().filter(|lock| lock.is_locked()) {
            Some(lock) => {
                lock.release();
                Ok(())
            }
            None => {
                Err(errors::TriggerError::new_err(format!("the lock '{}' is released, but no task has it", self.name)))
            }
        }
    }
}

/// A number with a unit; integers are exact. A `step` is 1 ps, the time precision that models are built with.
pub fn time_of(value: &Bound<'_, PyAny>, unit: &str) -> PyResult<Time> {
    let (value, unit) = if unit == "step" { (value.clone(), "ps") } else { (value.clone(), unit) };
    let from_unit: fn(u64) -> Time = match unit {
        "fs" => Time::fs,
        "ps" => Time::ps,
        "ns" => Time::ns,
        "us" => Time::us,
        "ms" => Time::ms,
        "s" | "sec" => Time::s,
        _ => return Err(PyValueError::new_err(format!("no unit '{unit}': fs, ps, ns, us, ms, sec or step"))),
    };
    if let Ok(whole) = value.extract::<u64>() {
        return Ok(from_unit(whole));
    }
    let number: f64 = value.extract()?;
    Time::from_unit(number, unit).map_err(|e| PyValueError::new_err(e.to_string()))
}
