// row_look_ahead_border compared with its text without a fault: the operands are equal, whether the columns beyond the
// end of the row are counted down or up to 0; the count starts at half of its range.
// A stall changes no state, so a run with stalls has the states of one without.
module row_look_ahead_border_properties (input clock);
  (* anyseq *) reg reset, advance, last;
  (* anyseq *) reg [`S-1:0] x, delayed;
  reg begun = 0;
  // No stall has occurred since the reset.
  reg flows = 1;
  always @(posedge clock) begin
    begun <= 1;
    flows <= flows && (advance || reset);
    assume (reset == !begun);
    counts: cover (begun && flows && p_1 != golden_q_1);
  end

for {bits} {n}: each row_look_ahead_border
  wire [`S-1:0] golden_p_{n}, golden_q_{n}, p_{n}, q_{n};
  golden_row_look_ahead_border #(.BITS(`S), .DISTANCE({n})) golden_{n} (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(golden_p_{n}),
    .q(golden_q_{n})
  );
  row_look_ahead_border #(.BITS(`S), .DISTANCE({n})) dut_{n} (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(delayed), .p(p_{n}), .q(q_{n})
  );
  (* hierconn *) wire [$clog2({n}+1)-1:0] \golden_{n}.remaining ;
  (* hierconn *) wire [`S-1:0] \golden_{n}.border ;
  (* hierconn *) wire [$clog2({n}+1)-1:0] \dut_{n}.remaining ;
  (* hierconn *) wire [`S-1:0] \dut_{n}.border ;
  wire [$clog2({n}+1)-1:0] sum_{n} = \golden_{n}.remaining + \dut_{n}.remaining ;
  wire [3*`S-1:0] golden_rest_{n} = {\golden_{n}.border , golden_p_{n}, golden_q_{n}};
  wire [3*`S-1:0] rest_{n} = {\dut_{n}.border , p_{n}, q_{n}};
  always @(posedge clock)
    if (!begun)
      assume (\golden_{n}.remaining == \dut_{n}.remaining && golden_rest_{n} == rest_{n});
    else begin
      waits_{n}: assert ($past(advance) || $past(reset)
        || ($stable(\golden_{n}.remaining ) && $stable(\dut_{n}.remaining ) && $stable(golden_rest_{n}) && $stable(rest_{n})));
      either_way_{n}: assert (!flows || \dut_{n}.remaining == \golden_{n}.remaining || sum_{n} == 0);
      operands_{n}: assert (!flows || golden_rest_{n} == rest_{n});
    end
end
endmodule
