//! The three kinds of look-ahead and look-back stages: border, delay and lerp, with the coefficient of the frame that passes.

use rust_hdl::prelude::*;

use super::CELL_STEPS;
use crate::cells::{
    Address, Code, State, Width,
    border::{CoefficientRegister, ColumnBorder, LookAheadBorder, LookBackBorder},
    delay::{Delay, FlagDelay, FrameDelay, PulseDelay},
    lerp::Lerp,
    line_delay::LineDelay,
};

/// `y[r] = lerp(p = u[min(r + 2^j, H-1)], q = u[r], g_j)`: a column look-ahead stage.
#[derive(LogicBlock)]
pub struct ColumnStage {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No frame is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// `W`.
    pub width: Signal<In, Width>,
    /// Counts steps modulo `W`.
    pub address: Signal<In, Address>,
    /// One step before.
    pub write_address: Signal<In, Address>,
    /// `u`, arriving.
    pub x: Signal<In, State>,
    /// Row `H - 1`.
    pub held: Signal<In, State>,
    /// Row `r + 2^j` lies outside the frame.
    pub outside: Signal<In, Bit>,
    /// The previous stage takes its coefficient over.
    pub load: Signal<In, Bit>,
    /// `g_j` of the frame.
    pub g: Signal<In, Code>,
    /// `y`.
    pub y: Signal<Out, State>,
    /// This stage takes its coefficient over.
    pub loads: Signal<Out, Bit>,
    past: LineDelay<18, 18>,
    border: ColumnBorder,
    marker: FrameDelay,
    coefficient: CoefficientRegister,
    lerp: Lerp,
}

impl ColumnStage {
    /// Stage `j`.
    pub fn new(stage: u32) -> Self {
        let lines = 1 << stage;
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            width: Signal::default(),
            address: Signal::default(),
            write_address: Signal::default(),
            x: Signal::default(),
            held: Signal::default(),
            outside: Signal::default(),
            load: Signal::default(),
            g: Signal::default(),
            y: Signal::default(),
            loads: Signal::default(),
            past: LineDelay::new(&[lines]),
            border: ColumnBorder::default(),
            marker: FrameDelay::new(lines as u64, CELL_STEPS),
            coefficient: CoefficientRegister::default(),
            lerp: Lerp::default(),
        }
    }
}

impl Logic for ColumnStage {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: column_stage_*");
        self.past.clock.next = self.clock.val();
        self.past.advance.next = self.advance.val();
        self.past.address.next = self.address.val();
        self.past.write_address.next = self.write_address.val();
        self.past.x.next = self.x.val();

        self.border.clock.next = self.clock.val();
        self.border.advance.next = self.advance.val();
        self.border.x.next = self.past.y.val();
        self.border.neighbour.next = self.x.val();
        self.border.border.next = self.held.val();
        self.border.outside.next = self.outside.val();

        self.marker.clock.next = self.clock.val();
        self.marker.reset.next = self.reset.val();
        self.marker.advance.next = self.advance.val();
        self.marker.width.next = self.width.val();
        self.marker.x.next = self.load.val();
        self.loads.next = self.marker.y.val();

        self.coefficient.clock.next = self.clock.val();
        self.coefficient.advance.next = self.advance.val();
        self.coefficient.load.next = self.marker.y.val();
        self.coefficient.d.next = self.g.val();

        self.lerp.clock.next = self.clock.val();
        self.lerp.advance.next = self.advance.val();
        self.lerp.p.next = self.border.p.val();
        self.lerp.q.next = self.border.q.val();
        self.lerp.g.next = self.coefficient.g.val();
        self.y.next = self.lerp.y.val();
    }
}

/// `y[c] = lerp(p = u[max(c - 2^j, 0)], q = u[c], g_j)`: a row stage towards the past.
#[derive(LogicBlock)]
pub struct LookBackStage {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No frame is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// `u`.
    pub x: Signal<In, State>,
    /// `u` is the first of its row.
    pub first: Signal<In, Bit>,
    /// Take the coefficient over.
    pub load: Signal<In, Bit>,
    /// `g_j` of the frame.
    pub g: Signal<In, Code>,
    /// `y`.
    pub y: Signal<Out, State>,
    /// `y` is the first of its row.
    pub first_out: Signal<Out, Bit>,
    /// The next stage takes its coefficient over.
    pub load_out: Signal<Out, Bit>,
    past: Delay<18>,
    border: LookBackBorder,
    mark: FlagDelay,
    marker: FlagDelay,
    coefficient: CoefficientRegister,
    lerp: Lerp,
}

impl LookBackStage {
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
            past: Delay::new(reach),
            border: LookBackBorder::new(reach as u64),
            mark: FlagDelay::new(CELL_STEPS as usize),
            marker: FlagDelay::new(CELL_STEPS as usize),
            coefficient: CoefficientRegister::default(),
            lerp: Lerp::default(),
        }
    }
}

impl Logic for LookBackStage {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: look_back_stage_*");
        self.past.clock.next = self.clock.val();
        self.past.reset.next = self.reset.val();
        self.past.advance.next = self.advance.val();
        self.past.x.next = self.x.val();

        self.border.clock.next = self.clock.val();
        self.border.reset.next = self.reset.val();
        self.border.advance.next = self.advance.val();
        self.border.first.next = self.first.val();
        self.border.x.next = self.x.val();
        self.border.past.next = self.past.y.val();

        self.mark.clock.next = self.clock.val();
        self.mark.reset.next = self.reset.val();
        self.mark.advance.next = self.advance.val();
        self.mark.x.next = self.first.val();
        self.first_out.next = self.mark.y.val();

        self.marker.clock.next = self.clock.val();
        self.marker.reset.next = self.reset.val();
        self.marker.advance.next = self.advance.val();
        self.marker.x.next = self.load.val();
        self.load_out.next = self.marker.y.val();

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

/// `y[c] = lerp(p = u[min(c + 2^j, W-1)], q = u[c], g_j)`: a row stage towards the future.
#[derive(LogicBlock)]
pub struct LookAheadStage {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No frame is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// `u`, arriving.
    pub x: Signal<In, State>,
    /// The arriving `u` is the last of its row.
    pub last: Signal<In, Bit>,
    /// The previous stage takes its coefficient over.
    pub load: Signal<In, Bit>,
    /// `g_j` of the frame.
    pub g: Signal<In, Code>,
    /// `y`.
    pub y: Signal<Out, State>,
    /// `y` is the last of its row.
    pub last_out: Signal<Out, Bit>,
    /// This stage takes its coefficient over.
    pub loads: Signal<Out, Bit>,
    past: Delay<18>,
    border: LookAheadBorder,
    mark: PulseDelay,
    marker: PulseDelay,
    coefficient: CoefficientRegister,
    lerp: Lerp,
}

impl LookAheadStage {
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
            past: Delay::new(reach),
            border: LookAheadBorder::new(reach as u64),
            mark: PulseDelay::new(CELL_STEPS + reach as u64),
            marker: PulseDelay::new(CELL_STEPS + reach as u64),
            coefficient: CoefficientRegister::default(),
            lerp: Lerp::default(),
        }
    }
}

impl Logic for LookAheadStage {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: look_ahead_stage_*");
        self.past.clock.next = self.clock.val();
        self.past.reset.next = self.reset.val();
        self.past.advance.next = self.advance.val();
        self.past.x.next = self.x.val();

        self.border.clock.next = self.clock.val();
        self.border.reset.next = self.reset.val();
        self.border.advance.next = self.advance.val();
        self.border.last.next = self.last.val();
        self.border.x.next = self.x.val();
        self.border.past.next = self.past.y.val();

        self.mark.clock.next = self.clock.val();
        self.mark.reset.next = self.reset.val();
        self.mark.advance.next = self.advance.val();
        self.mark.x.next = self.last.val();
        self.last_out.next = self.mark.y.val();

        self.marker.clock.next = self.clock.val();
        self.marker.reset.next = self.reset.val();
        self.marker.advance.next = self.advance.val();
        self.marker.x.next = self.load.val();
        self.loads.next = self.marker.y.val();

        self.coefficient.clock.next = self.clock.val();
        self.coefficient.advance.next = self.advance.val();
        self.coefficient.load.next = self.marker.y.val();
        self.coefficient.d.next = self.g.val();

        self.lerp.clock.next = self.clock.val();
        self.lerp.advance.next = self.advance.val();
        self.lerp.p.next = self.border.p.val();
        self.lerp.q.next = self.border.q.val();
        self.lerp.g.next = self.coefficient.g.val();
        self.y.next = self.lerp.y.val();
    }
}
