//! `hoverlock._core`: the binding of the engine to Python. Users import `hoverlock/*.py`, which adds
//! what needs no speed: the decorator, the runner, queues, logging, the pytest plug-in.
//!
//! The engine's scheduler resumes coroutines through their `am_send`. Modules `task` and `trigger` say why a wait
//! allocates no object, module `gil` when the interpreter's lock is released.

mod bus;
mod errors;
mod gil;
mod handle;
mod library;
mod on_thread;
mod simulation;
mod slots;
mod task;
mod trigger;

#[pyo3::pymodule]
mod _core {
    #[pymodule_export]
    use crate::bus::{Access, Burst, RawChecker, RawListener, RawMaster, RawMemory, RawSource, Symbols};
    #[pymodule_export]
    use crate::handle::{
        ArrayHandle, Bits, Element, Handle, HierarchyBase, RealHandle, TextHandle, Value, count_bits_from_left,
    };
    #[pymodule_export]
    use crate::library::{Coverage, Library, compile};
    #[pymodule_export]
    use crate::simulation::{RunningClock, Simulation, Waves, femtoseconds, now, region, start_clock};
    #[pymodule_export]
    use crate::task::{Task, create_task, start_soon};
    #[pymodule_export]
    use crate::trigger::{
        ClockCycles, Combine, FallingEdge, First, NextTimeStep, NullTrigger, RawEvent, RawLock, ReadOnly, ReadWrite,
        RisingEdge, Timer, Trigger, ValueChange, VerilogFinish, advise_units,
    };

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::slots::install(module.py());
        Ok(())
    }
}
