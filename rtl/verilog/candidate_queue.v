// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Candidates wait until their ring is complete, 15 lines and some steps, and are found again by their place.
// 512 can wait in the memory and two behind it; what finds no place is dropped and counted.
// Latency: 1 step from the ring's place to `found` and `candidate`.
module candidate_queue (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [174:0] word,
  input  wire active,
  input  wire [9:0] x,
  input  wire [10:0] y,
  output reg  found,
  output reg  [174:0] candidate,
  output reg  [14:0] centre_0,
  output reg  [14:0] centre_1,
  output reg  [1:0] dropped
);

reg [174:0] memory [0:511];
reg [8:0]   write_place;
reg [8:0]   read_place;
reg [9:0]   waiting;
reg [174:0] next;
reg         next_valid;
reg [174:0] head;
reg         head_valid;

wire fits   = active & head_valid & (head[20:0] == {y, x});
wire take_head = ~head_valid | fits;
wire take_next = ~next_valid | take_head;
wire some      = waiting != 10'd0;
wire full      = waiting[9];
wire push      = (word[21] | word[22]) & ~full;
wire pop       = take_next & some;

always @(posedge clock)
  if (reset) begin
    write_place <= 9'd0;
    read_place  <= 9'd0;
    waiting     <= 10'd0;
    next_valid  <= 1'b0;
    head_valid  <= 1'b0;
    found       <= 1'b0;
    dropped     <= 2'd0;
  end else if (advance) begin
    write_place <= write_place + {8'd0, push};
    read_place  <= read_place + {8'd0, pop};
    waiting     <= waiting + {9'd0, push} - {9'd0, pop};
    if (take_next)
      next_valid <= some;
    if (take_head)
      head_valid <= next_valid;
    found   <= fits;
    dropped <= full ? {1'b0, word[21]} + {1'b0, word[22]} : 2'd0;
  end

always @(posedge clock)
  if (advance & take_next)
    next <= memory[read_place];

always @(posedge clock)
  if (advance & push)
    memory[write_place] <= word;

always @(posedge clock)
  if (advance) begin
    if (take_head)
      head <= next;
    candidate <= head;
    centre_0  <= head[37:23];
    centre_1  <= head[53:39];
  end

endmodule
