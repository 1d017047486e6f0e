// top: the record stream of the whole design, for every video stream, register access and sink. Sequencer, registers,
// writer and FIFO are the real ones; the modules that compute features may output any value in each step.
module top_properties (input clock);
  (* anyseq *) reg reset, video_valid, video_startofpacket, video_endofpacket, feature_ready, csr_read, csr_write;
  (* anyseq *) reg [`P-1:0] video_data;
  (* anyseq *) reg [5:0] csr_address;
  (* anyseq *) reg [31:0] csr_writedata;
  wire video_ready, feature_valid, feature_startofpacket, feature_endofpacket, irq;
  wire [`RECORD-1:0] feature_data;
  wire [31:0] csr_readdata;
  hoverlock_top dut (
    .clock(clock), .reset(reset), .video_ready(video_ready), .video_valid(video_valid), .video_data(video_data),
    .video_startofpacket(video_startofpacket), .video_endofpacket(video_endofpacket), .feature_ready(feature_ready),
    .feature_valid(feature_valid), .feature_data(feature_data), .feature_startofpacket(feature_startofpacket),
    .feature_endofpacket(feature_endofpacket), .csr_address(csr_address), .csr_read(csr_read),
    .csr_readdata(csr_readdata), .csr_write(csr_write), .csr_writedata(csr_writedata), .irq(irq)
  );

  // A reset by software clears the pipeline, including the record that waits at the output.
  (* hierconn *) wire \dut.registers_clear ;
  (* hierconn *) wire [`FIFO_BITS:0] \dut.core.fifo.waiting ;
  (* hierconn *) wire [`FIFO_BITS-1:0] \dut.core.fifo.read_address ;
  (* hierconn *) wire [`FIFO_BITS-1:0] \dut.core.fifo.write_address ;
  (* hierconn *) wire \dut.core.fifo.next_valid ;
  (* hierconn *) wire \dut.core.fifo.in_packet ;
  (* hierconn *) wire \dut.core.fifo_stall ;
  (* hierconn *) wire \dut.core.extractor_write ;
  (* hierconn *) wire [`RECORD-1:0] \dut.core.extractor_record ;
  (* hierconn *) wire \dut.core.extractor.writer_done ;
  (* hierconn *) wire \dut.core.extractor.writer_write ;
  (* hierconn *) wire \dut.core.sequencer_advance ;

  (* hierconn *) wire \dut.core.sequencer_capture ;
  (* hierconn *) wire [`W-1:0] \dut.core.sequencer_width ;
  (* hierconn *) wire [11:0] \dut.core.sequencer_height ;
  (* hierconn *) wire [`B-1:0] \dut.core.extractor.frame_bank ;
  (* hierconn *) wire [`W-1:0] \dut.core.extractor.width ;
  (* hierconn *) wire [11:0] \dut.core.extractor.height ;
  (* hierconn *) wire [`B-1:0] \dut.registers_bank ;
  (* hierconn *) wire [`W-1:0] \dut.registers_width ;
  (* hierconn *) wire [11:0] \dut.registers_height ;
  (* hierconn *) wire \dut.registers_committed ;
  (* hierconn *) wire [`W-1:0] \dut.registers.taken_width ;
  (* hierconn *) wire [11:0] \dut.registers.taken_height ;
  (* hierconn *) wire [1:0] \dut.core.sequencer.state ;
  (* hierconn *) wire \dut.core.sequencer.same ;
  (* hierconn *) wire \dut.core.sequencer.possible ;
  (* hierconn *) wire \dut.core.sequencer.committed_delayed ;
  (* hierconn *) wire [`W-1:0] \dut.core.sequencer.offered_width ;
  (* hierconn *) wire [11:0] \dut.core.sequencer.offered_height ;

  // The set of the frame in progress, or of the last one: registers and size in the clock in which it began, if they were
  // committed then, and otherwise the set of the frame before. A reset by software leaves it.
  wire [`B+`W+11:0] offered = {\dut.registers_height , \dut.registers_width , \dut.registers_bank };
  wire [`B+`W+11:0] used = {\dut.core.extractor.height , \dut.core.extractor.width , \dut.core.extractor.frame_bank };
  reg taken = 0, was_committed;
  reg [`B+`W+11:0] set, was_offered;
  wire [`W-1:0] was_width = was_offered[`B+`W-1:`B];
  wire [11:0] was_height = was_offered[`B+`W+11:`B+`W];
  always @(posedge clock) begin
    was_offered <= offered;
    was_committed <= \dut.registers_committed ;
    if (reset)
      taken <= 0;
    else if (\dut.core.sequencer_capture && \dut.registers_committed ) begin
      taken <= 1;
      set <= offered;
    end
  end

  // `reset` reaches the pipeline a clock later: before, its registers may have any value.
  reg begun = 0, cleared = 0, was_reset, was_stalled;
  wire in_packet;
  avalon_stream #(.DATA(`RECORD)) stream (
    .clock(clock), .reset(\dut.registers_clear | ~cleared), .ready(feature_ready), .valid(feature_valid), .data(feature_data),
    .startofpacket(feature_startofpacket), .endofpacket(feature_endofpacket), .in_packet(in_packet)
  );

  // Number of records in the FIFO, and of trailers among them.
  reg [`FIFO_BITS:0] inside = 10'd0;
  wire leaves = feature_valid & feature_ready;
  always @(posedge clock) begin
    begun <= 1;
    cleared <= cleared | \dut.registers_clear ;
    was_reset <= \dut.registers_clear ;
    was_stalled <= \dut.core.fifo_stall ;
    inside <= \dut.registers_clear ? 10'd0 : inside + {9'd0, \dut.core.extractor_write } - {9'd0, leaves};
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    before: assert (cleared || (!taken && (!begun || \dut.registers_clear )));
    if (cleared) begin
      // The assumption of claim `record_fifo`, here proved of the writer and the sequencer together.
      no_write_after_stall: assert (was_reset || !was_stalled || !\dut.core.extractor_write );
      never_full: assert (\dut.core.fifo.waiting <= `FIFO-2 && (was_reset || was_stalled || \dut.core.fifo.waiting <= `FIFO-3));
      withdrawn: assert (!was_reset || !feature_valid);
      stall_reported: assert (\dut.core.fifo_stall == (\dut.core.fifo.waiting >= `FIFO-3));
      conserved: assert (inside == \dut.core.fifo.waiting + {9'd0, \dut.core.fifo.next_valid } + {9'd0, feature_valid});
      packets: assert (in_packet == \dut.core.fifo.in_packet );
      // The end of a packet is written with `done` and never otherwise: each finished frame ends one packet.
      one_end_a_frame: assert (!\dut.core.extractor.writer_write
        || \dut.core.extractor_record [63] == \dut.core.extractor.writer_done );
      ends_are_written: assert (!\dut.core.extractor.writer_done || \dut.core.extractor.writer_write );
      one_set: assert (!taken || used[`B-1:0] == set[`B-1:0]);
      its_size: assert (\dut.registers_clear || \dut.core.sequencer.state == 2'd0 || (taken && used[`B+`W+11:`B] == set[`B+`W+11:`B]));
      begins_with_a_set: assert (!\dut.core.sequencer_capture || taken || \dut.registers_committed );
      // Invariants, proved of `csr` and `sequencer` too.
      last_size: assert ({\dut.registers.taken_height , \dut.registers.taken_width } == (taken ? set[`B+`W+11:`B] : 0));
      with_commit: assert (\dut.registers_clear || offered[`B+`W+11:`B] == was_offered[`B+`W+11:`B]
        || \dut.registers_committed != was_committed);
      sequencer_size: assert ({\dut.core.sequencer.offered_height , \dut.core.sequencer.offered_width } == was_offered[`B+`W+11:`B]
        && \dut.core.sequencer.committed_delayed == was_committed
        && \dut.core.sequencer.possible == (was_width >= 11'd64 && was_width <= `COLUMNS && was_height >= 12'd64
          && was_height <= 12'd2048)
        && (was_reset || \dut.core.sequencer.same
          == (was_offered[`B+`W+11:`B] == {\dut.core.sequencer_height , \dut.core.sequencer_width })));
      packet_ends: cover (feature_valid && feature_endofpacket && !feature_startofpacket);
      held_back: cover (inside == 10'd3);
    end
  end
endmodule
