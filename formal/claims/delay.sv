// delay_WxN: y is the sample of N steps before, wherever the memory's address starts and whatever the memory holds.
// One arbitrary sample is followed from its write to its read.

// A delay of LENGTH words in a memory and one more step; `watched` is the memory's word at `slot`.
module followed #(parameter WIDTH = 16, BITS = 4, LENGTH = 9, COVERED = 0) (
  input clock, input reset, input advance, input choose, input [WIDTH-1:0] x, input [WIDTH-1:0] y,
  input [BITS-1:0] position, input [WIDTH-1:0] watched, output reg [BITS-1:0] slot
);
  // Steps since a reset, up to the number after which an address that started beyond the memory has wrapped.
  localparam SETTLED = 1 << BITS;
  reg [5:0] steps = 6'd0;
  // Steps since the sample was taken.
  reg [5:0] age = 6'd0;
  reg [WIDTH-1:0] sample;
  // Equal initial values make the cover quicker to reach.
  reg always_advanced = 1;
  always @(posedge clock) begin
    always_advanced <= always_advanced && advance && !reset && choose;
    if (reset) begin
      steps <= 6'd0;
      age <= 6'd0;
    end else if (advance) begin
      if (steps != SETTLED) steps <= steps + 6'd1;
      if (age == 6'd0 && choose && steps == SETTLED) begin
        age <= 6'd1;
        sample <= x;
        slot <= position;
      end else if (age != 6'd0 && age != 6'd63)
        age <= age + 6'd1;
    end
  end

  wire [6:0] at = {1'b0, slot} + age;
  always @(posedge clock) begin
    inside: assert (position < LENGTH || steps <= position);
    settled: assert (age == 6'd0 || steps == SETTLED);
    if (age != 6'd0 && age <= LENGTH)
      kept: assert (slot < LENGTH && watched == sample && position == (at >= LENGTH ? at - LENGTH : at));
    delayed: assert (age != LENGTH + 1 || y == sample);
    if (COVERED) arrives: cover (always_advanced && age == LENGTH + 1 && y != x);
  end
endmodule

module delay_properties (input clock);
  (* anyseq *) reg reset, advance, choose;
  (* anyseq *) reg [17:0] x;

  wire [14:0] y_15x5;
  delay_15x5 dut_15x5 (.clock(clock), .reset(reset), .advance(advance), .x(x[14:0]), .y(y_15x5));
  (* hierconn *) wire [1:0] \dut_15x5.position ;
  (* hierconn *) wire [1:0] \dut_15x5.slot ;
  (* hierconn *) wire [14:0] \dut_15x5.watched ;
  followed #(.WIDTH(15), .BITS(2), .LENGTH(4)) followed_15x5 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[14:0]), .y(y_15x5),
    .position(\dut_15x5.position ), .watched(\dut_15x5.watched ), .slot(\dut_15x5.slot )
  );

  wire [15:0] y_16x10;
  delay_16x10 dut_16x10 (.clock(clock), .reset(reset), .advance(advance), .x(x[15:0]), .y(y_16x10));
  (* hierconn *) wire [3:0] \dut_16x10.position ;
  (* hierconn *) wire [3:0] \dut_16x10.slot ;
  (* hierconn *) wire [15:0] \dut_16x10.watched ;
  followed #(.WIDTH(16), .BITS(4), .LENGTH(9)) followed_16x10 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[15:0]), .y(y_16x10),
    .position(\dut_16x10.position ), .watched(\dut_16x10.watched ), .slot(\dut_16x10.slot )
  );

  wire [15:0] y_16x11;
  delay_16x11 dut_16x11 (.clock(clock), .reset(reset), .advance(advance), .x(x[15:0]), .y(y_16x11));
  (* hierconn *) wire [3:0] \dut_16x11.position ;
  (* hierconn *) wire [3:0] \dut_16x11.slot ;
  (* hierconn *) wire [15:0] \dut_16x11.watched ;
  followed #(.WIDTH(16), .BITS(4), .LENGTH(10)) followed_16x11 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[15:0]), .y(y_16x11),
    .position(\dut_16x11.position ), .watched(\dut_16x11.watched ), .slot(\dut_16x11.slot )
  );

  wire [15:0] y_16x4;
  delay_16x4 dut_16x4 (.clock(clock), .reset(reset), .advance(advance), .x(x[15:0]), .y(y_16x4));
  (* hierconn *) wire [1:0] \dut_16x4.position ;
  (* hierconn *) wire [1:0] \dut_16x4.slot ;
  (* hierconn *) wire [15:0] \dut_16x4.watched ;
  followed #(.WIDTH(16), .BITS(2), .LENGTH(3)) followed_16x4 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[15:0]), .y(y_16x4),
    .position(\dut_16x4.position ), .watched(\dut_16x4.watched ), .slot(\dut_16x4.slot )
  );

  wire [15:0] y_16x7;
  delay_16x7 dut_16x7 (.clock(clock), .reset(reset), .advance(advance), .x(x[15:0]), .y(y_16x7));
  (* hierconn *) wire [2:0] \dut_16x7.position ;
  (* hierconn *) wire [2:0] \dut_16x7.slot ;
  (* hierconn *) wire [15:0] \dut_16x7.watched ;
  followed #(.WIDTH(16), .BITS(3), .LENGTH(6)) followed_16x7 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[15:0]), .y(y_16x7),
    .position(\dut_16x7.position ), .watched(\dut_16x7.watched ), .slot(\dut_16x7.slot )
  );

  wire [17:0] y_18x20;
  delay_18x20 dut_18x20 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x20));
  (* hierconn *) wire [4:0] \dut_18x20.position ;
  (* hierconn *) wire [4:0] \dut_18x20.slot ;
  (* hierconn *) wire [17:0] \dut_18x20.watched ;
  followed #(.WIDTH(18), .BITS(5), .LENGTH(19)) followed_18x20 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[17:0]), .y(y_18x20),
    .position(\dut_18x20.position ), .watched(\dut_18x20.watched ), .slot(\dut_18x20.slot )
  );

  wire [63:0] y_64x4;
  delay_64x4 dut_64x4 (.clock(clock), .reset(reset), .advance(advance), .x({x[9:0], x, x, x}), .y(y_64x4));
  (* hierconn *) wire [1:0] \dut_64x4.position ;
  (* hierconn *) wire [1:0] \dut_64x4.slot ;
  (* hierconn *) wire [63:0] \dut_64x4.watched ;
  followed #(.WIDTH(64), .BITS(2), .LENGTH(3)) followed_64x4 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x({x[9:0], x, x, x}), .y(y_64x4),
    .position(\dut_64x4.position ), .watched(\dut_64x4.watched ), .slot(\dut_64x4.slot )
  );

  wire [17:0] y_18x4;
  delay_18x4 dut_18x4 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x4));
  (* hierconn *) wire [1:0] \dut_18x4.position ;
  (* hierconn *) wire [1:0] \dut_18x4.slot ;
  (* hierconn *) wire [17:0] \dut_18x4.watched ;
  followed #(.WIDTH(18), .BITS(2), .LENGTH(3), .COVERED(1)) followed_18x4 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[17:0]), .y(y_18x4),
    .position(\dut_18x4.position ), .watched(\dut_18x4.watched ), .slot(\dut_18x4.slot )
  );

  wire [17:0] y_18x8;
  delay_18x8 dut_18x8 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x8));
  (* hierconn *) wire [2:0] \dut_18x8.position ;
  (* hierconn *) wire [2:0] \dut_18x8.slot ;
  (* hierconn *) wire [17:0] \dut_18x8.watched ;
  followed #(.WIDTH(18), .BITS(3), .LENGTH(7)) followed_18x8 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[17:0]), .y(y_18x8),
    .position(\dut_18x8.position ), .watched(\dut_18x8.watched ), .slot(\dut_18x8.slot )
  );

  wire [17:0] y_18x16;
  delay_18x16 dut_18x16 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x16));
  (* hierconn *) wire [3:0] \dut_18x16.position ;
  (* hierconn *) wire [3:0] \dut_18x16.slot ;
  (* hierconn *) wire [17:0] \dut_18x16.watched ;
  followed #(.WIDTH(18), .BITS(4), .LENGTH(15)) followed_18x16 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[17:0]), .y(y_18x16),
    .position(\dut_18x16.position ), .watched(\dut_18x16.watched ), .slot(\dut_18x16.slot )
  );

  wire [17:0] y_18x32;
  delay_18x32 dut_18x32 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x32));
  (* hierconn *) wire [4:0] \dut_18x32.position ;
  (* hierconn *) wire [4:0] \dut_18x32.slot ;
  (* hierconn *) wire [17:0] \dut_18x32.watched ;
  followed #(.WIDTH(18), .BITS(5), .LENGTH(31)) followed_18x32 (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[17:0]), .y(y_18x32),
    .position(\dut_18x32.position ), .watched(\dut_18x32.watched ), .slot(\dut_18x32.slot )
  );

  // Delays of registers alone.
  reg [1:0] filled = 2'd0;
  reg [17:0] before, before_2;
  always @(posedge clock)
    if (advance) begin
      if (filled != 2'd2) filled <= filled + 2'd1;
      before <= x;
      before_2 <= before;
    end
  wire [14:0] y_15x1;
  delay_15x1 dut_15x1 (.clock(clock), .reset(reset), .advance(advance), .x(x[14:0]), .y(y_15x1));
  wire [15:0] y_16x1;
  delay_16x1 dut_16x1 (.clock(clock), .reset(reset), .advance(advance), .x(x[15:0]), .y(y_16x1));
  wire [17:0] y_18x1;
  delay_18x1 dut_18x1 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x1));
  wire [17:0] y_18x2;
  delay_18x2 dut_18x2 (.clock(clock), .reset(reset), .advance(advance), .x(x[17:0]), .y(y_18x2));
  (* hierconn *) wire [17:0] \dut_18x2.delayed_1 ;

  // Delays of flags: a reset clears the flags in flight.
  wire flag_2, flag_8;
  flag_delay_2 dut_flag_2 (.clock(clock), .reset(reset), .advance(advance), .x(x[0]), .y(flag_2));
  flag_delay_8 dut_flag_8 (.clock(clock), .reset(reset), .advance(advance), .x(x[0]), .y(flag_8));
  (* hierconn *) wire [0:0] \dut_flag_2.delayed ;
  (* hierconn *) wire [6:0] \dut_flag_8.delayed ;
  reg [3:0] flags_filled = 4'd0;
  reg [7:0] flags;
  always @(posedge clock)
    if (reset)
      flags_filled <= 4'd0;
    else if (advance) begin
      if (flags_filled != 4'd8) flags_filled <= flags_filled + 4'd1;
      flags <= {flags[6:0], x[0]};
    end
  always @(posedge clock) begin
    in_flight: assert (((\dut_flag_8.delayed ^ flags[6:0]) & ~(7'd127 << flags_filled)) == 7'd0);
    in_flight_2: assert (flags_filled == 4'd0 || \dut_flag_2.delayed == flags[0]);
    flags_delayed: assert ((flags_filled < 4'd8 || flag_8 == flags[7]) && (flags_filled < 4'd2 || flag_2 == flags[1]));
    one_step: assert (filled == 2'd0 || (y_15x1 == before[14:0] && y_16x1 == before[15:0] && y_18x1 == before && \dut_18x2.delayed_1 == before));
    two_steps: assert (filled != 2'd2 || y_18x2 == before_2);
  end
endmodule
