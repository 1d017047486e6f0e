//! Leaf cells: each has a Rust `update` for rust-hdl's simulator and hand-written Verilog beside it.
//!
//! All arithmetic and all memories are here, and all of it is unsigned. Modules composed of cells contain wiring only.
//! Conventions:
//!
//! - There is one clock. `reset` is synchronous and active high. It clears flags and counters but no data: data count
//!   only where a flag says so.
//! - `advance` is the clock enable of the whole datapath. A *step* is a clock edge with `advance` high. Every latency
//!   is in steps.
//! - Port names have no direction suffix. A signal `x_1` or `x_delayed_1` is `x` one step later.
//! - The first line of a cell's Verilog names its module. Equal cells become one module of that name.

pub mod address;
pub mod bank;
pub mod border;
pub mod csr;
pub mod decision;
pub mod delay;
pub mod difference;
pub mod join;
pub mod lerp;
pub mod line_delay;
pub mod maximum;
pub mod queue;
pub mod ring;
pub mod sequencer;
pub mod tail;

use rust_hdl::prelude::Bits;

/// Bits of a filter state, u16.2.
pub const STATE_BITS: usize = 18;

/// A filter state, u16.2.
pub type State = Bits<18>;

/// A filter coefficient, u0.16.
pub type Coefficient = Bits<16>;

/// `DOG_k` or a maximum of it.
pub type Response = Bits<15>;

/// An address of the line memories.
pub type Address = Bits<10>;

/// `W`, 64 to 1024.
pub type Width = Bits<11>;

/// `H`, 64 to 2048.
pub type Height = Bits<12>;
