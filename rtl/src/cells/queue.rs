//! The candidate queue between window and ring.
//!
//! A candidate is found 15 lines and some steps before its ring is complete. Delaying all responses that long would
//! take 45 memories of 10 Kbit. Candidates are rare, so they wait in a queue and are matched by their position.
//!
//! In a protected design a candidate has a parity bit. One with a flipped bit is dropped at the head of the queue: at a
//! wrong position it would wait for ever, and all others behind it.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::record_fifo::RESERVED;
use super::{Candidate, Column, FourNeighbours, PixelPosition, Response, Row, SignedResponse, flag::Flag, zeroed};
use crate::design::{
    CANDIDATE_BITS, CANDIDATE_QUEUE, CENTRES_AT, COLUMN_BITS, DOG_BITS, HITS_AT, NEIGHBOURS_AT, NEIGHBOURS_BITS,
    PARITY, POSITION_BITS, SCALE_PAIRS, SIGNED_BITS,
};

/// Returns the texts of all scale pairs with `between` between them.
pub(super) fn of_pairs(text: impl Fn(usize) -> String, between: &str) -> String {
    (0..SCALE_PAIRS).map(text).collect::<Vec<_>>().join(between)
}

/// Returns the texts of all scale pairs, the highest first, as in a concatenation.
pub(super) fn concatenated(text: impl Fn(usize) -> String) -> String {
    (0..SCALE_PAIRS).rev().map(text).collect::<Vec<_>>().join(", ")
}

/// Fills the numbers of a depth, a power of two, into the text of a queue: addresses have `log2(depth)` bits, the
/// number of entries that wait has one more and is `depth` if its highest bit is set.
pub(super) fn with_depth(text: &str, depth: usize) -> String {
    let bits = depth.trailing_zeros() as usize;
    [
        ("LAST", (depth - 1).to_string()),
        ("FULL", bits.to_string()),
        ("PAD_ADDRESS", format!("{}'d0", bits - 1)),
        ("PAD_COUNT", format!("{bits}'d0")),
        ("ADDRESS", format!("{}:0", bits - 1)),
        ("COUNT", format!("{bits}:0")),
        ("FIRST", format!("{bits}'d0")),
        ("NONE", format!("{}'d0", bits + 1)),
        ("FEATURES_FIT", format!("{}'d{}", bits + 1, depth - RESERVED)),
        ("TRAILER_FITS", format!("{}'d{}", bits + 1, depth - 3)),
    ]
    .iter()
    .fold(text.to_owned(), |text, (name, number)| text.replace(name, number))
}

/// A candidate as one memory word: from the lowest bit
/// `position`, and of all scale pairs `hit`, sign and response, neighbours left, right, upper, lower.
#[derive(LogicBlock, Default)]
pub struct CandidateWord {
    /// Row above column.
    pub position: Signal<In, PixelPosition>,
    /// Found at scale pair `k`.
    pub hit: [Signal<In, Bit>; SCALE_PAIRS],
    /// Sign and response of scale pair `k`.
    pub centre: [Signal<In, SignedResponse>; SCALE_PAIRS],
    /// Neighbours of scale pair `k`.
    pub neighbours: [Signal<In, FourNeighbours>; SCALE_PAIRS],
    /// Input sample.
    pub word: Signal<Out, Candidate>,
}

impl Logic for CandidateWord {
    fn update(&mut self) {
        let mut word = Candidate::default();
        word.set_bits(0, self.position.val());
        for k in 0..SCALE_PAIRS {
            word = word.replace_bit(HITS_AT + k, self.hit[k].val());
            word.set_bits(CENTRES_AT + SIGNED_BITS * k, self.centre[k].val());
            word.set_bits(NEIGHBOURS_AT + NEIGHBOURS_BITS * k, self.neighbours[k].val());
        }
        self.word.next = word;
    }

    fn connect(&mut self) {
        self.word.connect();
    }

    fn hdl(&self) -> Verilog {
        let all = |port: &str| concatenated(|k| format!("{port}_{k}"));
        Verilog::Custom(format!(
            "// module: candidate_word\nalways @(*)\n  word = {{{}, {}, {}, position}};\n",
            all("neighbours"),
            all("centre"),
            all("hit")
        ))
    }
}

/// The queue of candidates; it outputs the candidate whose ring is complete.
#[derive(LogicBlock, Default)]
pub struct CandidateQueue {
    /// Clock: registers sample at its rising edge.
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
    /// Its response at scale pair `k`.
    pub centre: [Signal<Out, Response>; SCALE_PAIRS],
    /// Features dropped because the queue was full, one step later.
    pub dropped: Signal<Out, Bits<2>>,
    /// A candidate with a flipped bit was at the head, one step later.
    pub upset: Flag<Out>,
    _memory: VecDeque<Candidate>,
    _next: Option<Candidate>,
    _head: Option<Candidate>,
}

impl Logic for CandidateQueue {
    fn update(&mut self) {
        self.upset.next = false;
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
            for k in 0..SCALE_PAIRS {
                self.centre[k].next = head.get_bits::<DOG_BITS>(CENTRES_AT + SIGNED_BITS * k);
            }
        }
        let full = self._memory.len() == CANDIDATE_QUEUE;
        let take_head = self._head.is_none() || fits;
        let take_next = self._next.is_none() || take_head;
        if take_head {
            self._head = self._next.take();
        }
        if take_next {
            self._next = self._memory.pop_front();
        }
        let word = self.word.val();
        let hits = (0..SCALE_PAIRS).map(|k| u64::from(word.get_bit(HITS_AT + k))).sum::<u64>();
        self.dropped.next = if full { hits } else { 0 }.into();
        if hits != 0 && !full {
            self._memory.push_back(word);
        }
    }

    fn connect(&mut self) {
        self.found.connect();
        self.candidate.connect();
        self.centre.iter_mut().for_each(|centre| centre.connect());
        self.dropped.connect();
        self.upset.connect();
    }

    fn hdl(&self) -> Verilog {
        let text = "\
// module: candidate_queue
reg [WORD_TOP:0] memory [0:LAST];
reg [ADDRESS]   write_address;
reg [ADDRESS]   read_address;
reg [COUNT]   waiting;
reg [WORD_TOP:0] next;
reg         next_valid;
reg [WORD_TOP:0] head;
reg         head_valid;

ODDwire fits   = active & head_valid & SOUND(head[POSITION_BITS-1:0] == {y, x});
wire take_head = ~head_valid | fitsOR_ODD;
wire take_next = ~next_valid | take_head;
wire not_empty      = waiting != NONE;
wire full      = waiting[FULL];
wire push      = (ANY_HIT) & ~full;
wire pop       = take_next & not_empty;

always @(posedge clock)
  if (reset) begin
    write_address <= FIRST;
    read_address  <= FIRST;
    waiting     <= NONE;
    next_valid  <= 1'b0;
    head_valid  <= 1'b0;
    found       <= 1'b0;
    dropped     <= 2'd0;
NO_UPSET  end else if (advance) begin
    write_address <= write_address + {PAD_ADDRESS, push};
    read_address  <= read_address + {PAD_ADDRESS, pop};
    waiting     <= waiting + {PAD_COUNT, push} - {PAD_COUNT, pop};
    if (take_next)
      next_valid <= not_empty;
    if (take_head)
      head_valid <= next_valid;
    found   <= fits;
    dropped <= full ? HITS : 2'd0;
UPSET  end

always @(posedge clock)
  if (advance & take_next)
    next <= memory[read_address];

always @(posedge clock)
  if (advance & push)
    memory[write_address] <= STORED;

always @(posedge clock)
  if (advance) begin
    if (take_head)
      head <= next;
    candidate <= CANDIDATE;
CENTRES  end
";
        // In the order in which no name is part of a later one.
        let parts = match PARITY {
            0 => [
                ("NO_UPSET", ""),
                ("OR_ODD", ""),
                ("UPSET", ""),
                ("ODD", ""),
                ("SOUND", ""),
                ("STORED", "word"),
                ("CANDIDATE;", "head;"),
            ],
            _ => [
                ("NO_UPSET", "    upset     <= 1'b0;\n"),
                ("OR_ODD", " | odd"),
                ("UPSET", "    upset <= odd;\n"),
                ("ODD", "// A parity bit is above each candidate.\nwire odd    = head_valid & (^head);\n"),
                ("SOUND", "~odd & "),
                ("STORED", "{^word, word}"),
                ("CANDIDATE;", "head[CANDIDATE_BITS-1:0];"),
            ],
        };
        let text = parts.iter().fold(text.to_owned(), |text, (name, part)| text.replace(name, part));
        let text = with_depth(&text, CANDIDATE_QUEUE)
            .replace("WORD_TOP", &(CANDIDATE_BITS + PARITY - 1).to_string())
            .replace("ANY_HIT", &of_pairs(|k| format!("word[{}]", HITS_AT + k), " | "))
            .replace("HITS", &of_pairs(|k| format!("{{1'b0, word[{}]}}", HITS_AT + k), " + "))
            .replace(
                "CENTRES",
                &of_pairs(
                    |k| {
                        let at = CENTRES_AT + SIGNED_BITS * k;
                        format!("    centre_{k}  <= head[{}:{at}];\n", at + DOG_BITS - 1)
                    },
                    "",
                ),
            );
        Verilog::Custom(text + &zeroed(CANDIDATE_BITS + PARITY, CANDIDATE_QUEUE, ""))
    }
}
