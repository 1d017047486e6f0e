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
    "flag_delay",
    "column_memory",
    "window_maximum_5",
    "window_maximum_7",
    "column_maximum",
    "decision",
    "cursor",
    "tail_counter",
    "eligible",
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
    "component",
];

/// Name, settings and table of the claims about connections.
const CONNECTIONS: [(&str, &str, &str); 2] = [
    ("smoothers", include_str!("../claims/smoothers.toml"), wiring::SMOOTHERS),
    ("wiring", include_str!("../claims/wiring.toml"), wiring::WIRING),
];

/// Claims whose wrappers have the word lengths, widths and names of the default design.
const OF_DEFAULT_DESIGN: [&str; 5] = ["smoothers", "column_memory", "unset_registers", "record_writer", "component"];

/// Claims about modules that have parity bits and a port `upset` if the memories of the design are protected, which no
/// claim states.
const OF_UNPROTECTED_DESIGNS: [&str; 5] = ["candidate_queue", "record_fifo", "csr", "top", "wiring"];

/// Returns all claims about the emitted Verilog of the default design: those of `claims/`, those about connections, and
/// those generated from the ring.
///
/// # Errors
/// If a TOML file of `claims/` is invalid.
pub fn claims() -> Result<Vec<Claim>, ClaimError> {
    claims_of(&Shape::kt27())
}

/// Returns the claims with the numbers of a design. Those that [`is_for_any_design`] rejects state only what holds for
/// the default design.
///
/// # Errors
/// If a TOML file of `claims/` is invalid.
pub fn claims_of(shape: &Shape) -> Result<Vec<Claim>, ClaimError> {
    let files = SHIPPED.iter().map(|(name, settings, properties)| file_claim(name, settings, properties, shape));
    let connections = CONNECTIONS.iter().map(|(name, settings, table)| wiring::claim(name, settings, table, shape));
    files.chain(connections).chain(ring::claims().into_iter().map(Ok)).collect()
}

/// Returns `true` if the wrapper of a claim takes its numbers from the design.
pub fn is_for_any_design(claim: &Claim) -> bool {
    !OF_DEFAULT_DESIGN.contains(&claim.name.as_str()) && !claim.name.starts_with("ring_taps")
}

/// Returns `true` if a claim for any design also holds for one with protected memories.
pub fn is_for_protected_designs(claim: &Claim) -> bool {
    !OF_UNPROTECTED_DESIGNS.contains(&claim.name.as_str())
}

/// Returns a claim of `claims/` for a design.
fn file_claim(name: &str, settings: &str, properties: &str, shape: &Shape) -> Result<Claim, ClaimError> {
    let mut claim = Claim::parse(name, settings, &shape.wrapper(properties))?;
    claim.observe.iter_mut().for_each(|observe| observe.text = shape.filled(&observe.text));
    if name == "top" {
        let own = ["csr", "sequencer", "bank", "record_writer", "record_fifo"];
        let parts = wiring::part_modules(wiring::WIRING, shape);
        claim.sources = ["hoverlock_top", "hoverlock_core", "extractor"].map(|module| format!("{module}.v")).to_vec();
        claim.sources.extend(parts.iter().map(|module| format!("{module}.v")));
        claim.cut = parts.into_iter().filter(|module| !own.contains(&module.as_str())).collect();
    }
    Ok(claim)
}
