// top: the record stream of the whole design, for every video stream, register access and sink. Sequencer, registers,
// writer and FIFO are the real ones; the modules that compute features may output any value in each step.
module top_properties (input clock);
  (* anyseq *) reg reset, video_valid, video_startofpacket, video_endofpacket, feature_ready, csr_read, csr_write;
  (* anyseq *) reg [15:0] video_data;
  (* anyseq *) reg [5:0] csr_address;
  (* anyseq *) reg [31:0] csr_writedata;
  wire video_ready, feature_valid, feature_startofpacket, feature_endofpacket, irq;
  wire [255:0] feature_data;
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
  (* hierconn *) wire [9:0] \dut.core.fifo.waiting ;
  (* hierconn *) wire [8:0] \dut.core.fifo.read_address ;
  (* hierconn *) wire [8:0] \dut.core.fifo.write_address ;
  (* hierconn *) wire \dut.core.fifo.next_valid ;
  (* hierconn *) wire \dut.core.fifo.in_packet ;
  (* hierconn *) wire \dut.core.fifo_stall ;
  (* hierconn *) wire \dut.core.extractor_write ;
  (* hierconn *) wire [255:0] \dut.core.extractor_record ;
  (* hierconn *) wire \dut.core.extractor.writer_done ;
  (* hierconn *) wire \dut.core.extractor.writer_write ;
  (* hierconn *) wire \dut.core.sequencer_advance ;

  // `reset` reaches the pipeline a clock later: before, its registers may have any value.
  reg begun = 0, cleared = 0, was_reset, was_stalled;
  wire in_packet;
  avalon_stream #(.DATA(256)) stream (
    .clock(clock), .reset(\dut.registers_clear | ~cleared), .ready(feature_ready), .valid(feature_valid), .data(feature_data),
    .startofpacket(feature_startofpacket), .endofpacket(feature_endofpacket), .in_packet(in_packet)
  );

  // Number of records in the FIFO, and of trailers among them.
  reg [9:0] inside = 10'd0;
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
    if (cleared) begin
      // The assumption of claim `record_fifo`, here proved of the writer and the sequencer together.
      no_write_after_stall: assert (was_reset || !was_stalled || !\dut.core.extractor_write );
      never_full: assert (\dut.core.fifo.waiting <= 10'd510 && (was_reset || was_stalled || \dut.core.fifo.waiting <= 10'd509));
      stall_reported: assert (\dut.core.fifo_stall == (\dut.core.fifo.waiting >= 10'd509));
      conserved: assert (inside == \dut.core.fifo.waiting + {9'd0, \dut.core.fifo.next_valid } + {9'd0, feature_valid});
      packets: assert (in_packet == \dut.core.fifo.in_packet );
      // The end of a packet is written with `done` and never otherwise: each finished frame ends one packet.
      one_end_a_frame: assert (!\dut.core.extractor.writer_write
        || \dut.core.extractor_record [63] == \dut.core.extractor.writer_done );
      ends_are_written: assert (!\dut.core.extractor.writer_done || \dut.core.extractor.writer_write );
      packet_ends: cover (feature_valid && feature_endofpacket && !feature_startofpacket);
      held_back: cover (inside == 10'd3);
    end
  end
endmodule
