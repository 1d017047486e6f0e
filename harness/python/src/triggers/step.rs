//! Spans of time and the regions of a time step.

#![allow(unsafe_op_in_unsafe_fn, reason = "what pyo3 writes for the classes made by macros; no unsafe code is here")]

use std::sync::atomic::{AtomicBool, Ordering};

use hoverlock_harness::Time;
use hoverlock_harness::sim;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::time::{rounded, time_of};
use crate::wait::Trigger;

/// Whether `Timer(units=...)` logs a deprecation warning.
static WARN_OF_UNITS: AtomicBool = AtomicBool::new(false);

/// Sets whether `Timer(units=...)` warns that the name is deprecated, as cocotb 2 does.
#[pyfunction]
pub fn advise_units(on: bool) {
    WARN_OF_UNITS.store(on, Ordering::Relaxed);
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
        if units.is_some() && WARN_OF_UNITS.load(Ordering::Relaxed) {
            time.py().import("hoverlock.deprecated")?.call_method1("advise", ("Timer(units)", 2))?;
        }
        let unit = unit.or(units).unwrap_or("step");
        let span = match round_mode {
            Some(mode) => rounded(time, unit, mode)?,
            None => time_of(time, unit)?,
        };
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
