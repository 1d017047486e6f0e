// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y_i[n] = x[n - k_i W] for the 15 lines k_i of the fine ring, the newest lowest, 28 lines the oldest: all rows of a column are one
// memory word, read, shifted by one row and written back. The address counts steps modulo W.
// Latency: up to 28 lines.
module line_delay_16x28_taps15 (
  input  wire clock,
  input  wire advance,
  input  wire [9:0] address,
  input  wire [9:0] write_address,
  input  wire [15:0] x,
  output reg  [239:0] y
);

reg [447:0] memory [0:1023];
reg [447:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= {column[431:0], x};
  end

always @(*)
  y = {column[447:432], column[431:416], column[415:400], column[383:368], column[367:352], column[335:320], column[287:272], column[255:240], column[223:208], column[175:160], column[143:128], column[127:112], column[95:80], column[79:64], column[63:48]};

endmodule
