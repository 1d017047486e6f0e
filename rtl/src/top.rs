//! `hoverlock_top`: Avalon-ST video in, Avalon-ST features out, Avalon-MM registers, an interrupt.

use hoverlock_fixed_point::model::coefficients::CoefficientError;
use rust_hdl::prelude::*;

use crate::{
    cells::{Pixel, csr::Csr},
    core::Core,
    design::{PARITY, RECORD_BITS, SCALE_PAIRS, compiled},
    registers::registers,
};

/// The top level. Its port names are those of the Platform Designer component.
#[derive(LogicBlock)]
pub struct Top {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Avalon-ST video sink: a beat is taken.
    pub video_ready: Signal<Out, Bit>,
    /// A beat is offered.
    pub video_valid: Signal<In, Bit>,
    /// Pixel of the beat, DN.
    pub video_data: Signal<In, Pixel>,
    /// Start of packet.
    pub video_startofpacket: Signal<In, Bit>,
    /// End of packet.
    pub video_endofpacket: Signal<In, Bit>,
    /// Avalon-ST feature source: the sink is ready.
    pub feature_ready: Signal<In, Bit>,
    /// A record is offered.
    pub feature_valid: Signal<Out, Bit>,
    /// Record.
    pub feature_data: Signal<Out, Bits<RECORD_BITS>>,
    /// Start of packet.
    pub feature_startofpacket: Signal<Out, Bit>,
    /// End of packet: the record is the trailer.
    pub feature_endofpacket: Signal<Out, Bit>,
    /// Avalon-MM slave, word address.
    pub csr_address: Signal<In, Bits<6>>,
    /// Read request of this cycle.
    pub csr_read: Signal<In, Bit>,
    /// Read data, one cycle after the request.
    pub csr_readdata: Signal<Out, Bits<32>>,
    /// Write request of this cycle.
    pub csr_write: Signal<In, Bit>,
    /// Data of the write request.
    pub csr_writedata: Signal<In, Bits<32>>,
    /// Interrupt request, level-sensitive, active high.
    pub irq: Signal<Out, Bit>,
    registers: Csr,
    core: Core,
}

impl Top {
    /// The hardware of the design point. `emission` is the reset value of the `emission` register.
    ///
    /// # Errors
    /// Where a smoother of the design point does not exist.
    pub fn new(emission: u32) -> Result<Self, CoefficientError> {
        let mut map = registers(&compiled())?;
        for register in map.iter_mut().filter(|register| register.name == "emission") {
            register.fields[0].reset = emission;
        }
        Ok(Self {
            clock: Signal::default(),
            reset: Signal::default(),
            video_ready: Signal::default(),
            video_valid: Signal::default(),
            video_data: Signal::default(),
            video_startofpacket: Signal::default(),
            video_endofpacket: Signal::default(),
            feature_ready: Signal::default(),
            feature_valid: Signal::default(),
            feature_data: Signal::default(),
            feature_startofpacket: Signal::default(),
            feature_endofpacket: Signal::default(),
            csr_address: Signal::default(),
            csr_read: Signal::default(),
            csr_readdata: Signal::default(),
            csr_write: Signal::default(),
            csr_writedata: Signal::default(),
            irq: Signal::default(),
            registers: Csr::new(map),
            core: Core::default(),
        })
    }
}

impl Logic for Top {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: hoverlock_top");
        self.registers.clock.next = self.clock.val();
        self.registers.reset.next = self.reset.val();
        self.registers.address.next = self.csr_address.val();
        self.registers.read.next = self.csr_read.val();
        self.registers.write.next = self.csr_write.val();
        self.registers.writedata.next = self.csr_writedata.val();
        self.csr_readdata.next = self.registers.readdata.val();
        self.irq.next = self.registers.irq.val();
        self.registers.busy.next = self.core.busy.val();
        self.registers.errors.next = self.core.errors.val();
        self.registers.begun.next = self.core.begun.val();
        self.registers.done.next = self.core.done.val();
        self.registers.count.next = self.core.count.val();
        self.registers.dropped.next = self.core.dropped.val();
        self.registers.frames.next = self.core.frames.val();
        self.registers.saturated.next = self.core.saturated.val();
        for k in 0..SCALE_PAIRS {
            self.registers.threshold[k].next = self.core.threshold[k].val();
        }
        for _flag in 0..PARITY {
            self.registers.upset.next = self.core.upset.val();
        }

        self.core.clock.next = self.clock.val();
        self.core.reset.next = self.registers.clear.val();
        self.core.enable.next = self.registers.enable.val();
        self.core.new_width.next = self.registers.width.val();
        self.core.new_height.next = self.registers.height.val();
        self.core.bank.next = self.registers.bank.val();
        self.core.committed.next = self.registers.committed.val();
        self.video_ready.next = self.core.video_ready.val();
        self.core.video_valid.next = self.video_valid.val();
        self.core.video_data.next = self.video_data.val();
        self.core.video_startofpacket.next = self.video_startofpacket.val();
        self.core.video_endofpacket.next = self.video_endofpacket.val();
        self.core.feature_ready.next = self.feature_ready.val();
        self.feature_valid.next = self.core.feature_valid.val();
        self.feature_data.next = self.core.feature_data.val();
        self.feature_startofpacket.next = self.core.feature_startofpacket.val();
        self.feature_endofpacket.next = self.core.feature_endofpacket.val();
    }
}
