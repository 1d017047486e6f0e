// difference: the module equals its equation.
module difference_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [`S-1:0] narrow, wide;
  wire [`D-1:0] magnitude;
  wire positive, saturated;
  difference dut (
    .clock(clock), .advance(advance), .narrow(narrow), .wide(wide),
    .magnitude(magnitude), .positive(positive), .saturated(saturated)
  );

  (* hierconn *) wire [`S-1:0] \dut.distance ;
  (* hierconn *) wire \dut.positive_1 ;

  function [`S-1:0] away(input [`S-1:0] a, input [`S-1:0] b);
    away = a >= b ? a - b : b - a;
  endfunction

  reg [`S-1:0] narrow_1, wide_1, narrow_2, wide_2;
  reg [1:0] filled = 0;
  always @(posedge clock)
    if (advance) begin
      {narrow_2, narrow_1} <= {narrow_1, narrow};
      {wide_2, wide_1} <= {wide_1, wide};
      filled <= {filled[0], 1'b1};
    end

  // Rounded to the LSB of the response, half up.
  wire [`S:0] rounded = ({1'b0, away(narrow_2, wide_2)} + (1 << `SHIFT >> 1)) >> `SHIFT;
  always @(posedge clock) begin
    if (filled[0]) step_1: assert (\dut.distance == away(narrow_1, wide_1) && \dut.positive_1 == (narrow_1 >= wide_1));
    if (filled[1]) begin
      response: assert (magnitude == (rounded > {`D{1'b1}} ? {`D{1'b1}} : rounded[`D-1:0]));
      sign: assert (positive == (narrow_2 >= wide_2));
      saturation: assert (saturated == (rounded > {`D{1'b1}}));
      saturates: cover (saturated);
      negative: cover (!positive && !saturated && magnitude == 5);
    end
  end
endmodule
