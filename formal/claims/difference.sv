// difference: the module equals its equation.
module difference_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [17:0] narrow, wide;
  wire [14:0] magnitude;
  wire positive, saturated;
  difference dut (
    .clock(clock), .advance(advance), .narrow(narrow), .wide(wide),
    .magnitude(magnitude), .positive(positive), .saturated(saturated)
  );

  (* hierconn *) wire [17:0] \dut.distance ;
  (* hierconn *) wire \dut.positive_1 ;

  function [17:0] away(input [17:0] a, input [17:0] b);
    away = a >= b ? a - b : b - a;
  endfunction

  reg [17:0] narrow_1, wide_1, narrow_2, wide_2;
  reg [1:0] filled = 0;
  always @(posedge clock)
    if (advance) begin
      {narrow_2, narrow_1} <= {narrow_1, narrow};
      {wide_2, wide_1} <= {wide_1, wide};
      filled <= {filled[0], 1'b1};
    end

  wire [18:0] rounded = ({1'b0, away(narrow_2, wide_2)} + 19'd1) >> 1;
  always @(posedge clock) begin
    if (filled[0]) step_1: assert (\dut.distance == away(narrow_1, wide_1) && \dut.positive_1 == (narrow_1 >= wide_1));
    if (filled[1]) begin
      response: assert (magnitude == (rounded > 19'd32767 ? 15'd32767 : rounded[14:0]));
      sign: assert (positive == (narrow_2 >= wide_2));
      saturation: assert (saturated == (rounded > 19'd32767));
      saturates: cover (saturated);
      negative: cover (!positive && !saturated && magnitude == 15'd5);
    end
  end
endmodule
