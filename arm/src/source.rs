//! The sending end of the stream: the messages that a process beside the FPGA sends to this program.

use crate::framing::{PayloadError, encode};
use crate::hardware::{EMISSION, IDENTIFICATION, VERSION, registers};
use crate::message::{self, Telemetry, Unsent, encode_frame, encode_pixels, encode_registers};
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::image::plane::Plane;

/// A source of messages, which it numbers from 0.
#[derive(Default)]
pub struct Source {
    sequence: u32,
    /// The messages so far, each with framing.
    pub messages: Vec<Vec<u8>>,
}

impl Source {
    /// Appends a message of a kind of [`message`] with this payload.
    ///
    /// # Errors
    /// If no message has a payload of this length.
    pub fn send(&mut self, kind: u32, payload: &[u8]) -> Result<(), PayloadError> {
        let mut message = Vec::new();
        encode(kind, self.sequence, payload, &mut message)?;
        self.sequence += 1;
        self.messages.push(message);
        Ok(())
    }

    /// Appends the register block of the emitted hardware, set to frames of `width` x `height` pixels.
    ///
    /// # Errors
    /// As [`Source::send`].
    pub fn send_registers(&mut self, width: usize, height: usize) -> Result<(), PayloadError> {
        let block = [
            (registers::IDENTIFICATION, IDENTIFICATION),
            (registers::VERSION, VERSION),
            (registers::EMISSION, EMISSION),
            (registers::SIZE, (height as u32) << 16 | width as u32),
        ];
        self.send(message::REGISTERS, &encode_registers(&block))
    }

    /// Appends the rows of a frame with a number.
    ///
    /// # Errors
    /// As [`Source::send`].
    pub fn send_pixels(&mut self, frame: u32, picture: &Plane<u16>) -> Result<(), PayloadError> {
        encode_pixels(frame, picture).iter().try_for_each(|rows| self.send(message::PIXELS, rows))
    }

    /// Appends the telemetry and then the records of a frame; `thresholds` has one element for each scale pair.
    ///
    /// # Errors
    /// As [`Source::send`].
    pub fn send_frame(
        &mut self,
        telemetry: &Telemetry,
        features: &[FeatureRecord],
        thresholds: &[u32],
    ) -> Result<(), PayloadError> {
        self.send(message::TELEMETRY, &telemetry.encode())?;
        self.send(message::FRAME, &encode_frame(telemetry.frame, features, 0, Unsent::default(), thresholds))
    }
}
