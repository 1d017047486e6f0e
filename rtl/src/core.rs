//! The extractor between its two streams: sequencer, datapath, FIFO.

use rust_hdl::prelude::*;

use crate::{
    cells::{Height, Response, Width, bank::Bank, queue::RecordFifo, sequencer::Sequencer},
    extractor::Extractor,
};

/// See the module.
#[derive(LogicBlock, Default)]
pub struct Core {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// Forgets everything but the registers.
    pub reset: Signal<In, Bit>,
    /// Frames are taken.
    pub enable: Signal<In, Bit>,
    /// `W` of the next frame.
    pub new_width: Signal<In, Width>,
    /// `H` of the next frame.
    pub new_height: Signal<In, Height>,
    /// What the next frame takes with it.
    pub bank: Signal<In, Bits<368>>,
    /// It takes the bank; otherwise it keeps what the frame before took.
    pub committed: Signal<In, Bit>,
    /// Video sink.
    pub video_ready: Signal<Out, Bit>,
    /// A beat is there.
    pub video_valid: Signal<In, Bit>,
    /// Its pixel.
    pub video_data: Signal<In, Bits<16>>,
    /// First of a frame.
    pub video_startofpacket: Signal<In, Bit>,
    /// Last of a frame.
    pub video_endofpacket: Signal<In, Bit>,
    /// Feature source: the sink is ready.
    pub feature_ready: Signal<In, Bit>,
    /// A record is there.
    pub feature_valid: Signal<Out, Bit>,
    /// The record.
    pub feature_data: Signal<Out, Bits<256>>,
    /// First of a frame.
    pub feature_startofpacket: Signal<Out, Bit>,
    /// The trailer.
    pub feature_endofpacket: Signal<Out, Bit>,
    /// Frames are in the pipeline.
    pub busy: Signal<Out, Bit>,
    /// Errors of this cycle.
    pub errors: Signal<Out, Bits<4>>,
    /// A frame begins with the next edge, and takes what is committed.
    pub begun: Signal<Out, Bit>,
    /// A frame is done.
    pub done: Signal<Out, Bit>,
    /// Its features.
    pub count: Signal<Out, Bits<20>>,
    /// Its dropped features.
    pub dropped: Signal<Out, Bits<20>>,
    /// Frames done.
    pub frames: Signal<Out, Bits<32>>,
    /// A response was cut.
    pub saturated: Signal<Out, Bit>,
    /// `T_0` in use.
    pub threshold_0: Signal<Out, Response>,
    /// `T_1` in use.
    pub threshold_1: Signal<Out, Response>,
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
        self.sequencer.stop.next = self.fifo.stop.val();
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
        self.threshold_0.next = self.extractor.threshold_0.val();
        self.threshold_1.next = self.extractor.threshold_1.val();

        self.fifo.clock.next = self.clock.val();
        self.fifo.reset.next = self.reset.val();
        self.fifo.write.next = self.extractor.write.val();
        self.fifo.record.next = self.extractor.record.val();
        self.fifo.ready.next = self.feature_ready.val();
        self.feature_valid.next = self.fifo.valid.val();
        self.feature_data.next = self.fifo.data.val();
        self.feature_startofpacket.next = self.fifo.start_of_packet.val();
        self.feature_endofpacket.next = self.fifo.end_of_packet.val();
    }
}
