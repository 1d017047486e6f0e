//! The datapath: pixels in, records out, nothing known of buses.
//!
//! | part | lines | steps |
//! |---|---|---|
//! | narrow and middle smoothers wait for the wide one | 32 | 44 |
//! | smoothers | 31, 31, 63 | 95, 95, 139 |
//! | difference | 0 | 2 |
//! | 7x7 window: centre decided | 3 | 11 |
//! | MaxDOG, on the way to the ring | 2 | 8 |
//! | ring complete at its centre | 18 | 24 |

use rust_hdl::prelude::*;

use crate::{
    cells::{
        Address, Height, Response, State, Width,
        address::AddressCounter,
        bank::Bank,
        decision::{Decision, Eligible, Threshold},
        delay::{Cursor, Delay, FlagDelay, FrameDelay},
        difference::Difference,
        join::{Neighbours, PixelState, RingRows, SignedResponse},
        line_delay::LineDelay,
        maximum::{ColumnMaximum, Maximum, WindowMaximum},
        queue::{CandidateQueue, CandidateWord, RecordWriter},
        ring::{RingComparator, RingTaps, rows},
    },
    smoother::{Smoother5, Smoother6},
};

/// The three smoothers, aligned.
#[derive(LogicBlock)]
pub struct Smoothers {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No frame is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// `W`.
    pub width: Signal<In, Width>,
    /// `H`.
    pub height: Signal<In, Height>,
    /// One step before the first pixel.
    pub start: Signal<In, Bit>,
    /// A pixel a step.
    pub pixel: Signal<In, Bits<16>>,
    /// What the frame takes with it, from its start on.
    pub frame_bank: Signal<In, Bits<368>>,
    /// The same, later, for the window stage.
    pub window_bank: Signal<Out, Bits<368>>,
    /// Counts steps modulo `W`.
    pub address: Signal<Out, Address>,
    /// One step before.
    pub address_1: Signal<Out, Address>,
    /// `G_0`.
    pub narrow: Signal<Out, State>,
    /// `G_1`.
    pub middle: Signal<Out, State>,
    /// `G_2`.
    pub wide: Signal<Out, State>,
    /// One step before their first samples.
    pub start_out: Signal<Out, Bit>,
    counter: AddressCounter,
    wait_lines: LineDelay<16, 16>,
    wait_one: Delay<16>,
    wait_two: Delay<16>,
    wait_start: FrameDelay,
    late_bank: Bank,
    rows_bank: Bank,
    late_state: PixelState,
    state: PixelState,
    narrow_smoother: Smoother5,
    middle_smoother: Smoother5,
    wide_smoother: Smoother6,
}

impl Default for Smoothers {
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
            window_bank: Signal::default(),
            address: Signal::default(),
            address_1: Signal::default(),
            narrow: Signal::default(),
            middle: Signal::default(),
            wide: Signal::default(),
            start_out: Signal::default(),
            counter: AddressCounter::default(),
            wait_lines: LineDelay::new(&[32]),
            wait_one: Delay::new(22),
            wait_two: Delay::new(22),
            wait_start: FrameDelay::new(32, 44),
            late_bank: Bank::default(),
            rows_bank: Bank::default(),
            late_state: PixelState::default(),
            state: PixelState::default(),
            narrow_smoother: Smoother5::default(),
            middle_smoother: Smoother5::default(),
            wide_smoother: Smoother6::default(),
        }
    }
}

impl Logic for Smoothers {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: smoothers");
        self.counter.clock.next = self.clock.val();
        self.counter.reset.next = self.reset.val();
        self.counter.advance.next = self.advance.val();
        self.counter.width.next = self.width.val();
        self.address.next = self.counter.now.val();
        self.address_1.next = self.counter.before_1.val();

        comment!("The wide smoother is 32 lines and 44 steps longer than the others, whose pixels wait for it.");
        self.wait_lines.clock.next = self.clock.val();
        self.wait_lines.advance.next = self.advance.val();
        self.wait_lines.address.next = self.counter.now.val();
        self.wait_lines.write_address.next = self.counter.before_1.val();
        self.wait_lines.x.next = self.pixel.val();
        self.wait_one.clock.next = self.clock.val();
        self.wait_one.reset.next = self.reset.val();
        self.wait_one.advance.next = self.advance.val();
        self.wait_one.x.next = self.wait_lines.y.val();
        self.wait_two.clock.next = self.clock.val();
        self.wait_two.reset.next = self.reset.val();
        self.wait_two.advance.next = self.advance.val();
        self.wait_two.x.next = self.wait_one.y.val();
        self.wait_start.clock.next = self.clock.val();
        self.wait_start.reset.next = self.reset.val();
        self.wait_start.advance.next = self.advance.val();
        self.wait_start.width.next = self.width.val();
        self.wait_start.x.next = self.start.val();
        self.late_state.x.next = self.wait_two.y.val();
        self.state.x.next = self.pixel.val();

        comment!("Coefficients: of the frame for the wide columns, then for the other columns, then for all rows.");
        self.late_bank.clock.next = self.clock.val();
        self.late_bank.load.next = self.wait_start.y.val();
        self.late_bank.d.next = self.frame_bank.val();
        self.rows_bank.clock.next = self.clock.val();
        self.rows_bank.load.next = self.wide_smoother.columns_done.val();
        self.rows_bank.d.next = self.frame_bank.val();
        self.window_bank.next = self.rows_bank.q.val();

        self.narrow_smoother.clock.next = self.clock.val();
        self.narrow_smoother.reset.next = self.reset.val();
        self.narrow_smoother.advance.next = self.advance.val();
        self.narrow_smoother.width.next = self.width.val();
        self.narrow_smoother.height.next = self.height.val();
        self.narrow_smoother.address.next = self.counter.now.val();
        self.narrow_smoother.address_1.next = self.counter.before_1.val();
        self.narrow_smoother.address_4.next = self.counter.before_4.val();
        self.narrow_smoother.address_5.next = self.counter.before_5.val();
        self.narrow_smoother.address_8.next = self.counter.before_8.val();
        self.narrow_smoother.address_12.next = self.counter.before_12.val();
        self.narrow_smoother.address_16.next = self.counter.before_16.val();
        self.narrow_smoother.address_20.next = self.counter.before_20.val();
        self.narrow_smoother.start.next = self.wait_start.y.val();
        self.narrow_smoother.x.next = self.late_state.y.val();
        self.narrow_smoother.g.next = self.late_bank.q.val().get_bits::<16>(0);
        self.narrow_smoother.column_g[0].next = self.late_bank.q.val().get_bits::<16>(16);
        self.narrow_smoother.row_g[0].next = self.rows_bank.q.val().get_bits::<16>(16);
        self.narrow_smoother.column_g[1].next = self.late_bank.q.val().get_bits::<16>(32);
        self.narrow_smoother.row_g[1].next = self.rows_bank.q.val().get_bits::<16>(32);
        self.narrow_smoother.column_g[2].next = self.late_bank.q.val().get_bits::<16>(48);
        self.narrow_smoother.row_g[2].next = self.rows_bank.q.val().get_bits::<16>(48);
        self.narrow_smoother.column_g[3].next = self.late_bank.q.val().get_bits::<16>(64);
        self.narrow_smoother.row_g[3].next = self.rows_bank.q.val().get_bits::<16>(64);
        self.narrow_smoother.column_g[4].next = self.late_bank.q.val().get_bits::<16>(80);
        self.narrow_smoother.row_g[4].next = self.rows_bank.q.val().get_bits::<16>(80);

        self.middle_smoother.clock.next = self.clock.val();
        self.middle_smoother.reset.next = self.reset.val();
        self.middle_smoother.advance.next = self.advance.val();
        self.middle_smoother.width.next = self.width.val();
        self.middle_smoother.height.next = self.height.val();
        self.middle_smoother.address.next = self.counter.now.val();
        self.middle_smoother.address_1.next = self.counter.before_1.val();
        self.middle_smoother.address_4.next = self.counter.before_4.val();
        self.middle_smoother.address_5.next = self.counter.before_5.val();
        self.middle_smoother.address_8.next = self.counter.before_8.val();
        self.middle_smoother.address_12.next = self.counter.before_12.val();
        self.middle_smoother.address_16.next = self.counter.before_16.val();
        self.middle_smoother.address_20.next = self.counter.before_20.val();
        self.middle_smoother.start.next = self.wait_start.y.val();
        self.middle_smoother.x.next = self.late_state.y.val();
        self.middle_smoother.g.next = self.late_bank.q.val().get_bits::<16>(96);
        self.middle_smoother.column_g[0].next = self.late_bank.q.val().get_bits::<16>(112);
        self.middle_smoother.row_g[0].next = self.rows_bank.q.val().get_bits::<16>(112);
        self.middle_smoother.column_g[1].next = self.late_bank.q.val().get_bits::<16>(128);
        self.middle_smoother.row_g[1].next = self.rows_bank.q.val().get_bits::<16>(128);
        self.middle_smoother.column_g[2].next = self.late_bank.q.val().get_bits::<16>(144);
        self.middle_smoother.row_g[2].next = self.rows_bank.q.val().get_bits::<16>(144);
        self.middle_smoother.column_g[3].next = self.late_bank.q.val().get_bits::<16>(160);
        self.middle_smoother.row_g[3].next = self.rows_bank.q.val().get_bits::<16>(160);
        self.middle_smoother.column_g[4].next = self.late_bank.q.val().get_bits::<16>(176);
        self.middle_smoother.row_g[4].next = self.rows_bank.q.val().get_bits::<16>(176);

        self.wide_smoother.clock.next = self.clock.val();
        self.wide_smoother.reset.next = self.reset.val();
        self.wide_smoother.advance.next = self.advance.val();
        self.wide_smoother.width.next = self.width.val();
        self.wide_smoother.height.next = self.height.val();
        self.wide_smoother.address.next = self.counter.now.val();
        self.wide_smoother.address_1.next = self.counter.before_1.val();
        self.wide_smoother.address_4.next = self.counter.before_4.val();
        self.wide_smoother.address_5.next = self.counter.before_5.val();
        self.wide_smoother.address_8.next = self.counter.before_8.val();
        self.wide_smoother.address_12.next = self.counter.before_12.val();
        self.wide_smoother.address_16.next = self.counter.before_16.val();
        self.wide_smoother.address_20.next = self.counter.before_20.val();
        self.wide_smoother.start.next = self.start.val();
        self.wide_smoother.x.next = self.state.y.val();
        self.wide_smoother.g.next = self.frame_bank.val().get_bits::<16>(192);
        self.wide_smoother.column_g[0].next = self.frame_bank.val().get_bits::<16>(208);
        self.wide_smoother.row_g[0].next = self.rows_bank.q.val().get_bits::<16>(208);
        self.wide_smoother.column_g[1].next = self.frame_bank.val().get_bits::<16>(224);
        self.wide_smoother.row_g[1].next = self.rows_bank.q.val().get_bits::<16>(224);
        self.wide_smoother.column_g[2].next = self.frame_bank.val().get_bits::<16>(240);
        self.wide_smoother.row_g[2].next = self.rows_bank.q.val().get_bits::<16>(240);
        self.wide_smoother.column_g[3].next = self.frame_bank.val().get_bits::<16>(256);
        self.wide_smoother.row_g[3].next = self.rows_bank.q.val().get_bits::<16>(256);
        self.wide_smoother.column_g[4].next = self.frame_bank.val().get_bits::<16>(272);
        self.wide_smoother.row_g[4].next = self.rows_bank.q.val().get_bits::<16>(272);
        self.wide_smoother.column_g[5].next = self.frame_bank.val().get_bits::<16>(288);
        self.wide_smoother.row_g[5].next = self.rows_bank.q.val().get_bits::<16>(288);

        self.narrow.next = self.narrow_smoother.y.val();
        self.middle.next = self.middle_smoother.y.val();
        self.wide.next = self.wide_smoother.y.val();
        self.start_out.next = self.wide_smoother.start_out.val();
    }
}

/// One scale pair: difference, 7x7 window and MaxDOG.
#[derive(LogicBlock)]
pub struct Layer {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No frame is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// Counts steps modulo `W`.
    pub address: Signal<In, Address>,
    /// One step before.
    pub address_1: Signal<In, Address>,
    /// The narrower smoother.
    pub narrow: Signal<In, State>,
    /// The wider one.
    pub wide: Signal<In, State>,
    /// `DOG_k` with its sign above it, two steps later.
    pub response: Signal<Out, Bits<16>>,
    /// A response was cut.
    pub saturated: Signal<Out, Bit>,
    /// The maximum of what comes earlier in the window, nine steps after the newest sample.
    pub strict: Signal<Out, Response>,
    /// The maximum of what comes later, together with it.
    pub loose: Signal<Out, Response>,
    /// The centre, together with them.
    pub p: Signal<Out, Bits<16>>,
    /// The centre one step later.
    pub centre: Signal<Out, Bits<16>>,
    /// Its neighbours, together with it.
    pub neighbours: Signal<Out, Bits<60>>,
    /// MaxDOG with the sign at its own centre, two lines and ten steps later.
    pub ring: Signal<Out, Bits<16>>,
    difference: Difference,
    signed_response: SignedResponse,
    lines: LineDelay<16, 96>,
    column: ColumnMaximum,
    later: WindowMaximum,
    earlier: WindowMaximum,
    same_row: WindowMaximum,
    max_dog: WindowMaximum,
    preceding: Delay<15>,
    following: Delay<15>,
    strict_maximum: Maximum,
    loose_maximum: Maximum,
    right: Delay<16>,
    middle: Delay<16>,
    left: Delay<16>,
    upper: Delay<16>,
    lower: Delay<16>,
    around: Neighbours,
    sign: FlagDelay,
    ring_word: SignedResponse,
}

impl Default for Layer {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            address: Signal::default(),
            address_1: Signal::default(),
            narrow: Signal::default(),
            wide: Signal::default(),
            response: Signal::default(),
            saturated: Signal::default(),
            strict: Signal::default(),
            loose: Signal::default(),
            p: Signal::default(),
            centre: Signal::default(),
            neighbours: Signal::default(),
            ring: Signal::default(),
            difference: Difference::default(),
            signed_response: SignedResponse::default(),
            lines: LineDelay::new(&[1, 2, 3, 4, 5, 6]),
            column: ColumnMaximum::default(),
            later: WindowMaximum::new(7),
            earlier: WindowMaximum::new(7),
            same_row: WindowMaximum::new(3),
            max_dog: WindowMaximum::new(5),
            preceding: Delay::new(5),
            following: Delay::new(1),
            strict_maximum: Maximum::default(),
            loose_maximum: Maximum::default(),
            right: Delay::new(10),
            middle: Delay::new(1),
            left: Delay::new(1),
            upper: Delay::new(11),
            lower: Delay::new(11),
            around: Neighbours::default(),
            sign: FlagDelay::new(8),
            ring_word: SignedResponse::default(),
        }
    }
}

impl Logic for Layer {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: layer");
        self.difference.clock.next = self.clock.val();
        self.difference.advance.next = self.advance.val();
        self.difference.narrow.next = self.narrow.val();
        self.difference.wide.next = self.wide.val();
        self.saturated.next = self.difference.saturated.val();
        self.signed_response.magnitude.next = self.difference.magnitude.val();
        self.signed_response.positive.next = self.difference.positive.val();
        self.response.next = self.signed_response.y.val();

        comment!("Seven rows of one column, their maxima, and the maxima of those along the rows.");
        self.lines.clock.next = self.clock.val();
        self.lines.advance.next = self.advance.val();
        self.lines.address.next = self.address.val();
        self.lines.write_address.next = self.address_1.val();
        self.lines.x.next = self.signed_response.y.val();
        self.column.clock.next = self.clock.val();
        self.column.advance.next = self.advance.val();
        self.column.newest.next = self.difference.magnitude.val();
        self.column.older.next = self.lines.y.val();
        self.later.clock.next = self.clock.val();
        self.later.advance.next = self.advance.val();
        self.later.x.next = self.column.later.val();
        self.earlier.clock.next = self.clock.val();
        self.earlier.advance.next = self.advance.val();
        self.earlier.x.next = self.column.earlier.val();
        self.same_row.clock.next = self.clock.val();
        self.same_row.advance.next = self.advance.val();
        self.same_row.x.next = self.column.middle.val();
        self.max_dog.clock.next = self.clock.val();
        self.max_dog.advance.next = self.advance.val();
        self.max_dog.x.next = self.column.five.val();

        comment!("In the centre row: three before the centre, three after it.");
        self.preceding.clock.next = self.clock.val();
        self.preceding.reset.next = self.reset.val();
        self.preceding.advance.next = self.advance.val();
        self.preceding.x.next = self.same_row.y.val();
        self.following.clock.next = self.clock.val();
        self.following.reset.next = self.reset.val();
        self.following.advance.next = self.advance.val();
        self.following.x.next = self.same_row.y.val();
        self.strict_maximum.clock.next = self.clock.val();
        self.strict_maximum.advance.next = self.advance.val();
        self.strict_maximum.a.next = self.earlier.y.val();
        self.strict_maximum.b.next = self.preceding.y.val();
        self.loose_maximum.clock.next = self.clock.val();
        self.loose_maximum.advance.next = self.advance.val();
        self.loose_maximum.a.next = self.later.y.val();
        self.loose_maximum.b.next = self.following.y.val();
        self.strict.next = self.strict_maximum.y.val();
        self.loose.next = self.loose_maximum.y.val();

        comment!("The centre and its neighbours.");
        self.right.clock.next = self.clock.val();
        self.right.reset.next = self.reset.val();
        self.right.advance.next = self.advance.val();
        self.right.x.next = self.lines.y.val().get_bits::<16>(32);
        self.middle.clock.next = self.clock.val();
        self.middle.reset.next = self.reset.val();
        self.middle.advance.next = self.advance.val();
        self.middle.x.next = self.right.y.val();
        self.left.clock.next = self.clock.val();
        self.left.reset.next = self.reset.val();
        self.left.advance.next = self.advance.val();
        self.left.x.next = self.middle.y.val();
        self.upper.clock.next = self.clock.val();
        self.upper.reset.next = self.reset.val();
        self.upper.advance.next = self.advance.val();
        self.upper.x.next = self.lines.y.val().get_bits::<16>(48);
        self.lower.clock.next = self.clock.val();
        self.lower.reset.next = self.reset.val();
        self.lower.advance.next = self.advance.val();
        self.lower.x.next = self.lines.y.val().get_bits::<16>(16);
        self.around.left.next = self.left.y.val();
        self.around.right.next = self.right.y.val();
        self.around.up.next = self.upper.y.val();
        self.around.down.next = self.lower.y.val();
        self.p.next = self.right.y.val();
        self.centre.next = self.middle.y.val();
        self.neighbours.next = self.around.y.val();

        comment!("MaxDOG and the sign at the centre of its window.");
        self.sign.clock.next = self.clock.val();
        self.sign.reset.next = self.reset.val();
        self.sign.advance.next = self.advance.val();
        self.sign.x.next = self.lines.y.val().get_bit(31);
        self.ring_word.magnitude.next = self.max_dog.y.val();
        self.ring_word.positive.next = self.sign.y.val();
        self.ring.next = self.ring_word.y.val();
    }
}

/// From pixels to records.
#[derive(LogicBlock)]
pub struct Extractor {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No frame is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// `W`.
    pub width: Signal<In, Width>,
    /// `H`.
    pub height: Signal<In, Height>,
    /// The pixel is a frame's first.
    pub start: Signal<In, Bit>,
    /// A pixel a step.
    pub pixel: Signal<In, Bits<16>>,
    /// What the frame takes with it.
    pub frame_bank: Signal<In, Bits<368>>,
    /// Its errors at the input, when its last record is due.
    pub errors: Signal<In, Bits<4>>,
    /// The FIFO has room for features.
    pub room: Signal<In, Bit>,
    /// Write `record` with this step.
    pub write: Signal<Out, Bit>,
    /// A record.
    pub record: Signal<Out, Bits<256>>,
    /// A frame is done.
    pub done: Signal<Out, Bit>,
    /// Features of the frame that were written.
    pub count: Signal<Out, Bits<20>>,
    /// That were dropped.
    pub dropped: Signal<Out, Bits<20>>,
    /// Frames done.
    pub frames: Signal<Out, Bits<32>>,
    /// A response was cut.
    pub saturated: Signal<Out, Bit>,
    /// `T_0` in use.
    pub threshold_0: Signal<Out, Response>,
    /// `T_1` in use.
    pub threshold_1: Signal<Out, Response>,
    pixels: Delay<16>,
    smoothers: Smoothers,
    response_start: FlagDelay,
    response_cursor: Cursor,
    layer_0: Layer,
    layer_1: Layer,
    window_start: FrameDelay,
    window_cursor: Cursor,
    eligible: Eligible,
    decision_0: Decision,
    decision_1: Decision,
    level_0: Threshold,
    level_1: Threshold,
    candidate: CandidateWord,
    ring_start: FrameDelay,
    ring_cursor: Cursor,
    queue: CandidateQueue,
    ring_lines_0: LineDelay<16, 240>,
    ring_lines_1: LineDelay<16, 224>,
    ring_rows_1: RingRows,
    ring_taps_0: RingTaps<240>,
    ring_taps_1: RingTaps<240>,
    ring_0: RingComparator,
    ring_1: RingComparator,
    writer: RecordWriter,
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
            write: Signal::default(),
            record: Signal::default(),
            done: Signal::default(),
            count: Signal::default(),
            dropped: Signal::default(),
            frames: Signal::default(),
            saturated: Signal::default(),
            threshold_0: Signal::default(),
            threshold_1: Signal::default(),
            pixels: Delay::new(1),
            smoothers: Smoothers::default(),
            response_start: FlagDelay::new(2),
            response_cursor: Cursor::default(),
            layer_0: Layer::default(),
            layer_1: Layer::default(),
            window_start: FrameDelay::new(3, 10),
            window_cursor: Cursor::default(),
            eligible: Eligible::default(),
            decision_0: Decision::default(),
            decision_1: Decision::default(),
            level_0: Threshold::default(),
            level_1: Threshold::default(),
            candidate: CandidateWord::default(),
            ring_start: FrameDelay::new(15, 13),
            ring_cursor: Cursor::default(),
            queue: CandidateQueue::default(),
            ring_lines_0: LineDelay::new(&ring_lines(0)),
            ring_lines_1: LineDelay::new(&ring_lines(1)),
            ring_rows_1: RingRows::default(),
            ring_taps_0: RingTaps::new(0),
            ring_taps_1: RingTaps::new(1),
            ring_0: RingComparator::default(),
            ring_1: RingComparator::default(),
            writer: RecordWriter::default(),
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
        self.layer_0.clock.next = self.clock.val();
        self.layer_0.reset.next = self.reset.val();
        self.layer_0.advance.next = self.advance.val();
        self.layer_0.address.next = self.smoothers.address.val();
        self.layer_0.address_1.next = self.smoothers.address_1.val();
        self.layer_0.narrow.next = self.smoothers.narrow.val();
        self.layer_0.wide.next = self.smoothers.middle.val();
        self.layer_1.clock.next = self.clock.val();
        self.layer_1.reset.next = self.reset.val();
        self.layer_1.advance.next = self.advance.val();
        self.layer_1.address.next = self.smoothers.address.val();
        self.layer_1.address_1.next = self.smoothers.address_1.val();
        self.layer_1.narrow.next = self.smoothers.middle.val();
        self.layer_1.wide.next = self.smoothers.wide.val();
        comment!("What is not of a frame may be anything.");
        self.response_cursor.clock.next = self.clock.val();
        self.response_cursor.reset.next = self.reset.val();
        self.response_cursor.advance.next = self.advance.val();
        self.response_cursor.width.next = self.width.val();
        self.response_cursor.height.next = self.height.val();
        self.response_cursor.start.next = self.response_start.y.val();
        self.saturated.next =
            (self.layer_0.saturated.val() | self.layer_1.saturated.val()) & self.response_cursor.active.val();

        comment!("The window: what is a feature.");
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
        self.decision_0.clock.next = self.clock.val();
        self.decision_0.reset.next = self.reset.val();
        self.decision_0.advance.next = self.advance.val();
        self.decision_0.eligible.next = self.eligible.eligible.val();
        self.decision_0.p.next = self.layer_0.p.val().get_bits::<15>(0);
        self.decision_0.strict.next = self.layer_0.strict.val();
        self.decision_0.loose.next = self.layer_0.loose.val();
        self.decision_0.threshold.next = self.level_0.threshold.val();
        self.level_0.clock.next = self.clock.val();
        self.level_0.reset.next = self.reset.val();
        self.level_0.advance.next = self.advance.val();
        self.level_0.start.next = self.window_start.y.val();
        self.level_0.hit.next = self.decision_0.hit.val();
        self.level_0.manual.next = self.smoothers.window_bank.val().get_bits::<15>(304);
        self.level_0.target.next = self.smoothers.window_bank.val().get_bits::<16>(336);
        self.level_0.follow.next = self.smoothers.window_bank.val().get_bit(352);
        self.threshold_0.next = self.level_0.threshold.val();
        self.decision_1.clock.next = self.clock.val();
        self.decision_1.reset.next = self.reset.val();
        self.decision_1.advance.next = self.advance.val();
        self.decision_1.eligible.next = self.eligible.eligible.val();
        self.decision_1.p.next = self.layer_1.p.val().get_bits::<15>(0);
        self.decision_1.strict.next = self.layer_1.strict.val();
        self.decision_1.loose.next = self.layer_1.loose.val();
        self.decision_1.threshold.next = self.level_1.threshold.val();
        self.level_1.clock.next = self.clock.val();
        self.level_1.reset.next = self.reset.val();
        self.level_1.advance.next = self.advance.val();
        self.level_1.start.next = self.window_start.y.val();
        self.level_1.hit.next = self.decision_1.hit.val();
        self.level_1.manual.next = self.smoothers.window_bank.val().get_bits::<15>(320);
        self.level_1.target.next = self.smoothers.window_bank.val().get_bits::<16>(336);
        self.level_1.follow.next = self.smoothers.window_bank.val().get_bit(352);
        self.threshold_1.next = self.level_1.threshold.val();

        comment!("A candidate waits until its ring is complete.");
        self.candidate.place.next = self.eligible.place.val();
        self.candidate.hit_0.next = self.decision_0.hit.val();
        self.candidate.hit_1.next = self.decision_1.hit.val();
        self.candidate.centre_0.next = self.layer_0.centre.val();
        self.candidate.centre_1.next = self.layer_1.centre.val();
        self.candidate.neighbours_0.next = self.layer_0.neighbours.val();
        self.candidate.neighbours_1.next = self.layer_1.neighbours.val();
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

        comment!("The ring: what a feature looks like.");
        self.ring_lines_0.clock.next = self.clock.val();
        self.ring_lines_0.advance.next = self.advance.val();
        self.ring_lines_0.address.next = self.smoothers.address.val();
        self.ring_lines_0.write_address.next = self.smoothers.address_1.val();
        self.ring_lines_0.x.next = self.layer_0.ring.val();
        self.ring_lines_1.clock.next = self.clock.val();
        self.ring_lines_1.advance.next = self.advance.val();
        self.ring_lines_1.address.next = self.smoothers.address.val();
        self.ring_lines_1.write_address.next = self.smoothers.address_1.val();
        self.ring_lines_1.x.next = self.layer_1.ring.val();
        self.ring_rows_1.newest.next = self.layer_1.ring.val();
        self.ring_rows_1.older.next = self.ring_lines_1.y.val();
        self.ring_taps_0.clock.next = self.clock.val();
        self.ring_taps_0.reset.next = self.reset.val();
        self.ring_taps_0.advance.next = self.advance.val();
        self.ring_taps_0.rows.next = self.ring_lines_0.y.val();
        self.ring_taps_1.clock.next = self.clock.val();
        self.ring_taps_1.reset.next = self.reset.val();
        self.ring_taps_1.advance.next = self.advance.val();
        self.ring_taps_1.rows.next = self.ring_rows_1.y.val();
        self.ring_0.clock.next = self.clock.val();
        self.ring_0.advance.next = self.advance.val();
        self.ring_0.centre.next = self.queue.centre_0.val();
        self.ring_0.points.next = self.ring_taps_0.points.val();
        self.ring_1.clock.next = self.clock.val();
        self.ring_1.advance.next = self.advance.val();
        self.ring_1.centre.next = self.queue.centre_1.val();
        self.ring_1.points.next = self.ring_taps_1.points.val();

        comment!("Records.");
        self.writer.clock.next = self.clock.val();
        self.writer.reset.next = self.reset.val();
        self.writer.advance.next = self.advance.val();
        self.writer.found.next = self.queue.found.val();
        self.writer.candidate.next = self.queue.candidate.val();
        self.writer.maxlbp_0.next = self.ring_0.maxlbp.val();
        self.writer.maxlbp_1.next = self.ring_1.maxlbp.val();
        self.writer.sign_0.next = self.ring_0.sign.val();
        self.writer.sign_1.next = self.ring_1.sign.val();
        self.writer.lost.next = self.queue.dropped.val();
        self.writer.frame_end.next = self.ring_cursor.last_row.val() & self.ring_cursor.last_column.val();
        self.writer.errors.next = self.errors.val();
        self.writer.take.next = self.ring_cursor.first_row.val() & self.ring_cursor.last_column.val();
        self.writer.threshold_0.next = self.level_0.threshold.val();
        self.writer.threshold_1.next = self.level_1.threshold.val();
        self.writer.room.next = self.room.val();
        self.write.next = self.writer.write.val() & self.advance.val();
        self.record.next = self.writer.record.val();
        self.done.next = self.writer.done.val() & self.advance.val();
        self.count.next = self.writer.count.val();
        self.dropped.next = self.writer.dropped.val();
        self.frames.next = self.writer.frames.val();
    }
}

/// The lines of a ring that a line delay holds: all but the newest.
fn ring_lines(scale: usize) -> Vec<usize> {
    rows(scale).into_iter().map(|(line, _)| line).filter(|line| *line > 0).collect()
}
