// Avalon-ST with a ready latency of 0: the rules of a source.
//   hold     a beat that waits for `ready` stays offered, data and packet flags unchanged
//   start    `startofpacket` is high on the first beat after the end of a packet, and on no other (PACKETS = 1)
// ASSUMED = 1: the source is outside the design; the rules are assumed. ASSUMED = 0: they are asserted.
// PACKETS = 0: a stream without packets; connect both flags to 0.
// `in_packet`, `waited` and `waiting`: the state of the rules, for the invariants of a proof.
// The proof must assume `reset` in its first clock.
module avalon_stream #(parameter DATA = 8, parameter PACKETS = 1, parameter ASSUMED = 0) (
  input  wire clock,
  input  wire reset,
  input  wire ready,
  input  wire valid,
  input  wire [DATA-1:0] data,
  input  wire startofpacket,
  input  wire endofpacket,
  output reg  in_packet,
  output reg  waited,
  output reg  [DATA+1:0] waiting
);
  initial waited = 0;
  wire [DATA+1:0] beat = {startofpacket, endofpacket, data};
  always @(posedge clock) begin
    waited <= valid & ~ready & ~reset;
    waiting <= beat;
    if (reset)
      in_packet <= 1'b0;
    else if (valid & ready)
      in_packet <= ~endofpacket;
  end

  wire holds = ~waited | reset | (valid & (beat == waiting));
  wire starts = reset | ~valid | (startofpacket == ~in_packet);
  generate
    if (ASSUMED) begin
      always @(*) begin
        assume (holds);
        if (PACKETS) assume (starts);
      end
    end else begin
      always @(posedge clock) begin
        hold: assert (holds);
        if (PACKETS) start: assert (starts);
      end
    end
  endgenerate
endmodule
