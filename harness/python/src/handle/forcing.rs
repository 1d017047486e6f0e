//! Force, freeze and release: special values that a bench assigns to a signal.

use hoverlock_harness::sim::Forcing;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyInt, PyString};

use super::number::{number_of, words_of_int};
use crate::errors::{self, RangeError};

/// The operation that an assignment such as `dut.enable.value = Force(1)` requests.
pub(super) enum Change<'py> {
    Force(Bound<'py, PyAny>),
    Freeze,
    Release,
}

impl<'py> Change<'py> {
    /// Returns the operation that a value requests, or `None` for a plain value.
    pub fn of(value: &Bound<'py, PyAny>) -> PyResult<Option<Change<'py>>> {
        let py = value.py();
        let Ok(kind) = value.getattr(intern!(py, "_change")) else { return Ok(None) };
        Ok(match kind.cast::<PyString>()?.to_str()? {
            "force" => Some(Change::Force(value.getattr(intern!(py, "value"))?)),
            "freeze" => Some(Change::Freeze),
            "release" => Some(Change::Release),
            _ => None,
        })
    }

    /// Applies the operation to `width` bits, of which `low` is the lowest.
    pub fn make(&self, forcing: &Forcing, name: &str, low: u32, width: u32) -> PyResult<()> {
        let bits = shifted(&ones(width), low);
        match self {
            Change::Force(value) => {
                let whole = number_of(value, name)?;
                let words = words_of_int(whole.cast::<PyInt>()?, width)?;
                let words = words
                    .ok_or_else(|| RangeError::new_err(format!("{whole} does not fit {width} bits of '{name}'")))?;
                forcing.force(&shifted(&words, low), &bits)
            }
            Change::Freeze => forcing.freeze(&bits),
            Change::Release => forcing.release(&bits),
        }
        .map_err(|e| errors::of_model(&e))
    }
}

/// Returns `width` bits that are 1, as 32-bit words, lowest first.
fn ones(width: u32) -> Vec<u32> {
    (0..width.div_ceil(32)).map(|at| u32::MAX >> (32 - (width - 32 * at).min(32))).collect()
}

/// Shifts 32-bit words, lowest first, up by `by` bits; leaves out the words above the highest 1.
fn shifted(words: &[u32], by: u32) -> Vec<u32> {
    let mut moved = vec![0u32; words.len() + by as usize / 32 + 1];
    for (at, word) in words.iter().enumerate() {
        let wide = u64::from(*word) << (by % 32);
        moved[at + by as usize / 32] |= wide as u32;
        moved[at + by as usize / 32 + 1] |= (wide >> 32) as u32;
    }
    while moved.last() == Some(&0) {
        moved.pop();
    }
    moved
}
