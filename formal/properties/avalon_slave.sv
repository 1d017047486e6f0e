// Avalon-MM: a slave with wait states and pipelined reads, or with neither, and its registers as software sees them.
// Rules of the master, assumed:
//   `read` and `write` are not high together; an access that waits for `waitrequest` to fall does not change
//   no read is offered while OUTSTANDING reads are unanswered, but in the clock of an answer
// Rules of the slave, asserted:
//   waits      `waitrequest` is high for at most WAITS clocks per access
//   invented   `readdatavalid` comes only while a read is outstanding
//   answers    a read is answered within LATENCY clocks of its acceptance
//   order      the answer to an arbitrary read of the register `followed` is the value last written there
// `followed` is an arbitrary address. `bits` marks its bits that read back as written: connect a function of `followed`,
// 0 for registers whose writes are not read back. A register that changes by itself has no such bits.
// A slave of fixed latency L without wait states: waitrequest = 0, readdatavalid = `read` of L clocks before.
// `outstanding`, `known`, `value`, `asked`, `ahead` and `wanted`: the state of the rules, for the invariants of a proof.
// The counters have 8 bits, or those that a larger parameter needs.
// The proof must assume `reset` in its first clock.
module avalon_slave #(
  parameter ADDRESS = 4, parameter DATA = 32, parameter WAITS = 0, parameter LATENCY = 1, parameter OUTSTANDING = 1,
  localparam COUNT = OUTSTANDING < 255 ? 8 : $clog2(OUTSTANDING + 2)
) (
  input  wire clock,
  input  wire reset,
  input  wire [ADDRESS-1:0] address,
  input  wire read,
  input  wire write,
  input  wire [DATA-1:0] writedata,
  input  wire waitrequest,
  input  wire readdatavalid,
  input  wire [DATA-1:0] readdata,
  input  wire [DATA-1:0] bits,
  output wire [ADDRESS-1:0] followed,
  output reg  [COUNT-1:0] outstanding,
  output reg  known,
  output reg  [DATA-1:0] value,
  output reg  asked,
  output reg  [COUNT-1:0] ahead,
  output reg  [DATA-1:0] wanted
);
  localparam WAIT_BITS = WAITS < 255 ? 8 : $clog2(WAITS + 2), SINCE_BITS = LATENCY < 255 ? 8 : $clog2(LATENCY + 2);
  (* anyconst *) reg [ADDRESS-1:0] any_address;
  (* anyseq *) reg choose;
  assign followed = any_address;

  wire access = read | write;
  wire accepted_read = read & ~waitrequest;
  wire [ADDRESS+DATA+1:0] request = {read, write, address, writedata & {DATA{write}}};
  reg waited = 0;
  reg [ADDRESS+DATA+1:0] waiting;
  reg [WAIT_BITS-1:0] waits_so_far;
  reg [SINCE_BITS-1:0] since;
  initial outstanding = 0;
  initial known = 1'b0;
  initial asked = 1'b0;
  wire chosen = accepted_read & choose & known & ~asked & (address == any_address);
  wire answered = asked & readdatavalid & (ahead == 0);

  always @(posedge clock) begin
    waited <= access & waitrequest & ~reset;
    waiting <= request;
    if (reset) begin
      outstanding <= 0;
      since <= 0;
      waits_so_far <= 0;
      known <= 1'b0;
      asked <= 1'b0;
    end else begin
      outstanding <= outstanding + accepted_read - readdatavalid;
      since <= outstanding == 0 || readdatavalid ? 0 : since + 1;
      waits_so_far <= access & waitrequest ? waits_so_far + 1 : 0;
      if (write & ~waitrequest & (address == any_address)) begin
        known <= 1'b1;
        value <= writedata;
      end
      if (chosen) begin
        asked <= 1'b1;
        ahead <= outstanding - readdatavalid;
        wanted <= value & bits;
      end else if (answered)
        asked <= 1'b0;
      else if (asked & readdatavalid)
        ahead <= ahead - 1;
    end
  end

  always @(*) begin
    assume (!(read && write));
    assume (!waited || request == waiting);
    assume (!read || outstanding < OUTSTANDING || readdatavalid);
  end

  always @(posedge clock)
    if (!reset) begin
      waits: assert (waits_so_far <= WAITS && !(access && waitrequest && waits_so_far == WAITS));
      invented: assert (!readdatavalid || outstanding != 0);
      answers: assert (outstanding == 0 || readdatavalid || since + 1 < LATENCY);
      order: assert (!answered || (readdata & bits) == wanted);
    end
endmodule
