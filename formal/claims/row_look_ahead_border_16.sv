// row_look_ahead_border_16: p[c] = x[min(c + 16, W - 1)], q[c] = x[c], sixteen steps after x[c] came.
module row_look_ahead_border_16_properties (input clock);
  (* anyseq *) reg reset, advance, last;
  (* anyseq *) reg [17:0] x;
  wire [17:0] p, q;
  // The samples of the last sixteen steps, the newest lowest.
  reg [287:0] samples;
  row_look_ahead_border_16 dut (
    .clock(clock), .reset(reset), .advance(advance), .last(last), .x(x), .delayed(samples[287:270]), .p(p), .q(q)
  );

  (* hierconn *) wire [4:0] \dut.remaining ;
  (* hierconn *) wire [17:0] \dut.border ;

  reg begun = 0, told = 0;
  // Steps since the last column of a row: 1 for the step after it, 17 for all later ones, and its sample.
  reg [4:0] after = 5'd17;
  reg [17:0] last_sample, p_wanted, q_wanted;
  always @(posedge clock) begin
    begun <= 1;
    if (reset) begin
      after <= 5'd17;
      told <= 0;
    end else if (advance) begin
      samples <= {samples[269:0], x};
      if (last) begin
        after <= 5'd1;
        last_sample <= x;
      end else if (after != 5'd17)
        after <= after + 5'd1;
      told <= 1;
      q_wanted <= samples[287:270];
      p_wanted <= after <= 5'd16 ? last_sample : x;
    end
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    // The last column of a row is not within sixteen steps of that of the row before.
    assume (!(advance && last && after <= 5'd16));
    if (begun) begin
      counts: assert (after >= 5'd1 && after <= 5'd17 && \dut.remaining == 5'd17 - after);
      border: assert (after == 5'd17 || \dut.border == last_sample);
      operands: assert (!told || (p == p_wanted && q == q_wanted));
      beyond: cover (told && after == 5'd9 && p != q);
    end
  end
endmodule
