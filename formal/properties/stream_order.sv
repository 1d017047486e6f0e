// The rules of a FIFO, a skid buffer or any other path of beats: each accepted beat leaves once, in order, unchanged, and
// no other beat leaves. One arbitrary beat is followed, with the number of beats before it.
//   invented   no beat leaves while none is inside
//   order      the beat that leaves in the position of the followed one is that beat
//   full       at most ENTRIES beats are inside
//   offers     while beats are inside, one is offered after at most LATENCY clocks without one, whether or not the sink
//              is ready: detects a source that waits for `ready` and one that stops permanently
// `take`: a beat enters at this clock edge (valid & ready of the input); `offered`: the output's valid;
// `leave`: a beat leaves (valid & ready of the output).
// `inside`, `following`, `ahead` and `followed`: the state of the rules, for the invariants of a proof.
// `inside` and `ahead` have 16 bits, or those that a larger ENTRIES needs.
// The proof must assume `reset` in its first clock.
module stream_order #(
  parameter DATA = 8, parameter ENTRIES = 16, parameter LATENCY = 0,
  localparam COUNT = ENTRIES < 65535 ? 16 : $clog2(ENTRIES + 2)
) (
  input  wire clock,
  input  wire reset,
  input  wire take,
  input  wire [DATA-1:0] taken,
  input  wire offered,
  input  wire leave,
  input  wire [DATA-1:0] leaving,
  output reg  [COUNT-1:0] inside,
  output reg  following,
  output reg  [COUNT-1:0] ahead,
  output reg  [DATA-1:0] followed
);
  (* anyseq *) reg choose;
  localparam IDLE_BITS = LATENCY < 255 ? 8 : $clog2(LATENCY + 2);
  reg [IDLE_BITS-1:0] idle = 0;
  wire lacks = (inside != 0) & ~offered;
  initial inside = 0;
  initial following = 1'b0;
  always @(posedge clock) begin
    if (reset) begin
      inside <= 0;
      idle <= 0;
      following <= 1'b0;
    end else begin
      idle <= lacks ? idle + 1 : 0;
      inside <= inside + take - leave;
      if (take & choose & ~following) begin
        following <= 1'b1;
        ahead <= inside - leave;
        followed <= taken;
      end else if (following & leave) begin
        following <= ahead != 0;
        ahead <= ahead - 1;
      end
    end
  end

  always @(posedge clock)
    if (!reset) begin
      invented: assert (!leave || inside != 0);
      full: assert (inside <= ENTRIES);
      offers: assert (idle <= LATENCY && !(lacks && idle == LATENCY));
      order: assert (!(following && leave && ahead == 0) || leaving == followed);
      count: assert (!following || ahead < inside);
    end
endmodule
