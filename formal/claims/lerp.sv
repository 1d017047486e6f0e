// lerp: y between p and q, within half an LSB of p + g (q - p) / 2^C, for every coefficient.
//
// The product of distance and coefficient is abstracted to any value up to distance (2^C - 1). The wrapper forms the
// same product, which Yosys merges with that of the module before the abstraction; so wrong operands are detected.
module lerp_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [`S-1:0] p, q;
  (* anyseq *) reg [`C-1:0] g;
  wire [`S-1:0] y;
  lerp dut (.clock(clock), .advance(advance), .p(p), .q(q), .g(g), .y(y));

  (* hierconn *) wire [`S-1:0] \dut.distance ;
  (* hierconn *) wire [`S+`C-1:0] \dut.product ;
  (* hierconn *) wire [`S-1:0] \dut.p_1 ;
  (* hierconn *) wire [`S-1:0] \dut.p_2 ;
  (* hierconn *) wire \dut.minus_1 ;
  (* hierconn *) wire \dut.minus_2 ;

  function [`S-1:0] away(input [`S-1:0] a, input [`S-1:0] b);
    away = a >= b ? a - b : b - a;
  endfunction

  // The operands of each step, and the product in the step in which y leaves.
  reg [`S-1:0] p1, q1, p2, q2, p3, q3;
  reg [`S+`C-1:0] product_2, product_3;
  reg [2:0] filled = 0;
  always @(posedge clock)
    if (advance) begin
      {p3, p2, p1} <= {p2, p1, p};
      {q3, q2, q1} <= {q2, q1, q};
      product_2 <= {{`C{1'b0}}, \dut.distance } * {{`S{1'b0}}, g};
      product_3 <= product_2;
      filled <= {filled[1:0], 1'b1};
    end

  wire [`S-1:0] distance_2 = away(p2, q2);
  wire [`S+`C:0] moved = {1'b0, away(y, p3), {`C{1'b0}}};
  wire [`S+`C:0] exact = {1'b0, product_3};
  always @(posedge clock) begin
    if (filled[0]) step_1: assert (\dut.distance == away(p1, q1) && \dut.minus_1 == (q1 < p1) && \dut.p_1 == p1);
    if (filled[1]) begin
      assume (product_2 <= {distance_2, {`C{1'b0}}} - {{`C{1'b0}}, distance_2});
      step_2: assert (\dut.product == product_2 && \dut.minus_2 == (q2 < p2) && \dut.p_2 == p2);
      range: assert (product_2 <= {distance_2, {`C{1'b0}}} - {{`C{1'b0}}, distance_2});
    end
    if (filled[2]) begin
      range_3: assert (product_3 <= {away(p3, q3), {`C{1'b0}}} - {{`C{1'b0}}, away(p3, q3)});
      between: assert (q3 >= p3 ? y >= p3 && y <= q3 : y >= q3 && y <= p3);
      half_lsb: assert (moved <= exact + (1 << (`C - 1)) && exact <= moved + (1 << (`C - 1)));
      constant: assert (p3 != q3 || y == p3);
      rising: cover (y > p3 && y < q3);
      falling: cover (y < p3 && y > q3);
    end
  end
endmodule
