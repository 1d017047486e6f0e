//! The flight program: converts feature records from the FPGA and telemetry into a displacement in metres.
//!
//! | module | its one job |
//! |---|---|
//! | [`framing`] | delimits messages on a byte stream that may lose or corrupt bytes |
//! | [`message`] | encodes and decodes the messages |
//! | [`pixels`] | gathers the pixels of the present frame |
//! | [`hardware`] | register addresses of the FPGA, and the check that it is the one this program was built for |
//! | [`bus`] | registers by byte address, mapped from a device |
//! | [`setup`] | checks, configures and enables the FPGA |
//! | [`navigator`] | messages in, one line per frame out |
//! | [`two_views`] | the estimator for two pictures without an IMU |
//! | `tracker` | the estimator: prediction, matching, search, keyframes, protection level |
//! | `filter` | position, attitude and keyframe poses with their covariance |
//! | `keyframe` | landmarks, and matching where they are predicted |
//! | [`line`](mod@line) | the result of a frame as a JSON line |
//! | [`mavlink`] | the result of a frame as a message to an autopilot |
//! | [`arinc429`] | the words that control the camera |
//! | [`source`] | the sending end of the stream |
//!
//! Matching, RANSAC and pose fit are the code of [`hoverlock_reference`]. Three rules hold everywhere and have a test
//! each: the bits of the output are the same on every machine, no memory is allocated after the first frame, and the
//! work of a frame is bounded.

pub mod arinc429;
pub mod bus;
pub mod calibration;
mod filter;
pub mod framing;
pub mod hardware;
mod keyframe;
pub mod line;
pub mod mavlink;
pub mod message;
pub mod navigator;
pub mod pixels;
pub mod setup;
pub mod source;
mod tracker;
pub mod two_views;
