// The marker that loads the coefficients of the column look-ahead stages, through all six, in two copies: `golden` after a
// reset, and one in which the delays of stages 0 to 4 have arbitrary contents and are never reset. The true marker of the
// first frame overtakes a false one in the next stage, so none leaves stage 5; and from its true marker on each stage is
// as after a reset.
module markers_properties (input clock);
  (* anyseq *) reg reset, advance, load;
  (* anyseq *) reg [15:0] g;
  (* anyconst *) reg [10:0] width;
  // The smoothers of five stages get their marker 32 lines and 44 steps later; they have no stage 5.
  (* anyconst *) reg late;

  reg begun = 0;
  // Steps since the reset, until the first marker has entered stage 5, and since the last marker.
  reg [16:0] steps = 17'd0, since = 17'd0;
  wire [16:0] lines_64 = {width, 6'd0};
  // The step in which the first marker enters each stage.
  wire [16:0] enters_0 = late ? {1'b0, width, 5'd0} + 17'd46 : 17'd2;
  wire [16:0] enters_1 = enters_0 + ({6'd0, width} << 1) - {6'd0, width} + 17'd4;
  wire [16:0] enters_2 = enters_0 + ({6'd0, width} << 2) - {6'd0, width} + 17'd8;
  wire [16:0] enters_3 = enters_0 + ({6'd0, width} << 3) - {6'd0, width} + 17'd12;
  wire [16:0] enters_4 = enters_0 + ({6'd0, width} << 4) - {6'd0, width} + 17'd16;
  wire [16:0] enters_5 = enters_0 + ({6'd0, width} << 5) - {6'd0, width} + 17'd20;
  wire first_pass = steps <= enters_5;
  always @(posedge clock) begin
    begun <= 1;
    if (reset) begin
      steps <= 17'd0;
      since <= 17'd0;
    end else if (advance) begin
      if (first_pass) steps <= steps + 17'd1;
      since <= load ? 17'd1 : since != lines_64 ? since + 17'd1 : since;
    end
  end

  wire golden_loads_0, loads_0;
  golden_column_look_ahead_0 golden_0 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(load), .g(g), .loads(golden_loads_0)
  );
  column_look_ahead_0 dut_0 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .load(load), .g(g), .loads(loads_0)
  );
  (* hierconn *) wire [11:0] \golden_0.load_delay.remaining ;
  (* hierconn *) wire [11:0] \golden_0.load_delay.total ;
  (* hierconn *) wire [15:0] \golden_0.coefficient_g ;
  (* hierconn *) wire [11:0] \dut_0.load_delay.remaining ;
  (* hierconn *) wire [11:0] \dut_0.load_delay.total ;
  (* hierconn *) wire [15:0] \dut_0.coefficient_g ;
  // The true marker has entered; entered in the last step; has left.
  reg entered_0 = 0, fresh_0 = 0, left_0 = 0;
  wire golden_loads_1, loads_1;
  golden_column_look_ahead_1 golden_1 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(golden_loads_0), .g(g), .loads(golden_loads_1)
  );
  column_look_ahead_1 dut_1 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .load(loads_0), .g(g), .loads(loads_1)
  );
  (* hierconn *) wire [11:0] \golden_1.load_delay.remaining ;
  (* hierconn *) wire [11:0] \golden_1.load_delay.total ;
  (* hierconn *) wire [15:0] \golden_1.coefficient_g ;
  (* hierconn *) wire [11:0] \dut_1.load_delay.remaining ;
  (* hierconn *) wire [11:0] \dut_1.load_delay.total ;
  (* hierconn *) wire [15:0] \dut_1.coefficient_g ;
  // The true marker has entered; entered in the last step; has left.
  reg entered_1 = 0, fresh_1 = 0, left_1 = 0;
  wire golden_loads_2, loads_2;
  golden_column_look_ahead_2 golden_2 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(golden_loads_1), .g(g), .loads(golden_loads_2)
  );
  column_look_ahead_2 dut_2 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .load(loads_1), .g(g), .loads(loads_2)
  );
  (* hierconn *) wire [12:0] \golden_2.load_delay.remaining ;
  (* hierconn *) wire [12:0] \golden_2.load_delay.total ;
  (* hierconn *) wire [15:0] \golden_2.coefficient_g ;
  (* hierconn *) wire [12:0] \dut_2.load_delay.remaining ;
  (* hierconn *) wire [12:0] \dut_2.load_delay.total ;
  (* hierconn *) wire [15:0] \dut_2.coefficient_g ;
  // The true marker has entered; entered in the last step; has left.
  reg entered_2 = 0, fresh_2 = 0, left_2 = 0;
  wire golden_loads_3, loads_3;
  golden_column_look_ahead_3 golden_3 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(golden_loads_2), .g(g), .loads(golden_loads_3)
  );
  column_look_ahead_3 dut_3 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .load(loads_2), .g(g), .loads(loads_3)
  );
  (* hierconn *) wire [13:0] \golden_3.load_delay.remaining ;
  (* hierconn *) wire [13:0] \golden_3.load_delay.total ;
  (* hierconn *) wire [15:0] \golden_3.coefficient_g ;
  (* hierconn *) wire [13:0] \dut_3.load_delay.remaining ;
  (* hierconn *) wire [13:0] \dut_3.load_delay.total ;
  (* hierconn *) wire [15:0] \dut_3.coefficient_g ;
  // The true marker has entered; entered in the last step; has left.
  reg entered_3 = 0, fresh_3 = 0, left_3 = 0;
  wire golden_loads_4, loads_4;
  golden_column_look_ahead_4 golden_4 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(golden_loads_3), .g(g), .loads(golden_loads_4)
  );
  column_look_ahead_4 dut_4 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .load(loads_3), .g(g), .loads(loads_4)
  );
  (* hierconn *) wire [14:0] \golden_4.load_delay.remaining ;
  (* hierconn *) wire [14:0] \golden_4.load_delay.total ;
  (* hierconn *) wire [15:0] \golden_4.coefficient_g ;
  (* hierconn *) wire [14:0] \dut_4.load_delay.remaining ;
  (* hierconn *) wire [14:0] \dut_4.load_delay.total ;
  (* hierconn *) wire [15:0] \dut_4.coefficient_g ;
  // The true marker has entered; entered in the last step; has left.
  reg entered_4 = 0, fresh_4 = 0, left_4 = 0;
  wire golden_loads_5, loads_5;
  golden_column_look_ahead_5 golden_5 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(golden_loads_4), .g(g), .loads(golden_loads_5)
  );
  column_look_ahead_5 dut_5 (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .load(loads_4), .g(g), .loads(loads_5)
  );
  (* hierconn *) wire [15:0] \golden_5.load_delay.remaining ;
  (* hierconn *) wire [15:0] \golden_5.load_delay.total ;
  (* hierconn *) wire [15:0] \golden_5.coefficient_g ;
  (* hierconn *) wire [15:0] \dut_5.load_delay.remaining ;
  (* hierconn *) wire [15:0] \dut_5.load_delay.total ;
  (* hierconn *) wire [15:0] \dut_5.coefficient_g ;
  // The true marker has entered; entered in the last step; has left.
  reg entered_5 = 0, fresh_5 = 0, left_5 = 0;

  always @(posedge clock)
    if (reset) begin
      entered_0 <= 0;
      fresh_0 <= 0;
      left_0 <= 0;
      entered_1 <= 0;
      fresh_1 <= 0;
      left_1 <= 0;
      entered_2 <= 0;
      fresh_2 <= 0;
      left_2 <= 0;
      entered_3 <= 0;
      fresh_3 <= 0;
      left_3 <= 0;
      entered_4 <= 0;
      fresh_4 <= 0;
      left_4 <= 0;
      entered_5 <= 0;
      fresh_5 <= 0;
      left_5 <= 0;
    end else if (advance) begin
      entered_0 <= entered_0 | load;
      fresh_0 <= load & ~entered_0;
      left_0 <= left_0 | golden_loads_0;
      entered_1 <= entered_1 | golden_loads_0;
      fresh_1 <= golden_loads_0 & ~entered_1;
      left_1 <= left_1 | golden_loads_1;
      entered_2 <= entered_2 | golden_loads_1;
      fresh_2 <= golden_loads_1 & ~entered_2;
      left_2 <= left_2 | golden_loads_2;
      entered_3 <= entered_3 | golden_loads_2;
      fresh_3 <= golden_loads_2 & ~entered_3;
      left_3 <= left_3 | golden_loads_3;
      entered_4 <= entered_4 | golden_loads_3;
      fresh_4 <= golden_loads_3 & ~entered_4;
      left_4 <= left_4 | golden_loads_4;
      entered_5 <= entered_5 | golden_loads_4;
      fresh_5 <= golden_loads_4 & ~entered_5;
      left_5 <= left_5 | golden_loads_5;
    end

  always @(posedge clock) begin
    // A free width from 64 to 1024 makes the sums of lengths symbolic, which is too much for the solver.
    assume (width == 11'd64 || width == 11'd65 || width == 11'd640 || width == 11'd1023 || width == 11'd1024);
    assume (reset == !begun);
    // The first step after a reset is the first of a frame; later frames follow at least 64 lines apart.
    if (!entered_0)
      assume (!advance || load == (steps == enters_0));
    else
      assume (!advance || !load || since == lines_64);
    if (begun) begin
      spaced: assert (since <= lines_64 && (entered_0 ? first_pass ? steps > enters_0 && since == steps - enters_0 : since >= 17'd1 : steps <= enters_0));
      lines_0: assert (\dut_0.load_delay.total == ({6'd0, width} << 0) + 17'd3 && \golden_0.load_delay.total == \dut_0.load_delay.total );
      golden_0_first: assert (!first_pass || (
        steps > enters_0 && steps < enters_1 ? \golden_0.load_delay.remaining == enters_1 - steps && !golden_loads_0
        : \golden_0.load_delay.remaining == 0 && golden_loads_0 == (steps == enters_1)));
      entered_0_when: assert (!first_pass || (entered_0 == (steps > enters_0) && fresh_0 == (steps == enters_0 + 17'd1)));
      after_0: assert (first_pass || (entered_0 && (!fresh_0 || 0 == 5)));
      fresh_0_waits: assert (!fresh_0 || !golden_loads_0);
      as_after_reset_0: assert (!entered_0 || \dut_0.load_delay.remaining == \golden_0.load_delay.remaining );
      loads_as_after_reset_0: assert (!entered_0 || fresh_0 || loads_0 == golden_loads_0);
      left_0_entered: assert (!left_0 || (entered_0 && !fresh_0 && (!first_pass || steps > enters_1)));
      coefficient_0: assert (!left_0 || \dut_0.coefficient_g == \golden_0.coefficient_g );
      lines_1: assert (\dut_1.load_delay.total == ({6'd0, width} << 1) + 17'd3 && \golden_1.load_delay.total == \dut_1.load_delay.total );
      golden_1_first: assert (!first_pass || (
        steps > enters_1 && steps < enters_2 ? \golden_1.load_delay.remaining == enters_2 - steps && !golden_loads_1
        : \golden_1.load_delay.remaining == 0 && golden_loads_1 == (steps == enters_2)));
      entered_1_when: assert (!first_pass || (entered_1 == (steps > enters_1) && fresh_1 == (steps == enters_1 + 17'd1)));
      after_1: assert (first_pass || (entered_1 && (!fresh_1 || 1 == 5)));
      fresh_1_waits: assert (!fresh_1 || !golden_loads_1);
      as_after_reset_1: assert (!entered_1 || \dut_1.load_delay.remaining == \golden_1.load_delay.remaining );
      loads_as_after_reset_1: assert (!entered_1 || fresh_1 || loads_1 == golden_loads_1);
      left_1_entered: assert (!left_1 || (entered_1 && !fresh_1 && (!first_pass || steps > enters_2)));
      coefficient_1: assert (!left_1 || \dut_1.coefficient_g == \golden_1.coefficient_g );
      lines_2: assert (\dut_2.load_delay.total == ({6'd0, width} << 2) + 17'd3 && \golden_2.load_delay.total == \dut_2.load_delay.total );
      golden_2_first: assert (!first_pass || (
        steps > enters_2 && steps < enters_3 ? \golden_2.load_delay.remaining == enters_3 - steps && !golden_loads_2
        : \golden_2.load_delay.remaining == 0 && golden_loads_2 == (steps == enters_3)));
      entered_2_when: assert (!first_pass || (entered_2 == (steps > enters_2) && fresh_2 == (steps == enters_2 + 17'd1)));
      after_2: assert (first_pass || (entered_2 && (!fresh_2 || 2 == 5)));
      fresh_2_waits: assert (!fresh_2 || !golden_loads_2);
      as_after_reset_2: assert (!entered_2 || \dut_2.load_delay.remaining == \golden_2.load_delay.remaining );
      loads_as_after_reset_2: assert (!entered_2 || fresh_2 || loads_2 == golden_loads_2);
      left_2_entered: assert (!left_2 || (entered_2 && !fresh_2 && (!first_pass || steps > enters_3)));
      coefficient_2: assert (!left_2 || \dut_2.coefficient_g == \golden_2.coefficient_g );
      lines_3: assert (\dut_3.load_delay.total == ({6'd0, width} << 3) + 17'd3 && \golden_3.load_delay.total == \dut_3.load_delay.total );
      golden_3_first: assert (!first_pass || (
        steps > enters_3 && steps < enters_4 ? \golden_3.load_delay.remaining == enters_4 - steps && !golden_loads_3
        : \golden_3.load_delay.remaining == 0 && golden_loads_3 == (steps == enters_4)));
      entered_3_when: assert (!first_pass || (entered_3 == (steps > enters_3) && fresh_3 == (steps == enters_3 + 17'd1)));
      after_3: assert (first_pass || (entered_3 && (!fresh_3 || 3 == 5)));
      fresh_3_waits: assert (!fresh_3 || !golden_loads_3);
      as_after_reset_3: assert (!entered_3 || \dut_3.load_delay.remaining == \golden_3.load_delay.remaining );
      loads_as_after_reset_3: assert (!entered_3 || fresh_3 || loads_3 == golden_loads_3);
      left_3_entered: assert (!left_3 || (entered_3 && !fresh_3 && (!first_pass || steps > enters_4)));
      coefficient_3: assert (!left_3 || \dut_3.coefficient_g == \golden_3.coefficient_g );
      lines_4: assert (\dut_4.load_delay.total == ({6'd0, width} << 4) + 17'd3 && \golden_4.load_delay.total == \dut_4.load_delay.total );
      golden_4_first: assert (!first_pass || (
        steps > enters_4 && steps < enters_5 ? \golden_4.load_delay.remaining == enters_5 - steps && !golden_loads_4
        : \golden_4.load_delay.remaining == 0 && golden_loads_4 == (steps == enters_5)));
      entered_4_when: assert (!first_pass || (entered_4 == (steps > enters_4) && fresh_4 == (steps == enters_4 + 17'd1)));
      after_4: assert (first_pass || (entered_4 && (!fresh_4 || 4 == 5)));
      fresh_4_waits: assert (!fresh_4 || !golden_loads_4);
      as_after_reset_4: assert (!entered_4 || \dut_4.load_delay.remaining == \golden_4.load_delay.remaining );
      loads_as_after_reset_4: assert (!entered_4 || fresh_4 || loads_4 == golden_loads_4);
      left_4_entered: assert (!left_4 || (entered_4 && !fresh_4 && (!first_pass || steps > enters_5)));
      coefficient_4: assert (!left_4 || \dut_4.coefficient_g == \golden_4.coefficient_g );
      lines_5: assert (\dut_5.load_delay.total == ({6'd0, width} << 5) + 17'd3 && \golden_5.load_delay.total == \dut_5.load_delay.total );
      golden_5_first: assert (!first_pass || (\golden_5.load_delay.remaining == 0 && !golden_loads_5));
      overtaken: assert (!first_pass || late || (!loads_5 && (\dut_5.load_delay.remaining == 0
        || steps + \dut_5.load_delay.remaining >= {1'b0, width, 5'd0} + 17'd4)));
      entered_5_when: assert (!first_pass || (entered_5 == (steps > enters_5) && fresh_5 == (steps == enters_5 + 17'd1)));
      after_5: assert (first_pass || (entered_5 && (!fresh_5 || 5 == 5)));
      fresh_5_waits: assert (!fresh_5 || !golden_loads_5);
      as_after_reset_5: assert (!entered_5 || \dut_5.load_delay.remaining == \golden_5.load_delay.remaining );
      loads_as_after_reset_5: assert (!entered_5 || fresh_5 || loads_5 == golden_loads_5);
      left_5_entered: assert (!left_5 || (entered_5 && !fresh_5 && (!first_pass || steps > enters_5)));
      coefficient_5: assert (!left_5 || \dut_5.coefficient_g == \golden_5.coefficient_g );
      none_leaves: assert (late || loads_5 == golden_loads_5);
      false_marker: cover (!late && loads_3 && !golden_loads_3);
    end
  end
endmodule
