//! Leaf cells: each has a Rust `update` for rust-hdl's simulator and hand-written Verilog beside it. A family of cells
//! is one module with parameters in a file of its own.
//!
//! All arithmetic and all memories are here, and all of it is unsigned. Modules composed of cells contain wiring only.
//! Conventions:
//!
//! - There is one clock. `reset` is synchronous and active high. It clears flags and counters but no data: data count
//!   only where a flag says so.
//! - `advance` is the clock enable of the whole datapath. A *step* is a clock edge with `advance` high. Every latency
//!   is in steps.
//! - Port names have no direction suffix. A signal `x_1` or `x_delayed_1` is `x` one step later.
//! - The first line of a cell's Verilog names its module. Equal cells become one module of that name. A family is named
//!   with the numbers of the cell.

pub mod address;
pub mod bank;
pub mod border;
pub mod csr;
pub mod decision;
pub mod delay;
pub mod difference;
pub mod flag;
pub mod join;
pub mod lerp;
pub mod line_delay;
pub mod maximum;
pub mod queue;
pub mod record_fifo;
pub mod record_limit;
pub mod record_writer;
pub mod ring;
pub mod sequencer;
pub mod tail;
pub mod threshold;

use rust_hdl::prelude::{Bits, Verilog};

pub use crate::design::STATE_BITS;
use crate::design::{
    BANK_BITS, CANDIDATE_BITS, COEFFICIENT_BITS, COLUMN_BITS, DOG_BITS, HEIGHT_BITS, NEIGHBOURS_BITS, PARITY,
    PIXEL_BITS, PIXEL_ROWS_BITS, POINTS_BITS, POSITION_BITS, ROW_BITS, SIGNED_BITS, WIDTH_BITS,
};

/// A camera sample.
pub type Pixel = Bits<PIXEL_BITS>;

/// The pixels of four rows of a column.
pub type PixelRows = Bits<PIXEL_ROWS_BITS>;

/// A filter state.
pub type State = Bits<STATE_BITS>;

/// A filter coefficient.
pub type Coefficient = Bits<COEFFICIENT_BITS>;

/// `DOG_k` or a maximum of it.
pub type Response = Bits<DOG_BITS>;

/// `DOG_k` or a maximum of it below its sign.
pub type SignedResponse = Bits<SIGNED_BITS>;

/// The magnitudes of the responses left, right, above and below a pixel, from the lowest bits up.
pub type FourNeighbours = Bits<NEIGHBOURS_BITS>;

/// The signed responses of the 32 points of a ring.
pub type Points = Bits<POINTS_BITS>;

/// An address of the line memories.
pub type Address = Bits<COLUMN_BITS>;

/// A column.
pub type Column = Bits<COLUMN_BITS>;

/// A row.
pub type Row = Bits<ROW_BITS>;

/// Row above column.
pub type PixelPosition = Bits<POSITION_BITS>;

/// `W`, from 64 to the design's width.
pub type Width = Bits<WIDTH_BITS>;

/// `H`, 64 to 2048.
pub type Height = Bits<HEIGHT_BITS>;

/// The register values of a frame.
pub type Fields = Bits<BANK_BITS>;

/// A candidate.
pub type Candidate = Bits<CANDIDATE_BITS>;

/// The families: the name of the module, and its file.
const FAMILIES: [(&str, &str); 9] = [
    ("delay", include_str!("delay.v")),
    ("flag_delay", include_str!("flag_delay.v")),
    ("pulse_delay", include_str!("pulse_delay.v")),
    ("frame_delay", include_str!("frame_delay.v")),
    ("line_delay", include_str!("line_delay.v")),
    ("line_delay_parity", include_str!("line_delay_parity.v")),
    ("row_look_back_border", include_str!("row_look_back_border.v")),
    ("row_look_ahead_border", include_str!("row_look_ahead_border.v")),
    ("window_maximum", include_str!("window_maximum.v")),
];

/// The text of a family's module.
pub(crate) fn family(name: &str) -> Option<&'static str> {
    FAMILIES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The Verilog of a cell of a family: the name of the module, and its parameters as the instance gives them.
fn of_family(name: &str, parameters: &[(&str, String)]) -> Verilog {
    let parameters: String = parameters.iter().map(|(name, value)| format!(" {name}={value}")).collect();
    Verilog::Custom(format!("// family: {name}{parameters}\n"))
}

/// Returns the Verilog that clears a memory at the start of a simulation, and the register `column` of its output if it
/// is named. A block memory is 0 after configuration, so words that were never written are even. Empty in a design
/// without protection.
fn zeroed(bits: usize, words: impl std::fmt::Display, column: &str) -> String {
    if PARITY == 0 {
        return String::new();
    }
    let column = if column.is_empty() { String::new() } else { format!("  {column} = {{({bits}){{1'b0}}}};\n") };
    format!(
        "
`ifndef SYNTHESIS
// A block memory and its output register are 0 after configuration.
integer entry;
initial begin
  for (entry = 0; entry < {words}; entry = entry + 1)
    memory[entry] = {{({bits}){{1'b0}}}};
{column}end
`endif
"
    )
}

/// Returns the check of a line memory whose word of `bits` bits was read into `column`. `odd` lists the parities of the
/// samples at the outputs. Empty in a design without protection.
fn protected(bits: usize, odd: &str) -> String {
    if PARITY == 0 {
        return String::new();
    }
    format!(
        "{}
// Each sample has a parity bit above it.
wire [{top}:0] odd = {{
    {odd}
}};
initial upset = 1'b0;

always @(posedge clock)
  if (advance)
    upset <= |odd;
",
        zeroed(bits, "LINE_WORDS", "column"),
        top = odd.matches('^').count() - 1,
    )
}

/// So many zeros in Verilog.
pub(crate) fn zeros(bits: usize) -> String {
    if bits == 1 { "1'b0".into() } else { format!("{bits}'d0") }
}

/// The lowest bits of a number.
pub(crate) const fn low(value: u64, bits: usize) -> u64 {
    value & ((1 << bits) - 1)
}
