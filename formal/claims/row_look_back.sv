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

for {k} {distance} {border}: 1 2 0, 2 4 1, 3 8 2, 4 16 3, 5 32 4
  wire first_out_{k}, load_out_{k};
  wire [17:0] y_{k};
  row_look_back_{k} dut_{k} (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_{k}),
    .first_out(first_out_{k}), .load_out(load_out_{k})
  );
  (* hierconn *) wire [17:0] \dut_{k}.border_p ;
  (* hierconn *) wire [17:0] \dut_{k}.border_q ;
  (* hierconn *) wire [17:0] \dut_{k}.sample_delay_y ;
  (* hierconn *) wire [{border}:0] \dut_{k}.border.remaining ;
  (* hierconn *) wire [17:0] \dut_{k}.border.border ;
  (* hierconn *) wire [2:0] \dut_{k}.first_delay.delayed ;
  (* hierconn *) wire [2:0] \dut_{k}.load_delay.delayed ;
  (* hierconn *) wire [15:0] \dut_{k}.coefficient.g ;
  (* hierconn, keep *) wire [17:0] \dut_{k}.lerp.p ;
  (* hierconn, keep *) wire \dut_{k}.lerp.advance ;
  (* hierconn, keep *) wire [17:0] \dut_{k}.sample_delay.x ;
  (* hierconn, keep *) wire \dut_{k}.sample_delay.advance ;
  always @(posedge clock)
    parts_{k}: assert (\dut_{k}.sample_delay.x == x && \dut_{k}.sample_delay.advance == advance
      && \dut_{k}.lerp.advance == advance);
  (* hierconn, keep *) wire [17:0] \dut_{k}.lerp.q ;
  (* hierconn, keep *) wire [15:0] \dut_{k}.lerp.g ;
  (* hierconn, keep *) wire [17:0] \dut_{k}.lerp.y ;
  row_look_back_stage #(.DISTANCE({distance})) stage_{k} (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_{k}.sample_delay_y ),
    .p(\dut_{k}.border_p ), .q(\dut_{k}.border_q ), .first_out(first_out_{k}), .load_out(load_out_{k}),
    .remaining(\dut_{k}.border.remaining ), .border(\dut_{k}.border.border ),
    .first_delayed(\dut_{k}.first_delay.delayed ), .load_delayed(\dut_{k}.load_delay.delayed ),
    .g(g), .coefficient(\dut_{k}.coefficient.g ), .lerp_p(\dut_{k}.lerp.p ), .lerp_q(\dut_{k}.lerp.q ), .lerp_g(\dut_{k}.lerp.g ),
    .y(y_{k}), .lerp_y(\dut_{k}.lerp.y )
  );
end
endmodule
