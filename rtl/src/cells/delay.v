// y[n] = x[n - STEPS] of BITS bits: registers up to 3 steps, beyond that a small memory, read and then written at the
// same address: the read gives the old word.
// The address may begin anywhere; its reset is for simulators with X.
// Latency: STEPS steps, 1 to 33: a memory in MLABs has 32 words, and a register follows it.
module delay #(
  parameter BITS = 16,
  parameter STEPS = 4
) (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [BITS-1:0] x,
  output wire [BITS-1:0] y
);

initial if (STEPS < 1 || STEPS > 33) begin
  $error("%m: STEPS is %0d, not 1 to 33", STEPS);
  $finish;
end

generate
  if (STEPS < 4) begin : in_registers
    reg [BITS*STEPS-1:0] delayed;
    wire [BITS*(STEPS+1)-1:0] shifted = {delayed, x};

    always @(posedge clock)
      if (advance)
        delayed <= shifted[BITS*STEPS-1:0];

    assign y = delayed[BITS*STEPS-1:BITS*(STEPS-1)];
    wire unused = ^{reset, shifted[BITS*(STEPS+1)-1:BITS*STEPS]};
  end else begin : in_memory
    localparam WORDS = STEPS - 1;
    localparam ADDRESS_BITS = $clog2(WORDS);
    localparam LAST = WORDS - 1;

    // Without the attribute Quartus leaves memories of some hundred bits in registers. A word is read and overwritten
    // at one address in one clock and the read needs the old one, so `no_rw_check` must not stand beside it.
    (* ramstyle = "MLAB" *) reg [BITS-1:0] memory [0:WORDS-1];
    reg [ADDRESS_BITS-1:0] position;
    reg [BITS-1:0] oldest;

    always @(posedge clock)
      if (reset)
        position <= 0;
      else if (advance)
        position <= position == LAST[ADDRESS_BITS-1:0] ? 0 : position + 1;

    always @(posedge clock)
      if (advance) begin
        oldest <= memory[position];
        memory[position] <= x;
      end

    assign y = oldest;
  end
endgenerate

endmodule
