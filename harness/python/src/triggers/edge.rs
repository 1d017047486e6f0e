//! Edges of a signal, or of one bit of it, and counts of them.

#![allow(unsafe_op_in_unsafe_fn, reason = "what pyo3 writes for the methods made by macros; no unsafe code is here")]

use hoverlock_harness::sim::{self, Edge};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::handle::{Bits, Handle};
use crate::wait::{FallingEdge, RisingEdge, Trigger, ValueChange};

fn not_a_signal(name: &str, given: &Bound<'_, PyAny>) -> PyErr {
    let shown = given.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
    PyTypeError::new_err(format!("{name} takes a signal or one bit of a signal, not {shown}"))
}

fn not_one_bit(name: &str, handle: &Handle) -> PyErr {
    let (signal, width) = (handle.name(), handle.width());
    PyTypeError::new_err(format!("{name} takes a signal of one bit, '{signal}' has {width}: use ValueChange"))
}

fn edge_of(rising: bool) -> Edge {
    if rising { Edge::Rising } else { Edge::Falling }
}

/// The constructor of an edge class.
macro_rules! edge_constructor {
    ($name:ident, $edge:expr, $of_bit:expr, $cache:ident, $one_bit:expr) => {
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
                    let signal_name = format!("{}[{}]", handle.name(), handle.index_at(at.into()));
                    return Py::new(py, PyClassInitializer::from(base).add_subclass($name { signal_name }));
                };
                let handle = signal.get();
                handle.check_thread()?;
                let made = handle.$cache.get_or_try_init(py, || {
                    if $one_bit && handle.width() != 1 {
                        return Err(not_one_bit(stringify!($name), handle));
                    }
                    let base = Trigger::new(sim::Trigger::Edge(handle.id(), $edge));
                    let whole =
                        PyClassInitializer::from(base).add_subclass($name { signal_name: handle.name().to_owned() });
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

edge_constructor!(RisingEdge, Edge::Rising, Edge::RisingBit, rising, true);
edge_constructor!(FallingEdge, Edge::Falling, Edge::FallingBit, falling, true);
edge_constructor!(ValueChange, Edge::Any, Edge::AnyBit, change, false);

/// The n-th rising edge from now, or that of another kind: `RisingEdge`, `FallingEdge` or `ValueChange`. The task does
/// not run at the edges before it. 0 only lets other tasks run.
///
/// >>> await ClockCycles(dut.clk, 100)
/// >>> await ClockCycles(dut.clk, 3, FallingEdge)
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct ClockCycles {}

#[pymethods]
impl ClockCycles {
    #[new]
    #[pyo3(signature = (signal, num_cycles, edge_type = None, *, rising = None))]
    fn new(
        signal: &Bound<'_, Handle>,
        num_cycles: u64,
        edge_type: Option<&Bound<'_, PyAny>>,
        rising: Option<bool>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let handle = signal.get();
        if handle.width() != 1 {
            return Err(not_one_bit("ClockCycles", handle));
        }
        // cocotb 2 names the edge by its trigger, cocotb 1 by a truth value.
        let py = signal.py();
        let edge = match (edge_type, rising) {
            (Some(_), Some(_)) => return Err(PyTypeError::new_err("ClockCycles takes edge_type or rising, not both")),
            (None, rising) => edge_of(rising.unwrap_or(true)),
            (Some(kind), None) if kind.is(py.get_type::<RisingEdge>()) => Edge::Rising,
            (Some(kind), None) if kind.is(py.get_type::<FallingEdge>()) => Edge::Falling,
            (Some(kind), None) if kind.is(py.get_type::<ValueChange>()) => Edge::Any,
            (Some(kind), None) => match kind.extract() {
                Ok(rising) => edge_of(rising),
                Err(_) => {
                    return Err(PyTypeError::new_err(format!(
                        "the edges that ClockCycles counts are RisingEdge, FallingEdge or ValueChange, not {}",
                        kind.repr()?
                    )));
                }
            },
        };
        let base = Trigger::new(match num_cycles {
            0 => sim::Trigger::Yield,
            _ => sim::Trigger::Edges(handle.id(), edge, num_cycles),
        });
        Ok(PyClassInitializer::from(base).add_subclass(ClockCycles {}))
    }
}
