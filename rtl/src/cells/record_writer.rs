//! The record writer: candidates with their rings become records, and a trailer ends each frame.

use hoverlock_registers::record::ERROR_UPSET;
use rust_hdl::prelude::*;

use super::queue::concatenated;
use super::{Candidate, Response, flag::Flag, low, zeros};
use crate::design::{
    CENTRES_AT, COLUMN_BITS, DOG_BITS, HITS_AT, NEIGHBOURS_AT, NEIGHBOURS_BITS, PARITY, POSITION_BITS, RECORD_BITS,
    ROW_BITS, SCALE_PAIRS, SIGNED_BITS,
};

/// Trailers that an upset marks.
const MARKED_FRAMES: u64 = 3;

/// From candidates with their rings to records, and the trailer that ends a frame.
///
/// Several scale pairs may find the same pixel; their records are written one a step. After a pixel that a pair found
/// it finds none for three steps. So two pairs never collide: after a pixel that both found comes none. Of three pairs
/// two may find a pixel and the third the next one: that candidate is held until the records before it are written, and
/// none comes while one is held.
///
/// In a protected design a flipped bit marks the trailers of the frames that may have read it. At most three frames are
/// in the pipeline: a frame has 64 lines at least, and the pipeline 82 at most.
#[derive(LogicBlock, Default)]
pub struct RecordWriter {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `candidate` is valid; its ring bits come one step later.
    pub found: Signal<In, Bit>,
    /// The candidate.
    pub candidate: Signal<In, Candidate>,
    /// MaxLBP of scale pair `k`, one bit per ring point, one step after `candidate`.
    pub maxlbp: [Signal<In, Bits<32>>; SCALE_PAIRS],
    /// Signs of scale pair `k`, one bit per ring point, one step after `candidate`.
    pub sign: [Signal<In, Bits<32>>; SCALE_PAIRS],
    /// Features that the candidate queue dropped.
    pub lost: Signal<In, Bits<2>>,
    /// Features withheld because of the record limit.
    pub over_limit: Signal<In, Bits<2>>,
    /// The last pixel of a frame was at the centre of the ring.
    pub frame_end: Signal<In, Bit>,
    /// Input error bits of the frame.
    pub errors: Signal<In, Bits<4>>,
    /// Store the thresholds for the trailer: after the trailer of the previous frame and before the next frame sets its
    /// own.
    pub take: Signal<In, Bit>,
    /// The thresholds in use.
    pub threshold: [Signal<In, Response>; SCALE_PAIRS],
    /// The FIFO accepts features.
    pub room: Signal<In, Bit>,
    /// A flipped bit was read.
    pub upset: Flag<In>,
    /// Write `record`.
    pub write: Signal<Out, Bit>,
    /// Record.
    pub record: Signal<Out, Bits<RECORD_BITS>>,
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
    _now: Described,
    /// Of three scale pairs only; 0 if the pair has no hits.
    _held: Described,
    _trailer: bool,
    /// Features of the frame withheld because of the record limit.
    _withheld: u64,
    _thresholds: [u64; SCALE_PAIRS],
    /// Trailers that are still to be marked after an upset.
    _marks: u64,
}

/// A candidate whose ring bits are there.
#[derive(Clone, Copy, Default)]
struct Described {
    /// Pairs whose records are to be written, bit `k` for pair `k`.
    hits: u64,
    candidate: Candidate,
    maxlbp: [u64; SCALE_PAIRS],
    sign: [u64; SCALE_PAIRS],
}

impl RecordWriter {
    fn step(&mut self) {
        if self.advance.val() {
            let feature = self._now.hits != 0;
            let end_now = self._trailer && !feature;
            let (count, dropped) = (self.count.val().to_u64(), self.dropped.val().to_u64());
            self.record.next = words_to_bits(if end_now { self.trailer(count, dropped) } else { self.feature() });
            let (taken, lost) = (feature && self.room.val(), feature && !self.room.val());
            let done = self.done.val();
            let keep = |value: u64| if done { 0 } else { value };
            self.count.next = ((keep(count) + u64::from(taken)) & 0xf_ffff).into();
            self.dropped.next = ((keep(dropped) + self.lost.val().to_u64() + u64::from(lost)) & 0xf_ffff).into();
            self._withheld = (keep(self._withheld) + self.over_limit.val().to_u64()) & 0xf_ffff;
            if self.upset.val() {
                self._marks = MARKED_FRAMES;
            } else if end_now {
                self._marks = self._marks.saturating_sub(1);
            }
            self.frames.next = ((self.frames.val().to_u64() + u64::from(done)) & 0xffff_ffff).into();
            self.write.next = taken || end_now;
            self.done.next = end_now;
            self._trailer = self.frame_end.val() || (self._trailer && !end_now);
            let new = Described {
                hits: if self._waits {
                    low(self._waiting.get_bits::<SCALE_PAIRS>(HITS_AT).to_u64(), SCALE_PAIRS)
                } else {
                    0
                },
                candidate: self._waiting,
                maxlbp: self.maxlbp.each_ref().map(|word| word.val().to_u64()),
                sign: self.sign.each_ref().map(|word| word.val().to_u64()),
            };
            // The record of the lowest pair was written.
            let rest = self._now.hits & self._now.hits.wrapping_sub(1);
            if SCALE_PAIRS < 3 {
                self._now = if self._waits { new } else { Described { hits: rest, ..self._now } };
            } else if rest != 0 {
                self._now.hits = rest;
                if self._waits {
                    self._held = new;
                }
            } else {
                self._now = if self._held.hits != 0 { std::mem::take(&mut self._held) } else { new };
            }
            if self.take.val() {
                self._thresholds = self.threshold.each_ref().map(|threshold| threshold.val().to_u64());
            }
            self._waits = self.found.val();
            self._waiting = self.candidate.val();
        }
        if self.reset.val() {
            (self._waits, self._now.hits, self._held.hits, self._trailer) = (false, 0, 0, false);
            (self._withheld, self._marks) = (0, 0);
            self.write.next = false;
            self.done.next = false;
            self.count.next = 0u64.into();
            self.dropped.next = 0u64.into();
            self.frames.next = 0u64.into();
        }
    }

    fn feature(&self) -> [u64; RECORD_BITS / 32] {
        let Described { hits, candidate, maxlbp, sign } = &self._now;
        let pair = (hits.trailing_zeros() as usize).min(SCALE_PAIRS - 1);
        let centre = candidate.get_bits::<SIGNED_BITS>(CENTRES_AT + SIGNED_BITS * pair).to_u64();
        let position = candidate.get_bits::<POSITION_BITS>(0).to_u64();
        let around = NEIGHBOURS_AT + NEIGHBOURS_BITS * pair;
        let neighbour = |i: usize| candidate.get_bits::<DOG_BITS>(around + DOG_BITS * i).to_u64();
        // Bits 0 and 2 of the flags.
        let flags = [0, 1, 4][pair] | (centre >> DOG_BITS) << 1;
        let mut words = [0; RECORD_BITS / 32];
        words[0] = (position >> COLUMN_BITS) << 16 | low(position, COLUMN_BITS);
        words[1] = flags << 16 | low(centre, DOG_BITS);
        words[2] = neighbour(1) << 16 | neighbour(0);
        words[3] = neighbour(3) << 16 | neighbour(2);
        for k in 0..SCALE_PAIRS {
            let (maxlbp_at, sign_at) = [(4, 6), (5, 7), (8, 9)][k];
            (words[maxlbp_at], words[sign_at]) = (maxlbp[k], sign[k]);
        }
        words
    }

    fn trailer(&self, count: u64, dropped: u64) -> [u64; RECORD_BITS / 32] {
        let layout = if SCALE_PAIRS > 2 { 0x9000 } else { 0x8000 };
        let mut words = [0; RECORD_BITS / 32];
        words[0] = self.frames.val().to_u64();
        let marked = self.upset.val() || self._marks != 0;
        let upset = if marked { u64::from(ERROR_UPSET) } else { 0 };
        words[1] = layout << 16 | upset | self.errors.val().to_u64();
        (words[2], words[3], words[6]) = (count, dropped, self._withheld);
        for (k, threshold) in self._thresholds.iter().enumerate() {
            words[4 + k / 2] |= threshold << (16 * (k % 2));
        }
        words
    }
}

fn words_to_bits(words: [u64; RECORD_BITS / 32]) -> Bits<RECORD_BITS> {
    let mut record = Bits::<RECORD_BITS>::default();
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
        let parts = writer_parts();
        let text = "\
// module: record_writer
// The candidate waits one step for its ring bits, then its records are written, scale pair 0 first.
reg         waits;
reg [CANDIDATE_BITS-1:0] waiting;
reg [HIT_TOP:0]   hits;
reg [CANDIDATE_BITS-1:0] now;
reg [RING_TOP:0] ring_bits;
HELDMARKSreg         trailer;
reg [19:0]  withheld;
reg [THRESHOLDS_TOP:0]  thresholds;

SELECTIONwire         feature = |hits;
wire         end_now = trailer & ~feature;
wire [SIGNED_BITS-1:0]  centre  = CENTRE;
wire [NEIGHBOURS_BITS-1:0]  neighbours = AROUND;
wire [31:0]  position = {ROW_PAD, now[POSITION_BITS-1:COLUMN_BITS], COLUMN_PAD, now[COLUMN_BITS-1:0]};
wire [31:0]  response = {FLAGS, DOG_PAD, centre[DOG_BITS-1:0]};
wire [63:0]  cardinal = {DOG_PAD, neighbours[4*DOG_BITS-1:3*DOG_BITS], DOG_PAD, neighbours[3*DOG_BITS-1:2*DOG_BITS],
                         DOG_PAD, neighbours[2*DOG_BITS-1:DOG_BITS], DOG_PAD, neighbours[DOG_BITS-1:0]};
wire [RECORD_TOP:0] trailer_record = {RESERVED, 12'd0, withheld, NO_THRESHOLDS, THRESHOLDS,
                        12'd0, dropped, 12'd0, count, LAYOUT, ERROR_BITS, frames};

always @(posedge clock)
  if (reset) begin
    waits   <= 1'b0;
    hits    <= NO_HITS;
    trailer <= 1'b0;
    write   <= 1'b0;
    done    <= 1'b0;
    count   <= 20'd0;
    dropped <= 20'd0;
    withheld <= 20'd0;
NO_MARKS    frames  <= 32'd0;
  end else if (advance) begin
    waits <= found;
NEXT_HITS    trailer <= frame_end | (trailer & ~end_now);
    write   <= (feature & room) | end_now;
    done    <= end_now;
    count   <= done ? {19'd0, feature & room} : count + {19'd0, feature & room};
    dropped <= (done ? 20'd0 : dropped) + {18'd0, lost} + {19'd0, feature & ~room};
    withheld <= (done ? 20'd0 : withheld) + {18'd0, over_limit};
NEXT_MARKS    frames  <= frames + {31'd0, done};
  end

always @(posedge clock)
  if (advance) begin
    waiting <= candidate;
    if (take)
      thresholds <= {ALL_THRESHOLDS};
NEXT_NOW    record <= end_now ? trailer_record : {ALL_RING_BITS, cardinal, response, position};
  end
";
        let text = parts.iter().fold(text.to_owned(), |text, (name, part)| text.replace(name, part));
        Verilog::Custom(
            text.replace("ROW_PAD", &zeros(16 - ROW_BITS))
                .replace("COLUMN_PAD", &zeros(16 - COLUMN_BITS))
                .replace("DOG_PAD", &zeros(16 - DOG_BITS)),
        )
    }
}

/// What of the record writer's Verilog depends on the number of scale pairs; a name before those that it contains.
fn writer_parts() -> Vec<(&'static str, String)> {
    let pairs = SCALE_PAIRS;
    let choice = |slice: &dyn Fn(usize) -> String| match pairs {
        1 => slice(0),
        2 => format!("second ? {} : {}", slice(1), slice(0)),
        _ => format!("third ? {} : second ? {} : {}", slice(2), slice(1), slice(0)),
    };
    let slice = |at: usize, bits: usize| format!("now[{}:{at}]", at + bits - 1);
    let (selection, flags) = match pairs {
        1 => ("", "14'd0, centre[DOG_BITS], 1'b0"),
        2 => ("wire         second  = ~hits[0];\n", "14'd0, centre[DOG_BITS], second"),
        _ => (
            "wire         second  = (hits[1:0] == 2'd2);\nwire         third   = (hits[1:0] == 2'd0);\n\
             // The hits whose records are still to be written after this step; a new candidate is held meanwhile.\n\
             wire [2:0]   rest = hits[0] ? {hits[2:1], 1'b0} : hits[1] ? {hits[2], 2'd0} : 3'd0;\n\
             wire         holds = |held_hits;\n",
            "13'd0, third, centre[DOG_BITS], second",
        ),
    };
    let hits = format!(
        "waiting[{}]",
        if pairs == 1 { HITS_AT.to_string() } else { format!("{}:{HITS_AT}", HITS_AT + pairs - 1) }
    );
    let all = |port: &str| concatenated(|k| format!("{port}_{k}"));
    // The words of pair 1 are 0 where there is none.
    let ring_bits = if pairs == 1 { "32'd0, ring_bits[63:32], 32'd0, ring_bits[31:0]" } else { "ring_bits" };
    let captured = match pairs {
        3 => "sign_2, maxlbp_2, sign_1, sign_0, maxlbp_1, maxlbp_0".to_owned(),
        _ => format!("{}, {}", all("sign"), all("maxlbp")),
    };
    let (next_hits, next_now) = match pairs {
        1 => (
            format!("    hits <= waits & {hits};\n"),
            format!("    if (waits) begin\n      now   <= waiting;\n      ring_bits <= {{{captured}}};\n    end\n"),
        ),
        2 => (
            format!(
                "    if (waits)\n      hits <= {hits};\n    else\n      hits <= hits[0] ? {{hits[1], 1'b0}} : 2'd0;\n"
            ),
            format!("    if (waits) begin\n      now   <= waiting;\n      ring_bits <= {{{captured}}};\n    end\n"),
        ),
        _ => (
            format!(
                "    if (rest != 3'd0) begin\n      hits <= rest;\n      if (waits)\n        held_hits <= {hits};\n    \
                 end else begin\n      hits <= holds ? held_hits : waits ? {hits} : 3'd0;\n      \
                 held_hits <= 3'd0;\n    end\n"
            ),
            format!(
                "    if (waits) begin\n      held <= waiting;\n      held_bits <= {{{captured}}};\n    end\n    \
                 if (rest == 3'd0) begin\n      now <= holds ? held : waiting;\n      \
                 ring_bits <= holds ? held_bits : {{{captured}}};\n    end\n"
            ),
        ),
    };
    let zero_words = RECORD_BITS - 224;
    let without_threshold = 64 - 16 * pairs;
    let held = match pairs {
        3 => "reg [2:0]   held_hits;\nreg [CANDIDATE_BITS-1:0] held;\nreg [191:0] held_bits;\n",
        _ => "",
    };
    let (marks, errors, no_marks, next_marks) = match PARITY {
        0 => ("", "12'd0, errors".to_owned(), "", String::new()),
        _ => (
            "// Trailers that are still to be marked after an upset.\nreg [1:0]   marks;\n\
             wire        marked = upset | (marks != 2'd0);\n",
            "11'd0, marked, errors".to_owned(),
            "    marks   <= 2'd0;\n",
            format!(
                "    if (upset)\n      marks <= 2'd{MARKED_FRAMES};\n    else if (end_now & (marks != 2'd0))\n      \
                 marks <= marks - 2'd1;\n"
            ),
        ),
    };
    vec![
        ("NO_MARKS", no_marks.into()),
        ("NEXT_MARKS", next_marks),
        ("MARKS", marks.into()),
        ("ERROR_BITS", errors),
        ("HELD", held.into()),
        ("HIT_TOP", (pairs - 1).to_string()),
        ("RING_TOP", (64 * pairs - 1).to_string()),
        ("SELECTION", selection.into()),
        ("CENTRE", choice(&|k| slice(CENTRES_AT + SIGNED_BITS * k, SIGNED_BITS))),
        ("AROUND", choice(&|k| slice(NEIGHBOURS_AT + NEIGHBOURS_BITS * k, NEIGHBOURS_BITS))),
        ("FLAGS", flags.into()),
        ("RECORD_TOP", (RECORD_BITS - 1).to_string()),
        ("THRESHOLDS_TOP", (pairs * DOG_BITS - 1).to_string()),
        ("RESERVED", format!("{zero_words}'d0")),
        ("ALL_THRESHOLDS", all("threshold")),
        ("NO_THRESHOLDS", format!("{without_threshold}'d0")),
        ("THRESHOLDS", concatenated(|k| format!("DOG_PAD, thresholds[{}:{}]", DOG_BITS * (k + 1) - 1, DOG_BITS * k))),
        ("LAYOUT", if pairs > 2 { "16'h9000" } else { "16'h8000" }.into()),
        ("NO_HITS", if pairs > 2 { "3'd0;\n    held_hits <= 3'd0".to_owned() } else { format!("{pairs}'d0") }),
        ("NEXT_HITS", next_hits),
        ("NEXT_NOW", next_now),
        ("ALL_RING_BITS", ring_bits.into()),
    ]
}
