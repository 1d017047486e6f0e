//! The stages `column_look_ahead`, `row_look_back` and `row_look_ahead`: border, lerp and the coefficient of the frame,
//! along the rows with the delay. Stage `j` of a row is the module with `DISTANCE = 2^j`.

use hoverlock_design::pipeline::CELL_STEPS;
use rust_hdl::prelude::*;

use crate::cells::{
    Coefficient, STATE_BITS, State,
    border::{CoefficientRegister, ColumnBorder, RowLookAheadBorder, RowLookBackBorder},
    delay::{Delay, FlagDelay, PulseDelay},
    lerp::Lerp,
};

/// `y[r] = lerp(p = u[min(r + 2^j, H-1)], q = u[r], g_j)`: `column_look_ahead`, for any `j`. The line memory
/// is no part of it.
#[derive(LogicBlock, Default)]
pub struct ColumnLookAhead {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Arriving sample `u[r + 2^j]`.
    pub x: Signal<In, State>,
    /// Filtered sample `u[r]`, from the line memory.
    pub delayed: Signal<In, State>,
    /// Sample of row `H - 1`.
    pub held: Signal<In, State>,
    /// Row `r + 2^j` lies outside the frame.
    pub outside: Signal<In, Bit>,
    /// Marker: load the coefficient.
    pub load: Signal<In, Bit>,
    /// `g_j` of the frame.
    pub g: Signal<In, Coefficient>,
    /// `y`.
    pub y: Signal<Out, State>,
    border: ColumnBorder,
    coefficient: CoefficientRegister,
    lerp: Lerp,
}

impl Logic for ColumnLookAhead {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: column_look_ahead");
        self.border.clock.next = self.clock.val();
        self.border.advance.next = self.advance.val();
        self.border.x.next = self.delayed.val();
        self.border.neighbour.next = self.x.val();
        self.border.border.next = self.held.val();
        self.border.outside.next = self.outside.val();

        self.coefficient.clock.next = self.clock.val();
        self.coefficient.advance.next = self.advance.val();
        self.coefficient.load.next = self.load.val();
        self.coefficient.d.next = self.g.val();

        self.lerp.clock.next = self.clock.val();
        self.lerp.advance.next = self.advance.val();
        self.lerp.p.next = self.border.p.val();
        self.lerp.q.next = self.border.q.val();
        self.lerp.g.next = self.coefficient.g.val();
        self.y.next = self.lerp.y.val();
    }
}

/// `y[c] = lerp(p = u[max(c - 2^j, 0)], q = u[c], g_j)`: `row_look_back`.
#[derive(LogicBlock)]
pub struct RowLookBack {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `u`.
    pub x: Signal<In, State>,
    /// `u` is the first of its row.
    pub first: Signal<In, Bit>,
    /// Marker: load the coefficient.
    pub load: Signal<In, Bit>,
    /// `g_j` of the frame.
    pub g: Signal<In, Coefficient>,
    /// `y`.
    pub y: Signal<Out, State>,
    /// `y` is the first of its row.
    pub first_out: Signal<Out, Bit>,
    /// Marker: the next stage loads its coefficient.
    pub load_out: Signal<Out, Bit>,
    sample_delay: Delay<STATE_BITS>,
    border: RowLookBackBorder,
    first_delay: FlagDelay,
    load_delay: FlagDelay,
    coefficient: CoefficientRegister,
    lerp: Lerp,
}

impl RowLookBack {
    /// Stage `j`.
    pub fn new(stage: u32) -> Self {
        let reach = 1 << stage;
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            x: Signal::default(),
            first: Signal::default(),
            load: Signal::default(),
            g: Signal::default(),
            y: Signal::default(),
            first_out: Signal::default(),
            load_out: Signal::default(),
            sample_delay: Delay::new(reach),
            border: RowLookBackBorder::new(reach as u64),
            first_delay: FlagDelay::new(CELL_STEPS as usize),
            load_delay: FlagDelay::new(CELL_STEPS as usize),
            coefficient: CoefficientRegister::default(),
            lerp: Lerp::default(),
        }
    }
}

impl Logic for RowLookBack {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: row_look_back DISTANCE=sample_delay.STEPS");
        comment!("parameter: sample_delay.STEPS=DISTANCE");
        comment!("parameter: border.DISTANCE=DISTANCE");
        self.sample_delay.clock.next = self.clock.val();
        self.sample_delay.reset.next = self.reset.val();
        self.sample_delay.advance.next = self.advance.val();
        self.sample_delay.x.next = self.x.val();

        self.border.clock.next = self.clock.val();
        self.border.reset.next = self.reset.val();
        self.border.advance.next = self.advance.val();
        self.border.first.next = self.first.val();
        self.border.x.next = self.x.val();
        self.border.delayed.next = self.sample_delay.y.val();

        self.first_delay.clock.next = self.clock.val();
        self.first_delay.reset.next = self.reset.val();
        self.first_delay.advance.next = self.advance.val();
        self.first_delay.x.next = self.first.val();
        self.first_out.next = self.first_delay.y.val();

        self.load_delay.clock.next = self.clock.val();
        self.load_delay.reset.next = self.reset.val();
        self.load_delay.advance.next = self.advance.val();
        self.load_delay.x.next = self.load.val();
        self.load_out.next = self.load_delay.y.val();

        self.coefficient.clock.next = self.clock.val();
        self.coefficient.advance.next = self.advance.val();
        self.coefficient.load.next = self.load.val();
        self.coefficient.d.next = self.g.val();

        self.lerp.clock.next = self.clock.val();
        self.lerp.advance.next = self.advance.val();
        self.lerp.p.next = self.border.p.val();
        self.lerp.q.next = self.border.q.val();
        self.lerp.g.next = self.coefficient.g.val();
        self.y.next = self.lerp.y.val();
    }
}

/// `y[c] = lerp(p = u[min(c + 2^j, W-1)], q = u[c], g_j)`: `row_look_ahead`.
#[derive(LogicBlock)]
pub struct RowLookAhead {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Arriving sample `u`.
    pub x: Signal<In, State>,
    /// The arriving `u` is the last of its row.
    pub last: Signal<In, Bit>,
    /// Marker: the previous stage loads its coefficient.
    pub load: Signal<In, Bit>,
    /// `g_j` of the frame.
    pub g: Signal<In, Coefficient>,
    /// `y`.
    pub y: Signal<Out, State>,
    /// `y` is the last of its row.
    pub last_out: Signal<Out, Bit>,
    /// Marker: this stage loads its coefficient.
    pub loads: Signal<Out, Bit>,
    sample_delay: Delay<STATE_BITS>,
    border: RowLookAheadBorder,
    last_delay: PulseDelay,
    load_delay: PulseDelay,
    coefficient: CoefficientRegister,
    lerp: Lerp,
}

impl RowLookAhead {
    /// Stage `j`.
    pub fn new(stage: u32) -> Self {
        let reach = 1 << stage;
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            x: Signal::default(),
            last: Signal::default(),
            load: Signal::default(),
            g: Signal::default(),
            y: Signal::default(),
            last_out: Signal::default(),
            loads: Signal::default(),
            sample_delay: Delay::new(reach),
            border: RowLookAheadBorder::new(reach as u64),
            last_delay: PulseDelay::new(CELL_STEPS + reach as u64),
            load_delay: PulseDelay::new(CELL_STEPS + reach as u64),
            coefficient: CoefficientRegister::default(),
            lerp: Lerp::default(),
        }
    }
}

impl Logic for RowLookAhead {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: row_look_ahead DISTANCE=sample_delay.STEPS");
        comment!("parameter: sample_delay.STEPS=DISTANCE");
        comment!("parameter: border.DISTANCE=DISTANCE");
        comment!("parameter: last_delay.STEPS=DISTANCE + CELL_STEPS");
        comment!("parameter: load_delay.STEPS=DISTANCE + CELL_STEPS");
        self.sample_delay.clock.next = self.clock.val();
        self.sample_delay.reset.next = self.reset.val();
        self.sample_delay.advance.next = self.advance.val();
        self.sample_delay.x.next = self.x.val();

        self.border.clock.next = self.clock.val();
        self.border.reset.next = self.reset.val();
        self.border.advance.next = self.advance.val();
        self.border.last.next = self.last.val();
        self.border.x.next = self.x.val();
        self.border.delayed.next = self.sample_delay.y.val();

        self.last_delay.clock.next = self.clock.val();
        self.last_delay.reset.next = self.reset.val();
        self.last_delay.advance.next = self.advance.val();
        self.last_delay.x.next = self.last.val();
        self.last_out.next = self.last_delay.y.val();

        self.load_delay.clock.next = self.clock.val();
        self.load_delay.reset.next = self.reset.val();
        self.load_delay.advance.next = self.advance.val();
        self.load_delay.x.next = self.load.val();
        self.loads.next = self.load_delay.y.val();

        self.coefficient.clock.next = self.clock.val();
        self.coefficient.advance.next = self.advance.val();
        self.coefficient.load.next = self.load_delay.y.val();
        self.coefficient.d.next = self.g.val();

        self.lerp.clock.next = self.clock.val();
        self.lerp.advance.next = self.advance.val();
        self.lerp.p.next = self.border.p.val();
        self.lerp.q.next = self.border.q.val();
        self.lerp.g.next = self.coefficient.g.val();
        self.y.next = self.lerp.y.val();
    }
}
