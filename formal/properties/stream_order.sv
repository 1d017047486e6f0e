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
// The proof must assume `reset` in its first clock.
module stream_order #(parameter DATA = 8, parameter ENTRIES = 16, parameter LATENCY = 0) (
  input  wire clock,
  input  wire reset,
  input  wire take,
  input  wire [DATA-1:0] taken,
  input  wire offered,
  input  wire leave,
  input  wire [DATA-1:0] leaving,
  output reg  [15:0] inside,
  output reg  following,
  output reg  [15:0] ahead,
  output reg  [DATA-1:0] followed
);
  (* anyseq *) reg choose;
  reg [7:0] idle = 8'd0;
  wire lacks = (inside != 16'd0) & ~offered;
  initial inside = 16'd0;
  initial following = 1'b0;
  always @(posedge clock) begin
    if (reset) begin
      inside <= 16'd0;
      idle <= 8'd0;
      following <= 1'b0;
    end else begin
      idle <= lacks ? idle + 8'd1 : 8'd0;
      inside <= inside + {15'd0, take} - {15'd0, leave};
      if (take & choose & ~following) begin
        following <= 1'b1;
        ahead <= inside - {15'd0, leave};
        followed <= taken;
      end else if (following & leave) begin
        following <= ahead != 16'd0;
        ahead <= ahead - 16'd1;
      end
    end
  end

  always @(posedge clock)
    if (!reset) begin
      invented: assert (!leave || inside != 16'd0);
      full: assert (inside <= ENTRIES);
      offers: assert (idle <= LATENCY && !(lacks && idle == LATENCY));
      order: assert (!(following && leave && ahead == 16'd0) || leaving == followed);
      count: assert (!following || ahead < inside);
    end
endmodule
