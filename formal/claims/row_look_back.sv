// row_look_back_K: p[c] = u[max(c - 2^K, 0)], q[c] = u[c]; the markers leave four steps after they entered.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset.

module row_look_back_stage #(parameter DISTANCE = 1) (
  input clock, input advance, input first, input load, input [17:0] x, input [17:0] delayed, input [17:0] p,
  input [17:0] q, input first_out, input load_out, input [6:0] remaining, input [17:0] border,
  input [2:0] first_delayed, input [2:0] load_delayed, input [15:0] g, input [15:0] coefficient,
  input [17:0] lerp_p, input [17:0] lerp_q, input [15:0] lerp_g, input [17:0] y, input [17:0] lerp_y
);
  // Steps since the start, and since the first sample of the row, both up to 64.
  reg [6:0] steps = 7'd0, since = 7'd64;
  reg seen = 0, stepped = 0, p_known = 0;
  reg [17:0] kept, p_wanted, q_wanted;
  // The samples of the last steps, the newest lowest.
  reg [18 * DISTANCE - 1:0] samples;
  // The markers of the last steps.
  reg [3:0] firsts, loads;
  // The coefficient at the last load.
  reg loaded = 0;
  reg [15:0] frames_g;
  always @(posedge clock)
    if (advance) begin
      if (steps != 7'd64) steps <= steps + 7'd1;
      samples <= {samples, x};
      if (first) begin
        since <= 7'd1;
        seen <= 1;
        kept <= x;
      end else if (since != 7'd64)
        since <= since + 7'd1;
      firsts <= {firsts, first};
      loads <= {loads, load};
      if (load) begin
        loaded <= 1;
        frames_g <= g;
      end
      stepped <= 1;
      p_wanted <= first ? x : since < DISTANCE ? kept : delayed;
      p_known <= first || seen || steps == 7'd64;
      q_wanted <= x;
    end

  always @(posedge clock) begin
    assume (delayed == samples[18 * DISTANCE - 1:18 * (DISTANCE - 1)]);
    counts: assert (seen ? remaining == (since < DISTANCE ? DISTANCE - since : 7'd0) : remaining + steps <= 7'd63 || remaining == 7'd0);
    holds: assert (!seen || !(since < DISTANCE) || border == kept);
    since_counts: assert (since >= 7'd1 && since <= 7'd64 && steps <= 7'd64 && (seen || since == 7'd64));
    operand_p: assert (!stepped || !p_known || p == p_wanted);
    operand_q: assert (!stepped || q == q_wanted);
    first_in_flight: assert (((first_delayed ^ firsts[2:0]) & ~(3'd7 << steps)) == 3'd0);
    load_in_flight: assert (((load_delayed ^ loads[2:0]) & ~(3'd7 << steps)) == 3'd0);
    first_leaves: assert (steps < 7'd4 || first_out == firsts[3]);
    load_leaves: assert (steps < 7'd4 || load_out == loads[3]);
    coefficient_of_load: assert (!loaded || coefficient == frames_g);
    operands: assert (lerp_p == p && lerp_q == q && lerp_g == coefficient && y == lerp_y);
    beyond: cover (stepped && seen && since == 7'd2 && p != q);
  end
endmodule

module row_look_back_properties (input clock);
  (* anyseq *) reg advance, first, load;
  (* anyseq *) reg [17:0] x;
  (* anyseq *) reg [15:0] g;

  wire first_out_0, load_out_0;
  wire [17:0] y_0;
  row_look_back_0 dut_0 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_0),
    .first_out(first_out_0), .load_out(load_out_0)
  );
  (* hierconn *) wire [17:0] \dut_0.border_p ;
  (* hierconn *) wire [17:0] \dut_0.border_q ;
  (* hierconn *) wire [17:0] \dut_0.sample_delay_y ;
  (* hierconn *) wire [2:0] \dut_0.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_0.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_0.coefficient.g ;
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
  row_look_back_stage #(.DISTANCE(1)) stage_0 (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_0.sample_delay_y ),
    .p(\dut_0.border_p ), .q(\dut_0.border_q ), .first_out(first_out_0), .load_out(load_out_0),
    .remaining(7'd0), .border(x),
    .first_delayed(\dut_0.first_delay.delayed ), .load_delayed(\dut_0.load_delay.delayed ),
    .g(g), .coefficient(\dut_0.coefficient.g ), .lerp_p(\dut_0.lerp.p ), .lerp_q(\dut_0.lerp.q ), .lerp_g(\dut_0.lerp.g ),
    .y(y_0), .lerp_y(\dut_0.lerp.y )
  );

  wire first_out_1, load_out_1;
  wire [17:0] y_1;
  row_look_back_1 dut_1 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_1),
    .first_out(first_out_1), .load_out(load_out_1)
  );
  (* hierconn *) wire [17:0] \dut_1.border_p ;
  (* hierconn *) wire [17:0] \dut_1.border_q ;
  (* hierconn *) wire [17:0] \dut_1.sample_delay_y ;
  (* hierconn *) wire [0:0] \dut_1.border.remaining ;
  (* hierconn *) wire [17:0] \dut_1.border.border ;
  (* hierconn *) wire [2:0] \dut_1.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_1.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_1.coefficient.g ;
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
  row_look_back_stage #(.DISTANCE(2)) stage_1 (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_1.sample_delay_y ),
    .p(\dut_1.border_p ), .q(\dut_1.border_q ), .first_out(first_out_1), .load_out(load_out_1),
    .remaining({6'd0, \dut_1.border.remaining }), .border(\dut_1.border.border ),
    .first_delayed(\dut_1.first_delay.delayed ), .load_delayed(\dut_1.load_delay.delayed ),
    .g(g), .coefficient(\dut_1.coefficient.g ), .lerp_p(\dut_1.lerp.p ), .lerp_q(\dut_1.lerp.q ), .lerp_g(\dut_1.lerp.g ),
    .y(y_1), .lerp_y(\dut_1.lerp.y )
  );

  wire first_out_2, load_out_2;
  wire [17:0] y_2;
  row_look_back_2 dut_2 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_2),
    .first_out(first_out_2), .load_out(load_out_2)
  );
  (* hierconn *) wire [17:0] \dut_2.border_p ;
  (* hierconn *) wire [17:0] \dut_2.border_q ;
  (* hierconn *) wire [17:0] \dut_2.sample_delay_y ;
  (* hierconn *) wire [1:0] \dut_2.border.remaining ;
  (* hierconn *) wire [17:0] \dut_2.border.border ;
  (* hierconn *) wire [2:0] \dut_2.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_2.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_2.coefficient.g ;
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
  row_look_back_stage #(.DISTANCE(4)) stage_2 (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_2.sample_delay_y ),
    .p(\dut_2.border_p ), .q(\dut_2.border_q ), .first_out(first_out_2), .load_out(load_out_2),
    .remaining({5'd0, \dut_2.border.remaining }), .border(\dut_2.border.border ),
    .first_delayed(\dut_2.first_delay.delayed ), .load_delayed(\dut_2.load_delay.delayed ),
    .g(g), .coefficient(\dut_2.coefficient.g ), .lerp_p(\dut_2.lerp.p ), .lerp_q(\dut_2.lerp.q ), .lerp_g(\dut_2.lerp.g ),
    .y(y_2), .lerp_y(\dut_2.lerp.y )
  );

  wire first_out_3, load_out_3;
  wire [17:0] y_3;
  row_look_back_3 dut_3 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_3),
    .first_out(first_out_3), .load_out(load_out_3)
  );
  (* hierconn *) wire [17:0] \dut_3.border_p ;
  (* hierconn *) wire [17:0] \dut_3.border_q ;
  (* hierconn *) wire [17:0] \dut_3.sample_delay_y ;
  (* hierconn *) wire [2:0] \dut_3.border.remaining ;
  (* hierconn *) wire [17:0] \dut_3.border.border ;
  (* hierconn *) wire [2:0] \dut_3.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_3.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_3.coefficient.g ;
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
  row_look_back_stage #(.DISTANCE(8)) stage_3 (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_3.sample_delay_y ),
    .p(\dut_3.border_p ), .q(\dut_3.border_q ), .first_out(first_out_3), .load_out(load_out_3),
    .remaining({4'd0, \dut_3.border.remaining }), .border(\dut_3.border.border ),
    .first_delayed(\dut_3.first_delay.delayed ), .load_delayed(\dut_3.load_delay.delayed ),
    .g(g), .coefficient(\dut_3.coefficient.g ), .lerp_p(\dut_3.lerp.p ), .lerp_q(\dut_3.lerp.q ), .lerp_g(\dut_3.lerp.g ),
    .y(y_3), .lerp_y(\dut_3.lerp.y )
  );

  wire first_out_4, load_out_4;
  wire [17:0] y_4;
  row_look_back_4 dut_4 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_4),
    .first_out(first_out_4), .load_out(load_out_4)
  );
  (* hierconn *) wire [17:0] \dut_4.border_p ;
  (* hierconn *) wire [17:0] \dut_4.border_q ;
  (* hierconn *) wire [17:0] \dut_4.sample_delay_y ;
  (* hierconn *) wire [3:0] \dut_4.border.remaining ;
  (* hierconn *) wire [17:0] \dut_4.border.border ;
  (* hierconn *) wire [2:0] \dut_4.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_4.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_4.coefficient.g ;
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
  row_look_back_stage #(.DISTANCE(16)) stage_4 (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_4.sample_delay_y ),
    .p(\dut_4.border_p ), .q(\dut_4.border_q ), .first_out(first_out_4), .load_out(load_out_4),
    .remaining({3'd0, \dut_4.border.remaining }), .border(\dut_4.border.border ),
    .first_delayed(\dut_4.first_delay.delayed ), .load_delayed(\dut_4.load_delay.delayed ),
    .g(g), .coefficient(\dut_4.coefficient.g ), .lerp_p(\dut_4.lerp.p ), .lerp_q(\dut_4.lerp.q ), .lerp_g(\dut_4.lerp.g ),
    .y(y_4), .lerp_y(\dut_4.lerp.y )
  );

  wire first_out_5, load_out_5;
  wire [17:0] y_5;
  row_look_back_5 dut_5 (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_5),
    .first_out(first_out_5), .load_out(load_out_5)
  );
  (* hierconn *) wire [17:0] \dut_5.border_p ;
  (* hierconn *) wire [17:0] \dut_5.border_q ;
  (* hierconn *) wire [17:0] \dut_5.sample_delay_y ;
  (* hierconn *) wire [4:0] \dut_5.border.remaining ;
  (* hierconn *) wire [17:0] \dut_5.border.border ;
  (* hierconn *) wire [2:0] \dut_5.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_5.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_5.coefficient.g ;
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
  row_look_back_stage #(.DISTANCE(32)) stage_5 (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_5.sample_delay_y ),
    .p(\dut_5.border_p ), .q(\dut_5.border_q ), .first_out(first_out_5), .load_out(load_out_5),
    .remaining({2'd0, \dut_5.border.remaining }), .border(\dut_5.border.border ),
    .first_delayed(\dut_5.first_delay.delayed ), .load_delayed(\dut_5.load_delay.delayed ),
    .g(g), .coefficient(\dut_5.coefficient.g ), .lerp_p(\dut_5.lerp.p ), .lerp_q(\dut_5.lerp.q ), .lerp_g(\dut_5.lerp.g ),
    .y(y_5), .lerp_y(\dut_5.lerp.y )
  );
endmodule
