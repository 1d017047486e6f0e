//! The record FIFO between the extractor and the feature stream.
//!
//! In a protected design a record has a parity bit, and the trailer behind a record with a flipped bit says so. The
//! flipped bit may be the one that makes a record a trailer, so the trailer after it says so, too.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::queue::with_depth;
use super::{flag::Flag, zeroed};
use crate::design::{PARITY, RECORD_BITS, RECORD_FIFO};

/// FIFO entries reserved for trailers: features are dropped, trailers never are.
pub const RESERVED: usize = 16;

/// The record FIFO with an Avalon-ST source.
#[derive(LogicBlock, Default)]
pub struct RecordFifo {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It empties the memory.
    pub reset: Signal<In, Bit>,
    /// Write in this cycle.
    pub write: Signal<In, Bit>,
    /// Record.
    pub record: Signal<In, Bits<RECORD_BITS>>,
    /// The FIFO accepts features.
    pub room: Signal<Out, Bit>,
    /// No space for a trailer: the datapath must stall.
    pub stall: Signal<Out, Bit>,
    /// The sink takes `data`.
    pub ready: Signal<In, Bit>,
    /// `data` is a record.
    pub valid: Signal<Out, Bit>,
    /// Record.
    pub data: Signal<Out, Bits<RECORD_BITS>>,
    /// First of its packet.
    pub start_of_packet: Signal<Out, Bit>,
    /// Last of its packet, the trailer.
    pub end_of_packet: Signal<Out, Bit>,
    /// A record with a flipped bit was read, one clock later.
    pub upset: Flag<Out>,
    _memory: VecDeque<Bits<RECORD_BITS>>,
    _next: Option<Bits<RECORD_BITS>>,
    _first: bool,
}

impl Logic for RecordFifo {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self._memory.clear();
                self._next = None;
                self._first = false;
                self.valid.next = false;
            } else {
                let take_data = !self.valid.val() || self.ready.val();
                let take_next = self._next.is_none() || take_data;
                let popped = if take_next { self._memory.pop_front() } else { None };
                if self.valid.val() && self.ready.val() {
                    self._first = !self.end_of_packet.val();
                }
                if take_data {
                    self.valid.next = self._next.is_some();
                    if let Some(record) = self._next {
                        self.data.next = record;
                    }
                }
                if take_next {
                    self._next = popped;
                }
                if self.write.val() {
                    self._memory.push_back(self.record.val());
                }
            }
            self.room.next = self._memory.len() < RECORD_FIFO - RESERVED;
            self.stall.next = self._memory.len() >= RECORD_FIFO - 3;
        }
        self.start_of_packet.next = !self._first;
        self.end_of_packet.next = self.data.val().get_bit(63);
        self.upset.next = false;
    }

    fn connect(&mut self) {
        self.room.connect();
        self.stall.connect();
        self.valid.connect();
        self.data.connect();
        self.start_of_packet.connect();
        self.end_of_packet.connect();
        self.upset.connect();
    }

    fn hdl(&self) -> Verilog {
        let text = "\
// module: record_fifo
reg [WORD_TOP:0] memory [0:LAST];
reg [ADDRESS]   write_address;
reg [ADDRESS]   read_address;
reg [COUNT]   waiting;
reg [WORD_TOP:0] next;
reg         next_valid;
reg         in_packet;

wire take_data = ~valid | ready;
wire take_next = ~next_valid | take_data;
wire not_empty      = waiting != NONE;
wire pop       = take_next & not_empty;
wire [COUNT] after = waiting + {PAD_COUNT, write} - {PAD_COUNT, pop};
CHECK
always @(posedge clock)
  if (reset) begin
    write_address <= FIRST;
    read_address  <= FIRST;
    waiting     <= NONE;
    next_valid  <= 1'b0;
    valid       <= 1'b0;
    in_packet      <= 1'b0;
    room        <= 1'b1;
    stall        <= 1'b0;
NO_UPSET  end else begin
    write_address <= write_address + {PAD_ADDRESS, write};
    read_address  <= read_address + {PAD_ADDRESS, pop};
    waiting     <= after;
    room        <= after < FEATURES_FIT;
    stall        <= after >= TRAILER_FITS;
    if (take_next)
      next_valid <= not_empty;
    if (take_data)
      valid <= next_valid;
    if (valid & ready)
      in_packet <= ~end_of_packet;
UPSET  end

always @(posedge clock)
  if (take_next)
    next <= memory[read_address];

always @(posedge clock)
  if (write)
    memory[write_address] <= STORED;

always @(posedge clock)
  if (take_data)
    data <= SENT;

always @(*) begin
  start_of_packet = ~in_packet;
  end_of_packet   = data[63];
end
";
        // In the order in which no name is part of a later one.
        let parts = match PARITY {
            0 => [("CHECK", ""), ("NO_UPSET", ""), ("UPSET", ""), ("STORED", "record"), ("SENT", "next")],
            _ => [
                (
                    "CHECK",
                    "
// A parity bit is above each record. Trailers that are still to be marked.
reg [1:0]   marks;
wire read   = take_data & next_valid;
wire odd    = ^next;
wire marked = next[63] & (odd | (marks != 2'd0));
",
                ),
                ("NO_UPSET", "    marks       <= 2'd0;\n    upset     <= 1'b0;\n"),
                (
                    "UPSET",
                    "    upset <= read & odd;
    if (read) begin
      if (odd)
        marks <= 2'd2;
      else if (next[63] & (marks != 2'd0))
        marks <= marks - 2'd1;
    end
",
                ),
                ("STORED", "{^record, record}"),
                ("SENT", "{next[RECORD_BITS-1:37], next[36] | marked, next[35:0]}"),
            ],
        };
        let text = parts.iter().fold(text.to_owned(), |text, (name, part)| text.replace(name, part));
        let text = with_depth(&text, RECORD_FIFO).replace("WORD_TOP", &(RECORD_BITS + PARITY - 1).to_string());
        Verilog::Custom(text + &zeroed(RECORD_BITS + PARITY, RECORD_FIFO, ""))
    }
}
