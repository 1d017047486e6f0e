//! The three smoothers, aligned: the narrow and the middle one get their pixels 32 lines and 44 steps later than the
//! wide one.

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

/// The three smoothers with aligned outputs.
#[derive(LogicBlock)]
pub struct Smoothers {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`.
    pub width: Signal<In, Width>,
    /// `H`.
    pub height: Signal<In, Height>,
    /// Marker one step before the first pixel of a frame.
    pub start: Signal<In, Bit>,
    /// One pixel per step.
    pub pixel: Signal<In, Bits<16>>,
    /// Register values of the frame, valid from its start.
    pub frame_bank: Signal<In, Bits<368>>,
    /// The same for the window stage, which the frame reaches later.
    pub window_bank: Signal<Out, Bits<368>>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<Out, Address>,
    /// The address one step ago.
    pub address_delayed_1: Signal<Out, Address>,
    /// `G_0`.
    pub narrow: Signal<Out, State>,
    /// `G_1`.
    pub middle: Signal<Out, State>,
    /// `G_2`.
    pub wide: Signal<Out, State>,
    /// Marker one step before the first smoothed samples of a frame.
    pub start_out: Signal<Out, Bit>,
    counter: AddressCounter,
    pixel_line_delay: LineDelay<16, 16>,
    pixel_delay_0: Delay<16>,
    pixel_delay_1: Delay<16>,
    start_delay: FrameDelay,
    delayed_bank: Bank,
    rows_bank: Bank,
    delayed_state: PixelState,
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
            address_delayed_1: Signal::default(),
            narrow: Signal::default(),
            middle: Signal::default(),
            wide: Signal::default(),
            start_out: Signal::default(),
            counter: AddressCounter::default(),
            pixel_line_delay: LineDelay::new(&[32]),
            pixel_delay_0: Delay::new(22),
            pixel_delay_1: Delay::new(22),
            start_delay: FrameDelay::new(32, 44),
            delayed_bank: Bank::default(),
            rows_bank: Bank::default(),
            delayed_state: PixelState::default(),
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
        self.address.next = self.counter.address.val();
        self.address_delayed_1.next = self.counter.delayed_1.val();

        comment!(
            "The wide smoother is 32 lines and 44 steps longer than the others, so their pixels are delayed by that."
        );
        self.pixel_line_delay.clock.next = self.clock.val();
        self.pixel_line_delay.advance.next = self.advance.val();
        self.pixel_line_delay.address.next = self.counter.address.val();
        self.pixel_line_delay.write_address.next = self.counter.delayed_1.val();
        self.pixel_line_delay.x.next = self.pixel.val();
        self.pixel_delay_0.clock.next = self.clock.val();
        self.pixel_delay_0.reset.next = self.reset.val();
        self.pixel_delay_0.advance.next = self.advance.val();
        self.pixel_delay_0.x.next = self.pixel_line_delay.y.val();
        self.pixel_delay_1.clock.next = self.clock.val();
        self.pixel_delay_1.reset.next = self.reset.val();
        self.pixel_delay_1.advance.next = self.advance.val();
        self.pixel_delay_1.x.next = self.pixel_delay_0.y.val();
        self.start_delay.clock.next = self.clock.val();
        self.start_delay.reset.next = self.reset.val();
        self.start_delay.advance.next = self.advance.val();
        self.start_delay.width.next = self.width.val();
        self.start_delay.x.next = self.start.val();
        self.delayed_state.x.next = self.pixel_delay_1.y.val();
        self.state.x.next = self.pixel.val();

        comment!("Banks: frame_bank for the wide columns, delayed_bank for the other columns, rows_bank for all rows.");
        self.delayed_bank.clock.next = self.clock.val();
        self.delayed_bank.load.next = self.start_delay.y.val();
        self.delayed_bank.d.next = self.frame_bank.val();
        self.rows_bank.clock.next = self.clock.val();
        self.rows_bank.load.next = self.wide_smoother.columns_done.val();
        self.rows_bank.d.next = self.frame_bank.val();
        self.window_bank.next = self.rows_bank.q.val();

        self.narrow_smoother.clock.next = self.clock.val();
        self.narrow_smoother.reset.next = self.reset.val();
        self.narrow_smoother.advance.next = self.advance.val();
        self.narrow_smoother.width.next = self.width.val();
        self.narrow_smoother.height.next = self.height.val();
        self.narrow_smoother.address.next = self.counter.address.val();
        self.narrow_smoother.address_delayed_1.next = self.counter.delayed_1.val();
        self.narrow_smoother.address_delayed_4.next = self.counter.delayed_4.val();
        self.narrow_smoother.address_delayed_5.next = self.counter.delayed_5.val();
        self.narrow_smoother.address_delayed_8.next = self.counter.delayed_8.val();
        self.narrow_smoother.address_delayed_12.next = self.counter.delayed_12.val();
        self.narrow_smoother.address_delayed_16.next = self.counter.delayed_16.val();
        self.narrow_smoother.address_delayed_20.next = self.counter.delayed_20.val();
        self.narrow_smoother.start.next = self.start_delay.y.val();
        self.narrow_smoother.x.next = self.delayed_state.y.val();
        self.narrow_smoother.g.next = self.delayed_bank.q.val().get_bits::<16>(0);
        self.narrow_smoother.column_g[0].next = self.delayed_bank.q.val().get_bits::<16>(16);
        self.narrow_smoother.row_g[0].next = self.rows_bank.q.val().get_bits::<16>(16);
        self.narrow_smoother.column_g[1].next = self.delayed_bank.q.val().get_bits::<16>(32);
        self.narrow_smoother.row_g[1].next = self.rows_bank.q.val().get_bits::<16>(32);
        self.narrow_smoother.column_g[2].next = self.delayed_bank.q.val().get_bits::<16>(48);
        self.narrow_smoother.row_g[2].next = self.rows_bank.q.val().get_bits::<16>(48);
        self.narrow_smoother.column_g[3].next = self.delayed_bank.q.val().get_bits::<16>(64);
        self.narrow_smoother.row_g[3].next = self.rows_bank.q.val().get_bits::<16>(64);
        self.narrow_smoother.column_g[4].next = self.delayed_bank.q.val().get_bits::<16>(80);
        self.narrow_smoother.row_g[4].next = self.rows_bank.q.val().get_bits::<16>(80);

        self.middle_smoother.clock.next = self.clock.val();
        self.middle_smoother.reset.next = self.reset.val();
        self.middle_smoother.advance.next = self.advance.val();
        self.middle_smoother.width.next = self.width.val();
        self.middle_smoother.height.next = self.height.val();
        self.middle_smoother.address.next = self.counter.address.val();
        self.middle_smoother.address_delayed_1.next = self.counter.delayed_1.val();
        self.middle_smoother.address_delayed_4.next = self.counter.delayed_4.val();
        self.middle_smoother.address_delayed_5.next = self.counter.delayed_5.val();
        self.middle_smoother.address_delayed_8.next = self.counter.delayed_8.val();
        self.middle_smoother.address_delayed_12.next = self.counter.delayed_12.val();
        self.middle_smoother.address_delayed_16.next = self.counter.delayed_16.val();
        self.middle_smoother.address_delayed_20.next = self.counter.delayed_20.val();
        self.middle_smoother.start.next = self.start_delay.y.val();
        self.middle_smoother.x.next = self.delayed_state.y.val();
        self.middle_smoother.g.next = self.delayed_bank.q.val().get_bits::<16>(96);
        self.middle_smoother.column_g[0].next = self.delayed_bank.q.val().get_bits::<16>(112);
        self.middle_smoother.row_g[0].next = self.rows_bank.q.val().get_bits::<16>(112);
        self.middle_smoother.column_g[1].next = self.delayed_bank.q.val().get_bits::<16>(128);
        self.middle_smoother.row_g[1].next = self.rows_bank.q.val().get_bits::<16>(128);
        self.middle_smoother.column_g[2].next = self.delayed_bank.q.val().get_bits::<16>(144);
        self.middle_smoother.row_g[2].next = self.rows_bank.q.val().get_bits::<16>(144);
        self.middle_smoother.column_g[3].next = self.delayed_bank.q.val().get_bits::<16>(160);
        self.middle_smoother.row_g[3].next = self.rows_bank.q.val().get_bits::<16>(160);
        self.middle_smoother.column_g[4].next = self.delayed_bank.q.val().get_bits::<16>(176);
        self.middle_smoother.row_g[4].next = self.rows_bank.q.val().get_bits::<16>(176);

        self.wide_smoother.clock.next = self.clock.val();
        self.wide_smoother.reset.next = self.reset.val();
        self.wide_smoother.advance.next = self.advance.val();
        self.wide_smoother.width.next = self.width.val();
        self.wide_smoother.height.next = self.height.val();
        self.wide_smoother.address.next = self.counter.address.val();
        self.wide_smoother.address_delayed_1.next = self.counter.delayed_1.val();
        self.wide_smoother.address_delayed_4.next = self.counter.delayed_4.val();
        self.wide_smoother.address_delayed_5.next = self.counter.delayed_5.val();
        self.wide_smoother.address_delayed_8.next = self.counter.delayed_8.val();
        self.wide_smoother.address_delayed_12.next = self.counter.delayed_12.val();
        self.wide_smoother.address_delayed_16.next = self.counter.delayed_16.val();
        self.wide_smoother.address_delayed_20.next = self.counter.delayed_20.val();
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
