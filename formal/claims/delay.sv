// delay: y is the sample of STEPS steps before, wherever the memory's address starts and whatever the memory holds.
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
  (* anyseq *) reg [63:0] x;

for {bits} {steps}: each delay 4..
  wire [{bits}-1:0] y_{bits}x{steps};
  delay #(.BITS({bits}), .STEPS({steps})) dut_{bits}x{steps} (
    .clock(clock), .reset(reset), .advance(advance), .x(x[{bits}-1:0]), .y(y_{bits}x{steps})
  );
  (* hierconn *) wire [$clog2({steps}-1)-1:0] \dut_{bits}x{steps}.in_memory.position ;
  (* hierconn *) wire [$clog2({steps}-1)-1:0] \dut_{bits}x{steps}.observed.slot ;
  (* hierconn *) wire [{bits}-1:0] \dut_{bits}x{steps}.observed.watched ;
  followed #(.WIDTH({bits}), .BITS($clog2({steps}-1)), .LENGTH({steps} - 1), .COVERED({steps} == 4)) followed_{bits}x{steps} (
    .clock(clock), .reset(reset), .advance(advance), .choose(choose), .x(x[{bits}-1:0]), .y(y_{bits}x{steps}),
    .position(\dut_{bits}x{steps}.in_memory.position ), .watched(\dut_{bits}x{steps}.observed.watched ),
    .slot(\dut_{bits}x{steps}.observed.slot )
  );
end

  // Delays of registers alone: the last samples, the newest lowest. Bit k of `taken` is set after more than k samples.
  reg [2:0] taken = 3'd0;
  reg [63:0] sample_1, sample_2, sample_3;
  always @(posedge clock)
    if (advance) begin
      taken <= {taken[1:0], 1'b1};
      {sample_3, sample_2, sample_1} <= {sample_2, sample_1, x};
    end
for {bits} {steps}: each delay 1..3
  wire [{bits}-1:0] y_{bits}x{steps};
  delay #(.BITS({bits}), .STEPS({steps})) dut_{bits}x{steps} (
    .clock(clock), .reset(reset), .advance(advance), .x(x[{bits}-1:0]), .y(y_{bits}x{steps})
  );
  (* hierconn *) wire [{bits}*{steps}-1:0] \dut_{bits}x{steps}.in_registers.delayed ;
  wire [{bits}*3-1:0] samples_{bits}x{steps} = {sample_3[{bits}-1:0], sample_2[{bits}-1:0], sample_1[{bits}-1:0]};
  wire [{bits}*3-1:0] of_taken_{bits}x{steps} = {{{bits}{taken[2]}}, {{bits}{taken[1]}}, {{bits}{taken[0]}}};
  always @(posedge clock) begin
    in_registers_{bits}x{steps}: assert (((\dut_{bits}x{steps}.in_registers.delayed ^ samples_{bits}x{steps}[{bits}*{steps}-1:0])
      & of_taken_{bits}x{steps}[{bits}*{steps}-1:0]) == 0);
    out_of_registers_{bits}x{steps}: assert (!taken[{steps}-1] || y_{bits}x{steps} == samples_{bits}x{steps}[{bits}*({steps}-1) +: {bits}]);
  end
end
endmodule
