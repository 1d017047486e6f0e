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
                    let signal_name = format!("{}[{at}]", handle.name());
                    return Py::new(py, PyClassInitializer::from(base).add_subclass($name { signal_name }));
                };
                let handle = signal.get();
                handle.check_thread()?;
                let made = handle.$cache.get_or_try_init(py, || {
                    if $one_bit && handle.width() != 1 {
                        return Err(PyTypeError::new_err(format!(
                            "{} takes a signal of one bit, '{}' has {}: use ValueChange",
                            stringify!($name),
                            handle.name(),
                            handle.width()
                        )));
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

/// The n-th rising (or falling) edge from now; the task does not run at the edges before it. 0 only lets other tasks
/// run.
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
