// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 4 W], 18 bits: all 4 rows of a column are one memory word, read, shifted by one row and written back.
// The address counts steps modulo W, so a frame may begin at any of them. Only what a frame wrote itself is ever used.
// Latency: 4 lines.
module line_delay_18x4 (
  input  wire clock,
  input  wire advance,
  input  wire [9:0] address,
  input  wire [9:0] write_address,
  input  wire [17:0] x,
  output reg  [17:0] y
);

reg [71:0] memory [0:1023];
reg [71:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= {column[53:0], x};
  end

always @(*)
  y = {column[71:54]};

endmodule
