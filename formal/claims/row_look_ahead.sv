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

for {k} {distance} {delay}: 0 1 2, 1 2 2, 2 4 2, 3 8 3, 4 16 4, 5 32 5
  wire last_out_{k}, load_out_{k};
  wire [17:0] y_{k};
  row_look_ahead_{k} dut_{k} (
    .clock(clock), .reset(1'b0), .advance(advance), .x(x), .last(last), .load(load), .g(g), .y(y_{k}),
    .last_out(last_out_{k}), .loads(load_out_{k})
  );
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
  (* hierconn *) wire [17:0] \dut_{k}.border_p ;
  (* hierconn *) wire [17:0] \dut_{k}.border_q ;
  (* hierconn *) wire [17:0] \dut_{k}.sample_delay_y ;
  (* hierconn *) wire [{k}:0] \dut_{k}.border.remaining ;
  (* hierconn *) wire [17:0] \dut_{k}.border.border ;
  (* hierconn *) wire [{delay}:0] \dut_{k}.last_delay.remaining ;
  (* hierconn *) wire [{delay}:0] \dut_{k}.load_delay.remaining ;
  row_look_ahead_stage #(.DISTANCE({distance})) stage_{k} (
    .clock(clock), .advance(advance), .last(last), .load(load), .x(x), .delayed(\dut_{k}.sample_delay_y ),
    .p(\dut_{k}.border_p ), .q(\dut_{k}.border_q ), .last_out(last_out_{k}), .load_out(load_out_{k}),
    .remaining(\dut_{k}.border.remaining ), .border(\dut_{k}.border.border ),
    .last_remaining(\dut_{k}.last_delay.remaining ), .load_remaining(\dut_{k}.load_delay.remaining ), .g(g), .y(y_{k}),
    .lerp_p(\dut_{k}.lerp.p ), .lerp_q(\dut_{k}.lerp.q ), .lerp_g(\dut_{k}.lerp.g ), .lerp_y(\dut_{k}.lerp.y )
  );
end

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
