//! Design files: the parameters of the hardware, their checks and the designs that are built in.
//!
//! A [`DesignPoint`] holds all parameters. [`KEYS`] lists the keys of a design file with unit, meaning, limits and
//! field; parsing, writing, error messages and the constants of the hardware follow from it. A design file,
//! `designs/NAME.toml`, is TOML with every key. A configuration has some of the keys and changes a design: an absent
//! key keeps its value. [`SHIPPED`] holds the files that are built in, and [`KT27`], the default, is the first of them.
//!
//! # Units
//! A camera sample has `P` bits, 8 to 16. One DN is a step of a 16-bit sample, so full scale is `FS = 2^16` DN for
//! every camera, and a step of the camera is `2^(16-P)` DN. Two designs are compared in DN. The formats of pixel and
//! state count in steps of the camera: the state has `f` fraction bits, so its LSB is `2^(16-P-f)` DN. A DoG magnitude
//! has `N` bits over a quarter of full scale, so its LSB is `2^(14-N)` DN whatever `P` is: 0.5 DN at `N = 15`, 4 DN at
//! `N = 12`. Thresholds, responses and neighbours of a record are in that LSB, its position is in pixels. One LSB of
//! the DoG is `2^s` LSB of the state with `s = f + P - 2 - N`, 1 at the default design.
//!
//! The window of the maxima and the points of a ring are parameters of the algorithm, not of a design: they are the
//! same for every design.

mod choice;
mod error;
mod file;
mod format;
mod hardware;
mod key;
mod load;
pub mod pipeline;
mod point;
mod shipped;

pub use choice::{Protection, SmootherKind};
pub use error::DesignError;
pub use file::comment;
pub use format::{Format, FormatError};
pub use hardware::{MAX_ROWS, MIN_SIDE, Unbuildable};
pub use key::{Key, KeyValue};
pub use load::LoadError;
pub use point::{
    AutomaticThreshold, DesignPoint, KEYS, MAX_FRACTION_BITS, MAX_RING_RADIUS, MAX_SCALE_PAIRS, smoother_names,
};
pub use shipped::{KT27, SHIPPED};
