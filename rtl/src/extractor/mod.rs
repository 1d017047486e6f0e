//! The datapath from pixels to records, without bus interfaces.
//!
//! The build script says which smoothers each scale pair subtracts, because their number is the design's.
//!
//! [`hoverlock_design::pipeline`] says how many lines and steps each part takes.

pub mod scale_pair;
pub mod smoothers;

use hoverlock_design::pipeline::{DIFFERENCE_STEPS, RING_LINES, RING_STEPS, WINDOW_RADIUS, WINDOW_STEPS};
use rust_hdl::prelude::*;

use self::{scale_pair::ScalePair, smoothers::Smoothers};
use crate::cells::{
    Fields, Height, Pixel, Response, Width,
    decision::{Decision, Eligible},
    delay::{Cursor, Delay, FlagDelay, FrameDelay},
    flag::Flag,
    join::RingRows,
    line_delay::LineDelay,
    queue::{CandidateQueue, CandidateWord},
    record_limit::RecordLimit,
    record_writer::RecordWriter,
    ring::{RingComparator, RingTaps, rows},
    threshold::Threshold,
};
use crate::design::{
    DOG_BITS, OLDER_BITS, PARITY, PIXEL_BITS, RECORD_BITS, RECORD_LIMIT_AT, RING_BITS, SCALE_PAIRS, SIGNED_BITS,
    TARGET_AT,
};

// A pair `k` subtracts `wide` from `narrow` and has its threshold at `threshold_at` in a bank. The lines of a ring are
// a memory; those of a ring that reaches the newest row are a memory and that row.
macro_rules! extractor {
    (
        [$($k:tt $narrow:ident $wide:ident $threshold_at:ident),*]
        [$($narrow_ring:tt $narrow_lines:ident),*]
        [$($wide_ring:tt $ring_lines:ident $ring_rows:ident),*]
    ) => {
/// The extractor: pixels in, records out.
#[derive(LogicBlock)]
pub struct Extractor {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`, the columns of the frame.
    pub width: Signal<In, Width>,
    /// `H`, the rows of the frame.
    pub height: Signal<In, Height>,
    /// The pixel is the first of a frame.
    pub start: Signal<In, Bit>,
    /// One pixel per step.
    pub pixel: Signal<In, Pixel>,
    /// Register values captured for the frame.
    pub frame_bank: Signal<In, Fields>,
    /// Input errors of the frame, sampled with its trailer.
    pub errors: Signal<In, Bits<4>>,
    /// The FIFO accepts features.
    pub room: Signal<In, Bit>,
    /// A bit of `frame_bank` has flipped.
    pub bank_upset: Flag<In>,
    /// Write `record` in this cycle.
    pub write: Signal<Out, Bit>,
    /// Output record.
    pub record: Signal<Out, Bits<RECORD_BITS>>,
    /// Pulse: a frame is complete.
    pub done: Signal<Out, Bit>,
    /// Features of the frame that were written to the FIFO.
    pub count: Signal<Out, Bits<20>>,
    /// Features of the frame that were dropped.
    pub dropped: Signal<Out, Bits<20>>,
    /// Number of complete frames.
    pub frames: Signal<Out, Bits<32>>,
    /// A response was saturated.
    pub saturated: Signal<Out, Bit>,
    /// Thresholds `T_k` in use.
    pub threshold: [Signal<Out, Response>; SCALE_PAIRS],
    /// A flipped bit was read.
    pub upset: Flag<Out>,
    pixels: Delay<PIXEL_BITS>,
    smoothers: Smoothers,
    response_start: FlagDelay,
    response_cursor: Cursor,
    scale_pair: [ScalePair; SCALE_PAIRS],
    window_start: FrameDelay,
    window_cursor: Cursor,
    eligible: Eligible,
    decision: [Decision; SCALE_PAIRS],
    controller: [Threshold; SCALE_PAIRS],
    record_limit: RecordLimit,
    candidate: CandidateWord,
    ring_start: FrameDelay,
    ring_cursor: Cursor,
    queue: CandidateQueue,
    $($narrow_lines: LineDelay<SIGNED_BITS, RING_BITS>,)*
    $($ring_lines: LineDelay<SIGNED_BITS, OLDER_BITS>,)*
    $($ring_rows: RingRows,)*
    ring_taps: [RingTaps<RING_BITS>; SCALE_PAIRS],
    ring: [RingComparator; SCALE_PAIRS],
    writer: RecordWriter,
    window_upset: Flag<Local>,
    ring_upset: Flag<Local>,
}

impl Default for Extractor {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            width: Signal::default(),
            height: Signal::default(),
            start: Signal::default(),
            pixel: Signal::default(),
            frame_bank: Signal::default(),
            errors: Signal::default(),
            room: Signal::default(),
            bank_upset: Default::default(),
            write: Signal::default(),
            record: Signal::default(),
            done: Signal::default(),
            count: Signal::default(),
            dropped: Signal::default(),
            frames: Signal::default(),
            saturated: Signal::default(),
            threshold: Default::default(),
            upset: Default::default(),
            pixels: Delay::new(1),
            smoothers: Smoothers::default(),
            response_start: FlagDelay::new(DIFFERENCE_STEPS as usize),
            response_cursor: Cursor::default(),
            scale_pair: Default::default(),
            window_start: FrameDelay::new(WINDOW_RADIUS, WINDOW_STEPS),
            window_cursor: Cursor::default(),
            eligible: Eligible::default(),
            decision: Default::default(),
            controller: Default::default(),
            record_limit: RecordLimit::default(),
            candidate: CandidateWord::default(),
            ring_start: FrameDelay::new(RING_LINES - WINDOW_RADIUS, RING_STEPS - WINDOW_STEPS),
            ring_cursor: Cursor::default(),
            queue: CandidateQueue::default(),
            $($narrow_lines: LineDelay::new(&ring_lines($narrow_ring)),)*
            $($ring_lines: LineDelay::new(&ring_lines($wide_ring)),)*
            $($ring_rows: RingRows::default(),)*
            ring_taps: std::array::from_fn(RingTaps::new),
            ring: Default::default(),
            writer: RecordWriter::default(),
            window_upset: Default::default(),
            ring_upset: Default::default(),
        }
    }
}

impl Logic for Extractor {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: extractor");
        self.pixels.clock.next = self.clock.val();
        self.pixels.reset.next = self.reset.val();
        self.pixels.advance.next = self.advance.val();
        self.pixels.x.next = self.pixel.val();
        self.smoothers.clock.next = self.clock.val();
        self.smoothers.reset.next = self.reset.val();
        self.smoothers.advance.next = self.advance.val();
        self.smoothers.width.next = self.width.val();
        self.smoothers.height.next = self.height.val();
        self.smoothers.start.next = self.start.val();
        self.smoothers.pixel.next = self.pixels.y.val();
        self.smoothers.frame_bank.next = self.frame_bank.val();
        self.response_start.clock.next = self.clock.val();
        self.response_start.reset.next = self.reset.val();
        self.response_start.advance.next = self.advance.val();
        self.response_start.x.next = self.smoothers.start_out.val();
        $(
        self.scale_pair[$k].clock.next = self.clock.val();
        self.scale_pair[$k].reset.next = self.reset.val();
        self.scale_pair[$k].advance.next = self.advance.val();
        self.scale_pair[$k].address.next = self.smoothers.address.val();
        self.scale_pair[$k].registered_write_address.next = self.smoothers.registered_write_address.val();
        self.scale_pair[$k].narrow.next = self.smoothers.$narrow.val();
        self.scale_pair[$k].wide.next = self.smoothers.$wide.val();
        )*
        comment!("Samples between frames are undefined and must not set the status bit.");
        self.response_cursor.clock.next = self.clock.val();
        self.response_cursor.reset.next = self.reset.val();
        self.response_cursor.advance.next = self.advance.val();
        self.response_cursor.width.next = self.width.val();
        self.response_cursor.height.next = self.height.val();
        self.response_cursor.start.next = self.response_start.y.val();
        self.saturated.next =
            ($(self.scale_pair[$k].saturated.val())|*) & self.response_cursor.active.val();

        comment!("The 7x7 window decides whether its centre is a feature.");
        self.window_start.clock.next = self.clock.val();
        self.window_start.reset.next = self.reset.val();
        self.window_start.advance.next = self.advance.val();
        self.window_start.width.next = self.width.val();
        self.window_start.x.next = self.response_start.y.val();
        self.window_cursor.clock.next = self.clock.val();
        self.window_cursor.reset.next = self.reset.val();
        self.window_cursor.advance.next = self.advance.val();
        self.window_cursor.width.next = self.width.val();
        self.window_cursor.height.next = self.height.val();
        self.window_cursor.start.next = self.window_start.y.val();
        self.eligible.clock.next = self.clock.val();
        self.eligible.advance.next = self.advance.val();
        self.eligible.width.next = self.width.val();
        self.eligible.height.next = self.height.val();
        self.eligible.active.next = self.window_cursor.active.val();
        self.eligible.x.next = self.window_cursor.x.val();
        self.eligible.y.next = self.window_cursor.y.val();
        $(
        self.decision[$k].clock.next = self.clock.val();
        self.decision[$k].reset.next = self.reset.val();
        self.decision[$k].advance.next = self.advance.val();
        self.decision[$k].eligible.next = self.eligible.eligible.val();
        self.decision[$k].p.next = self.scale_pair[$k].p.val().get_bits::<DOG_BITS>(0);
        self.decision[$k].strict.next = self.scale_pair[$k].strict.val();
        self.decision[$k].loose.next = self.scale_pair[$k].loose.val();
        self.decision[$k].threshold.next = self.controller[$k].threshold.val();
        self.controller[$k].clock.next = self.clock.val();
        self.controller[$k].reset.next = self.reset.val();
        self.controller[$k].advance.next = self.advance.val();
        self.controller[$k].enters.next = self.response_start.y.val();
        self.controller[$k].start.next = self.window_start.y.val();
        self.controller[$k].maximum.next = self.decision[$k].maximum.val();
        self.controller[$k].hit.next = self.decision[$k].hit.val();
        self.controller[$k].centre.next = self.scale_pair[$k].centre.val().get_bits::<DOG_BITS>(0);
        self.controller[$k].manual.next = self.smoothers.window_bank.val().get_bits::<DOG_BITS>($threshold_at);
        self.controller[$k].target.next = self.smoothers.window_bank.val().get_bits::<16>(TARGET_AT);
        self.controller[$k].follow.next = self.smoothers.window_bank.val().get_bit(TARGET_AT + 16);
        self.threshold[$k].next = self.controller[$k].threshold.val();
        )*

        comment!("Of too many features some are withheld.");
        self.record_limit.clock.next = self.clock.val();
        self.record_limit.reset.next = self.reset.val();
        self.record_limit.advance.next = self.advance.val();
        self.record_limit.height.next = self.height.val();
        self.record_limit.y.next = self.window_cursor.y.val();
        self.record_limit.last_column.next = self.window_cursor.last_column.val();
        self.record_limit.limit.next = self.smoothers.window_bank.val().get_bits::<16>(RECORD_LIMIT_AT);
        $(self.record_limit.threshold[$k].next = self.controller[$k].threshold.val();)*
        $(self.record_limit.hit[$k].next = self.decision[$k].hit.val();)*
        $(self.record_limit.p[$k].next = self.scale_pair[$k].p.val().get_bits::<DOG_BITS>(0);)*

        comment!("A candidate waits until its ring is complete.");
        self.candidate.position.next = self.eligible.position.val();
        $(self.candidate.hit[$k].next = self.record_limit.keep[$k].val();)*
        $(self.candidate.centre[$k].next = self.scale_pair[$k].centre.val();)*
        $(self.candidate.neighbours[$k].next = self.scale_pair[$k].neighbours.val();)*
        self.ring_start.clock.next = self.clock.val();
        self.ring_start.reset.next = self.reset.val();
        self.ring_start.advance.next = self.advance.val();
        self.ring_start.width.next = self.width.val();
        self.ring_start.x.next = self.window_start.y.val();
        self.ring_cursor.clock.next = self.clock.val();
        self.ring_cursor.reset.next = self.reset.val();
        self.ring_cursor.advance.next = self.advance.val();
        self.ring_cursor.width.next = self.width.val();
        self.ring_cursor.height.next = self.height.val();
        self.ring_cursor.start.next = self.ring_start.y.val();
        self.queue.clock.next = self.clock.val();
        self.queue.reset.next = self.reset.val();
        self.queue.advance.next = self.advance.val();
        self.queue.word.next = self.candidate.word.val();
        self.queue.active.next = self.ring_cursor.active.val();
        self.queue.x.next = self.ring_cursor.x.val();
        self.queue.y.next = self.ring_cursor.y.val();

        comment!("The ring gives the descriptor of a feature.");
        $(
        self.$narrow_lines.clock.next = self.clock.val();
        self.$narrow_lines.advance.next = self.advance.val();
        self.$narrow_lines.address.next = self.smoothers.address.val();
        self.$narrow_lines.write_address.next = self.smoothers.write_address.val();
        self.$narrow_lines.x.next = self.scale_pair[$narrow_ring].ring.val();
        )*
        $(
        self.$ring_lines.clock.next = self.clock.val();
        self.$ring_lines.advance.next = self.advance.val();
        self.$ring_lines.address.next = self.smoothers.address.val();
        self.$ring_lines.write_address.next = self.smoothers.write_address.val();
        self.$ring_lines.x.next = self.scale_pair[$wide_ring].ring.val();
        self.$ring_rows.newest.next = self.scale_pair[$wide_ring].ring.val();
        self.$ring_rows.older.next = self.$ring_lines.y.val();
        )*
        $(
        self.ring_taps[$narrow_ring].clock.next = self.clock.val();
        self.ring_taps[$narrow_ring].reset.next = self.reset.val();
        self.ring_taps[$narrow_ring].advance.next = self.advance.val();
        self.ring_taps[$narrow_ring].rows.next = self.$narrow_lines.y.val();
        )*
        $(
        self.ring_taps[$wide_ring].clock.next = self.clock.val();
        self.ring_taps[$wide_ring].reset.next = self.reset.val();
        self.ring_taps[$wide_ring].advance.next = self.advance.val();
        self.ring_taps[$wide_ring].rows.next = self.$ring_rows.y.val();
        )*
        $(
        self.ring[$k].clock.next = self.clock.val();
        self.ring[$k].advance.next = self.advance.val();
        self.ring[$k].centre.next = self.queue.centre[$k].val();
        self.ring[$k].points.next = self.ring_taps[$k].points.val();
        )*

        comment!("Feature records and trailers.");
        self.writer.clock.next = self.clock.val();
        self.writer.reset.next = self.reset.val();
        self.writer.advance.next = self.advance.val();
        self.writer.found.next = self.queue.found.val();
        self.writer.candidate.next = self.queue.candidate.val();
        $(self.writer.maxlbp[$k].next = self.ring[$k].maxlbp.val();)*
        $(self.writer.sign[$k].next = self.ring[$k].sign.val();)*
        self.writer.lost.next = self.queue.dropped.val();
        self.writer.over_limit.next = self.record_limit.withheld.val();
        self.writer.frame_end.next = self.ring_cursor.last_row.val() & self.ring_cursor.last_column.val();
        self.writer.errors.next = self.errors.val();
        self.writer.take.next = self.ring_cursor.first_row.val() & self.ring_cursor.last_column.val();
        $(self.writer.threshold[$k].next = self.controller[$k].threshold.val();)*
        self.writer.room.next = self.room.val();
        for _flag in 0..PARITY {
            self.window_upset.next = $(self.scale_pair[$k].upset.val())|*;
            self.ring_upset.next =
                self.queue.upset.val() $(| self.$narrow_lines.upset.val())* $(| self.$ring_lines.upset.val())*;
            self.upset.next =
                self.bank_upset.val() | self.smoothers.upset.val() | self.window_upset.val() | self.ring_upset.val();
            self.writer.upset.next = self.upset.val();
        }
        self.write.next = self.writer.write.val() & self.advance.val();
        self.record.next = self.writer.record.val();
        self.done.next = self.writer.done.val() & self.advance.val();
        self.count.next = self.writer.count.val();
        self.dropped.next = self.writer.dropped.val();
        self.frames.next = self.writer.frames.val();
    }
}
    };
}

#[allow(unused_imports, reason = "constants of the pairs that the design has")]
use crate::design::{THRESHOLD_0_AT, THRESHOLD_1_AT, THRESHOLD_2_AT};

include!(concat!(env!("OUT_DIR"), "/extractor.rs"));

/// The lines of a ring that come from a line delay: all but the newest.
fn ring_lines(scale: usize) -> Vec<usize> {
    rows(scale).into_iter().map(|(line, _)| line).filter(|line| *line > 0).collect()
}
