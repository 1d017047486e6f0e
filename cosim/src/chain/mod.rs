//! The chain from a frame to a line: extractor, message stream, flight program.

mod choice;
mod error;
mod extractor;
mod flight_program;
mod float;
mod line;

use hoverlock_arm::calibration::Calibration;
use hoverlock_arm::hardware::Fpga;
use hoverlock_arm::message::{
    self, Command, InertialSample, MAX_INERTIAL_SAMPLES, Telemetry, encode_inertial, encode_registers,
};
use hoverlock_arm::source::Source as MessageStream;
use hoverlock_design::{DesignPoint, KT27};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use hoverlock_rtl::emission::emission_of;
use hoverlock_rtl::registers::registers;

pub use choice::{FeatureSource, FlightProgram};
pub use error::ChainError;
use extractor::Extractor;
pub use flight_program::arm_binary;
use flight_program::{Arm, Host};
pub use float::{FloatFeatures, clear_float_features, float_features};
pub use line::FlightLine;

use crate::Monitor;

/// Extractor and flight program, connected by the message stream.
pub struct Chain {
    extractor: Extractor,
    stream: MessageStream,
    host: Host,
    arm: Option<Arm>,
    /// Number of frames so far.
    frames: usize,
    /// The first frame for which the lines of ARM binary and host differ.
    first_difference: Option<usize>,
}

/// How the messages of a frame reach the flight program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delivery {
    /// Each message arrives once.
    #[default]
    Once,
    /// Each message arrives twice.
    Twice,
}

/// The output of the flight program for a frame.
#[derive(Debug, Clone)]
pub struct FrameOutput {
    /// The line as it was written.
    pub text: String,
    /// The parsed line.
    pub line: FlightLine,
    /// The inliers of the estimate.
    pub inliers: Vec<Pair>,
}

/// Checks that design, feature source and flight program can work together, and that the program is installed.
///
/// # Errors
/// The ARM binary, which has the registers of `kt27` built in, is combined with other hardware, or does not exist.
pub fn check_choice(features: FeatureSource, design: &DesignPoint, program: FlightProgram) -> Result<(), ChainError> {
    if features == FeatureSource::Rtl && program == FlightProgram::Arm && design.of_hardware() != *KT27 {
        return Err(ChainError::ArmNeedsKt27);
    }
    program.check_installed()
}

/// Returns the FPGA that the flight program is to expect.
fn expected_fpga(features: FeatureSource, design: &DesignPoint) -> Result<Fpga, ChainError> {
    // Without hardware the stream begins with the registers that the program was built with.
    if features != FeatureSource::Rtl || design.of_hardware() == *KT27 {
        return Ok(Fpga { columns: design.width, ..Fpga::default() });
    }
    let map = registers(design)?;
    let coefficients = map.iter().filter(|register| register.is_coefficient());
    let reset = |name: &str| map.iter().find(|register| register.name == name).map_or(0, |found| found.fields[0].reset);
    Ok(Fpga {
        version: reset("version"),
        emission: emission_of(design)?,
        columns: design.width,
        pairs: design.scale_pairs,
        target: design.threshold.target,
        coefficients: coefficients.map(|register| (register.offset, register.fields[0].reset)).collect(),
    })
}

impl Chain {
    /// Starts extractor and flight program. The flight program captures the first frame as its reference. Without a
    /// calibration its camera is one that nobody has calibrated.
    ///
    /// # Errors
    /// A tool or a program is missing, the design cannot be built, or the frame does not fit it.
    pub fn start(
        features: FeatureSource,
        design: &DesignPoint,
        program: FlightProgram,
        first: &Plane<u16>,
        calibration: Option<&Calibration>,
        monitor: &dyn Monitor,
    ) -> Result<Self, ChainError> {
        let fpga = expected_fpga(features, design)?;
        let arm = (program == FlightProgram::Arm).then(Arm::start).transpose()?;
        let extractor = Extractor::new(features, design, &fpga, first, monitor)?;
        let mut stream = MessageStream::default();
        match extractor.registers() {
            Some(block) => stream.send(message::REGISTERS, &encode_registers(block))?,
            None => stream.send_registers(first.width(), first.height())?,
        }
        if let Some(calibration) = calibration {
            stream.send(message::CALIBRATION, &calibration.encode())?;
        }
        stream.send(message::COMMAND, &Command::Capture.encode())?;
        let mut chain = Self { extractor, stream, host: Host::new(fpga), arm, frames: 0, first_difference: None };
        chain.send(Delivery::Once)?;
        Ok(chain)
    }

    /// Sends a command to the flight program. Returns the ARINC 429 word for the camera if the command causes one.
    ///
    /// # Errors
    /// The flight program has failed.
    pub fn command(&mut self, command: Command) -> Result<Option<u32>, ChainError> {
        self.stream.send(message::COMMAND, &command.encode())?;
        self.send(Delivery::Once)?;
        self.host.camera_word()
    }

    /// Sends the samples of the inertial sensor since the frame before.
    ///
    /// # Errors
    /// The flight program has failed.
    pub fn inertial(&mut self, samples: &[InertialSample]) -> Result<(), ChainError> {
        for part in samples.chunks(MAX_INERTIAL_SAMPLES) {
            self.stream.send(message::INERTIAL, &encode_inertial(part))?;
            self.send(Delivery::Once)?;
        }
        Ok(())
    }

    /// Processes a frame with its telemetry. With the ARM binary the output is its line; the host's line is compared
    /// with it.
    ///
    /// # Errors
    /// The hardware or the flight program has failed.
    pub fn process(
        &mut self,
        telemetry: &Telemetry,
        frame: &Plane<u16>,
        delivery: Delivery,
    ) -> Result<FrameOutput, ChainError> {
        let readings = telemetry.encode();
        // The flight program would be silent about them.
        Telemetry::parse(&readings).map_err(|source| ChainError::Telemetry { frame: telemetry.frame, source })?;
        self.stream.send(message::TELEMETRY, &readings)?;
        let packet = self.extractor.packet(frame)?;
        self.stream.send_pixels(telemetry.frame, frame)?;
        self.stream.send(message::FRAME, &packet)?;
        let lines = self.send(delivery)?;
        let [host] = &lines[..] else { return Err(ChainError::LineCount(lines.len())) };
        let text = match &mut self.arm {
            Some(arm) => arm.next_line()?,
            None => host.clone(),
        };
        if text != *host {
            self.first_difference.get_or_insert(self.frames);
        }
        self.frames += 1;
        match serde_json::from_str(&text) {
            Ok(line) => Ok(FrameOutput { text, line, inliers: self.host.inliers().to_vec() }),
            Err(source) => Err(ChainError::Line { line: text, source }),
        }
    }

    /// Extracts a frame whose messages get lost on the way to the flight program.
    ///
    /// # Errors
    /// The hardware has failed.
    pub fn lose(&mut self, frame: &Plane<u16>) -> Result<(), ChainError> {
        self.extractor.packet(frame).map(|_| ())
    }

    /// Returns the first frame for which the lines of ARM binary and host differ.
    pub fn first_difference(&self) -> Option<usize> {
        self.first_difference
    }

    /// Returns the number of clock cycles simulated so far; `None` without simulated hardware.
    pub fn cycles(&self) -> Option<u64> {
        self.extractor.cycles()
    }

    /// Sends the pending messages and returns the lines of the host.
    fn send(&mut self, delivery: Delivery) -> Result<Vec<String>, ChainError> {
        let mut lines = Vec::new();
        let times = if delivery == Delivery::Twice { 2 } else { 1 };
        for message in self.stream.messages.drain(..) {
            for _ in 0..times {
                lines.extend(self.host.process(&message)?);
                if let Some(arm) = &mut self.arm {
                    arm.send(&message)?;
                }
            }
        }
        Ok(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_take_frames_as_wide_as_their_design() {
        for (name, columns) in [("kt27", 1024), ("hd1080", 1920)] {
            let design = DesignPoint::shipped(name).unwrap();
            for features in [FeatureSource::Float, FeatureSource::Fixed] {
                assert_eq!(expected_fpga(features, &design).unwrap(), Fpga { columns, ..Fpga::default() });
            }
        }
    }
}
