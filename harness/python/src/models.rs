//! The bit-true model and the coefficient generator on numpy arrays.

use std::sync::{Mutex, PoisonError};

use hoverlock_fixed_point::model::bit_true::{RECORD_WORDS, TWO_PAIR_WORDS};
use hoverlock_fixed_point::model::coefficients::{LerpCoefficients, look_ahead_for};
use hoverlock_fixed_point::model::design::DesignPoint;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_reference::image::plane::Plane;
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The constants of the committed Verilog, as the program on the ARM gets them.
#[allow(dead_code, reason = "the constants of all registers")]
#[path = "../../../rtl/registers/hoverlock_registers.rs"]
mod registers;

fn bad(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The bit-true model of a design point; reuses its memory from frame to frame.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct BitTrue {
    design_point: DesignPoint,
    model: Mutex<SimdBitTrue>,
}

fn plane_of(frame: &PyReadonlyArray2<'_, u16>) -> PyResult<Plane<u16>> {
    let (height, width) = (frame.shape()[0], frame.shape()[1]);
    if height == 0 || width == 0 {
        return Err(PyValueError::new_err(format!("a frame of {width} x {height} pixels")));
    }
    let samples = frame.as_array().iter().copied().collect();
    Plane::from_vec(width, height, samples).map_err(bad)
}

fn array_of<'py, T: Element + Copy, U: Copy>(
    py: Python<'py>,
    plane: &Plane<U>,
    convert: impl Fn(U) -> T,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let samples: Vec<T> = plane.as_slice().iter().map(|&v| convert(v)).collect();
    PyArray1::from_vec(py, samples).reshape([plane.height(), plane.width()])
}

#[pymethods]
impl BitTrue {
    /// The default design point, changed by what a TOML text says.
    #[new]
    #[pyo3(signature = (toml = None))]
    fn new(toml: Option<&str>) -> PyResult<BitTrue> {
        let design_point = match toml {
            None => DesignPoint::default(),
            Some(text) => DesignPoint::default().with_toml(text).map_err(bad)?,
        };
        let model = Mutex::new(SimdBitTrue::new(&design_point).map_err(bad)?);
        Ok(BitTrue { design_point, model })
    }

    /// The design point as TOML.
    #[getter]
    fn design_point(&self) -> String {
        self.design_point.to_toml()
    }

    /// The thresholds before the first frame, in LSB of the DoG.
    #[getter]
    fn initial_thresholds(&self) -> Vec<u32> {
        vec![self.design_point.threshold.initial; self.design_point.pairs()]
    }

    /// The features of a frame as packed records: `uint32` of shape `(features, 8)`, or `(features, 10)` with three
    /// scale pairs. Thresholds in LSB of the DoG.
    fn features<'py>(
        &self,
        py: Python<'py>,
        frame: PyReadonlyArray2<'py, u16>,
        thresholds: Vec<u32>,
    ) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let pixels = plane_of(&frame)?;
        let mut model = self.model.lock().unwrap_or_else(PoisonError::into_inner);
        let each = if self.design_point.pairs() > 2 { RECORD_WORDS } else { TWO_PAIR_WORDS };
        let records = model.frame(&pixels, &thresholds).iter();
        let words: Vec<u32> = records.flat_map(|record| record.pack().into_iter().take(each)).collect();
        let count = words.len() / each;
        PyArray1::from_vec(py, words).reshape([count, each])
    }

    /// All planes of a frame, by name: see `hoverlock.models.Planes`.
    fn planes<'py>(&self, py: Python<'py>, frame: PyReadonlyArray2<'py, u16>) -> PyResult<Bound<'py, PyDict>> {
        let pixels = plane_of(&frame)?;
        let mut model = self.model.lock().unwrap_or_else(PoisonError::into_inner);
        model.frame(&pixels, &[]);
        let planes = model.planes();
        let out = PyDict::new(py);
        for (smoother, plane) in planes.smoothed.iter().enumerate() {
            out.set_item(format!("smoothed{smoother}"), array_of(py, plane, |v| v)?)?;
        }
        for (k, layer) in planes.layers.iter().enumerate() {
            out.set_item(format!("signed_dog{k}"), array_of(py, &planes.signed_dog[k], |v| v)?)?;
            out.set_item(format!("dog{k}"), array_of(py, &layer.dog.magnitude, |v| v)?)?;
            out.set_item(format!("positive{k}"), array_of(py, &layer.dog.positive, |v| v)?)?;
            out.set_item(format!("max_dog{k}"), array_of(py, &layer.max_dog, |v| v)?)?;
        }
        Ok(out)
    }
}

/// The coefficients of a smoother: `(a, g, [g_j], saturated stages)`.
#[pyfunction]
pub fn lerp_coefficients(sigma: f64, look_ahead: u32, frac_bits: u32) -> PyResult<(f64, u32, Vec<u32>, Vec<u32>)> {
    let c = LerpCoefficients::design(sigma, look_ahead, frac_bits).map_err(bad)?;
    Ok((c.a, c.g, c.g_j, c.saturated))
}

/// The shortest look-ahead whose stages leave out no more than `error` of the sum.
#[pyfunction]
pub fn look_ahead_of(a: f64, error: f64) -> PyResult<u32> {
    look_ahead_for(a, error).map_err(bad)
}

/// What the register `emission` of the committed Verilog reads.
#[pyfunction]
pub fn emission_value() -> u32 {
    registers::EMISSION_VALUE
}
