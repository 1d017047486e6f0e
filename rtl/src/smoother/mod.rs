//! One two-sided smoother: `s[r] = s[r-1] + g (x[r] - s[r-1])` down the columns, then `m` column look-ahead stages, `m`
//! row look-back stages and `m` row look-ahead stages. Every cell is a lerp.
//!
//! | part | steps | lines |
//! |---|---|---|
//! | `recursion` | 4 | 0 |
//! | `column_look_ahead_j` | 4 | `2^j` |
//! | `row_look_back_j` | 4 | 0 |
//! | `row_look_ahead_j` | `4 + 2^j` | 0 |
//!
//! Together `2^m - 1` lines and `4 + 12 m + 2^m - 1` steps. A marker comes one step before its sample, so that
//! registers loaded by the marker are valid with the sample.

pub mod stages;

/// Steps of one cell with its border.
pub const CELL_STEPS: u64 = 4;

/// Steps of a smoother in addition to its lines.
pub const fn steps(look_ahead: u64) -> u64 {
    CELL_STEPS + 3 * CELL_STEPS * look_ahead + (1 << look_ahead) - 1
}

// An index of an array, `[M - 1]`, is printed by its name, so each length has a type of its own and not a const
// generic.
macro_rules! smoother {
    ($smoother:ident, $m:tt, $tag:tt) => {
        #[doc = concat!("A smoother of look-ahead `m = ", $m, "`.")]
        #[derive(LogicBlock)]
        pub struct $smoother {
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
            /// Line memory address: the number of steps modulo `W`.
            pub address: Signal<In, Address>,
            /// The address one step ago.
            pub address_delayed_1: Signal<In, Address>,
            /// The address four steps ago.
            pub address_delayed_4: Signal<In, Address>,
            /// The address five steps ago.
            pub address_delayed_5: Signal<In, Address>,
            /// The address eight steps ago.
            pub address_delayed_8: Signal<In, Address>,
            /// The address twelve steps ago.
            pub address_delayed_12: Signal<In, Address>,
            /// The address sixteen steps ago.
            pub address_delayed_16: Signal<In, Address>,
            /// The address twenty steps ago.
            pub address_delayed_20: Signal<In, Address>,
            /// Marker one step before the first sample of a frame.
            pub start: Signal<In, Bit>,
            /// One sample per step.
            pub x: Signal<In, State>,
            /// `g` of the recursion, valid with the first sample of a frame.
            pub g: Signal<In, Coefficient>,
            /// `g_j` of the column stages, stable until the frame has loaded them.
            pub column_g: [Signal<In, Coefficient>; $m],
            /// `g_j` of the row stages, stable until the frame has loaded them.
            pub row_g: [Signal<In, Coefficient>; $m],
            /// Marker one step before the first sample leaves the column stages.
            pub columns_done: Signal<Out, Bit>,
            /// The smoothed sample.
            pub y: Signal<Out, State>,
            /// Marker one step before the first smoothed sample of a frame.
            pub start_out: Signal<Out, Bit>,
            cursor: Cursor,
            recursion_load: FlagDelay,
            recursion_coefficient: CoefficientRegister,
            recursion_memory: LineDelay<STATE_BITS, STATE_BITS>,
            recursion_border: ColumnBorder,
            recursion: Lerp,
            last_row: FlagDelay,
            tail_start: FlagDelay,
            tail: TailCounter,
            held: HeldRow,
            column_look_ahead: [ColumnLookAhead; $m],
            column_start: FlagDelay,
            row_cursor: Cursor,
            row_load: FlagDelay,
            row_look_back: [RowLookBack; $m],
            row_end: PulseDelay,
            row_look_ahead: [RowLookAhead; $m],
            row_start: FlagDelay,
        }

        impl $smoother {
            /// A smoother. Its length is fixed; its coefficients come with each frame.
            pub fn new() -> Self {
                Self {
                    clock: Signal::default(),
                    reset: Signal::default(),
                    advance: Signal::default(),
                    width: Signal::default(),
                    height: Signal::default(),
                    address: Signal::default(),
                    address_delayed_1: Signal::default(),
                    address_delayed_4: Signal::default(),
                    address_delayed_5: Signal::default(),
                    address_delayed_8: Signal::default(),
                    address_delayed_12: Signal::default(),
                    address_delayed_16: Signal::default(),
                    address_delayed_20: Signal::default(),
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
                    column_look_ahead: std::array::from_fn(|stage| ColumnLookAhead::new(stage as u32)),
                    column_start: FlagDelay::new(2),
                    row_cursor: Cursor::default(),
                    row_load: FlagDelay::new(2),
                    row_look_back: std::array::from_fn(|stage| RowLookBack::new(stage as u32)),
                    row_end: PulseDelay::new(CELL_STEPS * $m as u64),
                    row_look_ahead: std::array::from_fn(|stage| RowLookAhead::new(stage as u32)),
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
                comment!("Recursion down the columns; its state returns one line later through a memory.");
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
                self.recursion_memory.write_address.next = self.address_delayed_5.val();
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

                comment!("The last row is held for the column look-ahead stages.");
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
                self.held.write_address.next = self.address_delayed_1.val();
                self.held.x.next = self.recursion.y.val();
                self.held.select.next = self.tail.select.val();
                self.held.address_0.next = self.address.val();
                self.held.address_1.next = self.address_delayed_4.val();
                self.held.address_2.next = self.address_delayed_8.val();
                self.held.address_3.next = self.address_delayed_12.val();
                self.held.address_4.next = self.address_delayed_16.val();
                self.held.address_5.next = self.address_delayed_20.val();

                comment!("Column look-ahead: stage j uses the row 2^j lines later.");
                for j in 0..$m {
                    self.column_look_ahead[j].clock.next = self.clock.val();
                    self.column_look_ahead[j].reset.next = self.reset.val();
                    self.column_look_ahead[j].advance.next = self.advance.val();
                    self.column_look_ahead[j].width.next = self.width.val();
                    self.column_look_ahead[j].address.next = self.address.val();
                    self.column_look_ahead[j].write_address.next = self.address_delayed_1.val();
                    self.column_look_ahead[j].held.next = self.held.y.val();
                    self.column_look_ahead[j].outside.next = self.tail.outside.val().get_bit(j);
                    self.column_look_ahead[j].g.next = self.column_g[j].val();
                }
                self.column_look_ahead[0].x.next = self.recursion.y.val();
                self.column_look_ahead[0].load.next = self.recursion_load.y.val();
                for j in 1..$m {
                    self.column_look_ahead[j].x.next = self.column_look_ahead[j - 1].y.val();
                    self.column_look_ahead[j].load.next = self.column_look_ahead[j - 1].loads.val();
                }

                self.column_start.clock.next = self.clock.val();
                self.column_start.reset.next = self.reset.val();
                self.column_start.advance.next = self.advance.val();
                self.column_start.x.next = self.column_look_ahead[$m - 1].loads.val();
                self.columns_done.next = self.column_start.y.val();

                comment!("Row look-back, then row look-ahead.");
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
                    self.row_look_back[j].clock.next = self.clock.val();
                    self.row_look_back[j].reset.next = self.reset.val();
                    self.row_look_back[j].advance.next = self.advance.val();
                    self.row_look_back[j].g.next = self.row_g[j].val();
                }
                self.row_look_back[0].x.next = self.column_look_ahead[$m - 1].y.val();
                self.row_look_back[0].first.next = self.row_cursor.first_column.val();
                self.row_look_back[0].load.next = self.row_load.y.val();
                for j in 1..$m {
                    self.row_look_back[j].x.next = self.row_look_back[j - 1].y.val();
                    self.row_look_back[j].first.next = self.row_look_back[j - 1].first_out.val();
                    self.row_look_back[j].load.next = self.row_look_back[j - 1].load_out.val();
                }

                self.row_end.clock.next = self.clock.val();
                self.row_end.reset.next = self.reset.val();
                self.row_end.advance.next = self.advance.val();
                self.row_end.x.next = self.row_cursor.last_column.val();

                for j in 0..$m {
                    self.row_look_ahead[j].clock.next = self.clock.val();
                    self.row_look_ahead[j].reset.next = self.reset.val();
                    self.row_look_ahead[j].advance.next = self.advance.val();
                    self.row_look_ahead[j].g.next = self.row_g[j].val();
                }
                self.row_look_ahead[0].x.next = self.row_look_back[$m - 1].y.val();
                self.row_look_ahead[0].last.next = self.row_end.y.val();
                self.row_look_ahead[0].load.next = self.row_look_back[$m - 2].load_out.val();
                for j in 1..$m {
                    self.row_look_ahead[j].x.next = self.row_look_ahead[j - 1].y.val();
                    self.row_look_ahead[j].last.next = self.row_look_ahead[j - 1].last_out.val();
                    self.row_look_ahead[j].load.next = self.row_look_ahead[j - 1].loads.val();
                }
                self.y.next = self.row_look_ahead[$m - 1].y.val();

                self.row_start.clock.next = self.clock.val();
                self.row_start.reset.next = self.reset.val();
                self.row_start.advance.next = self.advance.val();
                self.row_start.x.next = self.row_look_ahead[$m - 1].loads.val();
                self.start_out.next = self.row_start.y.val();
            }
        }
    };
}

pub(crate) use smoother;
