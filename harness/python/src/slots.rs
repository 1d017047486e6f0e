//! Hand-written type slots for the operations that a bench does in every cycle: await a trigger, read and write
//! `handle.value`, convert a value to `int`.
//!
//! The code that pyo3 generates around a method (a count of nested calls, a check of the type of `self`) and the
//! interpreter's look-up of an attribute cost several times as much as these methods themselves. The slots call the
//! same methods, and pass everything else to the slots that pyo3 generated. CPython allows this only outside of its
//! limited API, so the module is built for one version of Python.

use std::os::raw::c_int;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicPtr, Ordering};

use pyo3::ffi::{self, PyObject};
use pyo3::prelude::*;
use pyo3::{PyClass, PyTypeInfo, intern};

use crate::handle::{Handle, Value};
use crate::triggers;
use crate::wait::{Progress, Trigger};

/// The interned string `value`: the name of an attribute in Python source is this same object.
static VALUE: AtomicPtr<PyObject> = AtomicPtr::new(std::ptr::null_mut());

/// The slot by which pyo3 reads the attributes of a handle.
static OTHER_ATTRIBUTES: OnceLock<ffi::getattrofunc> = OnceLock::new();

/// Installs the slots; called before there are objects of these types.
pub fn install(py: Python<'_>) {
    VALUE.store(intern!(py, "value").clone().into_ptr(), Ordering::Relaxed);
    for kind in triggers::kinds(py) {
        // SAFETY: a type on the heap, which has a table of these slots; the interpreter's lock is held.
        unsafe {
            (*(*kind).tp_as_async).am_await = Some(await_trigger);
            (*(*kind).tp_as_async).am_send = Some(send_to_trigger);
            ffi::PyType_Modified(kind);
        }
    }
    let (handle, value) = (Handle::type_object_raw(py), Value::type_object_raw(py));
    // SAFETY: as above.
    unsafe {
        (*(*value).tp_as_number).nb_int = Some(int_of_value);
        ffi::PyType_Modified(value);
        OTHER_ATTRIBUTES.get_or_init(|| (*handle).tp_getattro.unwrap_or(ffi::PyObject_GenericGetAttr));
        (*handle).tp_getattro = Some(attribute_of_handle);
        (*handle).tp_setattro = Some(set_attribute_of_handle);
        ffi::PyType_Modified(handle);
    }
}

/// Returns the object that a slot got as its first argument.
///
/// # Safety
/// The interpreter's lock is held, and the object, which outlives the call, is of that class.
#[inline(always)]
unsafe fn of_class<'a, 'py, T: PyClass>(py: Python<'py>, object: *mut PyObject) -> Borrowed<'a, 'py, T> {
    // SAFETY: as the caller promises.
    unsafe { Borrowed::from_ptr(py, object).cast_unchecked() }
}

/// Converts a result into the return value of a slot; raises the exception of an error.
#[inline(always)]
fn slot_result<T>(py: Python<'_>, object: PyResult<Bound<'_, T>>) -> *mut PyObject {
    match object {
        Ok(object) => object.into_ptr(),
        Err(error) => {
            error.restore(py);
            std::ptr::null_mut()
        }
    }
}

unsafe extern "C" fn await_trigger(trigger: *mut PyObject) -> *mut PyObject {
    // SAFETY: the interpreter calls a slot with its lock and an object of the slot's type.
    let (py, trigger) = unsafe {
        let py = Python::assume_attached();
        (py, of_class::<Trigger>(py, trigger))
    };
    slot_result(py, trigger.get().begin().map(|()| trigger.to_owned()))
}

unsafe extern "C" fn send_to_trigger(
    trigger: *mut PyObject,
    _: *mut PyObject,
    result: *mut *mut PyObject,
) -> ffi::PySendResult {
    // SAFETY: as in `await_trigger`.
    let (py, trigger) = unsafe {
        let py = Python::assume_attached();
        (py, of_class::<Trigger>(py, trigger))
    };
    let (status, object) = match trigger.get().proceed() {
        Ok(Progress::Pending) => (ffi::PySendResult::PYGEN_NEXT, trigger.to_owned().into_ptr()),
        Ok(Progress::Fired(None)) => (ffi::PySendResult::PYGEN_RETURN, py.None().into_ptr()),
        Ok(Progress::Fired(Some(result))) => (ffi::PySendResult::PYGEN_RETURN, result.into_ptr()),
        Err(error) => {
            error.restore(py);
            (ffi::PySendResult::PYGEN_ERROR, std::ptr::null_mut())
        }
    };
    // SAFETY: the interpreter passes a valid place for the result.
    unsafe { *result = object };
    status
}

unsafe extern "C" fn int_of_value(value: *mut PyObject) -> *mut PyObject {
    // SAFETY: as in `await_trigger`.
    let (py, value) = unsafe {
        let py = Python::assume_attached();
        (py, of_class::<Value>(py, value))
    };
    slot_result(py, value.get().int(py))
}

unsafe extern "C" fn attribute_of_handle(handle: *mut PyObject, name: *mut PyObject) -> *mut PyObject {
    if name != VALUE.load(Ordering::Relaxed) {
        let others = OTHER_ATTRIBUTES.get().copied().unwrap_or(ffi::PyObject_GenericGetAttr);
        // SAFETY: the arguments are passed on.
        return unsafe { others(handle, name) };
    }
    // SAFETY: as in `await_trigger`.
    let (py, handle) = unsafe {
        let py = Python::assume_attached();
        (py, of_class::<Handle>(py, handle))
    };
    slot_result(py, handle.get().read(py))
}

unsafe extern "C" fn set_attribute_of_handle(
    handle: *mut PyObject,
    name: *mut PyObject,
    value: *mut PyObject,
) -> c_int {
    // No value: the attribute is to be deleted.
    if name != VALUE.load(Ordering::Relaxed) || value.is_null() {
        // SAFETY: the arguments are passed on.
        return unsafe { ffi::PyObject_GenericSetAttr(handle, name, value) };
    }
    // SAFETY: as in `await_trigger`; the value outlives the call.
    let (py, handle, value) = unsafe {
        let py = Python::assume_attached();
        (py, of_class::<Handle>(py, handle), Borrowed::<PyAny>::from_ptr(py, value))
    };
    match handle.get().write(&value) {
        Ok(()) => 0,
        Err(error) => {
            error.restore(py);
            -1
        }
    }
}
