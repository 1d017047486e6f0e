// y[n] = x[n - k W] for each k of which bit k - 1 of TAPS is set, the newest lowest, as line_delay. A parity bit stays
// with each sample; `upset` is high where a sample at a tap and its bit do not agree: a bit flipped in the memory.
// The address counts steps modulo W, so a frame may begin at any address. Only samples that the frame itself wrote are
// used.
// Latency: 1 to ROWS lines to y, one step more to `upset`.
module line_delay_parity #(
  parameter BITS = 16,
  parameter ROWS = 1,
  parameter [ROWS-1:0] TAPS = 1,
  parameter OUTPUTS = 1,
  parameter ADDRESS_BITS = 10
) (
  input  wire clock,
  input  wire advance,
  input  wire [ADDRESS_BITS-1:0] address,
  input  wire [ADDRESS_BITS-1:0] write_address,
  input  wire [BITS-1:0] x,
  output wire [BITS*OUTPUTS-1:0] y,
  output reg  upset
);

localparam WORDS = 1 << ADDRESS_BITS;
localparam SAMPLE = BITS + 1;

// The number of taps below a row.
function integer taps_below(input integer row);
  integer i;
  begin
    taps_below = 0;
    for (i = 0; i < row; i = i + 1)
      taps_below = taps_below + (TAPS[i] ? 1 : 0);
  end
endfunction

initial if (taps_below(ROWS) != OUTPUTS) begin
  $error("%m: TAPS has %0d bits set, and OUTPUTS is %0d", taps_below(ROWS), OUTPUTS);
  $finish;
end

reg [SAMPLE*ROWS-1:0] memory [0:WORDS-1];
reg [SAMPLE*ROWS-1:0] column;
wire [SAMPLE*(ROWS+1)-1:0] shifted = {column, ^x, x};
wire [OUTPUTS-1:0] odd;

`ifndef SYNTHESIS
// A block memory and its output register are 0 after configuration.
integer entry;
initial begin
  for (entry = 0; entry < WORDS; entry = entry + 1)
    memory[entry] = {(SAMPLE*ROWS){1'b0}};
  column = {(SAMPLE*ROWS){1'b0}};
end
`endif

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= shifted[SAMPLE*ROWS-1:0];
  end

genvar k;
generate
  for (k = 0; k < ROWS; k = k + 1) begin : tap
    if (TAPS[k]) begin : used
      assign y[BITS*taps_below(k) +: BITS] = column[SAMPLE*k +: BITS];
      assign odd[taps_below(k)] = ^column[SAMPLE*k +: SAMPLE];
    end
  end
endgenerate

initial upset = 1'b0;

always @(posedge clock)
  if (advance)
    upset <= |odd;

wire unused = ^shifted[SAMPLE*(ROWS+1)-1:SAMPLE*ROWS];

endmodule
