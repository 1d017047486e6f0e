//! Indices into the bits of a value.

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PySlice;

/// Returns the lowest bit and the width of an index: `[3]` or, higher bit first as in Verilog, `[7:4]`.
///
/// # Errors
/// `IndexError` outside of the `of_width` bits, or for a lower bit first.
pub(super) fn span(index: &Bound<'_, PyAny>, of_width: u32) -> PyResult<(u32, u32)> {
    let within = |i: i64| {
        u32::try_from(i)
            .ok()
            .filter(|i| *i < of_width)
            .ok_or_else(|| PyIndexError::new_err(format!("bit {i} of a value of {of_width} bits")))
    };
    let Ok(slice) = index.cast::<PySlice>() else { return Ok((within(index.extract()?)?, 1)) };
    let end = |name: &str, default: i64| -> PyResult<i64> {
        let bound = slice.getattr(name)?;
        if bound.is_none() { Ok(default) } else { bound.extract() }
    };
    let (high, low) = (within(end("start", i64::from(of_width) - 1)?)?, within(end("stop", 0)?)?);
    if high < low || !slice.getattr("step")?.is_none() {
        return Err(PyIndexError::new_err(format!("[{high}:{low}]: write the higher bit first, as in Verilog")));
    }
    Ok((low, high - low + 1))
}

/// Returns the same for positions that count from the left, both ends included: `[0]` is the highest bit, `[0:7]` are
/// the highest eight.
pub(super) fn span_from_left(index: &Bound<'_, PyAny>, of_width: u32) -> PyResult<(u32, u32)> {
    let last = i64::from(of_width) - 1;
    let within = |i: i64| {
        let at = if i < 0 { i + last + 1 } else { i };
        u32::try_from(at)
            .ok()
            .filter(|at| *at < of_width)
            .ok_or_else(|| PyIndexError::new_err(format!("position {i} of a value of {of_width} bits")))
    };
    let Ok(slice) = index.cast::<PySlice>() else { return Ok((of_width - 1 - within(index.extract()?)?, 1)) };
    let end = |name: &str, default: i64| -> PyResult<u32> {
        let bound = slice.getattr(name)?;
        within(if bound.is_none() { default } else { bound.extract()? })
    };
    let (left, right) = (end("start", 0)?, end("stop", last)?);
    if left > right || !slice.getattr("step")?.is_none() {
        return Err(PyIndexError::new_err(format!("[{left}:{right}]: positions count from the left, as in cocotb 1")));
    }
    Ok((of_width - 1 - right, right - left + 1))
}
