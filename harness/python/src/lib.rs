//! `hoverlock._core`: the binding of the engine to Python. Users import the Python modules in `hoverlock/`, which add
//! the parts that need no speed: the decorator, the runner, queues, logging, the pytest plug-in.
//!
//! The engine's scheduler resumes coroutines through their `am_send`. Module `wait` explains why a wait allocates no
//! object, module `gil` when the interpreter's lock is released.
//!
//! Each module uses only those before it: `gil`, `errors`, `on_thread`, `running` and `time`; `wait`, the classes that
//! can be awaited; `coroutine`, `task` and `handle`; `triggers`, `bus` and `library`; `simulation` and `slots`.

mod bus;
mod coroutine;
mod errors;
mod gil;
mod handle;
mod library;
mod on_thread;
mod running;
mod simulation;
mod slots;
mod task;
mod time;
mod triggers;
mod wait;

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
    use crate::running::{current_task, now, region};
    #[pymodule_export]
    use crate::simulation::{RunningClock, Simulation, Waves, start_clock};
    #[pymodule_export]
    use crate::task::{create_task, start_soon};
    #[pymodule_export]
    use crate::time::femtoseconds;
    #[pymodule_export]
    use crate::triggers::{
        ClockCycles, Combine, First, NextTimeStep, NullTrigger, RawEvent, RawLock, ReadOnly, ReadWrite, Timer,
        VerilogFinish, advise_units,
    };
    #[pymodule_export]
    use crate::wait::{FallingEdge, RisingEdge, Task, Trigger, ValueChange};

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::slots::install(module.py());
        Ok(())
    }
}
