//! Indices into the bits of a value.

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PySlice;

/// Returns the place of the rightmost bit, counted from the right, and the width of an index into a value whose bits
/// are declared as `[left:right]`: `[3]` or, the left one first as in Verilog, `[7:4]`.
///
/// # Errors
/// `IndexError` outside of the bits, or for the right one first.
pub(super) fn span(index: &Bound<'_, PyAny>, (left, right): (i64, i64)) -> PyResult<(u32, u32)> {
    // Places of at most 2^32 bits.
    let place = |i: i64| {
        let is_inside = (left.min(right)..=left.max(right)).contains(&i);
        let place = u32::try_from(i.abs_diff(right)).ok().filter(|_| is_inside);
        place.ok_or_else(|| PyIndexError::new_err(format!("bit {i} of a value of the bits [{left}:{right}]")))
    };
    let Ok(slice) = index.cast::<PySlice>() else { return Ok((place(index.extract()?)?, 1)) };
    let end = |name: &str, default: i64| -> PyResult<i64> {
        let bound = slice.getattr(name)?;
        if bound.is_none() { Ok(default) } else { bound.extract() }
    };
    let (first, last) = (end("start", left)?, end("stop", right)?);
    let (high, low) = (place(first)?, place(last)?);
    if high < low || !slice.getattr("step")?.is_none() {
        return Err(PyIndexError::new_err(format!(
            "[{first}:{last}]: write the left bit first, as in Verilog: the bits are [{left}:{right}]"
        )));
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
