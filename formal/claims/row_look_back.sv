// row_look_back: p[c] = u[max(c - DISTANCE, 0)], q[c] = u[c]; the markers leave four steps after they entered.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset, but for a count that no state
// has: the one bit of a stage of one column.

module row_look_back_stage #(parameter DISTANCE = 1) (
  input clock, input advance, input first, input load, input [`S-1:0] x, input [`S-1:0] delayed, input [`S-1:0] p,
  input [`S-1:0] q, input first_out, input load_out, input [6:0] remaining, input [`S-1:0] border,
  input [3:0] first_delayed, input [3:0] load_delayed, input [`C-1:0] g, input [`C-1:0] coefficient,
  input [`S-1:0] lerp_p, input [`S-1:0] lerp_q, input [`C-1:0] lerp_g, input [`S-1:0] y, input [`S-1:0] lerp_y
);
  // Steps since the start, and since the first sample of the row, both up to 64.
  reg [6:0] steps = 7'd0, since = 7'd64;
  reg seen = 0, stepped = 0, p_known = 0;
  reg [`S-1:0] kept, p_wanted, q_wanted;
  // The samples of the last steps, the newest lowest.
  reg [`S * DISTANCE - 1:0] samples;
  // The markers of the last steps.
  reg [3:0] firsts, loads;
  // The coefficient at the last load.
  reg loaded = 0;
  reg [`C-1:0] frames_g;
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
    assume (delayed == samples[`S * DISTANCE - 1:`S * (DISTANCE - 1)]);
    assume (steps != 7'd0 || remaining < DISTANCE);
    below: assert (remaining < DISTANCE);
    counts: assert (seen ? remaining == (since < DISTANCE ? DISTANCE - since : 7'd0) : remaining + steps <= 7'd63 || remaining == 7'd0);
    holds: assert (!seen || !(since < DISTANCE) || border == kept);
    since_counts: assert (since >= 7'd1 && since <= 7'd64 && steps <= 7'd64 && (seen || since == 7'd64));
    operand_p: assert (!stepped || !p_known || p == p_wanted);
    operand_q: assert (!stepped || q == q_wanted);
    first_in_flight: assert (((first_delayed ^ firsts) & ~(4'd15 << steps)) == 4'd0);
    load_in_flight: assert (((load_delayed ^ loads) & ~(4'd15 << steps)) == 4'd0);
    first_leaves: assert (steps < 7'd4 || first_out == firsts[3]);
    load_leaves: assert (steps < 7'd4 || load_out == loads[3]);
    coefficient_of_load: assert (!loaded || coefficient == frames_g);
    operands: assert (lerp_p == p && lerp_q == q && lerp_g == coefficient && y == lerp_y);
    beyond: cover (stepped && seen && since == 7'd2 && p != q);
  end
endmodule

module row_look_back_properties (input clock);
  (* anyseq *) reg advance, first, load;
  (* anyseq *) reg [`S-1:0] x;
  (* anyseq *) reg [`C-1:0] g;

for {k}: each row_look_back
  wire first_out_{k}, load_out_{k};
  wire [`S-1:0] y_{k};
  row_look_back #(.DISTANCE({k})) dut_{k} (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .first(first), .load(load), .g(g), .y(y_{k}),
    .first_out(first_out_{k}), .load_out(load_out_{k})
  );
  (* hierconn *) wire [`S-1:0] \dut_{k}.border_p ;
  (* hierconn *) wire [`S-1:0] \dut_{k}.border_q ;
  (* hierconn, keep *) wire [`S-1:0] \dut_{k}.sample_delay.y ;
  (* hierconn *) wire [({k} > 1 ? $clog2({k}) : 1)-1:0] \dut_{k}.border.remaining ;
  (* hierconn *) wire [`S-1:0] \dut_{k}.border.border ;
  (* hierconn *) wire [3:0] \dut_{k}.first_delay.delayed ;
  (* hierconn *) wire [3:0] \dut_{k}.load_delay.delayed ;
  (* hierconn *) wire [`C-1:0] \dut_{k}.coefficient.g ;
  (* hierconn, keep *) wire [`S-1:0] \dut_{k}.lerp.p ;
  (* hierconn, keep *) wire \dut_{k}.lerp.advance ;
  (* hierconn, keep *) wire [`S-1:0] \dut_{k}.sample_delay.x ;
  (* hierconn, keep *) wire \dut_{k}.sample_delay.advance ;
  (* hierconn, keep *) wire [31:0] \dut_{k}.sample_delay.parameter_STEPS ;
  (* hierconn, keep *) wire [31:0] \dut_{k}.sample_delay.parameter_BITS ;
  always @(posedge clock)
    parts_{k}: assert (\dut_{k}.sample_delay.parameter_STEPS == {k} && \dut_{k}.sample_delay.parameter_BITS == `S
      && \dut_{k}.sample_delay.x == x && \dut_{k}.sample_delay.advance == advance
      && \dut_{k}.lerp.advance == advance);
  (* hierconn, keep *) wire [`S-1:0] \dut_{k}.lerp.q ;
  (* hierconn, keep *) wire [`C-1:0] \dut_{k}.lerp.g ;
  (* hierconn, keep *) wire [`S-1:0] \dut_{k}.lerp.y ;
  row_look_back_stage #(.DISTANCE({k})) stage_{k} (
    .clock(clock), .advance(advance), .first(first), .load(load), .x(x), .delayed(\dut_{k}.sample_delay.y ),
    .p(\dut_{k}.border_p ), .q(\dut_{k}.border_q ), .first_out(first_out_{k}), .load_out(load_out_{k}),
    .remaining(\dut_{k}.border.remaining ), .border(\dut_{k}.border.border ),
    .first_delayed(\dut_{k}.first_delay.delayed ), .load_delayed(\dut_{k}.load_delay.delayed ),
    .g(g), .coefficient(\dut_{k}.coefficient.g ), .lerp_p(\dut_{k}.lerp.p ), .lerp_q(\dut_{k}.lerp.q ), .lerp_g(\dut_{k}.lerp.g ),
    .y(y_{k}), .lerp_y(\dut_{k}.lerp.y )
  );
end
endmodule
