//! From a frame to a line: extractor, message stream, flight program.

mod estimator;
mod extractor;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use clap::builder::PossibleValue;
use hoverlock_arm::hardware::Fpga;
use hoverlock_arm::message::{self, Command, Telemetry, encode_registers};
use hoverlock_arm::source::Source as Stream;
use hoverlock_design::{DesignPoint, KT27};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use hoverlock_reports::estimates::Estimate;
use hoverlock_rtl::emission::emission_of;
use hoverlock_rtl::registers::{COEFFICIENTS_AT, registers};
use nalgebra::Vector2;
use serde::{Deserialize, Serializer};

pub use estimator::Program;
use estimator::{Arm, Host};
use extractor::Extractor;
pub use extractor::Source;

/// Extractor and flight program, joined by the stream of messages.
pub struct Chain {
    extractor: Extractor,
    stream: Stream,
    host: Host,
    arm: Option<Arm>,
    frames: usize,
    /// The first frame for which the ARM binary's line was not the host's.
    differs: Option<usize>,
}

/// What the flight program makes of a frame.
pub struct Written {
    /// As it was written.
    pub line: String,
    /// The same, read.
    pub read: Line,
    /// The pairs of which its estimate was made.
    pub inliers: Vec<Pair>,
}

/// A line of the flight program, as far as it is used here.
#[derive(Debug, Clone, Deserialize)]
pub struct Line {
    pub status: String,
    pub reason: Option<String>,
    pub reference: Option<usize>,
    pub x_e_m: Option<f64>,
    pub y_e_m: Option<f64>,
    pub z_e_m: Option<f64>,
    pub yaw_rad: Option<f64>,
    pub covariance_m2: Option<[f64; 4]>,
    pub quality: Option<u8>,
    pub inliers: Option<usize>,
    pub matches: Option<usize>,
    pub features: usize,
}

impl Line {
    /// Along `X_e` and `Y_e`, m.
    pub fn displacement(&self) -> Option<Vector2<f64>> {
        Some(Vector2::new(self.x_e_m?, self.y_e_m?))
    }

    /// The same for a page.
    pub fn estimate(&self) -> Option<Estimate> {
        let [xx, _, _, yy] = self.covariance_m2?;
        Some(Estimate {
            displacement: self.displacement()?.into(),
            sigma: [xx.sqrt(), yy.sqrt()],
            quality: self.quality?,
            inliers: self.inliers?,
            matches: self.matches?,
        })
    }
}

/// Refuses the ARM binary, which has the registers of kt27 built in, with other hardware.
pub fn suits(features: Source, design: &DesignPoint, program: Program) -> Result<()> {
    if features == Source::Rtl && program == Program::Arm && *design != *KT27 {
        bail!(
            "--features rtl --estimator arm: the ARM binary is built for the Verilog of kt27 and refuses any other; \
             leave --design and --config, or --estimator out"
        );
    }
    Ok(())
}

/// The FPGA of a design.
///
/// # Errors
/// The design cannot be built.
fn fpga(features: Source, design: &DesignPoint) -> Result<Fpga> {
    // Where no hardware is, the stream begins with the registers that the program was built with.
    if features != Source::Rtl || *design == *KT27 {
        return Ok(Fpga { columns: design.width, ..Fpga::default() });
    }
    let map = registers(design)?;
    let coefficients = map.iter().filter(|register| register.offset >= COEFFICIENTS_AT);
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
    /// Starts extractor and flight program, which captures the first frame as its reference.
    pub fn start(features: Source, design: &DesignPoint, program: Program, first: &Plane<u16>) -> Result<Self> {
        let fpga = fpga(features, design)?;
        let arm = (program == Program::Arm).then(Arm::start).transpose()?;
        let extractor = Extractor::new(features, design, &fpga, first)?;
        let mut stream = Stream::default();
        match extractor.registers() {
            Some(block) => stream.send(message::REGISTERS, &encode_registers(block)),
            None => stream.send_registers(first.width(), first.height()),
        }
        stream.send(message::COMMAND, &Command::Capture.encode());
        let mut chain = Self { extractor, stream, host: Host::of(fpga), arm, frames: 0, differs: None };
        chain.send()?;
        Ok(chain)
    }

    /// Tells the flight program something; the word that it sends to the camera, where it does.
    pub fn command(&mut self, command: Command) -> Result<Option<u32>> {
        self.stream.send(message::COMMAND, &command.encode());
        self.send()?;
        self.host.camera_word()
    }

    /// A frame with its telemetry. With the ARM binary its line is the one that counts, and is compared with the
    /// host's.
    pub fn frame(&mut self, telemetry: &Telemetry, frame: &Plane<u16>) -> Result<Written> {
        self.stream.send(message::TELEMETRY, &telemetry.encode());
        let packet = self.extractor.packet(frame)?;
        self.stream.send(message::FRAME, &packet);
        let lines = self.send()?;
        let [host] = &lines[..] else { bail!("the flight program wrote {} lines for a frame", lines.len()) };
        let line = match &mut self.arm {
            Some(arm) => arm.line()?,
            None => host.clone(),
        };
        if line != *host {
            self.differs.get_or_insert(self.frames);
        }
        self.frames += 1;
        let read = serde_json::from_str(&line).with_context(|| format!("the flight program wrote no line: {line}"))?;
        Ok(Written { line, read, inliers: self.host.inliers().to_vec() })
    }

    /// The first frame for which the ARM binary's line was not the host's.
    pub fn differs(&self) -> Option<usize> {
        self.differs
    }

    /// Clock cycles simulated so far, where hardware is.
    pub fn cycles(&self) -> Option<u64> {
        self.extractor.cycles()
    }

    fn send(&mut self) -> Result<Vec<String>> {
        let mut lines = Vec::new();
        for message in self.stream.messages.drain(..) {
            lines.extend(self.host.take(&message)?);
            if let Some(arm) = &mut self.arm {
                arm.send(&message)?;
            }
        }
        Ok(lines)
    }
}

/// A choice as it is written on the command line.
pub fn named<S: Serializer>(choice: &impl ValueEnum, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(choice.to_possible_value().as_ref().map_or("", |value| value.get_name()))
}

/// Both choices as a page tells them.
pub fn told(features: Source, program: Program) -> [String; 2] {
    let name = |choice: Option<PossibleValue>, help: &str| {
        let name = choice.map(|value| value.get_name().to_owned()).unwrap_or_default();
        format!("{name}, {help}")
    };
    let features_help = match features {
        Source::Float => "the reference in f32",
        Source::Fixed => "the bit-true model",
        Source::Rtl => "the emitted Verilog under Verilator, records through a DMA and a ring of buffers",
    };
    let program_help = match program {
        Program::Host => "in the process of the command",
        Program::Arm => "the ARM binary under qemu; its lines are the host's, compared byte for byte",
    };
    [name(features.to_possible_value(), features_help), name(program.to_possible_value(), program_help)]
}

/// The name of a choice on the command line.
pub fn name(choice: &impl ValueEnum) -> String {
    choice.to_possible_value().as_ref().map_or("", |value| value.get_name()).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_take_frames_as_wide_as_their_design() {
        for (name, columns) in [("kt27", 1024), ("hd1080", 1920)] {
            let design = DesignPoint::shipped(name).unwrap();
            for features in [Source::Float, Source::Fixed] {
                assert_eq!(fpga(features, &design).unwrap(), Fpga { columns, ..Fpga::default() });
            }
        }
    }
}
