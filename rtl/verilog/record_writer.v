// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Feature records of 256 bits, scale pair 0 before 1, and the trailer that ends a frame: frame number, errors, count, dropped, thresholds.
//   step 1  candidate waits   step 2  ring words arrive   step 3  record of pair 0   step 4  record of pair 1
// Latency: 3 steps from `found` to `write`.
module record_writer (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire found,
  input  wire [174:0] candidate,
  input  wire [31:0] maxlbp_0,
  input  wire [31:0] maxlbp_1,
  input  wire [31:0] sign_0,
  input  wire [31:0] sign_1,
  input  wire [1:0] lost,
  input  wire frame_end,
  input  wire [3:0] errors,
  input  wire take,
  input  wire [14:0] threshold_0,
  input  wire [14:0] threshold_1,
  input  wire room,
  output reg  write,
  output reg  [255:0] record,
  output reg  done,
  output reg  [19:0] count,
  output reg  [19:0] dropped,
  output reg  [31:0] frames
);

// The candidate waits one step for its ring words, then its records are written, scale pair 0 first.
reg         waits;
reg [174:0] waiting;
reg [1:0]   hits;
reg [174:0] now;
reg [127:0] words;
reg         trailer;
reg [29:0]  thresholds;

wire         second  = ~hits[0];
wire         feature = |hits;
wire         end_now = trailer & ~feature;
wire [15:0]  centre  = second ? now[54:39] : now[38:23];
wire [59:0]  around  = second ? now[174:115] : now[114:55];
wire [31:0]  place   = {5'd0, now[20:10], 6'd0, now[9:0]};
wire [31:0]  answer  = {14'd0, centre[15], second, 1'b0, centre[14:0]};
wire [63:0]  cardinal   = {1'b0, around[59:45], 1'b0, around[44:30], 1'b0, around[29:15], 1'b0, around[14:0]};
wire [255:0] ended   = {96'd0, 1'b0, thresholds[29:15], 1'b0, thresholds[14:0], 12'd0, dropped, 12'd0, count,
                        16'h8000, 12'd0, errors, frames};

always @(posedge clock)
  if (reset) begin
    waits   <= 1'b0;
    hits    <= 2'd0;
    trailer <= 1'b0;
    write   <= 1'b0;
    done    <= 1'b0;
    count   <= 20'd0;
    dropped <= 20'd0;
    frames  <= 32'd0;
  end else if (advance) begin
    waits <= found;
    if (waits)
      hits <= waiting[22:21];
    else
      hits <= hits[0] ? {hits[1], 1'b0} : 2'd0;
    trailer <= frame_end | (trailer & ~end_now);
    write   <= (feature & room) | end_now;
    done    <= end_now;
    count   <= done ? {19'd0, feature & room} : count + {19'd0, feature & room};
    dropped <= (done ? 20'd0 : dropped) + {18'd0, lost} + {19'd0, feature & ~room};
    frames  <= frames + {31'd0, done};
  end

always @(posedge clock)
  if (advance) begin
    waiting <= candidate;
    if (take)
      thresholds <= {threshold_1, threshold_0};
    if (waits) begin
      now   <= waiting;
      words <= {sign_1, sign_0, maxlbp_1, maxlbp_0};
    end
    record <= end_now ? ended : {words, cardinal, answer, place};
  end

endmodule
