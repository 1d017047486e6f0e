//! Errors of extractor and flight program.

use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

use hoverlock_arm::arinc429::WordError;
use hoverlock_arm::framing::PayloadError;
use hoverlock_arm::hardware::HardwareError;
use hoverlock_arm::message::MessageError;
use hoverlock_arm::setup::SetupError;
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_fixed_point::model::simd::SimdError;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_rtl::emission::EmitError;
use hoverlock_simulation::SimulationError;

use super::flight_program::NAV_VARIABLE;

/// Why the chain of extractor and flight program cannot be started or has failed.
#[derive(Debug, thiserror::Error)]
pub enum ChainError {
    /// The float extractor does not exist for this number of sigmas.
    #[error("a chain of {0} sigmas; the float extractor takes 2 to 4")]
    ChainLength(usize),
    /// A frame is larger than the design allows.
    #[error(
        "frames of {width} x {height} px: the design takes {max_width} x {max_height} at most; choose one \
         with `width = {width}` and `height = {height}`"
    )]
    FrameSize {
        /// Columns of the frame.
        width: usize,
        /// Rows of the frame.
        height: usize,
        /// Columns that the design allows.
        max_width: usize,
        /// Rows that the design allows.
        max_height: usize,
    },
    /// The flight program takes no such readings.
    #[error("telemetry of frame {frame}: {source}")]
    Telemetry {
        /// Number of the frame.
        frame: u32,
        /// What is wrong with them.
        source: MessageError,
    },
    /// A packet does not fit a message.
    #[error(transparent)]
    Payload(#[from] PayloadError),
    /// The ARM binary was asked to work with hardware other than that of `kt27`.
    #[error(
        "the ARM binary is built for the Verilog of kt27 and refuses any other hardware; choose the design kt27, or \
         the flight program of the host"
    )]
    ArmNeedsKt27,
    /// The environment names an ARM binary that does not exist.
    #[error(
        "{NAV_VARIABLE}={path}: no such file; `make arm` builds the ARM binary",
        path = .0.display()
    )]
    NamedBinaryMissing(PathBuf),
    /// There is no ARM binary where `make arm` puts it.
    #[error(
        "no ARM binary at {path}; build it with `make arm`, or name it in {NAV_VARIABLE}",
        path = .0.display()
    )]
    BinaryMissing(PathBuf),
    /// qemu-arm is not installed.
    #[error("qemu-arm is not installed; `make arm` installs it")]
    QemuMissing,
    /// The ARM binary could not be run, written or read.
    #[error("ARM binary: {step}: {source}")]
    Arm {
        /// The step that failed.
        step: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The ARM binary has ended.
    #[error("ARM binary: the flight program has failed ({status}): {message}")]
    ArmEnded {
        /// Exit status of qemu-arm.
        status: ExitStatus,
        /// The last line that the program wrote to stderr.
        message: String,
    },
    /// The flight program did not write exactly one line for a frame.
    #[error("the flight program wrote {0} lines for a frame")]
    LineCount(usize),
    /// The flight program wrote something other than a line of JSON with the expected keys.
    #[error("the flight program wrote no line: {line}: {source}")]
    Line {
        /// The text that was written.
        line: String,
        /// The error of the JSON parser.
        source: serde_json::Error,
    },
    /// The simulated hardware sent no packet for a frame.
    #[error("the hardware gives no packet for a frame")]
    NoPacket,
    /// The message stream could not be decoded.
    #[error("the stream of messages cannot be read: {0}")]
    Stream(#[from] io::Error),
    /// The design is not the hardware that the flight program expects, or a frame does not fit it.
    #[error(transparent)]
    Hardware(#[from] HardwareError),
    /// The simulated hardware could not be set up.
    #[error(transparent)]
    Setup(#[from] SetupError<SimulationError>),
    /// The simulation has failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The design has no valid coefficients.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// The bit-true model does not exist for the design.
    #[error(transparent)]
    Model(#[from] SimdError),
    /// A sigma is out of range.
    #[error(transparent)]
    Sigma(#[from] DesignError),
    /// The Verilog of the design could not be emitted.
    #[error(transparent)]
    Emission(#[from] EmitError),
    /// The word for the camera could not be encoded.
    #[error(transparent)]
    CameraWord(#[from] WordError),
}
