//! The three smoothers, aligned: the narrow and the middle one take their pixels 32 lines and 44 steps later than the wide one.

use rust_hdl::prelude::*;

use crate::{
    cells::{
        Address, Height, State, Width,
        address::AddressCounter,
        bank::Bank,
        delay::{Delay, FrameDelay},
        join::PixelState,
        line_delay::LineDelay,
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
