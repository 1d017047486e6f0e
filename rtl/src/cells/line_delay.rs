//! `y_i[n] = x[n - k_i W]`: a delay by lines in block memory.
//!
//! One memory word holds all rows of a column. A step reads the word at `address`. One step later it is written back
//! with the new sample in its lowest bits and without the oldest sample. So a row costs no multiplexer and no register,
//! and one address counter modulo `W` serves all line memories of the design. The address counts steps and not columns,
//! so a frame may begin at any address: the delay is always `k W` steps. An M10K of 1024 words is 10 bits wide, so the
//! rows fill the memories up to the last few bits.
//!
//! A word that logic follows comes from a register behind the memory, is written one step later, and the delay is the
//! same: a read takes `r` steps, 1 or 2.
//!
//! The word is written at the address of `r + e` steps ago. With `e > 0` the loop through the memory takes `W - e`
//! steps, which leaves `e` steps for the logic of a recursion.
//!
//! In a protected design each sample has a parity bit, which is made as the sample comes in, stays with it and is
//! checked wherever the sample is used.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::{Address, Pixel, State, flag::Flag, of_family, protected};
use crate::design::{COLUMN_BITS, LINE_WORDS, PARITY, PIXEL_BITS, STATE_BITS};

/// The line memory. A sample has `B` bits; `OUT` is `B` times the number of taps.
#[derive(LogicBlock)]
pub struct LineDelay<const B: usize, const OUT: usize> {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<In, Address>,
    /// The address `r + e` steps ago.
    pub write_address: Signal<In, Address>,
    /// One sample per step.
    pub x: Signal<In, Bits<B>>,
    /// The taps, the newest lowest.
    pub y: Signal<Out, Bits<OUT>>,
    /// A sample with a flipped bit was at a tap, one step later.
    pub upset: Flag<Out>,
    _rows: usize,
    _taps: Vec<usize>,
    _memory: Vec<Vec<Bits<B>>>,
    /// The words of the last reads, the newest first: one for each step of a read.
    _columns: VecDeque<Vec<Bits<B>>>,
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
            upset: Default::default(),
            _rows: rows,
            _taps: taps.to_vec(),
            _memory: vec![vec![0u64.into(); rows]; LINE_WORDS],
            _columns: vec![vec![0u64.into(); rows]].into(),
        }
    }

    /// The same with a register behind the memory.
    pub fn registered(taps: &[usize]) -> Self {
        let mut lines = Self::new(taps);
        lines._columns.push_back(vec![0u64.into(); lines._rows]);
        lines
    }
}

impl<const B: usize, const OUT: usize> Logic for LineDelay<B, OUT> {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let read = self._memory[self.address.val().index()].clone();
            let mut written = self._columns.pop_back().unwrap_or_default();
            written.insert(0, self.x.val());
            written.truncate(self._rows);
            self._memory[self.write_address.val().index()] = written;
            self._columns.push_front(read);
            let mut out = self.y.val();
            for (i, tap) in self._taps.iter().enumerate() {
                out.set_bits(i * B, self._columns[self._columns.len() - 1][tap - 1]);
            }
            self.y.next = out;
        }
        self.upset.next = false;
    }

    fn connect(&mut self) {
        self.y.connect();
        self.upset.connect();
    }

    fn hdl(&self) -> Verilog {
        let (rows, taps) = (self._rows, self._taps.iter().fold(0u64, |taps, tap| taps | 1 << (tap - 1)));
        let parameters = [
            ("BITS", B.to_string()),
            ("ROWS", rows.to_string()),
            ("TAPS", format!("{rows}'h{taps:x}")),
            ("OUTPUTS", self._taps.len().to_string()),
            ("ADDRESS_BITS", COLUMN_BITS.to_string()),
            ("READ", self._columns.len().to_string()),
        ];
        of_family(if PARITY == 1 { "line_delay_parity" } else { "line_delay" }, &parameters)
    }
}

/// The rows of all column look-ahead stages in one memory: `taps_i[n] = pixel[n - k_i W]`, `y_i[n] = x_i[n - l_i W]`.
///
/// One word for all of them leaves no bits of a block unused, and all smoothers share the rows of pixels.
#[derive(LogicBlock)]
pub struct ColumnMemory<const TAPS: usize, const STAGES: usize> {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<In, Address>,
    /// The address one step ago.
    pub write_address: Signal<In, Address>,
    /// One pixel per step.
    pub pixel: Signal<In, Pixel>,
    /// The pixel `k_i` lines ago.
    pub taps: [Signal<Out, Pixel>; TAPS],
    /// One state per step and stage.
    pub x: [Signal<In, State>; STAGES],
    /// The state `l_i` lines ago.
    pub y: [Signal<Out, State>; STAGES],
    /// A sample with a flipped bit was at an output, one step later.
    pub upset: Flag<Out>,
    _taps: Vec<usize>,
    _lines: Vec<usize>,
    _pixels: Vec<Vec<Pixel>>,
    _states: Vec<Vec<Vec<State>>>,
    _column: (Vec<Pixel>, Vec<Vec<State>>),
}

impl<const TAPS: usize, const STAGES: usize> ColumnMemory<TAPS, STAGES> {
    /// Taps of the pixel after these numbers of lines, rising, at least 1, and states after these.
    pub fn new(taps: &[usize; TAPS], lines: &[usize; STAGES]) -> Self {
        debug_assert!(taps.is_sorted() && taps[0] >= 1);
        let pixels = vec![Pixel::default(); taps[TAPS - 1]];
        let states: Vec<_> = lines.iter().map(|lines| vec![State::default(); *lines]).collect();
        Self {
            clock: Signal::default(),
            advance: Signal::default(),
            address: Signal::default(),
            write_address: Signal::default(),
            pixel: Signal::default(),
            taps: std::array::from_fn(|_| Signal::default()),
            x: std::array::from_fn(|_| Signal::default()),
            y: std::array::from_fn(|_| Signal::default()),
            upset: Default::default(),
            _taps: taps.to_vec(),
            _lines: lines.to_vec(),
            _pixels: vec![pixels.clone(); LINE_WORDS],
            _states: vec![states.clone(); LINE_WORDS],
            _column: (pixels, states),
        }
    }
}

impl<const TAPS: usize, const STAGES: usize> Logic for ColumnMemory<TAPS, STAGES> {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let (read, written) = (self.address.val().index(), self.write_address.val().index());
            let next = (self._pixels[read].clone(), self._states[read].clone());
            let (mut pixels, mut states) = std::mem::replace(&mut self._column, next);
            pixels.rotate_right(1);
            pixels[0] = self.pixel.val();
            for (rows, x) in states.iter_mut().zip(&self.x) {
                rows.rotate_right(1);
                rows[0] = x.val();
            }
            (self._pixels[written], self._states[written]) = (pixels, states);
            let (pixels, states) = &self._column;
            for (y, tap) in self.taps.iter_mut().zip(&self._taps) {
                y.next = pixels[tap - 1];
            }
            for (y, rows) in self.y.iter_mut().zip(states) {
                y.next = rows[rows.len() - 1];
            }
        }
        self.upset.next = false;
    }

    fn connect(&mut self) {
        self.taps.iter_mut().for_each(|tap| tap.connect());
        self.y.iter_mut().for_each(|y| y.connect());
        self.upset.connect();
    }

    fn hdl(&self) -> Verilog {
        // A sample with its parity bit above it.
        let sealed = |input: String| if PARITY == 1 { format!("^{input}, {input}") } else { input };
        let mut from = 0;
        let (mut outputs, mut words, mut checked) = (String::new(), Vec::new(), Vec::new());
        let mut add = |input: String, bits: usize, lines: usize| {
            let kept = (from + (lines - 1) * bits).checked_sub(1).filter(|_| lines > 1);
            words.push(match kept {
                Some(top) => format!("column[{top}:{from}], {}", sealed(input)),
                None => sealed(input),
            });
            from += lines * bits;
            from
        };
        let mut output = |port: String, from: usize, bits: usize| {
            outputs += &format!("  {port} = column[{}:{from}];\n", from + bits - 1);
            checked.push(format!("^column[{}:{from}]", from + bits));
        };
        let (pixel_bits, state_bits) = (PIXEL_BITS + PARITY, STATE_BITS + PARITY);
        add("pixel".into(), pixel_bits, self._taps[TAPS - 1]);
        for (i, tap) in self._taps.iter().enumerate() {
            output(format!("taps_{i}"), (tap - 1) * pixel_bits, PIXEL_BITS);
        }
        for (i, lines) in self._lines.iter().enumerate() {
            let end = add(format!("x_{i}"), state_bits, *lines);
            output(format!("y_{i}"), end - state_bits, STATE_BITS);
        }
        words.reverse();
        let text = format!(
            "// module: column_memory
reg [{top}:0] memory [0:LINE_WORDS-1];
reg [{top}:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= {{
      {}
    }};
  end

always @(*) begin
{outputs}end
",
            words.join(",\n      "),
            top = from - 1,
        );
        Verilog::Custom(text + &protected(from, &checked.join(",\n    ")))
    }
}
