// y[n] = x[n - k W] for each k of which bit k - 1 of TAPS is set, the newest lowest, as line_delay. A parity bit stays
// with each sample; `upset` is high where a sample at a tap and its bit do not agree: a bit flipped in the memory.
// Latency: 1 to ROWS lines to y, one step more to `upset`.
module line_delay_parity #(
  parameter BITS = 16,
  parameter ROWS = 1,
  parameter [ROWS-1:0] TAPS = 1,
  parameter OUTPUTS = 1,
  parameter ADDRESS_BITS = 10,
  parameter READ = 1
) (
  input  wire clock,
  input  wire advance,
  input  wire [ADDRESS_BITS-1:0] address,
  input  wire [ADDRESS_BITS-1:0] write_address,
  input  wire [BITS-1:0] x,
  output wire [BITS*OUTPUTS-1:0] y,
  output reg  upset
);

// Bits of a sample with its parity bit.
localparam CODE = BITS + 1;

wire [CODE*OUTPUTS-1:0] samples;
wire [OUTPUTS-1:0] odd;

line_delay #(.BITS(CODE), .ROWS(ROWS), .TAPS(TAPS), .OUTPUTS(OUTPUTS), .ADDRESS_BITS(ADDRESS_BITS), .READ(READ)) lines (
  .clock(clock),
  .advance(advance),
  .address(address),
  .write_address(write_address),
  .x({^x, x}),
  .y(samples)
);

`ifndef SYNTHESIS
// A block memory and its output register are 0 after configuration.
integer entry;
initial begin
  for (entry = 0; entry < (1 << ADDRESS_BITS); entry = entry + 1)
    lines.memory[entry] = {(CODE*ROWS){1'b0}};
  lines.words = {(CODE*ROWS*READ){1'b0}};
end
`endif

genvar k;
generate
  for (k = 0; k < OUTPUTS; k = k + 1) begin : tap
    assign y[BITS*k +: BITS] = samples[CODE*k +: BITS];
    assign odd[k] = ^samples[CODE*k +: CODE];
  end
endgenerate

initial upset = 1'b0;

always @(posedge clock)
  if (advance)
    upset <= |odd;

endmodule
