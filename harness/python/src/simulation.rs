//! One simulation of a built model, run from Python.

use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use hoverlock_harness::Time;
use hoverlock_harness::model::InstanceOptions;
use hoverlock_harness::sim::{Clock, Dut, EdgeOrder, Level, Limits, Sim};
use hoverlock_harness::wave::{Recording, RecordingId};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::bus::{Transfer, TransferOptions, Transferred};
use crate::coroutine::PyCoroutine;
use crate::errors::{self, SimulationError};
use crate::gil;
use crate::handle::{self, Handle};
use crate::library::Library;
use crate::on_thread::OnThread;
use crate::running::{self, Entered};
use crate::wait::Task;

/// A simulation: a fresh instance of a model, with its tasks. It stays on the thread on which it was made.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Simulation(OnThread<Inner>);

struct Inner {
    /// `None` while it runs and after it was closed.
    sim: RefCell<Option<Sim>>,
    dut: Dut,
    interrupt: Rc<RefCell<Option<PyErr>>>,
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (
        library, *, seed = 0, plusargs = vec![], edges_after_eval = false, deposits_on_outputs = false
    ))]
    fn new(
        py: Python<'_>,
        library: &Library,
        seed: u64,
        plusargs: Vec<String>,
        edges_after_eval: bool,
        deposits_on_outputs: bool,
    ) -> PyResult<Simulation> {
        let options = InstanceOptions { seed, plusargs };
        let model = library.library.instance_with(&options).map_err(|e| errors::of_model(&e))?;
        let sim = Sim::new(model).map_err(|e| errors::exception(py, e))?;
        if edges_after_eval {
            sim.set_edge_order(EdgeOrder::AfterEval);
        }
        sim.deposit_on_outputs(deposits_on_outputs);
        let interrupt = Rc::new(RefCell::new(None));
        let slot = interrupt.clone();
        sim.set_interrupt(move || match gil::pause() {
            Ok(()) => false,
            Err(error) => {
                *slot.borrow_mut() = Some(error);
                true
            }
        });
        Ok(Simulation(OnThread::new(Inner { dut: sim.dut(), sim: RefCell::new(Some(sim)), interrupt })))
    }

    /// Returns all handles as a list of `(name, handle)`.
    fn handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        handle::all(py, &self.0.get()?.dut)
    }

    /// Returns the exception for a name that the design does not have; its message has the nearest names.
    fn no_such_signal(&self, name: &str) -> PyResult<PyErr> {
        Ok(match self.0.get()?.dut.signal(name) {
            Err(error) => errors::of_model(&error),
            Ok(_) => SimulationError::new_err(format!("'{name}' is a signal")),
        })
    }

    /// Runs a coroutine to its end, then finishes the time step; returns the coroutine's result.
    #[pyo3(signature = (coroutine, name, *, time_limit_fs = None, wall_limit = None))]
    fn run(
        &self,
        py: Python<'_>,
        coroutine: Bound<'_, PyAny>,
        name: &str,
        time_limit_fs: Option<u64>,
        wall_limit: Option<f64>,
    ) -> PyResult<Py<PyAny>> {
        let wall_clock = wall_limit.map(Duration::try_from_secs_f64).transpose();
        let wall_clock = wall_clock.map_err(|e| PyValueError::new_err(format!("wall_limit: {e}")))?;
        let inner = self.0.get()?;
        let task = Py::new(py, Task::new(inner.dut.clone(), name))?;
        let body = PyCoroutine::new(coroutine, task.clone_ref(py));
        inner.running(py, |sim| {
            sim.set_limits(Limits { time: time_limit_fs.map(Time::fs), wall_clock, ..Limits::default() });
            sim.run_coroutine(name, Box::new(body))
        })?;
        Ok(task.get().result_or_none(py))
    }

    /// Sends whole frames through a stream of the design, without the scheduler.
    fn transfer<'py>(&self, samples: &Bound<'py, PyAny>, options: TransferOptions<'py>) -> PyResult<Transferred<'py>> {
        let py = samples.py();
        let inner = self.0.get()?;
        let transfer = Transfer::new(py, &inner.dut, options)?;
        let mut result = None;
        inner.running(py, |sim| {
            result = Some(transfer.run(sim, samples));
            Ok(())
        })?;
        result.unwrap_or_else(|| Err(SimulationError::new_err("the transfer did not run")))
    }

    /// Starts a wave file: of all signals, of the named signals, or of the last time steps before a failure.
    #[pyo3(signature = (path, signals = None, before_failure = None))]
    fn start_waves(
        &self,
        py: Python<'_>,
        path: PathBuf,
        signals: Option<Vec<String>>,
        before_failure: Option<usize>,
    ) -> PyResult<Waves> {
        let recording = match (signals, before_failure) {
            (signals, Some(steps)) => Recording::before_failure(path, signals.unwrap_or_default(), steps),
            (Some(signals), None) => Recording::signals(path, signals),
            (None, None) => Recording::everything(path),
        };
        let dut = &self.0.get()?.dut;
        let id = dut.start_waves(&recording).map_err(|e| errors::exception(py, e))?;
        Ok(Waves(OnThread::new((dut.clone(), Cell::new(Some(id))))))
    }

    /// Writes the coverage counted so far, in Verilator's format.
    fn write_coverage(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.0.get()?.dut.write_coverage(path).map_err(|e| errors::exception(py, e))
    }

    /// Advances simulation time by a span in femtoseconds; clocks and tasks run meanwhile.
    fn run_for(&self, py: Python<'_>, femtoseconds: u64) -> PyResult<()> {
        self.0.get()?.running(py, |sim| sim.run_for(Time::fs(femtoseconds)))
    }

    /// Returns, as text, which trigger each task waits for.
    fn report(&self) -> PyResult<String> {
        Ok(self.0.get()?.sim.borrow().as_ref().map_or_else(String::new, |sim| sim.report().to_string()))
    }

    /// Returns the names of the tasks that have not ended.
    fn living_tasks(&self) -> PyResult<Vec<String>> {
        let sim = self.0.get()?.sim.borrow();
        Ok(sim.as_ref().map_or_else(Vec::new, |sim| sim.report().tasks.into_iter().map(|t| t.task).collect()))
    }

    /// Calls `listener(time_fs, level, source, text)` with every line of the log.
    fn set_log_listener(&self, listener: Py<PyAny>) -> PyResult<()> {
        if let Some(sim) = self.0.get()?.sim.borrow().as_ref() {
            sim.set_log_listener(move |line| {
                let py = gil::resume();
                let level = match line.level {
                    Level::Debug => 10,
                    Level::Info => 20,
                    Level::Warning => 30,
                    Level::Error => 40,
                };
                let given = (line.time.as_fs(), level, line.source.as_str(), line.text.as_str());
                if let Err(error) = listener.call1(py, given) {
                    error.write_unraisable(py, None);
                }
            });
        }
        Ok(())
    }

    /// Returns the number of evaluations of the model.
    fn evaluations(&self) -> PyResult<u64> {
        Ok(self.0.get()?.sim.borrow().as_ref().map_or(0, Sim::evaluations))
    }

    /// Returns the simulation time in femtoseconds.
    fn now(&self) -> PyResult<u64> {
        Ok(self.0.get()?.dut.now().as_fs())
    }

    /// Cancels all tasks, runs the Verilog's `final` blocks and frees the model; returns the lines that the blocks
    /// print.
    fn close(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let inner = self.0.get()?;
        let _entered = Entered::new(inner.dut.clone());
        let Some(mut sim) = inner.sim.borrow_mut().take() else { return Ok(Vec::new()) };
        let recorded = sim.stop_waves();
        let messages = sim.finish();
        recorded.map_err(|error| errors::exception(py, error))?;
        let text = |message| match message {
            hoverlock_harness::model::Message::Text(text) => Some(text),
            _ => None,
        };
        Ok(messages.into_iter().filter_map(text).collect())
    }
}

impl Inner {
    /// Runs `work` with this simulation as the current one of the thread. The exception of a signal such as Ctrl-C
    /// takes precedence over the result.
    fn running<T>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Sim) -> Result<T, hoverlock_harness::Error>,
    ) -> PyResult<T> {
        let Some(mut sim) = self.sim.borrow_mut().take() else {
            return Err(SimulationError::new_err("the simulation runs already, or was closed"));
        };
        let _entered = Entered::new(self.dut.clone());
        let ended = {
            let _running = gil::Running;
            work(&mut sim)
        };
        *self.sim.borrow_mut() = Some(sim);
        match (self.interrupt.borrow_mut().take(), ended) {
            (Some(signal), _) => Err(signal),
            (None, Ok(value)) => Ok(value),
            (None, Err(error)) => Err(errors::exception(py, error)),
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(mut sim) = self.sim.borrow_mut().take() {
            let _entered = Entered::new(self.dut.clone());
            sim.cancel_all();
        }
    }
}

/// A wave file that is being written.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Waves(OnThread<(Dut, Cell<Option<RecordingId>>)>);

#[pymethods]
impl Waves {
    /// Completes the file.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        let (dut, id) = self.0.get()?;
        id.take().map_or(Ok(()), |id| dut.stop_waves(id)).map_err(|e| errors::exception(py, e))
    }
}

/// A clock driven by the engine.
#[pyclass(frozen, module = "hoverlock._core", name = "RunningClock")]
pub struct RunningClock(OnThread<Clock>);

#[pymethods]
impl RunningClock {
    /// Stops it at its level.
    fn stop(&self) -> PyResult<()> {
        self.0.get()?.stop();
        Ok(())
    }
}

/// Starts a clock in the running simulation: it is 1 for `high` and 0 for `low`, and its first rising edge comes after
/// `phase`, all in fs.
///
/// # Errors
/// `SimulationError` if no simulation runs or the signal belongs to another one.
#[pyfunction]
pub fn start_clock(py: Python<'_>, signal: &Handle, high: u64, low: u64, phase: u64) -> PyResult<RunningClock> {
    let dut = running::current()?;
    if !dut.has(signal.id()) {
        let text = format!("'{}' belongs to another simulation than the one that runs", signal.name());
        return Err(SimulationError::new_err(text));
    }
    let clock = dut
        .clock_with(signal.name(), Time::fs(high), Time::fs(low), Time::fs(phase))
        .map_err(|e| errors::exception(py, e))?;
    Ok(RunningClock(OnThread::new(clock)))
}
