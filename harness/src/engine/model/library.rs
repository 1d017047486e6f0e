//! A built model as a loaded shared library, and the functions of its shim.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::Arc;

use crate::engine::build::{Constant, Diagnostic, Record, Trace};
use crate::engine::error::{BuildError, ModelError};
use crate::engine::model::{InstanceOptions, Model};

pub(crate) type Instance = *mut c_void;

/// The greatest number of unpacked dimensions, as in the shim.
pub(crate) const DIMENSIONS: usize = 8;

/// A signal of the shim's table, laid out as its `HvSignal`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct RawSlot {
    pub data: *mut u8,
    pub target: *mut u8,
    pub force_enable: *mut u8,
    pub force_value: *mut u8,
    pub kind: u32,
    pub element_bytes: u32,
    pub dimensions: u32,
    pub extents: [u32; DIMENSIONS],
}

macro_rules! functions {
    ($($name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The shim's functions.
        #[derive(Clone, Copy)]
        pub(crate) struct Functions { $(pub $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)* }

        impl Functions {
            fn find(library: &libloading::Library) -> Result<Functions, libloading::Error> {
                // SAFETY: the names and types are those of shim.cpp, whose text is part of the cache key.
                unsafe {
                    Ok(Functions { $($name: *library.get(concat!(stringify!($name), "\0").as_bytes())?,)* })
                }
            }
        }
    };
}

functions! {
    hv_interface: fn() -> u32;
    hv_new: fn(u64, i32, i32, *const *const c_char) -> Instance;
    hv_delete: fn(Instance);
    hv_bind: fn(Instance);
    hv_eval_bound: fn(Instance);
    hv_final: fn(Instance);
    hv_time: fn(Instance, u64);
    hv_precision: fn(Instance) -> i32;
    hv_pending: fn(Instance) -> *const u8;
    hv_signals: fn(Instance, *mut *const RawSlot) -> u32;
    hv_text_get: fn(*const u8, *mut u64) -> *const c_char;
    hv_text_set: fn(*mut u8, *const c_char, u64);
    hv_take_text: fn(Instance, *mut u64) -> *const c_char;
    hv_take_event: fn(Instance, *mut u32, *mut u32, *mut *const c_char, *mut *const c_char) -> i32;
    hv_trace_open: fn(Instance, *const c_char, i32, *const c_char) -> i32;
    hv_trace_dump: fn(Instance, u64);
    hv_trace_flush: fn(Instance);
    hv_trace_close: fn(Instance);
    hv_coverage_write: fn(Instance, *const c_char) -> i32;
}

struct Inner {
    functions: Functions,
    record: Record,
}

/// A built and loaded model, from which instances are made. Cheap to clone, usable from all threads.
#[derive(Clone)]
pub struct Library(Arc<Inner>);

impl Library {
    pub(crate) fn load(path: &Path, record: Record) -> Result<Library, BuildError> {
        let failed = |e: libloading::Error| BuildError::Load { path: path.to_owned(), reason: e.to_string() };
        // SAFETY: the library was built by this crate; its constructors only set up C++ globals of its own.
        let library = unsafe { libloading::Library::new(path) }.map_err(failed)?;
        let functions = Functions::find(&library).map_err(failed)?;
        // SAFETY: takes nothing and returns a constant.
        let interface = unsafe { (functions.hv_interface)() };
        if interface != crate::engine::build::INTERFACE {
            let reason = format!("its interface is {interface}, not {}", crate::engine::build::INTERFACE);
            return Err(BuildError::Load { path: path.to_owned(), reason });
        }
        // Never unloaded: thread-local objects of the runtime live until each thread ends and need the code.
        std::mem::forget(library);
        Ok(Library(Arc::new(Inner { functions, record })))
    }

    /// Creates a fresh instance in its initial state.
    ///
    /// # Errors
    /// If the model cannot be made, for lack of memory.
    pub fn instance(&self) -> Result<Model, ModelError> {
        self.instance_with(&InstanceOptions::default())
    }

    /// Creates a fresh instance with a seed for random initial values and `$random`, and with plusargs.
    ///
    /// # Errors
    /// If a plusarg has a zero byte, or the model cannot be made, for lack of memory.
    pub fn instance_with(&self, options: &InstanceOptions) -> Result<Model, ModelError> {
        Model::new(self.clone(), options)
    }

    /// Returns the top module's name.
    pub fn top(&self) -> &str {
        &self.0.record.top
    }

    /// Returns Verilator's warnings.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.0.record.warnings
    }

    /// Returns parameters and local parameters of all instances, by their names below the top module.
    pub fn constants(&self) -> &[(String, Constant)] {
        &self.0.record.constants
    }

    /// Returns the names of all variables below the top module, whether the model makes them accessible or not.
    pub fn names(&self) -> &[String] {
        &self.0.record.names
    }

    /// Returns the format of the wave files that the model was built to write.
    pub fn trace(&self) -> Trace {
        self.0.record.trace
    }

    pub(crate) fn functions(&self) -> &Functions {
        &self.0.functions
    }

    pub(crate) fn record(&self) -> &Record {
        &self.0.record
    }
}

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Library").field("top", &self.top()).finish_non_exhaustive()
    }
}
