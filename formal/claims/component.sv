// component: the top that Platform Designer takes. Bytes of beats are pixels and records in memory order; the modules
// below may do anything that claim `top` allows.
module component_properties (input clock);
  (* anyseq *) reg reset, video_valid, video_empty, video_startofpacket, video_endofpacket, feature_ready;
  (* anyseq *) reg csr_read, csr_write;
  (* anyseq *) reg [15:0] video_data;
  (* anyseq *) reg [5:0] csr_address;
  (* anyseq *) reg [31:0] csr_writedata;
  wire video_ready, feature_valid, feature_startofpacket, feature_endofpacket, irq;
  wire [63:0] feature_data;
  wire [2:0] feature_empty;
  wire [31:0] csr_readdata;
  hoverlock_component dut (
    .clock(clock), .reset(reset), .video_ready(video_ready), .video_valid(video_valid), .video_data(video_data),
    .video_empty(video_empty), .video_startofpacket(video_startofpacket), .video_endofpacket(video_endofpacket),
    .feature_ready(feature_ready), .feature_valid(feature_valid), .feature_data(feature_data),
    .feature_empty(feature_empty), .feature_startofpacket(feature_startofpacket),
    .feature_endofpacket(feature_endofpacket), .csr_address(csr_address), .csr_read(csr_read),
    .csr_readdata(csr_readdata), .csr_write(csr_write), .csr_writedata(csr_writedata), .irq(irq)
  );

  (* hierconn *) wire \dut.top.reset ;
  (* hierconn *) wire \dut.top.video_ready ;
  (* hierconn *) wire \dut.top.video_valid ;
  (* hierconn *) wire [15:0] \dut.top.video_data ;
  (* hierconn *) wire \dut.top.video_startofpacket ;
  (* hierconn *) wire \dut.top.video_endofpacket ;
  (* hierconn *) wire \dut.top.feature_ready ;
  (* hierconn *) wire \dut.top.feature_valid ;
  (* hierconn *) wire [255:0] \dut.top.feature_data ;
  (* hierconn *) wire \dut.top.feature_startofpacket ;
  (* hierconn *) wire \dut.top.feature_endofpacket ;
  (* hierconn *) wire [5:0] \dut.top.csr_address ;
  (* hierconn *) wire \dut.top.csr_read ;
  (* hierconn *) wire [31:0] \dut.top.csr_readdata ;
  (* hierconn *) wire \dut.top.csr_write ;
  (* hierconn *) wire [31:0] \dut.top.csr_writedata ;
  (* hierconn *) wire \dut.top.irq ;
  (* hierconn *) wire [1:0] \dut.beat ;

  // A reset, also one by software, withdraws the record that waits; none is offered in the clock after it.
  (* anyseq *) reg withdraws;
  wire clears = reset | withdraws;
  reg begun = 0, was_cleared;
  wire in_packet, out_packet;
  avalon_stream #(.DATA(256), .ASSUMED(1)) records (
    .clock(clock), .reset(clears), .ready(\dut.top.feature_ready ), .valid(\dut.top.feature_valid ),
    .data(\dut.top.feature_data ), .startofpacket(\dut.top.feature_startofpacket ),
    .endofpacket(\dut.top.feature_endofpacket ), .in_packet(in_packet)
  );
  avalon_stream #(.DATA(67)) beats (
    .clock(clock), .reset(clears), .ready(feature_ready), .valid(feature_valid), .data({feature_empty, feature_data}),
    .startofpacket(feature_startofpacket), .endofpacket(feature_endofpacket), .in_packet(out_packet)
  );

  // Beats of the offered record that the sink has taken.
  reg [1:0] nth;
  always @(posedge clock) begin
    begun <= 1;
    was_cleared <= clears;
    if (clears)
      nth <= 2'd0;
    else if (feature_valid & feature_ready)
      nth <= nth + 2'd1;
  end

  wire [63:0] word = \dut.top.feature_data >> {nth, 6'd0};
  integer k;
  reg in_order;
  always @(*) begin
    in_order = 1;
    for (k = 0; k < 8; k = k + 1)
      in_order = in_order & (feature_data[8 * (7 - k) +: 8] == word[8 * k +: 8]);
  end
  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun && was_cleared) assume (!\dut.top.feature_valid );
    pixels: assert (\dut.top.video_data == {video_data[7:0], video_data[15:8]} && \dut.top.video_valid == video_valid
      && \dut.top.video_startofpacket == video_startofpacket && video_ready == \dut.top.video_ready );
    whole_pixels: assert (\dut.top.video_endofpacket == (video_endofpacket && !video_empty));
    registers: assert (\dut.top.csr_address == csr_address && \dut.top.csr_read == csr_read
      && \dut.top.csr_write == csr_write && \dut.top.csr_writedata == csr_writedata
      && csr_readdata == \dut.top.csr_readdata && irq == \dut.top.irq && \dut.top.reset == reset);
    if (begun) begin
      counts: assert (\dut.top.feature_valid ? \dut.beat == nth : clears || nth == 2'd0);
      bytes: assert (feature_valid == \dut.top.feature_valid && feature_empty == 3'd0 && (!feature_valid || in_order));
      taken: assert (!feature_valid || \dut.top.feature_ready == (feature_ready && nth == 2'd3));
      packets: assert (!feature_valid || (feature_startofpacket == (\dut.top.feature_startofpacket && nth == 2'd0)
        && feature_endofpacket == (\dut.top.feature_endofpacket && nth == 2'd3)));
      same_packet: assert (was_cleared ? !in_packet && !out_packet && nth == 2'd0 : out_packet == (in_packet || nth != 2'd0));
      last_beat: cover (feature_valid && feature_endofpacket && feature_ready);
    end
  end
endmodule
