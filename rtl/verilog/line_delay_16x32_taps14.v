// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y_i[n] = x[n - k_i W] for the 14 lines k_i > 0 of the coarse ring, the newest lowest, 32 lines the oldest: all rows of a column are
// one memory word, read, shifted by one row and written back. The address counts steps modulo W.
// Latency: up to 32 lines.
module line_delay_16x32_taps14 (
  input  wire clock,
  input  wire advance,
  input  wire [9:0] address,
  input  wire [9:0] write_address,
  input  wire [15:0] x,
  output reg  [223:0] y
);

reg [511:0] memory [0:1023];
reg [511:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= {column[495:0], x};
  end

always @(*)
  y = {column[511:496], column[495:480], column[463:448], column[431:416], column[399:384], column[351:336], column[303:288], column[255:240], column[207:192], column[159:144], column[111:96], column[79:64], column[47:32], column[15:0]};

endmodule
