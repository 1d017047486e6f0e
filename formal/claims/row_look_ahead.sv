// row_look_ahead: p[c] = u[min(c + DISTANCE, W - 1)], q[c] = u[c], DISTANCE steps after u[c] entered; the markers leave
// DISTANCE + 4 steps after they entered.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset.

module row_look_ahead_stage #(parameter DISTANCE = 1) (
  input clock, input advance, input last, input load, input [`S-1:0] x, input [`S-1:0] delayed, input [`S-1:0] p,
  input [`S-1:0] q, input last_out, input load_out, input [6:0] remaining, input [`S-1:0] border,
  input [6:0] last_remaining, input [6:0] load_remaining, input [`C-1:0] g, input [`S-1:0] y, input [`S-1:0] lerp_p,
  input [`S-1:0] lerp_q, input [`C-1:0] lerp_g, input [`S-1:0] lerp_y
);
  // Steps since the start, and since the last sample of the row, both up to 64.
  reg [6:0] steps = 7'd0, since = 7'd64;
  reg seen = 0, stepped = 0, p_known = 0;
  reg [`S-1:0] kept, p_wanted, q_wanted;
  // The samples of the last steps, the newest lowest.
  reg [`S * DISTANCE - 1:0] samples;
  reg [6:0] since_load = 7'd64;
  reg seen_load = 0;
  // The coefficient in the step of the last marker that left.
  reg loaded = 0;
  reg [`C-1:0] frames_g;
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
    assume (delayed == samples[`S * DISTANCE - 1:`S * (DISTANCE - 1)]);
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
  (* anyseq *) reg [`S-1:0] x;
  (* anyseq *) reg [`C-1:0] g;

for {k}: each row_look_ahead
  wire last_out_{k}, load_out_{k};
  wire [`S-1:0] y_{k};
  row_look_ahead #(.DISTANCE({k})) dut_{k} (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_{k}),
    .last_out(last_out_{k}), .loads(load_out_{k})
  );
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
  (* hierconn *) wire [`S-1:0] \dut_{k}.border_p ;
  (* hierconn *) wire [`S-1:0] \dut_{k}.border_q ;
  (* hierconn, keep *) wire [`S-1:0] \dut_{k}.sample_delay.y ;
  (* hierconn *) wire [$clog2({k}+1)-1:0] \dut_{k}.border.remaining ;
  (* hierconn *) wire [`S-1:0] \dut_{k}.border.border ;
  (* hierconn *) wire [$clog2({k}+4)-1:0] \dut_{k}.last_delay.remaining ;
  (* hierconn *) wire [$clog2({k}+4)-1:0] \dut_{k}.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE({k})) stage_{k} (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_{k}.sample_delay.y ),
    .p(\dut_{k}.border_p ), .q(\dut_{k}.border_q ), .last_out(last_out_{k}), .load_out(load_out_{k}),
    .remaining(\dut_{k}.border.remaining ), .border(\dut_{k}.border.border ),
    .last_remaining(\dut_{k}.last_delay.remaining ), .load_remaining(\dut_{k}.load_delay.remaining ), .g(g), .y(y_{k}),
    .lerp_p(\dut_{k}.lerp.p ), .lerp_q(\dut_{k}.lerp.q ), .lerp_g(\dut_{k}.lerp.g ), .lerp_y(\dut_{k}.lerp.y )
  );
end

  // The end of a row, from the row cursor of a smoother to its first look-ahead stage, and other delays of pulses.
  reg [6:0] steps = 7'd0, since = 7'd64;
  reg seen = 0;
  always @(posedge clock)
    if (advance) begin
      if (steps != 7'd64) steps <= steps + 7'd1;
      since <= load ? 7'd1 : since != 7'd64 ? since + 7'd1 : since;
      seen <= seen | load;
    end
  always @(posedge clock)
    end_since: assert (since >= 7'd1 && since <= 7'd64 && steps <= 7'd64 && (seen || since == 7'd64));
for {n}: each pulse_delay
  wire end_{n};
  pulse_delay #(.STEPS({n})) pulse_{n} (.clock(clock), .reset(1'b0), .advance(advance), .x(load), .y(end_{n}));
  (* hierconn *) wire [$clog2({n})-1:0] \pulse_{n}.remaining ;
  always @(posedge clock) begin
    counts_{n}: assert (seen ? \pulse_{n}.remaining == (since < 7'd{n} ? 7'd{n} - since : 7'd0)
      : \pulse_{n}.remaining + steps <= 7'd63 || \pulse_{n}.remaining == 0);
    leaves_{n}: assert (seen ? end_{n} == (since == 7'd{n}) || since == 7'd1 : !end_{n} || steps < 7'd64);
  end
end
endmodule
