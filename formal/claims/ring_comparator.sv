// ring_comparator: each descriptor bit equals its definition, for an arbitrary point.
module ring_comparator_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [14:0] centre;
  (* anyseq *) reg [511:0] points;
  (* anyconst *) reg [4:0] i;
  wire [31:0] maxlbp, sign;
  ring_comparator dut (.clock(clock), .advance(advance), .centre(centre), .points(points), .maxlbp(maxlbp), .sign(sign));

  wire [511:0] shifted = points >> {i, 4'd0};
  reg [14:0] was_centre;
  reg [15:0] was_point;
  reg filled = 0;
  always @(posedge clock)
    if (advance) begin
      filled <= 1;
      was_centre <= centre;
      was_point <= shifted[15:0];
    end

  always @(posedge clock)
    if (filled) begin
      maxlbp_bit: assert (maxlbp[i] == (was_centre >= was_point[14:0]));
      sign_bit: assert (sign[i] == was_point[15]);
      equal: cover (maxlbp[i] && was_centre == was_point[14:0] && was_centre == 15'd5 && sign == 32'h0000ffff);
    end
endmodule
