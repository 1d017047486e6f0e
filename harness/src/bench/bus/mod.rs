//! Bus models in Rust. They run at the edges of a clock, without a task, and read every signal as it was before the
//! edge.
//!
//! | bus | drives the design | answers or listens |
//! |---|---|---|
//! | Avalon-ST | [`stream::Source`] | [`stream::Sink`], [`stream::Monitor`] |
//! | AXI4-Stream | the same, with [`stream::Dialect::Axi`] | the same |
//! | Avalon-MM | [`avalon_mm::Master`] | [`avalon_mm::Memory`] |
//! | AXI4-Lite | [`axi_lite::Master`] | [`axi_lite::Memory`] |
//! | AXI4, with bursts | [`axi4::Master`], which checks the slave | [`axi4::Memory`], [`axi4::Checker`] |
//!
//! Every model that drives takes a [`Pause`]: the cycles in which it inserts idle or stall cycles. Sinks, monitors and
//! memories check the rules of their bus: a broken rule ends the run with a [`Violation`] that names rule and time.
//! [`bulk`] moves whole frames without the scheduler.

pub mod avalon_mm;
pub mod axi4;
pub mod axi_lite;
pub mod bulk;
mod handshake;
mod memory_contents;
mod pause;
mod reset;
pub mod stream;

pub use self::memory_contents::MemoryContents;
pub use self::pause::{Pause, Random, Switch};
pub use self::reset::Reset;
pub use super::error::Violation;
use crate::bench::sim::{Dut, Signal};
use crate::engine::error::ModelError;

/// Returns the signal `prefix` + `name`, or `None` if there is none.
fn optional(dut: &Dut, prefix: &str, name: &str) -> Result<Option<Signal>, ModelError> {
    let name = format!("{prefix}{name}");
    if dut.has_signal(&name) { dut.signal(&name).map(Some) } else { Ok(None) }
}
