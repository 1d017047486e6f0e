// Avalon-MM: a slave with wait states and pipelined reads, or with neither, and its registers as software sees them.
// Rules of the master, assumed:
//   `read` and `write` are not high together; an access that waits for `waitrequest` to fall does not change
// Rules of the slave, asserted:
//   waits      `waitrequest` is high for at most WAITS clocks per access
//   invented   `readdatavalid` comes only while a read is outstanding
//   answers    a read is answered within LATENCY clocks of its acceptance
//   order      the answer to an arbitrary read of the register `followed` is the value last written there
// `followed` is an arbitrary address. `bits` marks its bits that read back as written: connect a function of `followed`,
// 0 for registers whose writes are not read back. A register that changes by itself has no such bits.
// A slave of fixed latency L without wait states: waitrequest = 0, readdatavalid = `read` of L clocks before.
// `outstanding`, `known`, `value`, `asked`, `ahead` and `wanted`: the state of the rules, for the invariants of a proof.
// The proof must assume `reset` in its first clock.
module avalon_slave #(
  parameter ADDRESS = 4, parameter DATA = 32, parameter WAITS = 0, parameter LATENCY = 1, parameter OUTSTANDING = 1
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
  output reg  [7:0] outstanding,
  output reg  known,
  output reg  [DATA-1:0] value,
  output reg  asked,
  output reg  [7:0] ahead,
  output reg  [DATA-1:0] wanted
);
  (* anyconst *) reg [ADDRESS-1:0] any_address;
  (* anyseq *) reg choose;
  assign followed = any_address;

  wire access = read | write;
  wire accepted_read = read & ~waitrequest;
  wire [ADDRESS+DATA+1:0] request = {read, write, address, writedata & {DATA{write}}};
  reg waited = 0;
  reg [ADDRESS+DATA+1:0] waiting;
  reg [7:0] waits_so_far, since;
  initial outstanding = 8'd0;
  initial known = 1'b0;
  initial asked = 1'b0;
  wire chosen = accepted_read & choose & known & ~asked & (address == any_address);
  wire answered = asked & readdatavalid & (ahead == 8'd0);

  always @(posedge clock) begin
    waited <= access & waitrequest & ~reset;
    waiting <= request;
    if (reset) begin
      outstanding <= 8'd0;
      since <= 8'd0;
      waits_so_far <= 8'd0;
      known <= 1'b0;
      asked <= 1'b0;
    end else begin
      outstanding <= outstanding + {7'd0, accepted_read} - {7'd0, readdatavalid};
      since <= outstanding == 8'd0 || readdatavalid ? 8'd0 : since + 8'd1;
      waits_so_far <= access & waitrequest ? waits_so_far + 8'd1 : 8'd0;
      if (write & ~waitrequest & (address == any_address)) begin
        known <= 1'b1;
        value <= writedata;
      end
      if (chosen) begin
        asked <= 1'b1;
        ahead <= outstanding - {7'd0, readdatavalid};
        wanted <= value & bits;
      end else if (answered)
        asked <= 1'b0;
      else if (asked & readdatavalid)
        ahead <= ahead - 8'd1;
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
      invented: assert (!readdatavalid || outstanding != 8'd0);
      answers: assert (outstanding == 8'd0 || readdatavalid || since + 8'd1 < LATENCY);
      order: assert (!answered || (readdata & bits) == wanted);
    end
endmodule
