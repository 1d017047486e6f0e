//! The candidate queue between window and ring, the record writer and the record FIFO.
//!
//! A candidate is found 15 lines and some steps before its ring is complete. Delaying all responses that long would
//! take 45 memories of 10 Kbit. Candidates are rare, so they wait in a queue and are matched by their position.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::{Candidate, Column, FourNeighbours, PixelPosition, Response, Row, SignedResponse, low, zeros};
use crate::design::{
    CENTRE_0_AT, CENTRE_1_AT, COLUMN_BITS, DOG_BITS, HIT_0_AT, HIT_1_AT, NEIGHBOURS_0_AT, NEIGHBOURS_1_AT,
    POSITION_BITS, ROW_BITS, SIGNED_BITS,
};

/// A candidate as one memory word: from the lowest bit
/// `position, hit_0, hit_1, sign and response of scale 0, of scale 1, neighbours of scale 0, of scale 1`, neighbours
/// left, right, upper, lower.
#[derive(LogicBlock, Default)]
pub struct CandidateWord {
    /// Row above column.
    pub position: Signal<In, PixelPosition>,
    /// Found at scale pair 0.
    pub hit_0: Signal<In, Bit>,
    /// Found at scale pair 1.
    pub hit_1: Signal<In, Bit>,
    /// Sign and response of scale pair 0.
    pub centre_0: Signal<In, SignedResponse>,
    /// Of scale pair 1.
    pub centre_1: Signal<In, SignedResponse>,
    /// Neighbours of scale pair 0.
    pub neighbours_0: Signal<In, FourNeighbours>,
    /// Of scale pair 1.
    pub neighbours_1: Signal<In, FourNeighbours>,
    /// Input sample.
    pub word: Signal<Out, Candidate>,
}

impl Logic for CandidateWord {
    fn update(&mut self) {
        let mut word = Candidate::default();
        word.set_bits(0, self.position.val());
        word = word.replace_bit(HIT_0_AT, self.hit_0.val()).replace_bit(HIT_1_AT, self.hit_1.val());
        let (zero, one) = (self.centre_0.val(), self.centre_1.val());
        word.set_bits(CENTRE_0_AT, zero);
        word.set_bits(CENTRE_1_AT, one);
        word.set_bits(NEIGHBOURS_0_AT, self.neighbours_0.val());
        word.set_bits(NEIGHBOURS_1_AT, self.neighbours_1.val());
        self.word.next = word;
    }

    fn connect(&mut self) {
        self.word.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: candidate_word
always @(*)
  word = {neighbours_1, neighbours_0, centre_1, centre_0, hit_1, hit_0, position};
"
            .into(),
        )
    }
}

/// The queue of candidates; it outputs the candidate whose ring is complete.
#[derive(LogicBlock, Default)]
pub struct CandidateQueue {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It empties the memory.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Input candidate.
    pub word: Signal<In, Candidate>,
    /// A sample is at the centre of the ring in the next step.
    pub active: Signal<In, Bit>,
    /// Column of the sample.
    pub x: Signal<In, Column>,
    /// Row of the sample.
    pub y: Signal<In, Row>,
    /// The centre is a candidate, one step later.
    pub found: Signal<Out, Bit>,
    /// The candidate, valid with `found`.
    pub candidate: Signal<Out, Candidate>,
    /// Its response at scale pair 0.
    pub centre_0: Signal<Out, Response>,
    /// At scale pair 1.
    pub centre_1: Signal<Out, Response>,
    /// Features dropped because the queue was full, one step later.
    pub dropped: Signal<Out, Bits<2>>,
    _memory: VecDeque<Candidate>,
    _next: Option<Candidate>,
    _head: Option<Candidate>,
}

/// Depth of the memory. Two more candidates fit into the output registers.
pub const CANDIDATES: usize = 512;

impl Logic for CandidateQueue {
    fn update(&mut self) {
        if !self.clock.pos_edge() {
            return;
        }
        if self.reset.val() {
            self._memory.clear();
            self._next = None;
            self._head = None;
            self.found.next = false;
            self.dropped.next = 0u64.into();
            return;
        }
        if !self.advance.val() {
            return;
        }
        let position = self.y.val().to_u64() << COLUMN_BITS | self.x.val().to_u64();
        let fits =
            self.active.val() && self._head.is_some_and(|head| head.get_bits::<POSITION_BITS>(0).to_u64() == position);
        self.found.next = fits;
        if let Some(head) = self._head {
            self.candidate.next = head;
            self.centre_0.next = head.get_bits::<DOG_BITS>(CENTRE_0_AT);
            self.centre_1.next = head.get_bits::<DOG_BITS>(CENTRE_1_AT);
        }
        let full = self._memory.len() == CANDIDATES;
        let take_head = self._head.is_none() || fits;
        let take_next = self._next.is_none() || take_head;
        if take_head {
            self._head = self._next.take();
        }
        if take_next {
            self._next = self._memory.pop_front();
        }
        let word = self.word.val();
        let hits = u64::from(word.get_bit(HIT_0_AT)) + u64::from(word.get_bit(HIT_1_AT));
        self.dropped.next = if full { hits } else { 0 }.into();
        if hits != 0 && !full {
            self._memory.push_back(word);
        }
    }

    fn connect(&mut self) {
        self.found.connect();
        self.candidate.connect();
        self.centre_0.connect();
        self.centre_1.connect();
        self.dropped.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: candidate_queue
reg [CANDIDATE_BITS-1:0] memory [0:511];
reg [8:0]   write_address;
reg [8:0]   read_address;
reg [9:0]   waiting;
reg [CANDIDATE_BITS-1:0] next;
reg         next_valid;
reg [CANDIDATE_BITS-1:0] head;
reg         head_valid;

wire fits   = active & head_valid & (head[POSITION_BITS-1:0] == {y, x});
wire take_head = ~head_valid | fits;
wire take_next = ~next_valid | take_head;
wire not_empty      = waiting != 10'd0;
wire full      = waiting[9];
wire push      = (word[HIT_0_AT] | word[HIT_1_AT]) & ~full;
wire pop       = take_next & not_empty;

always @(posedge clock)
  if (reset) begin
    write_address <= 9'd0;
    read_address  <= 9'd0;
    waiting     <= 10'd0;
    next_valid  <= 1'b0;
    head_valid  <= 1'b0;
    found       <= 1'b0;
    dropped     <= 2'd0;
  end else if (advance) begin
    write_address <= write_address + {8'd0, push};
    read_address  <= read_address + {8'd0, pop};
    waiting     <= waiting + {9'd0, push} - {9'd0, pop};
    if (take_next)
      next_valid <= not_empty;
    if (take_head)
      head_valid <= next_valid;
    found   <= fits;
    dropped <= full ? {1'b0, word[HIT_0_AT]} + {1'b0, word[HIT_1_AT]} : 2'd0;
  end

always @(posedge clock)
  if (advance & take_next)
    next <= memory[read_address];

always @(posedge clock)
  if (advance & push)
    memory[write_address] <= word;

always @(posedge clock)
  if (advance) begin
    if (take_head)
      head <= next;
    candidate <= head;
    centre_0  <= head[CENTRE_0_AT+DOG_BITS-1:CENTRE_0_AT];
    centre_1  <= head[CENTRE_1_AT+DOG_BITS-1:CENTRE_1_AT];
  end
"
            .into(),
        )
    }
}

/// From candidates with their rings to records of 256 bits, and the trailer that ends a frame.
///
/// Both scale pairs may find the same pixel; the second record is written one step after the first. This never
/// collides: after a pixel that both found, neither finds another one for three steps.
#[derive(LogicBlock, Default)]
pub struct RecordWriter {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `candidate` is valid; its ring bits come one step later.
    pub found: Signal<In, Bit>,
    /// The candidate.
    pub candidate: Signal<In, Candidate>,
    /// MaxLBP of scale pair 0.
    pub maxlbp_0: Signal<In, Bits<32>>,
    /// MaxLBP of scale pair 1.
    pub maxlbp_1: Signal<In, Bits<32>>,
    /// Signs of scale pair 0.
    pub sign_0: Signal<In, Bits<32>>,
    /// Signs of scale pair 1.
    pub sign_1: Signal<In, Bits<32>>,
    /// Features that the candidate queue dropped.
    pub lost: Signal<In, Bits<2>>,
    /// The last pixel of a frame was at the centre of the ring.
    pub frame_end: Signal<In, Bit>,
    /// Input error bits of the frame.
    pub errors: Signal<In, Bits<4>>,
    /// Store the thresholds for the trailer: after the trailer of the previous frame and before the next frame sets its
    /// own.
    pub take: Signal<In, Bit>,
    /// The threshold in use.
    pub threshold_0: Signal<In, Response>,
    /// The threshold in use.
    pub threshold_1: Signal<In, Response>,
    /// The FIFO accepts features.
    pub room: Signal<In, Bit>,
    /// Write `record`.
    pub write: Signal<Out, Bit>,
    /// Record, 256 bits.
    pub record: Signal<Out, Bits<256>>,
    /// Pulse: a trailer is written, the frame is complete.
    pub done: Signal<Out, Bit>,
    /// Features of the frame written.
    pub count: Signal<Out, Bits<20>>,
    /// Features of the frame dropped.
    pub dropped: Signal<Out, Bits<20>>,
    /// Number of complete frames.
    pub frames: Signal<Out, Bits<32>>,
    _waits: bool,
    _waiting: Candidate,
    _hits: u64,
    _now: Candidate,
    _ring_bits: [u64; 4],
    _trailer: bool,
    _thresholds: u64,
}

impl RecordWriter {
    fn step(&mut self) {
        if self.advance.val() {
            let feature = self._hits != 0;
            let end_now = self._trailer && !feature;
            let (count, dropped) = (self.count.val().to_u64(), self.dropped.val().to_u64());
            self.record.next = words_to_bits(if end_now { self.trailer(count, dropped) } else { self.feature() });
            let (taken, lost) = (feature && self.room.val(), feature && !self.room.val());
            let done = self.done.val();
            let keep = |value: u64| if done { 0 } else { value };
            self.count.next = ((keep(count) + u64::from(taken)) & 0xf_ffff).into();
            self.dropped.next = ((keep(dropped) + self.lost.val().to_u64() + u64::from(lost)) & 0xf_ffff).into();
            self.frames.next = ((self.frames.val().to_u64() + u64::from(done)) & 0xffff_ffff).into();
            self.write.next = taken || end_now;
            self.done.next = end_now;
            self._trailer = self.frame_end.val() || (self._trailer && !end_now);
            self._hits = match (self._waits, self._hits & 1) {
                (true, _) => self._waiting.get_bits::<2>(HIT_0_AT).to_u64(),
                (false, 1) => self._hits & 2,
                (false, _) => 0,
            };
            if self._waits {
                self._now = self._waiting;
                self._ring_bits =
                    [&self.maxlbp_0, &self.maxlbp_1, &self.sign_0, &self.sign_1].map(|word| word.val().to_u64());
            }
            if self.take.val() {
                self._thresholds = self.threshold_1.val().to_u64() << 16 | self.threshold_0.val().to_u64();
            }
            self._waits = self.found.val();
            self._waiting = self.candidate.val();
        }
        if self.reset.val() {
            (self._waits, self._hits, self._trailer) = (false, 0, false);
            self.write.next = false;
            self.done.next = false;
            self.count.next = 0u64.into();
            self.dropped.next = 0u64.into();
            self.frames.next = 0u64.into();
        }
    }

    fn feature(&self) -> [u64; 8] {
        let second = self._hits & 1 == 0;
        let (centre, around) = if second { (CENTRE_1_AT, NEIGHBOURS_1_AT) } else { (CENTRE_0_AT, NEIGHBOURS_0_AT) };
        let centre = self._now.get_bits::<SIGNED_BITS>(centre).to_u64();
        let position = self._now.get_bits::<POSITION_BITS>(0).to_u64();
        let neighbour = |i: usize| self._now.get_bits::<DOG_BITS>(around + DOG_BITS * i).to_u64();
        let [maxlbp_0, maxlbp_1, sign_0, sign_1] = self._ring_bits;
        [
            (position >> COLUMN_BITS) << 16 | low(position, COLUMN_BITS),
            (centre >> DOG_BITS) << 17 | u64::from(second) << 16 | low(centre, DOG_BITS),
            neighbour(1) << 16 | neighbour(0),
            neighbour(3) << 16 | neighbour(2),
            maxlbp_0,
            maxlbp_1,
            sign_0,
            sign_1,
        ]
    }

    fn trailer(&self, count: u64, dropped: u64) -> [u64; 8] {
        let flags = 0x8000_0000 | self.errors.val().to_u64();
        [self.frames.val().to_u64(), flags, count, dropped, self._thresholds, 0, 0, 0]
    }
}

fn words_to_bits(words: [u64; 8]) -> Bits<256> {
    let mut record = Bits::<256>::default();
    words.into_iter().enumerate().for_each(|(i, word)| record.set_bits(32 * i, Bits::<32>::from(word)));
    record
}

impl Logic for RecordWriter {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            self.step();
        }
    }

    fn connect(&mut self) {
        self.write.connect();
        self.record.connect();
        self.done.connect();
        self.count.connect();
        self.dropped.connect();
        self.frames.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: record_writer
// The candidate waits one step for its ring bits, then its records are written, scale pair 0 first.
reg         waits;
reg [CANDIDATE_BITS-1:0] waiting;
reg [1:0]   hits;
reg [CANDIDATE_BITS-1:0] now;
reg [127:0] ring_bits;
reg         trailer;
reg [2*DOG_BITS-1:0]  thresholds;

wire         second  = ~hits[0];
wire         feature = |hits;
wire         end_now = trailer & ~feature;
wire [SIGNED_BITS-1:0]  centre  = second ? now[CENTRE_1_AT+SIGNED_BITS-1:CENTRE_1_AT] \
                               : now[CENTRE_0_AT+SIGNED_BITS-1:CENTRE_0_AT];
wire [NEIGHBOURS_BITS-1:0]  neighbours = second ? now[CANDIDATE_BITS-1:NEIGHBOURS_1_AT] \
                                   : now[NEIGHBOURS_1_AT-1:NEIGHBOURS_0_AT];
wire [31:0]  position = {ROW_PAD, now[POSITION_BITS-1:COLUMN_BITS], COLUMN_PAD, now[COLUMN_BITS-1:0]};
wire [31:0]  response = {14'd0, centre[DOG_BITS], second, DOG_PAD, centre[DOG_BITS-1:0]};
wire [63:0]  cardinal = {DOG_PAD, neighbours[4*DOG_BITS-1:3*DOG_BITS], DOG_PAD, neighbours[3*DOG_BITS-1:2*DOG_BITS],
                         DOG_PAD, neighbours[2*DOG_BITS-1:DOG_BITS], DOG_PAD, neighbours[DOG_BITS-1:0]};
wire [255:0] trailer_record = {96'd0, DOG_PAD, thresholds[2*DOG_BITS-1:DOG_BITS], \
                              DOG_PAD, thresholds[DOG_BITS-1:0], 12'd0, dropped, 12'd0, count,
                        16'h8000, 12'd0, errors, frames};

always @(posedge clock)
  if (reset) begin
    waits   <= 1'b0;
    hits    <= 2'd0;
    trailer <= 1'b0;
    write   <= 1'b0;
    done    <= 1'b0;
    count   <= 20'd0;
    dropped <= 20'd0;
    frames  <= 32'd0;
  end else if (advance) begin
    waits <= found;
    if (waits)
      hits <= waiting[HIT_1_AT:HIT_0_AT];
    else
      hits <= hits[0] ? {hits[1], 1'b0} : 2'd0;
    trailer <= frame_end | (trailer & ~end_now);
    write   <= (feature & room) | end_now;
    done    <= end_now;
    count   <= done ? {19'd0, feature & room} : count + {19'd0, feature & room};
    dropped <= (done ? 20'd0 : dropped) + {18'd0, lost} + {19'd0, feature & ~room};
    frames  <= frames + {31'd0, done};
  end

always @(posedge clock)
  if (advance) begin
    waiting <= candidate;
    if (take)
      thresholds <= {threshold_1, threshold_0};
    if (waits) begin
      now   <= waiting;
      ring_bits <= {sign_1, sign_0, maxlbp_1, maxlbp_0};
    end
    record <= end_now ? trailer_record : {ring_bits, cardinal, response, position};
  end
"
            .replace("ROW_PAD", &zeros(16 - ROW_BITS))
            .replace("COLUMN_PAD", &zeros(16 - COLUMN_BITS))
            .replace("DOG_PAD", &zeros(16 - DOG_BITS)),
        )
    }
}

/// Depth of the record FIFO.
pub const RECORDS: usize = 512;

/// FIFO entries reserved for trailers: features are dropped, trailers never are.
pub const RESERVED: usize = 16;

/// The record FIFO with an Avalon-ST source.
#[derive(LogicBlock, Default)]
pub struct RecordFifo {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It empties the memory.
    pub reset: Signal<In, Bit>,
    /// Write in this cycle.
    pub write: Signal<In, Bit>,
    /// Record, 256 bits.
    pub record: Signal<In, Bits<256>>,
    /// The FIFO accepts features.
    pub room: Signal<Out, Bit>,
    /// No space for a trailer: the datapath must stall.
    pub stall: Signal<Out, Bit>,
    /// The sink takes `data`.
    pub ready: Signal<In, Bit>,
    /// `data` is a record.
    pub valid: Signal<Out, Bit>,
    /// Record, 256 bits.
    pub data: Signal<Out, Bits<256>>,
    /// First of its packet.
    pub start_of_packet: Signal<Out, Bit>,
    /// Last of its packet, the trailer.
    pub end_of_packet: Signal<Out, Bit>,
    _memory: VecDeque<Bits<256>>,
    _next: Option<Bits<256>>,
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
            self.room.next = self._memory.len() < RECORDS - RESERVED;
            self.stall.next = self._memory.len() >= RECORDS - 3;
        }
        self.start_of_packet.next = !self._first;
        self.end_of_packet.next = self.data.val().get_bit(63);
    }

    fn connect(&mut self) {
        self.room.connect();
        self.stall.connect();
        self.valid.connect();
        self.data.connect();
        self.start_of_packet.connect();
        self.end_of_packet.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: record_fifo
reg [255:0] memory [0:511];
reg [8:0]   write_address;
reg [8:0]   read_address;
reg [9:0]   waiting;
reg [255:0] next;
reg         next_valid;
reg         in_packet;

wire take_data = ~valid | ready;
wire take_next = ~next_valid | take_data;
wire not_empty      = waiting != 10'd0;
wire pop       = take_next & not_empty;
wire [9:0] after = waiting + {9'd0, write} - {9'd0, pop};

always @(posedge clock)
  if (reset) begin
    write_address <= 9'd0;
    read_address  <= 9'd0;
    waiting     <= 10'd0;
    next_valid  <= 1'b0;
    valid       <= 1'b0;
    in_packet      <= 1'b0;
    room        <= 1'b1;
    stall        <= 1'b0;
  end else begin
    write_address <= write_address + {8'd0, write};
    read_address  <= read_address + {8'd0, pop};
    waiting     <= after;
    room        <= after < 10'd496;
    stall        <= after >= 10'd509;
    if (take_next)
      next_valid <= not_empty;
    if (take_data)
      valid <= next_valid;
    if (valid & ready)
      in_packet <= ~end_of_packet;
  end

always @(posedge clock)
  if (take_next)
    next <= memory[read_address];

always @(posedge clock)
  if (write)
    memory[write_address] <= record;

always @(posedge clock)
  if (take_data)
    data <= next;

always @(*) begin
  start_of_packet = ~in_packet;
  end_of_packet   = data[63];
end
"
            .into(),
        )
    }
}
