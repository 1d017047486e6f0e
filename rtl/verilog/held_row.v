// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The last row of a frame as it left the recursion, one line with one read port for all stages: no two need it together.
// A lerp of equal words is that word, so row H - 1 is the same behind every stage.
// Latency: 1 step from `select` to y.
module held_row (
  input  wire clock,
  input  wire advance,
  input  wire write,
  input  wire [9:0] write_address,
  input  wire [17:0] x,
  input  wire [5:0] select,
  input  wire [9:0] address_0,
  input  wire [9:0] address_1,
  input  wire [9:0] address_2,
  input  wire [9:0] address_3,
  input  wire [9:0] address_4,
  input  wire [9:0] address_5,
  output reg  [17:0] y
);

reg [17:0] memory [0:1023];
wire [9:0] address = ({10{select[0]}} & address_0) | ({10{select[1]}} & address_1) | ({10{select[2]}} & address_2)
                   | ({10{select[3]}} & address_3) | ({10{select[4]}} & address_4) | ({10{select[5]}} & address_5);

always @(posedge clock)
  if (advance) begin
    y <= memory[address];
    if (write)
      memory[write_address] <= x;
  end

endmodule
