//! The extractor core between its two streams: sequencer, datapath, record FIFO.

use rust_hdl::prelude::*;

use crate::{
    cells::{
        Fields, Height, Pixel, Response, Width, bank::Bank, flag::Flag, record_fifo::RecordFifo, sequencer::Sequencer,
    },
    design::{PARITY, RECORD_BITS, SCALE_PAIRS},
    extractor::Extractor,
};

/// The core: Avalon-ST video in, Avalon-ST feature records out.
#[derive(LogicBlock, Default)]
pub struct Core {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It clears everything but the control registers.
    pub reset: Signal<In, Bit>,
    /// Frames are accepted.
    pub enable: Signal<In, Bit>,
    /// `W` of the next frame.
    pub new_width: Signal<In, Width>,
    /// `H` of the next frame.
    pub new_height: Signal<In, Height>,
    /// Register values that the next frame captures.
    pub bank: Signal<In, Fields>,
    /// The next frame captures the bank; otherwise it keeps the set of the previous frame.
    pub committed: Signal<In, Bit>,
    /// Video sink.
    pub video_ready: Signal<Out, Bit>,
    /// A beat is offered.
    pub video_valid: Signal<In, Bit>,
    /// Pixel of the beat, DN.
    pub video_data: Signal<In, Pixel>,
    /// Start of packet.
    pub video_startofpacket: Signal<In, Bit>,
    /// End of packet.
    pub video_endofpacket: Signal<In, Bit>,
    /// Feature source: the sink is ready.
    pub feature_ready: Signal<In, Bit>,
    /// A record is offered.
    pub feature_valid: Signal<Out, Bit>,
    /// Record.
    pub feature_data: Signal<Out, Bits<RECORD_BITS>>,
    /// Start of packet.
    pub feature_startofpacket: Signal<Out, Bit>,
    /// End of packet: the record is the trailer.
    pub feature_endofpacket: Signal<Out, Bit>,
    /// At least one frame is in the pipeline.
    pub busy: Signal<Out, Bit>,
    /// Error bits of this cycle.
    pub errors: Signal<Out, Bits<4>>,
    /// A frame begins at the next clock edge and captures the committed set.
    pub begun: Signal<Out, Bit>,
    /// Pulse: a frame is complete.
    pub done: Signal<Out, Bit>,
    /// Features of that frame.
    pub count: Signal<Out, Bits<20>>,
    /// Dropped features of that frame.
    pub dropped: Signal<Out, Bits<20>>,
    /// Number of complete frames.
    pub frames: Signal<Out, Bits<32>>,
    /// A response was saturated.
    pub saturated: Signal<Out, Bit>,
    /// Thresholds `T_k` in use.
    pub threshold: [Signal<Out, Response>; SCALE_PAIRS],
    /// A flipped bit was read.
    pub upset: Flag<Out>,
    sequencer: Sequencer,
    frame_bank: Bank,
    extractor: Extractor,
    fifo: RecordFifo,
}

impl Logic for Core {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: hoverlock_core");
        self.sequencer.clock.next = self.clock.val();
        self.sequencer.reset.next = self.reset.val();
        self.sequencer.enable.next = self.enable.val();
        self.sequencer.new_width.next = self.new_width.val();
        self.sequencer.new_height.next = self.new_height.val();
        self.sequencer.committed.next = self.committed.val();
        self.sequencer.stall.next = self.fifo.stall.val();
        self.sequencer.valid.next = self.video_valid.val();
        self.sequencer.data.next = self.video_data.val();
        self.sequencer.start_of_packet.next = self.video_startofpacket.val();
        self.sequencer.end_of_packet.next = self.video_endofpacket.val();
        self.sequencer.frame_done.next = self.extractor.done.val();
        self.video_ready.next = self.sequencer.ready.val();
        self.busy.next = self.sequencer.busy.val();
        self.begun.next = self.sequencer.capture.val();
        self.errors.next = self.sequencer.errors.val();

        self.frame_bank.clock.next = self.clock.val();
        self.frame_bank.load.next = self.sequencer.capture.val() & self.committed.val();
        self.frame_bank.d.next = self.bank.val();

        self.extractor.clock.next = self.clock.val();
        self.extractor.reset.next = self.reset.val();
        self.extractor.advance.next = self.sequencer.advance.val();
        self.extractor.width.next = self.sequencer.width.val();
        self.extractor.height.next = self.sequencer.height.val();
        self.extractor.start.next = self.sequencer.start.val();
        self.extractor.pixel.next = self.sequencer.pixel.val();
        self.extractor.frame_bank.next = self.frame_bank.q.val();
        self.extractor.errors.next = self.sequencer.frame_errors.val();
        self.extractor.room.next = self.fifo.room.val();
        self.done.next = self.extractor.done.val();
        self.count.next = self.extractor.count.val();
        self.dropped.next = self.extractor.dropped.val();
        self.frames.next = self.extractor.frames.val();
        self.saturated.next = self.extractor.saturated.val();
        for k in 0..SCALE_PAIRS {
            self.threshold[k].next = self.extractor.threshold[k].val();
        }

        self.fifo.clock.next = self.clock.val();
        self.fifo.reset.next = self.reset.val();
        self.fifo.write.next = self.extractor.write.val();
        self.fifo.record.next = self.extractor.record.val();
        self.fifo.ready.next = self.feature_ready.val();
        self.feature_valid.next = self.fifo.valid.val();
        self.feature_data.next = self.fifo.data.val();
        self.feature_startofpacket.next = self.fifo.start_of_packet.val();
        self.feature_endofpacket.next = self.fifo.end_of_packet.val();
        for _flag in 0..PARITY {
            self.extractor.bank_upset.next = self.frame_bank.upset.val();
            self.upset.next = (self.extractor.upset.val() & self.sequencer.advance.val()) | self.fifo.upset.val();
        }
    }
}
