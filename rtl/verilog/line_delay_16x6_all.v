// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y_k[n] = x[n - k W] for k = 1 .. 6, the newest lowest: all rows of a column are one memory word, read, shifted by one row and
// written back. The address counts steps modulo W.
// Latency: 1 to 6 lines.
module line_delay_16x6_all (
  input  wire clock,
  input  wire advance,
  input  wire [9:0] address,
  input  wire [9:0] write_address,
  input  wire [15:0] x,
  output reg  [95:0] y
);

reg [95:0] memory [0:1023];
reg [95:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= {column[79:0], x};
  end

always @(*)
  y = {column[95:80], column[79:64], column[63:48], column[47:32], column[31:16], column[15:0]};

endmodule
