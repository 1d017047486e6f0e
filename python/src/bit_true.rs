//! The bit-true model on numpy arrays.

use std::sync::{Mutex, PoisonError};

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::{RECORD_WORDS, TWO_PAIR_WORDS};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::value_error;

/// The bit-true model of a design point; reuses its memory from frame to frame.
#[pyclass(frozen, module = "hoverlock_models._native")]
pub struct BitTrue {
    design_point: DesignPoint,
    model: Mutex<SimdBitTrue>,
}

/// Returns the frame as a plane of samples that the design's camera can send.
fn plane_of(frame: &PyReadonlyArray2<'_, u16>, design: &DesignPoint) -> PyResult<Plane<u16>> {
    let (height, width) = (frame.shape()[0], frame.shape()[1]);
    if height == 0 || width == 0 {
        return Err(PyValueError::new_err(format!("a frame of {width} x {height} pixels")));
    }
    let (bits, largest) = (design.pixel.bits(), design.pixel.max_raw());
    let samples: Vec<u16> = frame.as_array().iter().copied().collect();
    if let Some(at) = samples.iter().position(|sample| i64::from(*sample) > largest) {
        let (x, y, sample) = (at % width, at / width, samples[at]);
        return Err(PyValueError::new_err(format!(
            "the pixel at ({x}, {y}) is {sample}: those of this design have {bits} bits, 0 to {largest}; a 16-bit \
             sample v is v >> {}",
            16 - bits
        )));
    }
    Plane::from_vec(width, height, samples).map_err(value_error)
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
    /// Builds the model of the default design point, with the values of a TOML text in place of its own.
    #[new]
    #[pyo3(signature = (toml = None))]
    fn new(toml: Option<&str>) -> PyResult<BitTrue> {
        let design_point = match toml {
            None => DesignPoint::default(),
            Some(text) => DesignPoint::default().with_toml(text).map_err(value_error)?,
        };
        let model = Mutex::new(SimdBitTrue::new(&design_point).map_err(value_error)?);
        Ok(BitTrue { design_point, model })
    }

    /// Returns the whole design point as TOML text.
    #[getter]
    fn design_point(&self) -> String {
        self.design_point.to_toml()
    }

    /// Returns the thresholds before the first frame, one for each scale pair, in LSB of the DoG.
    #[getter]
    fn initial_thresholds(&self) -> Vec<u32> {
        vec![self.design_point.threshold.initial; self.design_point.pairs()]
    }

    /// Returns the features of a frame as packed records: `uint32` of shape `(features, 8)`, or `(features, 10)` for
    /// designs with three scale pairs. Thresholds in LSB of the DoG.
    fn features<'py>(
        &self,
        py: Python<'py>,
        frame: PyReadonlyArray2<'py, u16>,
        thresholds: Vec<u32>,
    ) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let pixels = plane_of(&frame, &self.design_point)?;
        let (pairs, given) = (self.design_point.pairs(), thresholds.len());
        if given != pairs {
            return Err(PyValueError::new_err(format!("{given} thresholds for a design of {pairs} scale pairs")));
        }
        let mut model = self.model.lock().unwrap_or_else(PoisonError::into_inner);
        let each = if self.design_point.pairs() > 2 { RECORD_WORDS } else { TWO_PAIR_WORDS };
        let records = model.frame(&pixels, &thresholds).iter();
        let words: Vec<u32> = records.flat_map(|record| record.pack().into_iter().take(each)).collect();
        let count = words.len() / each;
        PyArray1::from_vec(py, words).reshape([count, each])
    }

    /// Returns all planes of a frame by name: see `hoverlock_models.Planes`.
    fn planes<'py>(&self, py: Python<'py>, frame: PyReadonlyArray2<'py, u16>) -> PyResult<Bound<'py, PyDict>> {
        let pixels = plane_of(&frame, &self.design_point)?;
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

/// Returns the value of the register `emission` of the committed Verilog.
#[pyfunction]
pub fn emission_value() -> u32 {
    hoverlock_registers::kt27::EMISSION_VALUE
}
