//! Avalon-ST and AXI4-Stream: frames of symbols, transferred in beats with `valid` and `ready`.
//!
//! A frame is a list of symbols (bytes, pixels). A beat carries as many as fit into `data`: in Avalon-ST the first in
//! the highest bits, with `empty` counting the lanes that are not used at the end; in AXI4-Stream the first in the
//! lowest byte, with `tkeep` marking the lanes that are.
//!
//! ```text
//! clk    __/~~\__/~~\__/~~\__/~~\__/~~\__      a beat moves at an edge where valid and ready are 1;
//! valid  ____/~~~~~~~~~~~~~~~~~\_________      with a ready latency of L, where valid is 1, and valid may
//! ready  __________/~~~~~~~~~~~\_________      only be 1 L cycles after ready was
//! data   ----< A       >< B   >----------
//! ```

mod checker;
mod ports;
mod sink;
mod source;

pub use self::checker::Rules;
pub use self::ports::Ports;
pub(super) use self::ports::ReadyHistory;
pub use self::sink::{Monitor, Sink};
pub use self::source::Source;
use crate::bench::error::Error;

/// The protocol: names of the signals, and order of the symbols in a beat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// `valid ready data startofpacket endofpacket empty channel error`.
    Avalon {
        /// Cycles from `ready` to the beat it allows, at most 64.
        ready_latency: u32,
    },
    /// `tvalid tready tdata tlast tkeep tid tdest tuser`.
    Axi,
}

impl Dialect {
    /// Returns an error if the ready latency is over 64 cycles, of which the values of `ready` are kept.
    pub(super) fn check(self) -> Result<(), Error> {
        match self {
            Dialect::Avalon { ready_latency: 65.. } => {
                Err(Error::bench("the ready latency of a stream is at most 64 cycles"))
            }
            _ => Ok(()),
        }
    }
}

/// A packet, or a part of a stream without packets.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Frame {
    /// The symbols, in the order in which they are sent.
    pub symbols: Vec<u64>,
    /// `channel`, or `tid`.
    pub channel: u64,
    /// `error`, or `tuser`, of the last beat.
    pub error: u64,
    /// `tdest`.
    pub destination: u64,
    /// How a source sends the frame; a received frame has the default.
    pub sending: Sending,
}

/// The way in which a source sends a frame: with missing marks, or after a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sending {
    /// Sends no `startofpacket`: the frame continues the one before, or is stray.
    pub omit_start: bool,
    /// Sends no `endofpacket` or `tlast`: the next frame continues this one, or interrupts it.
    pub omit_end: bool,
    /// The least number of cycles without a beat before the first beat, counted from the frame before (or, if the
    /// source is idle, from the call of `send`).
    pub gap: u64,
}

impl Frame {
    /// Creates a frame of symbols of any unsigned type.
    pub fn new<T: Copy + Into<u64>>(symbols: &[T]) -> Frame {
        Frame { symbols: symbols.iter().map(|s| (*s).into()).collect(), ..Frame::default() }
    }

    /// Returns this frame on a channel.
    pub fn on_channel(mut self, channel: u64) -> Frame {
        self.channel = channel;
        self
    }

    /// Returns this frame without `startofpacket`.
    pub fn without_start(mut self) -> Frame {
        self.sending.omit_start = true;
        self
    }

    /// Returns this frame without `endofpacket` or `tlast`.
    pub fn without_end(mut self) -> Frame {
        self.sending.omit_end = true;
        self
    }

    /// Returns this frame with at least `cycles` cycles without a beat before it.
    pub fn after_gap(mut self, cycles: u64) -> Frame {
        self.sending.gap = cycles;
        self
    }
}
