//! The triggers of a bench: constructors and methods of what a coroutine awaits.

mod combined;
mod edge;
mod event;
mod step;

use pyo3::PyTypeInfo;
use pyo3::ffi::PyTypeObject;
use pyo3::prelude::*;

pub use self::combined::{Combine, First};
pub use self::edge::ClockCycles;
pub use self::event::{RawEvent, RawLock};
pub use self::step::{NextTimeStep, NullTrigger, ReadOnly, ReadWrite, Timer, VerilogFinish, advise_units};
use crate::wait::{FallingEdge, RisingEdge, Trigger, ValueChange};

/// Returns the type objects of all triggers.
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
