//! `y_i[n] = x[n - k_i W]`: a delay by lines in block memory.
//!
//! One memory word holds all rows of a column. A step reads the word at `address`. One step later it is written back
//! with the new sample in its lowest bits and without the oldest sample. So a row costs no multiplexer and no register,
//! and one address counter modulo `W` serves all line memories of the design. The address counts steps and not columns,
//! so a frame may begin at any address: the delay is always `k W` steps. An M10K of 1024 words is 10 bits wide, so the
//! rows fill the memories up to the last few bits.
//!
//! The word is written at the address of `1 + e` steps ago. With `e > 0` the loop through the memory takes `W - e`
//! steps, which leaves `e` steps for the logic of a recursion.

use rust_hdl::prelude::*;

use super::Address;
use crate::design::LINE_WORDS;

/// The line memory. A sample has `B` bits; `OUT` is `B` times the number of taps.
#[derive(LogicBlock)]
pub struct LineDelay<const B: usize, const OUT: usize> {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<In, Address>,
    /// The address one step ago, or `1 + e` steps ago.
    pub write_address: Signal<In, Address>,
    /// One sample per step.
    pub x: Signal<In, Bits<B>>,
    /// The taps, the newest lowest.
    pub y: Signal<Out, Bits<OUT>>,
    _rows: usize,
    _taps: Vec<usize>,
    _memory: Vec<Vec<Bits<B>>>,
    _column: Vec<Bits<B>>,
}

impl<const B: usize, const OUT: usize> LineDelay<B, OUT> {
    /// Taps after these numbers of lines, rising, at least 1.
    pub fn new(taps: &[usize]) -> Self {
        debug_assert!(OUT == B * taps.len() && taps.is_sorted() && taps[0] >= 1);
        let rows = taps.last().copied().unwrap_or(1);
        Self {
            clock: Signal::default(),
            advance: Signal::default(),
            address: Signal::default(),
            write_address: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            _rows: rows,
            _taps: taps.to_vec(),
            _memory: vec![vec![0u64.into(); rows]; LINE_WORDS],
            _column: vec![0u64.into(); rows],
        }
    }
}

impl<const B: usize, const OUT: usize> Logic for LineDelay<B, OUT> {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let read = self._memory[self.address.val().index()].clone();
            let mut written = self._column.clone();
            written.insert(0, self.x.val());
            written.truncate(self._rows);
            self._memory[self.write_address.val().index()] = written;
            self._column = read;
            let mut out = self.y.val();
            for (i, tap) in self._taps.iter().enumerate() {
                out.set_bits(i * B, self._column[tap - 1]);
            }
            self.y.next = out;
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        let (rows, taps) = (self._rows, &self._taps);
        let every = taps.len() == rows;
        let name = if taps.len() == 1 {
            format!("line_delay_{B}x{rows}")
        } else if every {
            format!("line_delay_{B}x{rows}_all")
        } else {
            format!("line_delay_{B}x{rows}_taps{}", taps.len())
        };
        let top = rows * B - 1;
        let shifted = if rows == 1 { "x".to_owned() } else { format!("{{column[{}:0], x}}", (rows - 1) * B - 1) };
        let slices: Vec<String> =
            taps.iter().rev().map(|tap| format!("column[{}:{}]", tap * B - 1, (tap - 1) * B)).collect();
        Verilog::Custom(format!(
            "// module: {name}
reg [{top}:0] memory [0:LINE_WORDS-1];
reg [{top}:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= {shifted};
  end

always @(*)
  y = {{{}}};
",
            slices.join(", ")
        ))
    }
}
