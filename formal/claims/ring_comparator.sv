// ring_comparator: each descriptor bit equals its definition, for an arbitrary point.
module ring_comparator_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [`D-1:0] centre;
  (* anyseq *) reg [32*`R-1:0] points;
  (* anyconst *) reg [4:0] i;
  wire [31:0] maxlbp, sign;
  ring_comparator dut (.clock(clock), .advance(advance), .centre(centre), .points(points), .maxlbp(maxlbp), .sign(sign));

  wire [32*`R-1:0] shifted = points >> (i * `R);
  reg [`D-1:0] was_centre;
  reg [`R-1:0] was_point;
  reg filled = 0;
  always @(posedge clock)
    if (advance) begin
      filled <= 1;
      was_centre <= centre;
      was_point <= shifted[`R-1:0];
    end

  always @(posedge clock)
    if (filled) begin
      maxlbp_bit: assert (maxlbp[i] == (was_centre >= was_point[`D-1:0]));
      sign_bit: assert (sign[i] == was_point[`D]);
      equal: cover (maxlbp[i] && was_centre == was_point[`D-1:0] && was_centre == 5 && sign == 32'h0000ffff);
    end
endmodule
