//! The registers of the hardware and the layout of its records: one data file, `map.toml`, and what follows from it.
//!
//! Registers are 32 bits wide, on an Avalon-MM slave with a read latency of one cycle and no wait states. Which fields
//! and coefficients there are depends on the design: [`registers`] returns the map of one. Software of the default
//! design uses the constants of [`kt27`].
//!
//! | module | content |
//! |---|---|
//! | [`kt27`] | byte addresses, masks and fixed values of the committed hardware, as `hoverlock rtl emit` writes them |
//! | [`record`] | words, fields and flags of the records |
//! | [`headers`] | the register map as C header, Rust constants and Markdown |

pub mod headers;
pub mod kt27;
mod layout;
pub mod record;

pub use layout::{Access, COEFFICIENTS_OFFSET, Field, Register, registers};
