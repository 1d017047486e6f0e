//! The claims about the emitted Verilog.

use crate::claim::{Claim, ClaimError};
use crate::ring;
use crate::shape::Shape;
use crate::wiring;

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        /// Name, settings and properties of the claims about the emitted Verilog.
        const SHIPPED: &[(&str, &str, &str)] = &[$((
            $name,
            include_str!(concat!("../claims/", $name, ".toml")),
            include_str!(concat!("../claims/", $name, ".sv")),
        )),*];
    };
}

shipped![
    "lerp",
    "difference",
    "row_look_back",
    "row_look_ahead",
    "row_look_ahead_border",
    "frame_delay",
    "address_counter",
    "delay",
    "column_memory",
    "window_maximum_5",
    "window_maximum_7",
    "column_maximum",
    "decision",
    "cursor",
    "threshold",
    "record_limit",
    "candidate_queue",
    "record_fifo",
    "sequencer",
    "unset_registers",
    "csr",
    "ring_comparator",
    "record_writer",
    "top",
];

/// Returns all claims about the emitted Verilog: those of `claims/`, then those generated from the ring.
///
/// # Errors
/// If a TOML file of `claims/` is invalid.
pub fn claims() -> Result<Vec<Claim>, ClaimError> {
    let files = SHIPPED.iter().map(|(name, settings, properties)| Claim::parse(name, settings, properties));
    files.chain([Ok(wiring::claim(&Shape::kt27()))]).chain(ring::claims().into_iter().map(Ok)).collect()
}
