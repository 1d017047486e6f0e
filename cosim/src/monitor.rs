//! The caller's view of a run while it is in progress.

use std::any::Any;
use std::error::Error;

use hoverlock_arm::message::{InertialSample, Telemetry};
use hoverlock_reference::image::plane::Plane;

use crate::hover::Row;

/// Any error of the caller.
pub type BoxError = Box<dyn Error + Send + Sync>;

/// Receives the progress of a run and can stop it. Every method has a default that does nothing, and `()` is a monitor
/// that ignores everything.
pub trait Monitor: Sync {
    /// Receives a remark about the input, such as a picture that is cropped: one sentence without a full stop.
    fn remark(&self, _text: &str) {}

    /// Receives the start of a step that can take minutes, such as building the Verilated model. The returned value is
    /// dropped at its end.
    fn long_step(&self, _name: &'static str) -> Option<Box<dyn Any>> {
        None
    }

    /// Receives each frame after it has passed through the flight program.
    ///
    /// # Errors
    /// An error stops the run, which returns it in the variant `Stopped` of its error.
    fn frame(&self, _frame: &FrameProgress<'_>) -> Result<(), BoxError> {
        Ok(())
    }
}

impl Monitor for () {}

/// A frame that has passed through extractor and flight program.
#[derive(Debug, Clone, Copy)]
pub struct FrameProgress<'a> {
    /// Number of the frame, from 0.
    pub number: usize,
    /// Number of frames of the run.
    pub frames: usize,
    /// The frame as the camera took it.
    pub picture: &'a Plane<u16>,
    /// The telemetry of the frame.
    pub telemetry: &'a Telemetry,
    /// Samples of the inertial sensor since the frame before.
    pub inertial: &'a [InertialSample],
    /// Quality of the estimate, 0 to 255; `None` without an estimate.
    pub quality: Option<u8>,
    /// True distance from the target, m; `None` if the truth is unknown.
    pub distance_m: Option<f64>,
    /// The row of the frame in the table of a hover; `None` outside a hover.
    pub row: Option<&'a Row>,
}
