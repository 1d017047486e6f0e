// row_look_back_border_16: p[c] = x[max(c - 16, 0)], q[c] = x[c], by the definition: a column counter and the samples.
module row_look_back_border_16_properties (input clock);
  (* anyseq *) reg reset, advance, first;
  (* anyseq *) reg [17:0] x;
  wire [17:0] p, q;
  // The samples of the last sixteen steps, the newest lowest.
  reg [287:0] samples;
  row_look_back_border_16 dut (
    .clock(clock), .reset(reset), .advance(advance), .first(first), .x(x), .delayed(samples[287:270]), .p(p), .q(q)
  );

  (* hierconn *) wire [3:0] \dut.remaining ;
  (* hierconn *) wire [17:0] \dut.border ;

  reg begun = 0, in_row = 0, told = 0;
  // Column of the next sample, 16 for all from there on, and the row's first sample.
  reg [4:0] column;
  reg [17:0] first_sample, p_wanted, q_wanted;
  always @(posedge clock) begin
    begun <= 1;
    if (reset) begin
      in_row <= 0;
      told <= 0;
    end else if (advance) begin
      samples <= {samples[269:0], x};
      if (first) begin
        in_row <= 1;
        first_sample <= x;
        column <= 5'd1;
      end else if (column != 5'd16)
        column <= column + 5'd1;
      told <= first | in_row;
      q_wanted <= x;
      p_wanted <= first ? x : column < 5'd16 ? first_sample : samples[287:270];
    end
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun) begin
      counts: assert (!in_row || (column >= 5'd1 && column <= 5'd16 && \dut.remaining == 5'd16 - column
        && \dut.border == first_sample));
      outside: assert (in_row || \dut.remaining == 4'd0);
      operands: assert (!told || (p == p_wanted && q == q_wanted));
      beyond: cover (told && column == 5'd16 && p != first_sample);
    end
  end
endmodule
