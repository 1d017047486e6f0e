//! One scale pair: `DOG`, its 7x7 window and `MaxDOG`.

use hoverlock_design::pipeline::{MAX_DOG_RADIUS, MAX_DOG_STEPS, WINDOW_RADIUS, WINDOW_STEPS, window_maximum_steps};
use rust_hdl::prelude::*;

use crate::cells::{
    Address, FourNeighbours, Response, State,
    delay::{Delay, FlagDelay},
    difference::Difference,
    flag::Flag,
    join::{Neighbours, SignedResponse},
    line_delay::LineDelay,
    maximum::{ColumnMaximum, Maximum, WindowMaximum},
};
use crate::design::{DOG_BITS, PARITY, SIGNED_BITS, WINDOW_BITS};

/// Samples of a row of the window.
const WINDOW: usize = 2 * WINDOW_RADIUS as usize + 1;

/// Steps by which the maximum of a half row is earlier than that of a whole one.
const SAME_ROW_WAITS: usize =
    (window_maximum_steps(2 * WINDOW_RADIUS + 1) - window_maximum_steps(WINDOW_RADIUS)) as usize;

/// Difference, 7x7 window and MaxDOG of one scale pair.
#[derive(LogicBlock)]
pub struct ScalePair {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<In, Address>,
    /// Where a line memory with a register behind it is written.
    pub registered_write_address: Signal<In, Address>,
    /// Sample of the narrower smoother.
    pub narrow: Signal<In, State>,
    /// Sample of the wider smoother.
    pub wide: Signal<In, State>,
    /// `DOG_k` with its sign above it, two steps later.
    pub response: Signal<Out, Bits<SIGNED_BITS>>,
    /// A response was saturated.
    pub saturated: Signal<Out, Bit>,
    /// Maximum of the samples earlier in raster order, nine steps after the newest sample.
    pub strict: Signal<Out, Response>,
    /// Maximum of the samples later in raster order, valid with `strict`.
    pub loose: Signal<Out, Response>,
    /// The centre, valid with `strict`.
    pub p: Signal<Out, Bits<SIGNED_BITS>>,
    /// The centre one step later.
    pub centre: Signal<Out, Bits<SIGNED_BITS>>,
    /// Its four neighbours, valid with `centre`.
    pub neighbours: Signal<Out, FourNeighbours>,
    /// MaxDOG with the sign of its centre above it, two lines and ten steps later.
    pub ring: Signal<Out, Bits<SIGNED_BITS>>,
    /// A response with a flipped bit was read.
    pub upset: Flag<Out>,
    difference: Difference,
    signed_response: SignedResponse,
    lines: LineDelay<SIGNED_BITS, WINDOW_BITS>,
    column: ColumnMaximum,
    later: WindowMaximum,
    earlier: WindowMaximum,
    same_row: WindowMaximum,
    max_dog: WindowMaximum,
    preceding: Delay<DOG_BITS>,
    following: Delay<DOG_BITS>,
    strict_maximum: Maximum,
    loose_maximum: Maximum,
    right: Delay<SIGNED_BITS>,
    middle: Delay<SIGNED_BITS>,
    left: Delay<SIGNED_BITS>,
    upper: Delay<SIGNED_BITS>,
    lower: Delay<SIGNED_BITS>,
    around: Neighbours,
    sign: FlagDelay,
    ring_sample: SignedResponse,
}

impl Default for ScalePair {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            address: Signal::default(),
            registered_write_address: Signal::default(),
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
            upset: Default::default(),
            difference: Difference::default(),
            signed_response: SignedResponse::default(),
            lines: LineDelay::registered(&[1, 2, 3, 4, 5, 6]),
            column: ColumnMaximum::default(),
            later: WindowMaximum::new(WINDOW),
            earlier: WindowMaximum::new(WINDOW),
            same_row: WindowMaximum::new(WINDOW_RADIUS as usize),
            max_dog: WindowMaximum::new(2 * MAX_DOG_RADIUS as usize + 1),
            preceding: Delay::new(SAME_ROW_WAITS + WINDOW_RADIUS as usize + 1),
            following: Delay::new(SAME_ROW_WAITS),
            strict_maximum: Maximum::default(),
            loose_maximum: Maximum::default(),
            right: Delay::new(WINDOW_STEPS as usize),
            middle: Delay::new(1),
            left: Delay::new(1),
            upper: Delay::new(WINDOW_STEPS as usize + 1),
            lower: Delay::new(WINDOW_STEPS as usize + 1),
            around: Neighbours::default(),
            sign: FlagDelay::new(MAX_DOG_STEPS as usize),
            ring_sample: SignedResponse::default(),
        }
    }
}

impl Logic for ScalePair {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: scale_pair");
        self.difference.clock.next = self.clock.val();
        self.difference.advance.next = self.advance.val();
        self.difference.narrow.next = self.narrow.val();
        self.difference.wide.next = self.wide.val();
        self.saturated.next = self.difference.saturated.val();
        self.signed_response.magnitude.next = self.difference.magnitude.val();
        self.signed_response.positive.next = self.difference.positive.val();
        self.response.next = self.signed_response.y.val();

        comment!("Maxima of seven rows of one column, then their maxima along the row.");
        self.lines.clock.next = self.clock.val();
        self.lines.advance.next = self.advance.val();
        self.lines.address.next = self.address.val();
        self.lines.write_address.next = self.registered_write_address.val();
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

        comment!("Centre row: three samples before the centre, three after it.");
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

        comment!("The centre and its four neighbours.");
        self.right.clock.next = self.clock.val();
        self.right.reset.next = self.reset.val();
        self.right.advance.next = self.advance.val();
        self.right.x.next = self.lines.y.val().get_bits::<SIGNED_BITS>(2 * SIGNED_BITS);
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
        self.upper.x.next = self.lines.y.val().get_bits::<SIGNED_BITS>(3 * SIGNED_BITS);
        self.lower.clock.next = self.clock.val();
        self.lower.reset.next = self.reset.val();
        self.lower.advance.next = self.advance.val();
        self.lower.x.next = self.lines.y.val().get_bits::<SIGNED_BITS>(SIGNED_BITS);
        self.around.left.next = self.left.y.val();
        self.around.right.next = self.right.y.val();
        self.around.upper.next = self.upper.y.val();
        self.around.lower.next = self.lower.y.val();
        self.p.next = self.right.y.val();
        self.centre.next = self.middle.y.val();
        self.neighbours.next = self.around.y.val();

        comment!("MaxDOG and the sign at the centre of its window.");
        self.sign.clock.next = self.clock.val();
        self.sign.reset.next = self.reset.val();
        self.sign.advance.next = self.advance.val();
        self.sign.x.next = self.lines.y.val().get_bit(2 * SIGNED_BITS - 1);
        self.ring_sample.magnitude.next = self.max_dog.y.val();
        self.ring_sample.positive.next = self.sign.y.val();
        self.ring.next = self.ring_sample.y.val();
        for _flag in 0..PARITY {
            self.upset.next = self.lines.upset.val();
        }
    }
}
