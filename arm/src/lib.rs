//! The flight program: feature records from the FPGA and telemetry become the displacement from a reference, in metres.
//!
//! | module | its one reason |
//! |---|---|
//! | [`framing`] | bytes of a link that may lose or corrupt them become whole messages |
//! | [`message`] | what the messages say |
//! | [`hardware`] | registers of the FPGA, and whether it is the one this program was built for |
//! | [`navigator`] | messages in, one line per frame out: reference, gate, search, pose |
//! | [`line`] | the result of a frame as a JSON line |
//! | [`arinc429`] | the words that control the camera |
//!
//! Matching, RANSAC and pose fit are those of [`hoverlock_reference`]: shared code, no copy. Three rules hold for all
//! of it, each
//! with its test: the bits of the output are the same on every machine, no memory is allocated after the first frame,
//! and the work of a
//! frame is bounded.

pub mod arinc429;
pub mod framing;
pub mod hardware;
pub mod line;
pub mod message;
pub mod navigator;
