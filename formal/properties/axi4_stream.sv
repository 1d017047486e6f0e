// AXI4-Stream (Arm IHI 0051): the rules of a transmitter.
//   hold       while `tvalid` waits for `tready` it stays high, and all signals of the beat are unchanged
//   low        `tvalid` is low after a clock edge in reset
//   reserved   no byte has `tstrb` without `tkeep`
// `side` is {tid, tdest, tuser}, or those of them that exist. Connect signals that the stream does not have to constants:
// tkeep and tstrb to ones, tlast and side to 0.
// ASSUMED = 1: the transmitter is outside the design; the rules are assumed. ASSUMED = 0: they are asserted.
// `waited` and `waiting`: the state of the rules, for the invariants of a proof.
module axi4_stream #(parameter BYTES = 1, parameter SIDE = 1, parameter ASSUMED = 0) (
  input  wire aclk,
  input  wire aresetn,
  input  wire tvalid,
  input  wire tready,
  input  wire [8*BYTES-1:0] tdata,
  input  wire [BYTES-1:0] tkeep,
  input  wire [BYTES-1:0] tstrb,
  input  wire tlast,
  input  wire [SIDE-1:0] side,
  output reg  waited,
  output reg  [10*BYTES+SIDE:0] waiting
);
  reg was_reset = 0;
  initial waited = 0;
  wire [10*BYTES+SIDE:0] beat = {side, tlast, tstrb, tkeep, tdata};
  always @(posedge aclk) begin
    was_reset <= ~aresetn;
    waited <= tvalid & ~tready & aresetn;
    waiting <= beat;
  end

  wire holds = ~waited | ~aresetn | (tvalid & (beat == waiting));
  wire is_low = ~was_reset | ~tvalid;
  wire no_reserved = ~tvalid | ~aresetn | ((tstrb & ~tkeep) == {BYTES{1'b0}});
  generate
    if (ASSUMED) begin
      always @(*) begin
        assume (holds);
        assume (is_low);
        assume (no_reserved);
      end
    end else begin
      always @(posedge aclk) begin
        hold: assert (holds);
        low: assert (is_low);
        reserved: assert (no_reserved);
      end
    end
  endgenerate
endmodule
