// row_look_ahead_K: p[c] = u[min(c + 2^K, W - 1)], q[c] = u[c], 2^K steps after u[c] entered; the markers leave
// 2^K + 4 steps after they entered.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset.

module row_look_ahead_stage #(parameter DISTANCE = 1) (
  input clock, input advance, input last, input load, input [17:0] x, input [17:0] delayed, input [17:0] p,
  input [17:0] q, input last_out, input load_out, input [6:0] remaining, input [17:0] border,
  input [6:0] last_remaining, input [6:0] load_remaining, input [15:0] g, input [17:0] y, input [17:0] lerp_p,
  input [17:0] lerp_q, input [15:0] lerp_g, input [17:0] lerp_y
);
  // Steps since the start, and since the last sample of the row, both up to 64.
  reg [6:0] steps = 7'd0, since = 7'd64;
  reg seen = 0, stepped = 0, p_known = 0;
  reg [17:0] kept, p_wanted, q_wanted;
  // The samples of the last steps, the newest lowest.
  reg [18 * DISTANCE - 1:0] samples;
  reg [6:0] since_load = 7'd64;
  reg seen_load = 0;
  // The coefficient in the step of the last marker that left.
  reg loaded = 0;
  reg [15:0] frames_g;
  always @(posedge clock)
    if (advance) begin
      if (load_out) begin
        loaded <= 1;
        frames_g <= g;
      end
      if (steps != 7'd64) steps <= steps + 7'd1;
      samples <= {samples, x};
      if (last) begin
        since <= 7'd1;
        seen <= 1;
        kept <= x;
      end else if (since != 7'd64)
        since <= since + 7'd1;
      if (load) begin
        since_load <= 7'd1;
        seen_load <= 1;
      end else if (since_load != 7'd64)
        since_load <= since_load + 7'd1;
      stepped <= 1;
      p_wanted <= last ? x : since <= DISTANCE ? kept : x;
      p_known <= seen || steps == 7'd64;
      q_wanted <= delayed;
    end

  always @(posedge clock) begin
    assume (delayed == samples[18 * DISTANCE - 1:18 * (DISTANCE - 1)]);
    // Rows are at least 64 columns wide.
    assume (!advance || !last || since == 7'd64);
    counts: assert (seen ? remaining == (since <= DISTANCE ? DISTANCE + 7'd1 - since : 7'd0) : remaining + steps <= 7'd63 || remaining == 7'd0);
    holds: assert (!seen || !(since <= DISTANCE) || border == kept);
    since_counts: assert (since >= 7'd1 && since <= 7'd64 && steps <= 7'd64 && (seen || since == 7'd64));
    operand_p: assert (!stepped || !p_known || p == p_wanted);
    operand_q: assert (!stepped || q == q_wanted);
    last_counts: assert (seen ? last_remaining == (since < DISTANCE + 7'd4 ? DISTANCE + 7'd4 - since : 7'd0)
      : last_remaining + steps <= 7'd63 || last_remaining == 7'd0);
    last_leaves: assert (seen ? last_out == (since == DISTANCE + 7'd4) || since == 7'd1 : !last_out || steps < 7'd64);
    load_counts: assert (seen_load ? load_remaining == (since_load < DISTANCE + 7'd4 ? DISTANCE + 7'd4 - since_load : 7'd0)
      : load_remaining + steps <= 7'd63 || load_remaining == 7'd0);
    load_leaves: assert (seen_load ? load_out == (since_load == DISTANCE + 7'd4) || since_load == 7'd1 : !load_out || steps < 7'd64);
    coefficient_of_load: assert (!loaded || lerp_g == frames_g);
    operands: assert (lerp_p == p && lerp_q == q && y == lerp_y);
    since_load_counts: assert (since_load >= 7'd1 && since_load <= 7'd64 && (seen_load || since_load == 7'd64));
    beyond: cover (stepped && seen && since == 7'd1 && p != q);
  end
endmodule

module row_look_ahead_properties (input clock);
  (* anyseq *) reg advance, last, load;
  (* anyseq *) reg [17:0] x;
  (* anyseq *) reg [15:0] g;

  wire last_out_0, load_out_0;
  wire [17:0] y_0;
  row_look_ahead_0 dut_0 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_0),
    .last_out(last_out_0), .loads(load_out_0)
  );
  (* hierconn, keep *) wire [17:0] \dut_0.lerp.p ;
  (* hierconn, keep *) wire \dut_0.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_0.sample_delay.x ;
  (* hierconn, keep *) wire \dut_0.sample_delay.advance ;
  always @(posedge clock)
    parts_0: assert (\dut_0.sample_delay.x == x && \dut_0.sample_delay.advance == advance
      && \dut_0.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_0.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_0.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_0.lerp.y ;
  (* hierconn *) wire [17:0] \dut_0.border_p ;
  (* hierconn *) wire [17:0] \dut_0.border_q ;
  (* hierconn *) wire [17:0] \dut_0.sample_delay_y ;
  (* hierconn *) wire [0:0] \dut_0.border.remaining ;
  (* hierconn *) wire [17:0] \dut_0.border.border ;
  (* hierconn *) wire [2:0] \dut_0.last_delay.remaining ;
  (* hierconn *) wire [2:0] \dut_0.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE(1)) stage_0 (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_0.sample_delay_y ),
    .p(\dut_0.border_p ), .q(\dut_0.border_q ), .last_out(last_out_0), .load_out(load_out_0),
    .remaining({6'd0, \dut_0.border.remaining }), .border(\dut_0.border.border ),
    .last_remaining({4'd0, \dut_0.last_delay.remaining }), .load_remaining({4'd0, \dut_0.load_delay.remaining }), .g(g), .y(y_0),
    .lerp_p(\dut_0.lerp.p ), .lerp_q(\dut_0.lerp.q ), .lerp_g(\dut_0.lerp.g ), .lerp_y(\dut_0.lerp.y )
  );

  wire last_out_1, load_out_1;
  wire [17:0] y_1;
  row_look_ahead_1 dut_1 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_1),
    .last_out(last_out_1), .loads(load_out_1)
  );
  (* hierconn, keep *) wire [17:0] \dut_1.lerp.p ;
  (* hierconn, keep *) wire \dut_1.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_1.sample_delay.x ;
  (* hierconn, keep *) wire \dut_1.sample_delay.advance ;
  always @(posedge clock)
    parts_1: assert (\dut_1.sample_delay.x == x && \dut_1.sample_delay.advance == advance
      && \dut_1.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_1.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_1.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_1.lerp.y ;
  (* hierconn *) wire [17:0] \dut_1.border_p ;
  (* hierconn *) wire [17:0] \dut_1.border_q ;
  (* hierconn *) wire [17:0] \dut_1.sample_delay_y ;
  (* hierconn *) wire [1:0] \dut_1.border.remaining ;
  (* hierconn *) wire [17:0] \dut_1.border.border ;
  (* hierconn *) wire [2:0] \dut_1.last_delay.remaining ;
  (* hierconn *) wire [2:0] \dut_1.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE(2)) stage_1 (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_1.sample_delay_y ),
    .p(\dut_1.border_p ), .q(\dut_1.border_q ), .last_out(last_out_1), .load_out(load_out_1),
    .remaining({5'd0, \dut_1.border.remaining }), .border(\dut_1.border.border ),
    .last_remaining({4'd0, \dut_1.last_delay.remaining }), .load_remaining({4'd0, \dut_1.load_delay.remaining }), .g(g), .y(y_1),
    .lerp_p(\dut_1.lerp.p ), .lerp_q(\dut_1.lerp.q ), .lerp_g(\dut_1.lerp.g ), .lerp_y(\dut_1.lerp.y )
  );

  wire last_out_2, load_out_2;
  wire [17:0] y_2;
  row_look_ahead_2 dut_2 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_2),
    .last_out(last_out_2), .loads(load_out_2)
  );
  (* hierconn, keep *) wire [17:0] \dut_2.lerp.p ;
  (* hierconn, keep *) wire \dut_2.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_2.sample_delay.x ;
  (* hierconn, keep *) wire \dut_2.sample_delay.advance ;
  always @(posedge clock)
    parts_2: assert (\dut_2.sample_delay.x == x && \dut_2.sample_delay.advance == advance
      && \dut_2.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_2.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_2.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_2.lerp.y ;
  (* hierconn *) wire [17:0] \dut_2.border_p ;
  (* hierconn *) wire [17:0] \dut_2.border_q ;
  (* hierconn *) wire [17:0] \dut_2.sample_delay_y ;
  (* hierconn *) wire [2:0] \dut_2.border.remaining ;
  (* hierconn *) wire [17:0] \dut_2.border.border ;
  (* hierconn *) wire [2:0] \dut_2.last_delay.remaining ;
  (* hierconn *) wire [2:0] \dut_2.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE(4)) stage_2 (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_2.sample_delay_y ),
    .p(\dut_2.border_p ), .q(\dut_2.border_q ), .last_out(last_out_2), .load_out(load_out_2),
    .remaining({4'd0, \dut_2.border.remaining }), .border(\dut_2.border.border ),
    .last_remaining({4'd0, \dut_2.last_delay.remaining }), .load_remaining({4'd0, \dut_2.load_delay.remaining }), .g(g), .y(y_2),
    .lerp_p(\dut_2.lerp.p ), .lerp_q(\dut_2.lerp.q ), .lerp_g(\dut_2.lerp.g ), .lerp_y(\dut_2.lerp.y )
  );

  wire last_out_3, load_out_3;
  wire [17:0] y_3;
  row_look_ahead_3 dut_3 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_3),
    .last_out(last_out_3), .loads(load_out_3)
  );
  (* hierconn, keep *) wire [17:0] \dut_3.lerp.p ;
  (* hierconn, keep *) wire \dut_3.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_3.sample_delay.x ;
  (* hierconn, keep *) wire \dut_3.sample_delay.advance ;
  always @(posedge clock)
    parts_3: assert (\dut_3.sample_delay.x == x && \dut_3.sample_delay.advance == advance
      && \dut_3.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_3.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_3.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_3.lerp.y ;
  (* hierconn *) wire [17:0] \dut_3.border_p ;
  (* hierconn *) wire [17:0] \dut_3.border_q ;
  (* hierconn *) wire [17:0] \dut_3.sample_delay_y ;
  (* hierconn *) wire [3:0] \dut_3.border.remaining ;
  (* hierconn *) wire [17:0] \dut_3.border.border ;
  (* hierconn *) wire [3:0] \dut_3.last_delay.remaining ;
  (* hierconn *) wire [3:0] \dut_3.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE(8)) stage_3 (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_3.sample_delay_y ),
    .p(\dut_3.border_p ), .q(\dut_3.border_q ), .last_out(last_out_3), .load_out(load_out_3),
    .remaining({3'd0, \dut_3.border.remaining }), .border(\dut_3.border.border ),
    .last_remaining({3'd0, \dut_3.last_delay.remaining }), .load_remaining({3'd0, \dut_3.load_delay.remaining }), .g(g), .y(y_3),
    .lerp_p(\dut_3.lerp.p ), .lerp_q(\dut_3.lerp.q ), .lerp_g(\dut_3.lerp.g ), .lerp_y(\dut_3.lerp.y )
  );

  wire last_out_4, load_out_4;
  wire [17:0] y_4;
  row_look_ahead_4 dut_4 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_4),
    .last_out(last_out_4), .loads(load_out_4)
  );
  (* hierconn, keep *) wire [17:0] \dut_4.lerp.p ;
  (* hierconn, keep *) wire \dut_4.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_4.sample_delay.x ;
  (* hierconn, keep *) wire \dut_4.sample_delay.advance ;
  always @(posedge clock)
    parts_4: assert (\dut_4.sample_delay.x == x && \dut_4.sample_delay.advance == advance
      && \dut_4.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_4.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_4.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_4.lerp.y ;
  (* hierconn *) wire [17:0] \dut_4.border_p ;
  (* hierconn *) wire [17:0] \dut_4.border_q ;
  (* hierconn *) wire [17:0] \dut_4.sample_delay_y ;
  (* hierconn *) wire [4:0] \dut_4.border.remaining ;
  (* hierconn *) wire [17:0] \dut_4.border.border ;
  (* hierconn *) wire [4:0] \dut_4.last_delay.remaining ;
  (* hierconn *) wire [4:0] \dut_4.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE(16)) stage_4 (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_4.sample_delay_y ),
    .p(\dut_4.border_p ), .q(\dut_4.border_q ), .last_out(last_out_4), .load_out(load_out_4),
    .remaining({2'd0, \dut_4.border.remaining }), .border(\dut_4.border.border ),
    .last_remaining({2'd0, \dut_4.last_delay.remaining }), .load_remaining({2'd0, \dut_4.load_delay.remaining }), .g(g), .y(y_4),
    .lerp_p(\dut_4.lerp.p ), .lerp_q(\dut_4.lerp.q ), .lerp_g(\dut_4.lerp.g ), .lerp_y(\dut_4.lerp.y )
  );

  wire last_out_5, load_out_5;
  wire [17:0] y_5;
  row_look_ahead_5 dut_5 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_5),
    .last_out(last_out_5), .loads(load_out_5)
  );
  (* hierconn, keep *) wire [17:0] \dut_5.lerp.p ;
  (* hierconn, keep *) wire \dut_5.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_5.sample_delay.x ;
  (* hierconn, keep *) wire \dut_5.sample_delay.advance ;
  always @(posedge clock)
    parts_5: assert (\dut_5.sample_delay.x == x && \dut_5.sample_delay.advance == advance
      && \dut_5.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_5.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_5.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_5.lerp.y ;
  (* hierconn *) wire [17:0] \dut_5.border_p ;
  (* hierconn *) wire [17:0] \dut_5.border_q ;
  (* hierconn *) wire [17:0] \dut_5.sample_delay_y ;
  (* hierconn *) wire [5:0] \dut_5.border.remaining ;
  (* hierconn *) wire [17:0] \dut_5.border.border ;
  (* hierconn *) wire [5:0] \dut_5.last_delay.remaining ;
  (* hierconn *) wire [5:0] \dut_5.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE(32)) stage_5 (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_5.sample_delay_y ),
    .p(\dut_5.border_p ), .q(\dut_5.border_q ), .last_out(last_out_5), .load_out(load_out_5),
    .remaining({1'd0, \dut_5.border.remaining }), .border(\dut_5.border.border ),
    .last_remaining({1'd0, \dut_5.last_delay.remaining }), .load_remaining({1'd0, \dut_5.load_delay.remaining }), .g(g), .y(y_5),
    .lerp_p(\dut_5.lerp.p ), .lerp_q(\dut_5.lerp.q ), .lerp_g(\dut_5.lerp.g ), .lerp_y(\dut_5.lerp.y )
  );

  // The end of a row, from the row cursor of the smoother to its first look-ahead stage, in smoothers of six stages.
  wire end_y;
  pulse_delay_24 row_end (.clock(clock), .reset(1'b0), .advance(advance), .x(load), .y(end_y));
  (* hierconn *) wire [4:0] \row_end.remaining ;
  reg [6:0] steps = 7'd0, since = 7'd64;
  reg seen = 0;
  always @(posedge clock)
    if (advance) begin
      if (steps != 7'd64) steps <= steps + 7'd1;
      since <= load ? 7'd1 : since != 7'd64 ? since + 7'd1 : since;
      seen <= seen | load;
    end
  always @(posedge clock) begin
    end_since: assert (since >= 7'd1 && since <= 7'd64 && steps <= 7'd64 && (seen || since == 7'd64));
    end_counts: assert (seen ? \row_end.remaining == (since < 7'd24 ? 7'd24 - since : 7'd0)
      : \row_end.remaining + steps <= 7'd63 || \row_end.remaining == 5'd0);
    end_leaves: assert (seen ? end_y == (since == 7'd24) || since == 7'd1 : !end_y || steps < 7'd64);
  end
endmodule
