// record_fifo: one arbitrary record is followed from its write to its departure.
module record_fifo_properties (input clock);
  (* anyseq *) reg reset, write, ready, choose;
  (* anyseq *) reg [`RECORD-1:0] record;
  wire room, stall, valid, start_of_packet, end_of_packet;
  wire [`RECORD-1:0] data;
  record_fifo dut (
    .clock(clock), .reset(reset), .write(write), .record(record), .room(room), .stall(stall), .ready(ready),
    .valid(valid), .data(data), .start_of_packet(start_of_packet), .end_of_packet(end_of_packet)
  );

  // The rules of the stream.
  wire in_packet;
  avalon_stream #(.DATA(`RECORD)) stream (
    .clock(clock), .reset(reset), .ready(ready), .valid(valid), .data(data), .startofpacket(start_of_packet),
    .endofpacket(end_of_packet), .in_packet(in_packet)
  );

  (* hierconn *) wire [`FIFO_BITS:0] \dut.waiting ;
  (* hierconn *) wire [`FIFO_BITS-1:0] \dut.read_address ;
  (* hierconn *) wire [`FIFO_BITS-1:0] \dut.write_address ;
  (* hierconn *) wire \dut.next_valid ;
  (* hierconn *) wire \dut.pop ;
  (* hierconn *) wire \dut.take_data ;
  (* hierconn *) wire [`RECORD-1:0] \dut.next ;
  (* hierconn *) wire [`FIFO_BITS-1:0] \dut.watched_address ;
  (* hierconn *) wire [`RECORD-1:0] \dut.watched ;

  localparam NOT_YET = 3'd0, STORED = 3'd1, NEXT = 3'd2, OFFERED = 3'd3, GONE = 3'd4;
  reg [2:0] place = NOT_YET;
  reg [`FIFO_BITS-1:0] at;
  reg [`RECORD-1:0] word;
  // Number of records before the followed one, and of all records inside.
  reg [`FIFO_BITS:0] ahead, inside;
  reg begun = 0, was_reset, was_stalled = 0;
  wire leaves = valid & ready;
  // Records are inside and none is offered; this lasts for at most two clocks.
  wire idle = inside != 10'd0 & ~valid;
  reg idle_1 = 0, idle_2 = 0;
  // A record was stored and none waited before the output.
  reg was_movable = 0;
  wire chosen = write & choose & (place == NOT_YET);
  assign \dut.watched_address = at;

  always @(posedge clock) begin
    begun <= 1;
    was_reset <= reset;
    was_movable <= ~reset & ~\dut.next_valid & \dut.waiting != 0;
    was_stalled <= stall & ~reset;
    {idle_2, idle_1} <= reset ? 2'b00 : {idle_1, idle};
    if (reset) begin
      place <= NOT_YET;
      inside <= 10'd0;
    end else begin
      inside <= inside + {9'd0, write} - {9'd0, leaves};
      if (chosen) begin
        place <= STORED;
        at <= \dut.write_address ;
        word <= record;
        ahead <= inside - {9'd0, leaves};
      end else begin
        if (place == STORED && \dut.pop && \dut.read_address == at) place <= NEXT;
        if (place == NEXT && \dut.take_data ) place <= OFFERED;
        if (place == OFFERED && leaves) place <= GONE;
        if (place != NOT_YET && place != OFFERED && leaves) ahead <= ahead - 10'd1;
      end
    end
  end

  wire [`FIFO_BITS-1:0] behind_read = at - \dut.read_address ;
  always @(posedge clock) begin
    if (!begun) assume (reset);
    // The writer's part of the contract: no step, so no record, in the clock after `stall` (claim `sequencer`).
    assume (!(write && was_stalled));
    if (begun) begin
      never_full: assert (\dut.waiting <= `FIFO-2 && (was_stalled || \dut.waiting <= `FIFO-3));
      addresses: assert (\dut.waiting [`FIFO_BITS-1:0] == \dut.write_address - \dut.read_address );
      conserved: assert (inside == \dut.waiting + {9'd0, \dut.next_valid } + {9'd0, valid});
      stored: assert (place != STORED || (\dut.watched == word && {1'b0, behind_read} < \dut.waiting
        && ahead == {1'b0, behind_read} + {9'd0, \dut.next_valid } + {9'd0, valid}));
      next: assert (place != NEXT || (\dut.next_valid && \dut.next == word && ahead == {9'd0, valid}));
      offered: assert (place != OFFERED || (valid && data == word && ahead == 10'd0));
      offers: assert (!(idle && idle_1 && idle_2));
      // Invariant: after one clock a record waits before the output.
      on_its_way: assert (!(idle && idle_1 && !was_reset) || \dut.next_valid );
      moves_up: assert (!was_movable || \dut.next_valid );
      packets: assert (start_of_packet == !in_packet);
      ends: assert (end_of_packet == data[63]);
      told_room: assert (room == (\dut.waiting < `FIFO-16));
      told_stall: assert (stall == (\dut.waiting >= `FIFO-3));
      known: assert (place <= GONE);
      left: cover (place == GONE && word == 77);
      queued: cover (place == STORED && ahead == 10'd2);
    end
  end
endmodule
