//! The flight program: feature records from the FPGA and telemetry become the displacement from a reference, in metres.
//!
//! | module | its one reason |
//! |---|---|
//! | [`framing`] | bytes of a link that may lose or corrupt them become whole messages |
//! | [`message`] | what the messages say |
//! | [`hardware`] | registers of the FPGA, and whether it is the one this program was built for |
//! | [`bus`] | registers by byte address, mapped from a device |
//! | [`setup`] | the order in which the FPGA is checked, written and enabled |
//! | [`navigator`] | messages in, one line per frame out: reference, gate, search, pose |
//! | [`reference`] | what frames are compared with, and when another takes its place without a jump |
//! | [`things`] | which features of the reference lie on houses, trees and cars |
//! | [`line`] | the result of a frame as a JSON line |
//! | [`mavlink`] | the result of a frame as a message to an autopilot |
//! | [`arinc429`] | the words that control the camera |
//! | [`source`] | the sending end of the stream |
//!
//! Matching, RANSAC and pose fit are those of [`hoverlock_reference`]: shared code, no copy. Three rules hold for all
//! of it, each
//! with its test: the bits of the output are the same on every machine, no memory is allocated after the first frame,
//! and the work of a
//! frame is bounded.

pub mod arinc429;
pub mod bus;
pub mod framing;
pub mod ground;
pub mod hardware;
pub mod line;
pub mod mavlink;
pub mod message;
pub mod navigator;
pub mod reference;
pub mod setup;
pub mod source;
pub mod things;
