//! Handles of a design: signals, bits of a signal, memories, reals and strings, levels of the hierarchy; and the
//! values read from them.

mod array;
mod bits;
mod forcing;
mod hierarchy;
mod names;
mod number;
mod range;
mod scalar;
mod signal;
mod signal_methods;
mod value;

use std::sync::Arc;

use hoverlock_harness::sim::Dut;
use pyo3::prelude::*;
use pyo3::types::PyList;

pub use self::array::{ArrayHandle, Element};
pub use self::bits::Bits;
pub use self::hierarchy::HierarchyBase;
pub use self::scalar::{RealHandle, TextHandle};
pub use self::signal::Handle;
pub use self::value::{Value, count_bits_from_left};

/// Returns the pairs of name and handle of all ports and internals of a simulation, in the order of the Verilog;
/// strings come last.
pub fn all<'py>(py: Python<'py>, dut: &Dut) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    let top: Arc<str> = dut.top().into();
    for info in dut.signals() {
        let name = info.name.clone();
        if info.range.is_some() {
            list.append((name, Bound::new(py, ArrayHandle::new(dut, &top, info)?)?))?;
        } else if info.real {
            list.append((name, Bound::new(py, RealHandle::new(dut, &top, info.name, info.direction)?)?))?;
        } else {
            list.append((name, Bound::new(py, Handle::new(dut, &top, info)?)?))?;
        }
    }
    for name in dut.texts() {
        list.append((name.clone(), Bound::new(py, TextHandle::new(dut, &top, name)?)?))?;
    }
    Ok(list)
}
