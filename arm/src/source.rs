//! The sending end of the stream: what a process beside the FPGA writes for this program to read.

use crate::framing::encode;
use crate::hardware::{EMISSION, IDENTIFICATION, VERSION, registers};
use crate::message::{self, Telemetry, encode_frame, encode_registers};
use hoverlock_fixed_point::model::bit_true::FeatureRecord;

/// Messages of one source, numbered from 0.
#[derive(Default)]
pub struct Source {
    sequence: u32,
    /// One message each.
    pub messages: Vec<Vec<u8>>,
}

impl Source {
    /// Appends a message.
    pub fn send(&mut self, kind: u32, payload: &[u8]) {
        let mut message = Vec::new();
        encode(kind, self.sequence, payload, &mut message);
        self.sequence += 1;
        self.messages.push(message);
    }

    /// The register block of the emitted hardware.
    pub fn start(&mut self, width: usize, height: usize) {
        let block = [
            (registers::IDENTIFICATION, IDENTIFICATION),
            (registers::VERSION, VERSION),
            (registers::EMISSION, EMISSION),
            (registers::SIZE, (height as u32) << 16 | width as u32),
        ];
        self.send(message::REGISTERS, &encode_registers(&block));
    }

    /// Telemetry, then records.
    pub fn frame(&mut self, telemetry: &Telemetry, features: &[FeatureRecord], thresholds: &[u32]) {
        self.send(message::TELEMETRY, &telemetry.encode());
        self.send(message::FRAME, &encode_frame(telemetry.frame, features, 0, 0, thresholds));
    }
}
