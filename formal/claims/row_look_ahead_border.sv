// row_look_ahead_border_N compared with its text without a fault: the operands are equal, whether the columns beyond the
// end of the row are counted down or up to 0; the count starts at half of its range.
// A stall changes no state, so a run with stalls has the states of one without.
module row_look_ahead_border_properties (input clock);
  (* anyseq *) reg reset, advance, last;
  (* anyseq *) reg [17:0] x, delayed;
  reg begun = 0;
  // No stall has occurred since the reset.
  reg flows = 1;
  always @(posedge clock) begin
    begun <= 1;
    flows <= flows && (advance || reset);
    assume (reset == !begun);
    counts: cover (begun && flows && p_16 != golden_q_16);
  end

  wire [17:0] golden_p_1, golden_q_1, p_1, q_1;
  golden_row_look_ahead_border_1 golden_1 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_1),
    .q(golden_q_1)
  );
  row_look_ahead_border_1 dut_1 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_1), .q(q_1)
  );
  (* hierconn *) wire [0:0] \golden_1.remaining ;
  (* hierconn *) wire [17:0] \golden_1.border ;
  (* hierconn *) wire [0:0] \dut_1.remaining ;
  (* hierconn *) wire [17:0] \dut_1.border ;
  wire [0:0] sum_1 = \golden_1.remaining + \dut_1.remaining ;
  wire [53:0] golden_rest_1 = {\golden_1.border , golden_p_1, golden_q_1};
  wire [53:0] rest_1 = {\dut_1.border , p_1, q_1};
  always @(posedge clock)
    if (!begun)
      assume (\golden_1.remaining == \dut_1.remaining && golden_rest_1 == rest_1);
    else begin
      waits_1: assert ($past(advance) || $past(reset)
        || ($stable(\golden_1.remaining ) && $stable(\dut_1.remaining ) && $stable(golden_rest_1) && $stable(rest_1)));
      either_way_1: assert (!flows || \dut_1.remaining == \golden_1.remaining || sum_1 == 1'd0);
      operands_1: assert (!flows || golden_rest_1 == rest_1);
    end

  wire [17:0] golden_p_2, golden_q_2, p_2, q_2;
  golden_row_look_ahead_border_2 golden_2 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_2),
    .q(golden_q_2)
  );
  row_look_ahead_border_2 dut_2 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_2), .q(q_2)
  );
  (* hierconn *) wire [1:0] \golden_2.remaining ;
  (* hierconn *) wire [17:0] \golden_2.border ;
  (* hierconn *) wire [1:0] \dut_2.remaining ;
  (* hierconn *) wire [17:0] \dut_2.border ;
  wire [1:0] sum_2 = \golden_2.remaining + \dut_2.remaining ;
  wire [53:0] golden_rest_2 = {\golden_2.border , golden_p_2, golden_q_2};
  wire [53:0] rest_2 = {\dut_2.border , p_2, q_2};
  always @(posedge clock)
    if (!begun)
      assume (\golden_2.remaining == \dut_2.remaining && golden_rest_2 == rest_2);
    else begin
      waits_2: assert ($past(advance) || $past(reset)
        || ($stable(\golden_2.remaining ) && $stable(\dut_2.remaining ) && $stable(golden_rest_2) && $stable(rest_2)));
      either_way_2: assert (!flows || \dut_2.remaining == \golden_2.remaining || sum_2 == 2'd0);
      operands_2: assert (!flows || golden_rest_2 == rest_2);
    end

  wire [17:0] golden_p_4, golden_q_4, p_4, q_4;
  golden_row_look_ahead_border_4 golden_4 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_4),
    .q(golden_q_4)
  );
  row_look_ahead_border_4 dut_4 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_4), .q(q_4)
  );
  (* hierconn *) wire [2:0] \golden_4.remaining ;
  (* hierconn *) wire [17:0] \golden_4.border ;
  (* hierconn *) wire [2:0] \dut_4.remaining ;
  (* hierconn *) wire [17:0] \dut_4.border ;
  wire [2:0] sum_4 = \golden_4.remaining + \dut_4.remaining ;
  wire [53:0] golden_rest_4 = {\golden_4.border , golden_p_4, golden_q_4};
  wire [53:0] rest_4 = {\dut_4.border , p_4, q_4};
  always @(posedge clock)
    if (!begun)
      assume (\golden_4.remaining == \dut_4.remaining && golden_rest_4 == rest_4);
    else begin
      waits_4: assert ($past(advance) || $past(reset)
        || ($stable(\golden_4.remaining ) && $stable(\dut_4.remaining ) && $stable(golden_rest_4) && $stable(rest_4)));
      either_way_4: assert (!flows || \dut_4.remaining == \golden_4.remaining || sum_4 == 3'd0);
      operands_4: assert (!flows || golden_rest_4 == rest_4);
    end

  wire [17:0] golden_p_8, golden_q_8, p_8, q_8;
  golden_row_look_ahead_border_8 golden_8 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_8),
    .q(golden_q_8)
  );
  row_look_ahead_border_8 dut_8 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_8), .q(q_8)
  );
  (* hierconn *) wire [3:0] \golden_8.remaining ;
  (* hierconn *) wire [17:0] \golden_8.border ;
  (* hierconn *) wire [3:0] \dut_8.remaining ;
  (* hierconn *) wire [17:0] \dut_8.border ;
  wire [3:0] sum_8 = \golden_8.remaining + \dut_8.remaining ;
  wire [53:0] golden_rest_8 = {\golden_8.border , golden_p_8, golden_q_8};
  wire [53:0] rest_8 = {\dut_8.border , p_8, q_8};
  always @(posedge clock)
    if (!begun)
      assume (\golden_8.remaining == \dut_8.remaining && golden_rest_8 == rest_8);
    else begin
      waits_8: assert ($past(advance) || $past(reset)
        || ($stable(\golden_8.remaining ) && $stable(\dut_8.remaining ) && $stable(golden_rest_8) && $stable(rest_8)));
      either_way_8: assert (!flows || \dut_8.remaining == \golden_8.remaining || sum_8 == 4'd0);
      operands_8: assert (!flows || golden_rest_8 == rest_8);
    end

  wire [17:0] golden_p_16, golden_q_16, p_16, q_16;
  golden_row_look_ahead_border_16 golden_16 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_16),
    .q(golden_q_16)
  );
  row_look_ahead_border_16 dut_16 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_16), .q(q_16)
  );
  (* hierconn *) wire [4:0] \golden_16.remaining ;
  (* hierconn *) wire [17:0] \golden_16.border ;
  (* hierconn *) wire [4:0] \dut_16.remaining ;
  (* hierconn *) wire [17:0] \dut_16.border ;
  wire [4:0] sum_16 = \golden_16.remaining + \dut_16.remaining ;
  wire [53:0] golden_rest_16 = {\golden_16.border , golden_p_16, golden_q_16};
  wire [53:0] rest_16 = {\dut_16.border , p_16, q_16};
  always @(posedge clock)
    if (!begun)
      assume (\golden_16.remaining == \dut_16.remaining && golden_rest_16 == rest_16);
    else begin
      waits_16: assert ($past(advance) || $past(reset)
        || ($stable(\golden_16.remaining ) && $stable(\dut_16.remaining ) && $stable(golden_rest_16) && $stable(rest_16)));
      either_way_16: assert (!flows || \dut_16.remaining == \golden_16.remaining || sum_16 == 5'd0);
      operands_16: assert (!flows || golden_rest_16 == rest_16);
    end

  wire [17:0] golden_p_32, golden_q_32, p_32, q_32;
  golden_row_look_ahead_border_32 golden_32 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_32),
    .q(golden_q_32)
  );
  row_look_ahead_border_32 dut_32 (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_32), .q(q_32)
  );
  (* hierconn *) wire [5:0] \golden_32.remaining ;
  (* hierconn *) wire [17:0] \golden_32.border ;
  (* hierconn *) wire [5:0] \dut_32.remaining ;
  (* hierconn *) wire [17:0] \dut_32.border ;
  wire [5:0] sum_32 = \golden_32.remaining + \dut_32.remaining ;
  wire [53:0] golden_rest_32 = {\golden_32.border , golden_p_32, golden_q_32};
  wire [53:0] rest_32 = {\dut_32.border , p_32, q_32};
  always @(posedge clock)
    if (!begun)
      assume (\golden_32.remaining == \dut_32.remaining && golden_rest_32 == rest_32);
    else begin
      waits_32: assert ($past(advance) || $past(reset)
        || ($stable(\golden_32.remaining ) && $stable(\dut_32.remaining ) && $stable(golden_rest_32) && $stable(rest_32)));
      either_way_32: assert (!flows || \dut_32.remaining == \golden_32.remaining || sum_32 == 6'd0);
      operands_32: assert (!flows || golden_rest_32 == rest_32);
    end
endmodule
