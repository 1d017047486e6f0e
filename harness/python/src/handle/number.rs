//! Numbers between Python and the words of a signal.

use pyo3::IntoPyObjectExt;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyInt, PyString};

/// Returns the value of an `int` (or `bool`) that fits 64 bits, otherwise `None`. Faster than pyo3's `extract`, which
/// looks for `__index__` first.
#[inline]
pub(super) fn word_of(value: &Bound<'_, PyAny>) -> Option<u64> {
    let whole = value.cast::<PyInt>().ok()?;
    // SAFETY: a live `int`, and the interpreter's lock is held.
    unsafe {
        let word = pyo3::ffi::PyLong_AsUnsignedLongLong(whole.as_ptr());
        if word == u64::MAX && !pyo3::ffi::PyErr_Occurred().is_null() {
            pyo3::ffi::PyErr_Clear();
            return None;
        }
        Some(word)
    }
}

/// Converts 32-bit words, lowest first, into an `int`.
pub(super) fn int_of_words<'py>(py: Python<'py>, words: &[u32]) -> PyResult<Bound<'py, PyAny>> {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    py.get_type::<PyInt>().call_method1("from_bytes", (bytes.as_slice(), "little"))
}

/// Converts a number into 32-bit words, lowest first, negative ones in two's complement. Returns `None` if it does not
/// fit `width` bits.
pub(super) fn words_of_int(value: &Bound<'_, PyInt>, width: u32) -> PyResult<Option<Vec<u32>>> {
    let py = value.py();
    let negative = value.lt(0)?;
    let modulus = 1u32.into_bound_py_any(py)?.lshift(width)?;
    let value = if negative { value.add(modulus)? } else { value.clone().into_any() };
    let half = value.rshift(width - 1)?.is_truthy()?;
    if value.lt(0)? || value.rshift(width)?.is_truthy()? || (negative && !half) {
        return Ok(None);
    }
    let bytes = width.div_ceil(32) as usize * 4;
    let bytes: Vec<u8> = value.call_method1("to_bytes", (bytes, "little"))?.extract()?;
    Ok(Some(bytes.as_chunks::<4>().0.iter().map(|w| u32::from_le_bytes(*w)).collect()))
}

/// Converts a value that is written to the signal `name` into an `int`: an integer, or binary digits.
pub(super) fn number_of<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = value.py();
    let digits = match value.cast::<PyString>() {
        Ok(text) => Some(text.to_str()?.to_owned()),
        Err(_) => match value.getattr(intern!(py, "is_resolvable")) {
            Ok(resolvable) if !resolvable.is_truthy()? => Some(value.str()?.to_str()?.to_owned()),
            _ => None,
        },
    };
    match digits {
        Some(digits) if has_unknown(&digits) => py.get_type::<PyInt>().call1((resolve(py, name, &digits)?, 2)),
        Some(digits) => py.get_type::<PyInt>().call1((digits, 2)),
        None => value.call_method0("__index__"),
    }
}

/// Returns `true` if all digits are digits of Verilog, and some of them (`X`, `Z` and the like) have no value in two
/// states.
pub(super) fn has_unknown(digits: &str) -> bool {
    digits.chars().all(|c| "01XZUWLH-xzuwlh".contains(c)) && digits.contains(|c| c != '0' && c != '1')
}

/// Replaces `X`, `Z` and the like in the digits by 0 and 1, if the bench has chosen that; otherwise an error.
pub(super) fn resolve(py: Python<'_>, name: &str, digits: &str) -> PyResult<String> {
    py.import("hoverlock.unknown")?.call_method1("resolve", (name, digits))?.extract()
}
