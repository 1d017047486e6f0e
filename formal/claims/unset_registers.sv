// Registers whose value after a reset does not matter: position and error bits of `sequencer`, position and line of
// `tail_counter`. Each module is compared with its text without a fault: from equal states before the same reset, all other
// registers and all outputs are equal.
module unset_registers_properties (input clock);
  (* anyseq *) reg reset, enable, committed, stall, valid, start_of_packet, end_of_packet, frame_done, advance, start;
  (* anyseq *) reg [10:0] new_width, width;
  (* anyseq *) reg [11:0] new_height;
  (* anyseq *) reg [15:0] data;
  wire [0:0] golden_ready;
  wire [10:0] golden_width;
  wire [11:0] golden_height;
  wire [0:0] golden_capture;
  wire [0:0] golden_advance;
  wire [0:0] golden_start;
  wire [15:0] golden_pixel;
  wire [0:0] golden_busy;
  wire [3:0] golden_errors;
  wire [3:0] golden_frame_errors;
  golden_sequencer golden (
    .clock(clock), .reset(reset), .enable(enable), .new_width(new_width), .new_height(new_height),
    .committed(committed), .stall(stall), .valid(valid), .data(data), .start_of_packet(start_of_packet),
    .end_of_packet(end_of_packet), .frame_done(frame_done), .ready(golden_ready), .width(golden_width), .height(golden_height),
    .capture(golden_capture), .advance(golden_advance), .start(golden_start), .pixel(golden_pixel), .busy(golden_busy),
    .errors(golden_errors), .frame_errors(golden_frame_errors)
  );
  (* hierconn *) wire [17:0] \golden.skid_front ;
  (* hierconn *) wire [17:0] \golden.skid_back ;
  (* hierconn *) wire [1:0] \golden.skid_count ;
  (* hierconn *) wire [1:0] \golden.state ;
  (* hierconn *) wire [0:0] \golden.ignoring ;
  (* hierconn *) wire [1:0] \golden.settle ;
  (* hierconn *) wire [16:0] \golden.drain ;
  (* hierconn *) wire [16:0] \golden.drain_from ;
  (* hierconn *) wire [10:0] \golden.offered_width ;
  (* hierconn *) wire [11:0] \golden.offered_height ;
  (* hierconn *) wire [0:0] \golden.possible ;
  (* hierconn *) wire [0:0] \golden.same ;
  (* hierconn *) wire [0:0] \golden.drained ;
  (* hierconn *) wire [0:0] \golden.committed_delayed ;
  (* hierconn *) wire [9:0] \golden.last_x ;
  (* hierconn *) wire [10:0] \golden.last_y ;
  (* hierconn *) wire [0:0] \golden.done_before ;
  (* hierconn *) wire [11:0] \golden.kept ;
  (* hierconn *) wire [2:0] \golden.frames ;
  (* hierconn *) wire [9:0] \golden.x ;
  (* hierconn *) wire [10:0] \golden.y ;
  (* hierconn *) wire [2:0] \golden.own ;
  wire [9:0] golden_outside;
  golden_tail_counter golden_tail (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .start(start), .outside(golden_outside)
  );
  (* hierconn *) wire [9:0] \golden_tail.x ;
  (* hierconn *) wire [5:0] \golden_tail.line ;
  (* hierconn *) wire [0:0] \golden_tail.active ;

  wire [0:0] dut_ready;
  wire [10:0] dut_width;
  wire [11:0] dut_height;
  wire [0:0] dut_capture;
  wire [0:0] dut_advance;
  wire [0:0] dut_start;
  wire [15:0] dut_pixel;
  wire [0:0] dut_busy;
  wire [3:0] dut_errors;
  wire [3:0] dut_frame_errors;
  sequencer dut (
    .clock(clock), .reset(reset), .enable(enable), .new_width(new_width), .new_height(new_height),
    .committed(committed), .stall(stall), .valid(valid), .data(data), .start_of_packet(start_of_packet),
    .end_of_packet(end_of_packet), .frame_done(frame_done), .ready(dut_ready), .width(dut_width), .height(dut_height),
    .capture(dut_capture), .advance(dut_advance), .start(dut_start), .pixel(dut_pixel), .busy(dut_busy),
    .errors(dut_errors), .frame_errors(dut_frame_errors)
  );
  (* hierconn *) wire [17:0] \dut.skid_front ;
  (* hierconn *) wire [17:0] \dut.skid_back ;
  (* hierconn *) wire [1:0] \dut.skid_count ;
  (* hierconn *) wire [1:0] \dut.state ;
  (* hierconn *) wire [0:0] \dut.ignoring ;
  (* hierconn *) wire [1:0] \dut.settle ;
  (* hierconn *) wire [16:0] \dut.drain ;
  (* hierconn *) wire [16:0] \dut.drain_from ;
  (* hierconn *) wire [10:0] \dut.offered_width ;
  (* hierconn *) wire [11:0] \dut.offered_height ;
  (* hierconn *) wire [0:0] \dut.possible ;
  (* hierconn *) wire [0:0] \dut.same ;
  (* hierconn *) wire [0:0] \dut.drained ;
  (* hierconn *) wire [0:0] \dut.committed_delayed ;
  (* hierconn *) wire [9:0] \dut.last_x ;
  (* hierconn *) wire [10:0] \dut.last_y ;
  (* hierconn *) wire [0:0] \dut.done_before ;
  (* hierconn *) wire [11:0] \dut.kept ;
  (* hierconn *) wire [2:0] \dut.frames ;
  (* hierconn *) wire [9:0] \dut.x ;
  (* hierconn *) wire [10:0] \dut.y ;
  (* hierconn *) wire [2:0] \dut.own ;
  wire [9:0] dut_outside;
  tail_counter dut_tail (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .start(start), .outside(dut_outside)
  );
  (* hierconn *) wire [9:0] \dut_tail.x ;
  (* hierconn *) wire [5:0] \dut_tail.line ;
  (* hierconn *) wire [0:0] \dut_tail.active ;

  wire [186:0] golden_rest = {
    \golden.skid_front , \golden.skid_back , \golden.skid_count , \golden.state , \golden.ignoring ,
    \golden.settle , \golden.drain , \golden.drain_from , \golden.offered_width , \golden.offered_height ,
    \golden.possible , \golden.same , \golden.drained , \golden.committed_delayed , \golden.last_x ,
    \golden.last_y , \golden.done_before , \golden.kept , \golden.frames , golden_width, golden_height,
    golden_advance, golden_start, golden_pixel, golden_errors, \golden_tail.active 
  };
  wire [186:0] dut_rest = {
    \dut.skid_front , \dut.skid_back , \dut.skid_count , \dut.state , \dut.ignoring , \dut.settle ,
    \dut.drain , \dut.drain_from , \dut.offered_width , \dut.offered_height , \dut.possible , \dut.same ,
    \dut.drained , \dut.committed_delayed , \dut.last_x , \dut.last_y , \dut.done_before , \dut.kept ,
    \dut.frames , dut_width, dut_height, dut_advance, dut_start, dut_pixel, dut_errors, \dut_tail.active 
  };

  reg begun = 0;
  always @(posedge clock) begin
    begun <= 1;
    if (!begun) begin
      assume (reset);
      before: assume (golden_rest == dut_rest && {\golden.x , \golden.y , \golden.own } == {\dut.x , \dut.y , \dut.own }
        && {\golden_tail.x , \golden_tail.line } == {\dut_tail.x , \dut_tail.line });
    end else begin
      rest: assert (golden_rest == dut_rest);
      in_frame: assert (\golden.state == 2'd0
        || {\golden.x , \golden.y , \golden.own } == {\dut.x , \dut.y , \dut.own });
      in_tail: assert (!\golden_tail.active || {\golden_tail.x , \golden_tail.line } == {\dut_tail.x , \dut_tail.line });
      outputs: assert (golden_ready == dut_ready && golden_capture == dut_capture && golden_busy == dut_busy
        && golden_frame_errors == dut_frame_errors && golden_outside == dut_outside);
      frame: cover (\golden.state == 2'd1);
    end
  end
endmodule
