//! The co-simulation of a folder of frames: each frame passes through extractor and flight program in order.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_pictures::Limits;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use hoverlock_reports::page::PageError;
use nalgebra::Vector2;
use serde::{Serialize, Serializer};
use serde_json::value::RawValue;

use crate::chain::{Chain, ChainError, Delivery, FeatureSource, FlightLine, FlightProgram, check_choice};
use crate::monitor::{BoxError, FrameProgress, Monitor};
use crate::pages::flight::{self, Flight};
use crate::sequence::{self, ASSUMED_TELEMETRY, PseudoTruth, Sequence, SequenceError, TELEMETRY};

/// The inputs of a co-simulation.
#[derive(Debug, Clone)]
pub struct CosimSettings {
    /// The folder of frames; see [`sequence::read`].
    pub sequence: PathBuf,
    /// The design of the extractor.
    pub design: DesignPoint,
    /// The source of the features.
    pub features: FeatureSource,
    /// The place where the flight program runs.
    pub flight_program: FlightProgram,
    /// Limits on the size of a picture.
    pub limits: Limits,
}

impl CosimSettings {
    /// Returns settings with the design `kt27`, the bit-true model and the flight program in this process.
    pub fn new(sequence: impl Into<PathBuf>) -> Self {
        Self {
            sequence: sequence.into(),
            design: KT27.clone(),
            features: FeatureSource::default(),
            flight_program: FlightProgram::default(),
            limits: Limits::default(),
        }
    }
}

/// Why a co-simulation was not completed.
#[derive(Debug, thiserror::Error)]
pub enum CosimError {
    /// The folder of frames was refused.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// Extractor or flight program could not be started or has failed.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// A line of the flight program is not JSON.
    #[error("the flight program wrote a line that is not JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The monitor has stopped the run.
    #[error(transparent)]
    Stopped(BoxError),
}

/// The result of a co-simulation. Serialised, it is the JSON object of `hoverlock cosim`.
#[derive(Serialize)]
pub struct CosimOutcome {
    /// A frame has an estimate, and the lines of ARM binary and host are the same.
    pub ok: bool,
    /// The folder of frames.
    #[serde(serialize_with = "lossy")]
    pub sequence: PathBuf,
    /// The source of the features.
    pub features: FeatureSource,
    /// The place where the flight program ran.
    #[serde(rename = "estimator")]
    pub flight_program: FlightProgram,
    /// The origin of the telemetry.
    pub telemetry: &'static str,
    /// The lines of the flight program, one per frame, byte for byte.
    pub estimates: Vec<Box<RawValue>>,
    /// The position of each frame by the homographies of the folder, relative to the reference.
    pub pseudo_truth: Vec<Option<Position>>,
    /// Errors of the estimates against `pseudo_truth`; `None` if no frame has both.
    pub against_truth: Option<Accuracy>,
    /// Number of clock cycles simulated; `None` without simulated hardware.
    pub cycles: Option<u64>,
    /// Duration of the run, s.
    pub seconds: f64,
    /// Which frames floating point solves; `None` if the features are those of floating point.
    pub float: Option<FloatReference>,
    /// Why `ok` is false.
    pub reason: Option<String>,
    /// The frames in order.
    #[serde(skip)]
    pub frames: Vec<CosimFrame>,
}

/// A position by the homographies of the folder.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Position {
    /// Along `X_e`, m.
    pub x_e_m: f64,
    /// Along `Y_e`, m.
    pub y_e_m: f64,
    /// The homographies of the frames between were multiplied.
    pub chained: bool,
}

/// Errors of the estimates against the homographies of the folder.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Accuracy {
    /// Number of frames that have both.
    pub frames: usize,
    /// Root mean square of the errors, m.
    pub rms_m: f64,
    /// Largest error, m.
    pub max_m: f64,
}

/// The same frames with features in floating point: what is lost to word lengths or hardware, and what to the frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FloatReference {
    /// Number of frames with an estimate in floating point.
    pub solved: usize,
    /// Number of those that have an estimate in this run too.
    pub estimated: usize,
}

/// A frame of a co-simulation.
pub struct CosimFrame {
    /// File name of the frame.
    pub name: String,
    /// The pixels, DN, if the page shows them.
    pub picture: Option<Plane<u16>>,
    /// The line of the flight program.
    pub line: FlightLine,
    /// The position by the homographies of the folder, relative to the reference.
    pub truth: Option<PseudoTruth>,
    /// The inliers of the estimate.
    pub inliers: Vec<Pair>,
}

impl CosimFrame {
    /// Returns estimate less position by the homographies, along `X_e` and `Y_e`, m.
    pub fn error(&self) -> Option<Vector2<f64>> {
        Some(self.line.displacement()? - self.truth?.displacement)
    }
}

/// Passes a folder of frames through extractor and flight program.
///
/// # Errors
/// The folder is refused, a tool is missing, extractor or flight program fail, or the monitor stops the run. A run in
/// which no frame has an estimate is not an error: its outcome has `ok` false and a reason.
pub fn cosim(settings: &CosimSettings, monitor: &dyn Monitor) -> Result<CosimOutcome, CosimError> {
    // A missing or unsuitable ARM binary is reported before the pictures are read.
    check_choice(settings.features, &settings.design, settings.flight_program)?;
    let largest = (settings.design.width as usize, settings.design.height as usize);
    let Sequence { frames, telemetry, inertial, calibration, is_telemetry_assumed, pseudo_truths } =
        sequence::read(&settings.sequence, &settings.limits, largest, monitor)?;
    let step = monitor.long_step("frames through extractor and flight program");
    let started = Instant::now();
    let first = frames[0].decode()?;
    let start =
        |features, program| Chain::start(features, &settings.design, program, &first, calibration.as_ref(), monitor);
    let mut chain = start(settings.features, settings.flight_program)?;
    let mut float = match settings.features {
        FeatureSource::Float => None,
        _ => Some(start(FeatureSource::Float, FlightProgram::Host)?),
    };
    let mut reference = FloatReference { solved: 0, estimated: 0 };
    let (mut outputs, mut estimates) = (Vec::new(), Vec::new());
    let total = frames.len();
    let mut inertial = &inertial[..];
    let mut origin: Option<PseudoTruth> = None;
    for (number, ((file, telemetry), truth)) in frames.iter().zip(&telemetry).zip(pseudo_truths).enumerate() {
        let picture = file.decode()?;
        let due = inertial.partition_point(|sample| sample.time_us <= telemetry.time_us);
        let (samples, later) = inertial.split_at(due);
        inertial = later;
        chain.inertial(samples)?;
        let output = chain.process(telemetry, &picture, Delivery::Once)?;
        if let Some(float) = &mut float {
            float.inertial(samples)?;
            let is_solved = float.process(telemetry, &picture, Delivery::Once)?.line.x_e_m.is_some();
            reference.solved += usize::from(is_solved);
            reference.estimated += usize::from(is_solved && output.line.x_e_m.is_some());
        }
        estimates.push(RawValue::from_string(output.text)?);
        let quality = output.line.quality;
        let progress = FrameProgress {
            number,
            frames: total,
            picture: &picture,
            telemetry,
            inertial: samples,
            quality,
            distance_m: None,
            row: None,
        };
        monitor.frame(&progress).map_err(CosimError::Stopped)?;
        if output.line.is_reference() {
            origin = truth;
        }
        let truth = truth.zip(origin).map(|(truth, origin)| truth.relative_to(&origin));
        let picture = flight::shows(number, total).then_some(picture);
        outputs.push(CosimFrame { name: file.name(), picture, line: output.line, truth, inliers: output.inliers });
    }
    drop(step);
    let reference = float.map(|_| reference);
    let reason = failure(&chain, &outputs, reference);
    let position = |truth: PseudoTruth| Position {
        x_e_m: truth.displacement.x,
        y_e_m: truth.displacement.y,
        chained: truth.is_chained,
    };
    Ok(CosimOutcome {
        ok: reason.is_none(),
        sequence: settings.sequence.clone(),
        features: settings.features,
        flight_program: settings.flight_program,
        telemetry: if is_telemetry_assumed { ASSUMED_TELEMETRY } else { TELEMETRY },
        estimates,
        pseudo_truth: outputs.iter().map(|frame| frame.truth.map(position)).collect(),
        against_truth: accuracy(&outputs),
        cycles: chain.cycles(),
        seconds: started.elapsed().as_secs_f64(),
        float: reference,
        reason,
        frames: outputs,
    })
}

/// Returns the reason why a run does not pass.
fn failure(chain: &Chain, frames: &[CosimFrame], float: Option<FloatReference>) -> Option<String> {
    if let Some(frame) = chain.first_difference() {
        return Some(format!("frame {frame}: the ARM binary's line is not the host's; is `make arm` up to date?"));
    }
    if frames.iter().all(|frame| frame.line.x_e_m.is_none()) {
        let first = frames.iter().find_map(|frame| frame.line.reason.clone()).unwrap_or_default();
        let judged = match float {
            Some(FloatReference { solved: 0, .. }) => "; nor in floating point, so these frames judge no design".into(),
            Some(FloatReference { solved, .. }) => format!("; {solved} have one in floating point"),
            None => String::new(),
        };
        return Some(format!("no frame has an estimate: {first}{judged}"));
    }
    None
}

/// Compares the frames that have an estimate and a homography.
fn accuracy(frames: &[CosimFrame]) -> Option<Accuracy> {
    let errors: Vec<f64> = frames.iter().filter_map(CosimFrame::error).map(|error| error.norm()).collect();
    (!errors.is_empty()).then(|| Accuracy {
        frames: errors.len(),
        rms_m: (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt(),
        max_m: errors.iter().copied().fold(0.0, f64::max),
    })
}

impl CosimOutcome {
    /// Returns what the run has shown: how many frames have an estimate, and how many of those that floating point
    /// solves.
    pub fn coverage(&self) -> String {
        let estimates = self.frames.iter().filter(|frame| frame.line.x_e_m.is_some()).count();
        let of_float = self.float.map(|FloatReference { solved, estimated }| {
            format!("; {estimated} of the {solved} that floating point solves")
        });
        format!("{estimates} estimates in {} frames{}", self.frames.len(), of_float.unwrap_or_default())
    }

    /// Renders the run as one HTML page. `command` is shown as its origin.
    ///
    /// # Errors
    /// A plot or the template fails. Either is a defect of this program, not of the input.
    pub fn page(&self, command: &str) -> Result<String, PageError> {
        let frames = self.frames.iter().map(|frame| flight::Frame {
            name: frame.name.clone(),
            status: frame.line.status.clone(),
            reason: frame.line.reason.clone(),
            features: frame.line.features,
            estimate: frame.line.estimate(),
            truth: frame.truth.map(|truth| truth.displacement.into()),
            chained: frame.truth.is_some_and(|truth| truth.is_chained),
            picture: frame.picture.as_ref(),
            inliers: frame.inliers.clone(),
        });
        let folder = self.sequence.canonicalize().unwrap_or_else(|_| self.sequence.clone());
        flight::html(&Flight {
            name: folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned(),
            command: command.to_owned(),
            features: self.features.description(),
            estimator: self.flight_program.description(),
            telemetry: self.telemetry.into(),
            failure: self.reason.clone(),
            coverage: self.coverage(),
            cycles: self.cycles,
            frames: frames.collect(),
        })
    }
}

/// Writes a path as a string. Bytes that are not UTF-8 are replaced, because JSON cannot represent them.
fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}
