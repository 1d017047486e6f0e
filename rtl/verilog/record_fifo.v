// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// 512 records before the sink. `room`: 16 places are free, so a feature may be written; `stop`: 3 or fewer are, so the datapath stands.
// Features are dropped and counted without room; trailers never are.
// Latency: 3 clocks from `write` to `valid` when empty.
module record_fifo (
  input  wire clock,
  input  wire reset,
  input  wire write,
  input  wire [255:0] record,
  output reg  room,
  output reg  stop,
  input  wire ready,
  output reg  valid,
  output reg  [255:0] data,
  output reg  start_of_packet,
  output reg  end_of_packet
);

reg [255:0] memory [0:511];
reg [8:0]   write_place;
reg [8:0]   read_place;
reg [9:0]   waiting;
reg [255:0] next;
reg         next_valid;
reg         in_packet;

wire take_data = ~valid | ready;
wire take_next = ~next_valid | take_data;
wire some      = waiting != 10'd0;
wire pop       = take_next & some;
wire [9:0] after = waiting + {9'd0, write} - {9'd0, pop};

always @(posedge clock)
  if (reset) begin
    write_place <= 9'd0;
    read_place  <= 9'd0;
    waiting     <= 10'd0;
    next_valid  <= 1'b0;
    valid       <= 1'b0;
    in_packet      <= 1'b0;
    room        <= 1'b1;
    stop        <= 1'b0;
  end else begin
    write_place <= write_place + {8'd0, write};
    read_place  <= read_place + {8'd0, pop};
    waiting     <= after;
    room        <= after < 10'd496;
    stop        <= after >= 10'd509;
    if (take_next)
      next_valid <= some;
    if (take_data)
      valid <= next_valid;
    if (valid & ready)
      in_packet <= ~end_of_packet;
  end

always @(posedge clock)
  if (take_next)
    next <= memory[read_place];

always @(posedge clock)
  if (write)
    memory[write_place] <= record;

always @(posedge clock)
  if (take_data)
    data <= next;

always @(*) begin
  start_of_packet = ~in_packet;
  end_of_packet   = data[63];
end

endmodule
