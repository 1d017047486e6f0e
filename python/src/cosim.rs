//! Hovers and co-simulations as functions. The interpreter's lock is released while they run; Ctrl-C ends them after
//! the current frame.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use hoverlock_cosim::campaign::{CampaignError, fly_row};
use hoverlock_cosim::hover::{CameraView, HoverError};
use hoverlock_cosim::{
    BoxError, CosimError, CosimSettings, FeatureSource, FlightProgram, FrameProgress, HoverSettings, Monitor,
};
use hoverlock_design::DesignPoint;
use hoverlock_edss::flight::Altitude;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::value_error;

/// A monitor that checks for signals such as Ctrl-C after each frame, and keeps the remarks about the input.
#[derive(Default)]
struct Supervisor {
    remarks: Mutex<Vec<String>>,
}

impl Monitor for Supervisor {
    fn remark(&self, text: &str) {
        self.remarks.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
    }

    fn frame(&self, _frame: &FrameProgress<'_>) -> Result<(), BoxError> {
        Ok(Python::attach(|py| py.check_signals())?)
    }
}

/// Returns the exception that stopped a run, such as `KeyboardInterrupt`.
fn stopped(cause: BoxError) -> PyErr {
    cause.downcast::<PyErr>().map_or_else(runtime_error, |error| *error)
}

fn runtime_error(error: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

fn hover_error(error: HoverError) -> PyErr {
    match error {
        HoverError::Stopped(cause) => stopped(cause),
        HoverError::Chain(_) | HoverError::CameraWord(_) => runtime_error(error),
        _ => value_error(error),
    }
}

/// Returns the choice that `text` names.
fn choice<T: Copy>(setting: &str, text: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice).ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        PyValueError::new_err(format!("{setting} is '{text}', and must be one of {}", names.join(", ")))
    })
}

fn feature_source(text: &str) -> PyResult<FeatureSource> {
    let choices = [("float", FeatureSource::Float), ("fixed", FeatureSource::Fixed), ("rtl", FeatureSource::Rtl)];
    choice("features", text, &choices)
}

fn place_of_flight_program(text: &str) -> PyResult<FlightProgram> {
    choice("flight_program", text, &[("host", FlightProgram::Host), ("arm", FlightProgram::Arm)])
}

/// The outcome of a hover: see `hoverlock_models.cosim.HoverResult`.
#[pyclass(frozen, module = "hoverlock_models._native")]
pub struct HoverOutcome(hoverlock_cosim::HoverOutcome);

#[pymethods]
impl HoverOutcome {
    /// Returns the summary as a JSON object.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&self.0).map_err(runtime_error)
    }

    /// Returns the checks in words.
    fn checks(&self) -> Vec<String> {
        self.0.checks.clone()
    }

    /// Returns the table of all frames as CSV.
    fn table(&self) -> PyResult<String> {
        self.0.table().map_err(runtime_error)
    }

    /// Renders the hover as an HTML page, with `command` as its origin.
    fn page(&self, py: Python<'_>, command: &str) -> PyResult<String> {
        py.detach(|| self.0.page(command)).map_err(runtime_error)
    }
}

/// Flies a hover: see `hoverlock_models.cosim.hover`.
///
/// # Errors
/// `ValueError` for an invalid setting, `RuntimeError` if a tool is missing or extractor or flight program fail.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn fly_hover(
    py: Python<'_>,
    scene: String,
    design: &str,
    features: &str,
    flight_program: &str,
    seconds: f64,
    seed: u64,
    height_m: f64,
    gusts_m_s: f64,
    altitude: &str,
    view: &str,
    renew_after_s: Option<f64>,
) -> PyResult<HoverOutcome> {
    let altitudes = [("hold", Altitude::Hold), ("smooth", Altitude::Smooth), ("abrupt", Altitude::Abrupt)];
    let settings = HoverSettings {
        scene,
        design: DesignPoint::load_or_change(design).map_err(value_error)?,
        features: feature_source(features)?,
        flight_program: place_of_flight_program(flight_program)?,
        seconds,
        seed,
        height_m,
        gusts_m_s,
        altitude: choice("altitude", altitude, &altitudes)?,
        view: choice("view", view, &[("wide", CameraView::Wide), ("narrow", CameraView::Narrow)])?,
        renew_after_s,
        ..HoverSettings::default()
    };
    let supervisor = Supervisor::default();
    py.detach(|| hoverlock_cosim::hover(&settings, &supervisor)).map(HoverOutcome).map_err(hover_error)
}

/// The outcome of a co-simulation: see `hoverlock_models.cosim.ReplayResult`.
#[pyclass(frozen, module = "hoverlock_models._native")]
pub struct ReplayOutcome {
    outcome: hoverlock_cosim::CosimOutcome,
    remarks: Vec<String>,
}

#[pymethods]
impl ReplayOutcome {
    /// Returns the summary as a JSON object.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&self.outcome).map_err(runtime_error)
    }

    /// Returns the remarks about the input, such as a picture that was cropped.
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// Renders the run as an HTML page, with `command` as its origin.
    fn page(&self, py: Python<'_>, command: &str) -> PyResult<String> {
        py.detach(|| self.outcome.page(command)).map_err(runtime_error)
    }
}

/// Passes a folder of frames through extractor and flight program: see `hoverlock_models.cosim.replay`.
///
/// # Errors
/// `ValueError` for an invalid setting or folder, `RuntimeError` if a tool is missing or extractor or flight program
/// fail.
#[pyfunction]
pub fn replay_sequence(
    py: Python<'_>,
    sequence: PathBuf,
    design: &str,
    features: &str,
    flight_program: &str,
) -> PyResult<ReplayOutcome> {
    let settings = CosimSettings {
        design: DesignPoint::load_or_change(design).map_err(value_error)?,
        features: feature_source(features)?,
        flight_program: place_of_flight_program(flight_program)?,
        ..CosimSettings::new(sequence)
    };
    let supervisor = Supervisor::default();
    let outcome = py.detach(|| hoverlock_cosim::cosim(&settings, &supervisor)).map_err(|error| match error {
        CosimError::Stopped(cause) => stopped(cause),
        CosimError::Sequence(_) => value_error(error),
        _ => runtime_error(error),
    })?;
    Ok(ReplayOutcome { outcome, remarks: supervisor.remarks.into_inner().unwrap_or_else(PoisonError::into_inner) })
}

/// Flies one point of a campaign. Takes its row of CSV and returns the row of its result, both without a header: see
/// `hoverlock_models.cosim.fly_point`.
///
/// # Errors
/// `ValueError` if the row, its scene or its design is invalid, otherwise `RuntimeError`.
#[pyfunction]
pub fn fly_point(py: Python<'_>, row: &str) -> PyResult<String> {
    py.detach(|| fly_row(row, &Supervisor::default())).map_err(|error| match error {
        CampaignError::Hover(error) => hover_error(error),
        CampaignError::Row(_)
        | CampaignError::EmptyRow
        | CampaignError::Scene(_)
        | CampaignError::Design(_)
        | CampaignError::OtherInputs { .. } => value_error(error),
        _ => runtime_error(error),
    })
}
