//! One two-sided smoother: `s[r] = s[r-1] + g (x[r] - s[r-1])` down the columns, `m` look-ahead stages up them, then `m` stages
//! towards the past and `m` towards the future along the rows. Every cell is a lerp.
//!
//! | part | steps | lines |
//! |---|---|---|
//! | recursion | 4 | 0 |
//! | column stage `j` | 4 | `2^j` |
//! | row stage `j`, past | 4 | 0 |
//! | row stage `j`, future | `4 + 2^j` | 0 |
//!
//! Together `2^m - 1` lines and `4 + 12 m + 2^m - 1` steps. Markers run one step before the sample they belong to, so that what
//! they start is there with the sample.

pub mod stages;

use rust_hdl::prelude::*;

use self::stages::{ColumnStage, LookAheadStage, LookBackStage};
use crate::cells::{
    Address, Code, Height, State, Width,
    border::{CoefficientRegister, ColumnBorder},
    delay::{Cursor, FlagDelay, PulseDelay},
    lerp::Lerp,
    line_delay::LineDelay,
    tail::{HeldRow, TailCounter},
};

/// Steps of one cell with its border.
pub const CELL_STEPS: u64 = 4;

/// Steps of a smoother beside its lines.
pub const fn steps(look_ahead: u64) -> u64 {
    CELL_STEPS + 3 * CELL_STEPS * look_ahead + (1 << look_ahead) - 1
}

// The transpiler does not know constants of a type: each length is a type of its own.
macro_rules! smoother {
    ($smoother:ident, $m:tt, $tag:tt) => {
        #[doc = concat!("A whole smoother of look-ahead ", $m, ".")]
        #[derive(LogicBlock)]
        pub struct $smoother {
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
            /// Counts steps modulo `W`.
            pub address: Signal<In, Address>,
            /// One step before.
            pub address_1: Signal<In, Address>,
            /// Four steps before.
            pub address_4: Signal<In, Address>,
            /// Five steps before.
            pub address_5: Signal<In, Address>,
            /// Eight steps before.
            pub address_8: Signal<In, Address>,
            /// Twelve steps before.
            pub address_12: Signal<In, Address>,
            /// Sixteen steps before.
            pub address_16: Signal<In, Address>,
            /// Twenty steps before.
            pub address_20: Signal<In, Address>,
            /// One step before the frame's first sample.
            pub start: Signal<In, Bit>,
            /// A sample a step.
            pub x: Signal<In, State>,
            /// `g` of the recursion, with the frame's first sample.
            pub g: Signal<In, Code>,
            /// `g_j` for the columns, as long as the frame needs them.
            pub column_g: [Signal<In, Code>; $m],
            /// `g_j` for the rows, as long as the frame needs them.
            pub row_g: [Signal<In, Code>; $m],
            /// One step before the frame leaves the columns.
            pub columns_done: Signal<Out, Bit>,
            /// The smoothed sample.
            pub y: Signal<Out, State>,
            /// One step before the smoothed frame's first sample.
            pub start_out: Signal<Out, Bit>,
            cursor: Cursor,
            recursion_load: FlagDelay,
            recursion_coefficient: CoefficientRegister,
            recursion_memory: LineDelay<18, 18>,
            recursion_border: ColumnBorder,
            recursion: Lerp,
            last_row: FlagDelay,
            tail_start: FlagDelay,
            tail: TailCounter,
            held: HeldRow,
            column: [ColumnStage; $m],
            column_start: FlagDelay,
            row_cursor: Cursor,
            row_load: FlagDelay,
            back: [LookBackStage; $m],
            row_end: PulseDelay,
            ahead: [LookAheadStage; $m],
            row_start: FlagDelay,
        }

        impl $smoother {
            /// A smoother; only its length is fixed, its coefficients come with each frame.
            pub fn new() -> Self {
                Self {
                    clock: Signal::default(),
                    reset: Signal::default(),
                    advance: Signal::default(),
                    width: Signal::default(),
                    height: Signal::default(),
                    address: Signal::default(),
                    address_1: Signal::default(),
                    address_4: Signal::default(),
                    address_5: Signal::default(),
                    address_8: Signal::default(),
                    address_12: Signal::default(),
                    address_16: Signal::default(),
                    address_20: Signal::default(),
                    start: Signal::default(),
                    x: Signal::default(),
                    g: Signal::default(),
                    column_g: std::array::from_fn(|_| Signal::default()),
                    row_g: std::array::from_fn(|_| Signal::default()),
                    columns_done: Signal::default(),
                    y: Signal::default(),
                    start_out: Signal::default(),
                    cursor: Cursor::default(),
                    recursion_load: FlagDelay::new(2),
                    recursion_coefficient: CoefficientRegister::default(),
                    recursion_memory: LineDelay::new(&[1]),
                    recursion_border: ColumnBorder::default(),
                    recursion: Lerp::default(),
                    last_row: FlagDelay::new(4),
                    tail_start: FlagDelay::new(2),
                    tail: TailCounter::default(),
                    held: HeldRow::default(),
                    column: std::array::from_fn(|stage| ColumnStage::new(stage as u32)),
                    column_start: FlagDelay::new(2),
                    row_cursor: Cursor::default(),
                    row_load: FlagDelay::new(2),
                    back: std::array::from_fn(|stage| LookBackStage::new(stage as u32)),
                    row_end: PulseDelay::new(CELL_STEPS * $m as u64),
                    ahead: std::array::from_fn(|stage| LookAheadStage::new(stage as u32)),
                    row_start: FlagDelay::new(2),
                }
            }
        }

        impl Default for $smoother {
            fn default() -> Self {
                Self::new()
            }
        }

        impl Logic for $smoother {
            #[hdl_gen]
            fn update(&mut self) {
                comment!($tag);
                comment!("Down the columns: the recursion, its state one line later through a memory.");
                self.cursor.clock.next = self.clock.val();
                self.cursor.reset.next = self.reset.val();
                self.cursor.advance.next = self.advance.val();
                self.cursor.width.next = self.width.val();
                self.cursor.height.next = self.height.val();
                self.cursor.start.next = self.start.val();

                self.recursion_load.clock.next = self.clock.val();
                self.recursion_load.reset.next = self.reset.val();
                self.recursion_load.advance.next = self.advance.val();
                self.recursion_load.x.next = self.start.val();

                self.recursion_coefficient.clock.next = self.clock.val();
                self.recursion_coefficient.advance.next = self.advance.val();
                self.recursion_coefficient.load.next = self.recursion_load.y.val();
                self.recursion_coefficient.d.next = self.g.val();

                self.recursion_memory.clock.next = self.clock.val();
                self.recursion_memory.advance.next = self.advance.val();
                self.recursion_memory.address.next = self.address.val();
                self.recursion_memory.write_address.next = self.address_5.val();
                self.recursion_memory.x.next = self.recursion.y.val();

                self.recursion_border.clock.next = self.clock.val();
                self.recursion_border.advance.next = self.advance.val();
                self.recursion_border.x.next = self.x.val();
                self.recursion_border.neighbour.next = self.recursion_memory.y.val();
                self.recursion_border.border.next = self.x.val();
                self.recursion_border.outside.next = self.cursor.first_row.val();

                self.recursion.clock.next = self.clock.val();
                self.recursion.advance.next = self.advance.val();
                self.recursion.p.next = self.recursion_border.p.val();
                self.recursion.q.next = self.recursion_border.q.val();
                self.recursion.g.next = self.recursion_coefficient.g.val();

                comment!("The last row is held for the stages below.");
                self.last_row.clock.next = self.clock.val();
                self.last_row.reset.next = self.reset.val();
                self.last_row.advance.next = self.advance.val();
                self.last_row.x.next = self.cursor.last_row.val();

                self.tail_start.clock.next = self.clock.val();
                self.tail_start.reset.next = self.reset.val();
                self.tail_start.advance.next = self.advance.val();
                self.tail_start.x.next = self.cursor.last_row.val() & self.cursor.first_column.val();

                self.tail.clock.next = self.clock.val();
                self.tail.reset.next = self.reset.val();
                self.tail.advance.next = self.advance.val();
                self.tail.width.next = self.width.val();
                self.tail.start.next = self.tail_start.y.val();

                self.held.clock.next = self.clock.val();
                self.held.advance.next = self.advance.val();
                self.held.write.next = self.last_row.y.val();
                self.held.write_address.next = self.address_1.val();
                self.held.x.next = self.recursion.y.val();
                self.held.select.next = self.tail.select.val();
                self.held.address_0.next = self.address.val();
                self.held.address_1.next = self.address_4.val();
                self.held.address_2.next = self.address_8.val();
                self.held.address_3.next = self.address_12.val();
                self.held.address_4.next = self.address_16.val();
                self.held.address_5.next = self.address_20.val();

                comment!("Up the columns: stage j leans on the row 2^j lines later.");
                for j in 0..$m {
                    self.column[j].clock.next = self.clock.val();
                    self.column[j].reset.next = self.reset.val();
                    self.column[j].advance.next = self.advance.val();
                    self.column[j].width.next = self.width.val();
                    self.column[j].address.next = self.address.val();
                    self.column[j].write_address.next = self.address_1.val();
                    self.column[j].held.next = self.held.y.val();
                    self.column[j].outside.next = self.tail.outside.val().get_bit(j);
                    self.column[j].g.next = self.column_g[j].val();
                }
                self.column[0].x.next = self.recursion.y.val();
                self.column[0].load.next = self.recursion_load.y.val();
                for j in 1..$m {
                    self.column[j].x.next = self.column[j - 1].y.val();
                    self.column[j].load.next = self.column[j - 1].loads.val();
                }

                self.column_start.clock.next = self.clock.val();
                self.column_start.reset.next = self.reset.val();
                self.column_start.advance.next = self.advance.val();
                self.column_start.x.next = self.column[$m - 1].loads.val();
                self.columns_done.next = self.column_start.y.val();

                comment!("Along the rows: first towards the past, then towards the future.");
                self.row_cursor.clock.next = self.clock.val();
                self.row_cursor.reset.next = self.reset.val();
                self.row_cursor.advance.next = self.advance.val();
                self.row_cursor.width.next = self.width.val();
                self.row_cursor.height.next = self.height.val();
                self.row_cursor.start.next = self.column_start.y.val();

                self.row_load.clock.next = self.clock.val();
                self.row_load.reset.next = self.reset.val();
                self.row_load.advance.next = self.advance.val();
                self.row_load.x.next = self.column_start.y.val();

                for j in 0..$m {
                    self.back[j].clock.next = self.clock.val();
                    self.back[j].reset.next = self.reset.val();
                    self.back[j].advance.next = self.advance.val();
                    self.back[j].g.next = self.row_g[j].val();
                }
                self.back[0].x.next = self.column[$m - 1].y.val();
                self.back[0].first.next = self.row_cursor.first_column.val();
                self.back[0].load.next = self.row_load.y.val();
                for j in 1..$m {
                    self.back[j].x.next = self.back[j - 1].y.val();
                    self.back[j].first.next = self.back[j - 1].first_out.val();
                    self.back[j].load.next = self.back[j - 1].load_out.val();
                }

                self.row_end.clock.next = self.clock.val();
                self.row_end.reset.next = self.reset.val();
                self.row_end.advance.next = self.advance.val();
                self.row_end.x.next = self.row_cursor.last_column.val();

                for j in 0..$m {
                    self.ahead[j].clock.next = self.clock.val();
                    self.ahead[j].reset.next = self.reset.val();
                    self.ahead[j].advance.next = self.advance.val();
                    self.ahead[j].g.next = self.row_g[j].val();
                }
                self.ahead[0].x.next = self.back[$m - 1].y.val();
                self.ahead[0].last.next = self.row_end.y.val();
                self.ahead[0].load.next = self.back[$m - 2].load_out.val();
                for j in 1..$m {
                    self.ahead[j].x.next = self.ahead[j - 1].y.val();
                    self.ahead[j].last.next = self.ahead[j - 1].last_out.val();
                    self.ahead[j].load.next = self.ahead[j - 1].loads.val();
                }
                self.y.next = self.ahead[$m - 1].y.val();

                self.row_start.clock.next = self.clock.val();
                self.row_start.reset.next = self.reset.val();
                self.row_start.advance.next = self.advance.val();
                self.row_start.x.next = self.ahead[$m - 1].loads.val();
                self.start_out.next = self.row_start.y.val();
            }
        }
    };
}

smoother!(Smoother5, 5, "module: smoother_5");
smoother!(Smoother6, 6, "module: smoother_6");
