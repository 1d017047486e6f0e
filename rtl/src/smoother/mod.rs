//! One two-sided smoother: `m` column look-ahead stages, the longest first, the recursion
//! `s[r] = s[r-1] + g (u[r] - s[r-1])` down the columns, then `m` row look-back stages and `m` row look-ahead stages.
//! Every cell is a lerp.
//!
//! | part | steps, of [`hoverlock_design::pipeline`] | lines |
//! |---|---|---|
//! | `first_stage`, `second_stage`: `column_look_ahead_j`, `j = m-1, m-2` | `TREE_STEPS` | 0 |
//! | `column_look_ahead_j`, `j = m-3 .. 0` | `CELL_STEPS` | `2^j` |
//! | `recursion` | `CELL_STEPS` | 0 |
//! | `row_look_back_j` | `CELL_STEPS` | 0 |
//! | `row_look_ahead_j` | `CELL_STEPS + 2^j` | 0 |
//!
//! The first two stages see pixels: rows `r`, `r + q`, `r + 2 q` and `r + 3 q`, `q = 2^(m-2)`, come in together, so two
//! cells of the first stage replace the line memory of the second. All line memories of the column stages are one
//! memory outside, which the smoothers share; so are the markers, because the column stages of all smoothers run side
//! by side. A marker loads the coefficient of a cell in the step in which the first operands of a frame are at its
//! lerp.

pub mod stages;

// An index of an array, `[M - 1]`, is printed by its name, so each length has a type of its own and not a const
// generic. `$stages` is `m - 2`.
macro_rules! smoother {
    ($smoother:ident, $m:tt, $stages:tt, $tag:tt) => {
        #[doc = concat!("A smoother of look-ahead `m = ", $m, "`.")]
        #[derive(LogicBlock)]
        pub struct $smoother {
            /// Clock: registers sample at its rising edge.
            pub clock: Signal<In, Clock>,
            /// Synchronous reset, active high.
            pub reset: Signal<In, Bit>,
            /// Clock enable: one step.
            pub advance: Signal<In, Bit>,
            /// Line memory address: the number of steps modulo `W`.
            pub address: Signal<In, Address>,
            /// Where the memory of the recursion is written.
            pub recursion_write_address: Signal<In, Address>,
            /// Pixels of rows `r`, `r + q`, `r + 2 q` and `r + 3 q` of a column, the first lowest.
            pub rows: Signal<In, PixelRows>,
            /// Marker: the first stage loads its coefficient.
            pub rows_load: Signal<In, Bit>,
            /// Input of stage `j` as it was `2^j` lines ago.
            pub delayed: [Signal<In, State>; $stages],
            /// Input of stage `j`, for the line memory.
            pub arriving: [Signal<Out, State>; $stages],
            /// Row `H - 1` at stage `j`.
            pub held: [Signal<In, State>; $stages],
            /// Row `r + 2^j` of stage `j` lies outside the frame.
            pub outside: [Signal<In, Bit>; $stages],
            /// Marker: stage `j` loads its coefficient.
            pub stage_load: [Signal<In, Bit>; $stages],
            /// The sample at the recursion is of the first row.
            pub first_row: Signal<In, Bit>,
            /// Marker: the recursion loads its coefficient.
            pub recursion_load: Signal<In, Bit>,
            /// The sample at the row stages is the first of its row.
            pub first_column: Signal<In, Bit>,
            /// The sample at the row stages is the last of its row.
            pub last_column: Signal<In, Bit>,
            /// Marker: the first row stage loads its coefficient.
            pub row_load: Signal<In, Bit>,
            /// `g` of the recursion.
            pub g: Signal<In, Coefficient>,
            /// `g_j` of the column and row stages.
            pub g_j: [Signal<In, Coefficient>; $m],
            /// The smoothed sample.
            pub y: Signal<Out, State>,
            /// Marker one step before the first smoothed sample of a frame.
            pub start_out: Signal<Out, Bit>,
            /// A state with a flipped bit was read.
            pub upset: Flag<Out>,
            pixel_state: [PixelState; 4],
            first_coefficient: CoefficientRegister,
            first_stage: [Lerp; 2],
            second_load: FlagDelay,
            second_coefficient: CoefficientRegister,
            second_stage: Lerp,
            column_look_ahead: [ColumnLookAhead; $stages],
            column: [Signal<Local, State>; $stages + 1],
            recursion_coefficient: CoefficientRegister,
            recursion_memory: LineDelay<STATE_BITS, STATE_BITS>,
            recursion_border: ColumnBorder,
            recursion: Lerp,
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
                    address: Signal::default(),
                    recursion_write_address: Signal::default(),
                    rows: Signal::default(),
                    rows_load: Signal::default(),
                    delayed: std::array::from_fn(|_| Signal::default()),
                    arriving: std::array::from_fn(|_| Signal::default()),
                    held: std::array::from_fn(|_| Signal::default()),
                    outside: std::array::from_fn(|_| Signal::default()),
                    stage_load: std::array::from_fn(|_| Signal::default()),
                    first_row: Signal::default(),
                    recursion_load: Signal::default(),
                    first_column: Signal::default(),
                    last_column: Signal::default(),
                    row_load: Signal::default(),
                    g: Signal::default(),
                    g_j: std::array::from_fn(|_| Signal::default()),
                    y: Signal::default(),
                    start_out: Signal::default(),
                    upset: Default::default(),
                    pixel_state: Default::default(),
                    first_coefficient: CoefficientRegister::default(),
                    first_stage: Default::default(),
                    second_load: FlagDelay::new(LERP_STEPS as usize),
                    second_coefficient: CoefficientRegister::default(),
                    second_stage: Lerp::default(),
                    column_look_ahead: std::array::from_fn(|_| ColumnLookAhead::default()),
                    column: std::array::from_fn(|_| Signal::default()),
                    recursion_coefficient: CoefficientRegister::default(),
                    recursion_memory: LineDelay::new(&[1]),
                    recursion_border: ColumnBorder::default(),
                    recursion: Lerp::default(),
                    row_look_back: std::array::from_fn(|stage| RowLookBack::new(stage as u32)),
                    row_end: PulseDelay::new(CELL_STEPS * $m as u64),
                    row_look_ahead: std::array::from_fn(|stage| RowLookAhead::new(stage as u32)),
                    row_start: FlagDelay::new(LERP_STEPS as usize - 1),
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
                comment!("The two longest column stages: two cells of the first give both rows of the second.");
                self.pixel_state[0].x.next = self.rows.val().get_bits::<PIXEL_BITS>(0);
                self.pixel_state[1].x.next = self.rows.val().get_bits::<PIXEL_BITS>(PIXEL_ROW_1_AT);
                self.pixel_state[2].x.next = self.rows.val().get_bits::<PIXEL_BITS>(PIXEL_ROW_2_AT);
                self.pixel_state[3].x.next = self.rows.val().get_bits::<PIXEL_BITS>(PIXEL_ROW_3_AT);

                self.first_coefficient.clock.next = self.clock.val();
                self.first_coefficient.advance.next = self.advance.val();
                self.first_coefficient.load.next = self.rows_load.val();
                self.first_coefficient.d.next = self.g_j[$m - 1].val();

                for i in 0..2 {
                    self.first_stage[i].clock.next = self.clock.val();
                    self.first_stage[i].advance.next = self.advance.val();
                    self.first_stage[i].p.next = self.pixel_state[i + 2].y.val();
                    self.first_stage[i].q.next = self.pixel_state[i].y.val();
                    self.first_stage[i].g.next = self.first_coefficient.g.val();
                }

                self.second_load.clock.next = self.clock.val();
                self.second_load.reset.next = self.reset.val();
                self.second_load.advance.next = self.advance.val();
                self.second_load.x.next = self.rows_load.val();

                self.second_coefficient.clock.next = self.clock.val();
                self.second_coefficient.advance.next = self.advance.val();
                self.second_coefficient.load.next = self.second_load.y.val();
                self.second_coefficient.d.next = self.g_j[$m - 2].val();

                self.second_stage.clock.next = self.clock.val();
                self.second_stage.advance.next = self.advance.val();
                self.second_stage.p.next = self.first_stage[1].y.val();
                self.second_stage.q.next = self.first_stage[0].y.val();
                self.second_stage.g.next = self.second_coefficient.g.val();
                self.column[$stages].next = self.second_stage.y.val();

                comment!("The other column stages: stage j uses the row 2^j lines later. column[j] leaves stage j.");
                for j in 0..$stages {
                    self.column_look_ahead[j].clock.next = self.clock.val();
                    self.column_look_ahead[j].advance.next = self.advance.val();
                    self.column_look_ahead[j].x.next = self.column[j + 1].val();
                    self.column_look_ahead[j].delayed.next = self.delayed[j].val();
                    self.column_look_ahead[j].held.next = self.held[j].val();
                    self.column_look_ahead[j].outside.next = self.outside[j].val();
                    self.column_look_ahead[j].load.next = self.stage_load[j].val();
                    self.column_look_ahead[j].g.next = self.g_j[j].val();
                    self.arriving[j].next = self.column[j + 1].val();
                    self.column[j].next = self.column_look_ahead[j].y.val();
                }

                comment!("Recursion down the columns; its state returns one line later through a memory.");
                self.recursion_coefficient.clock.next = self.clock.val();
                self.recursion_coefficient.advance.next = self.advance.val();
                self.recursion_coefficient.load.next = self.recursion_load.val();
                self.recursion_coefficient.d.next = self.g.val();

                self.recursion_memory.clock.next = self.clock.val();
                self.recursion_memory.advance.next = self.advance.val();
                self.recursion_memory.address.next = self.address.val();
                self.recursion_memory.write_address.next = self.recursion_write_address.val();
                self.recursion_memory.x.next = self.recursion.y.val();

                self.recursion_border.clock.next = self.clock.val();
                self.recursion_border.advance.next = self.advance.val();
                self.recursion_border.x.next = self.column[0].val();
                self.recursion_border.neighbour.next = self.recursion_memory.y.val();
                self.recursion_border.border.next = self.column[0].val();
                self.recursion_border.outside.next = self.first_row.val();

                self.recursion.clock.next = self.clock.val();
                self.recursion.advance.next = self.advance.val();
                self.recursion.p.next = self.recursion_border.p.val();
                self.recursion.q.next = self.recursion_border.q.val();
                self.recursion.g.next = self.recursion_coefficient.g.val();

                comment!("Row look-back, then row look-ahead.");
                for j in 0..$m {
                    self.row_look_back[j].clock.next = self.clock.val();
                    self.row_look_back[j].reset.next = self.reset.val();
                    self.row_look_back[j].advance.next = self.advance.val();
                    self.row_look_back[j].g.next = self.g_j[j].val();
                }
                self.row_look_back[0].x.next = self.recursion.y.val();
                self.row_look_back[0].first.next = self.first_column.val();
                self.row_look_back[0].load.next = self.row_load.val();
                for j in 1..$m {
                    self.row_look_back[j].x.next = self.row_look_back[j - 1].y.val();
                    self.row_look_back[j].first.next = self.row_look_back[j - 1].first_out.val();
                    self.row_look_back[j].load.next = self.row_look_back[j - 1].load_out.val();
                }

                self.row_end.clock.next = self.clock.val();
                self.row_end.reset.next = self.reset.val();
                self.row_end.advance.next = self.advance.val();
                self.row_end.x.next = self.last_column.val();

                for j in 0..$m {
                    self.row_look_ahead[j].clock.next = self.clock.val();
                    self.row_look_ahead[j].reset.next = self.reset.val();
                    self.row_look_ahead[j].advance.next = self.advance.val();
                    self.row_look_ahead[j].g.next = self.g_j[j].val();
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
                for _flag in 0..PARITY {
                    self.upset.next = self.recursion_memory.upset.val();
                }
            }
        }
    };
}

pub(crate) use smoother;
