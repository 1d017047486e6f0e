// flag_delay: y is the flag of STEPS steps before, or 0 if a reset came since; a reset clears the flags in flight.

module flag_delay_properties (input clock);
  (* anyseq *) reg reset, advance, x;

  // The last flags, the newest lowest. Bit k of `entered` is set after more than k flags since a reset.
  reg [31:0] entered = 32'd0;
  reg [31:0] flags;
  reg cleared = 0;
  always @(posedge clock) begin
    cleared <= cleared | reset;
    if (reset)
      entered <= 32'd0;
    else if (advance) begin
      entered <= {entered[30:0], 1'b1};
      flags <= {flags[30:0], x};
    end
  end
for {steps}: each flag_delay
  wire flag_{steps};
  flag_delay #(.STEPS({steps})) dut_flag_{steps} (.clock(clock), .reset(reset), .advance(advance), .x(x), .y(flag_{steps}));
  (* hierconn *) wire [{steps}-1:0] \dut_flag_{steps}.delayed ;
  always @(posedge clock) begin
    in_flight_{steps}: assert (((\dut_flag_{steps}.delayed ^ flags[{steps}-1:0]) & entered[{steps}-1:0]) == 0);
    clear_{steps}: assert (!cleared || (\dut_flag_{steps}.delayed & ~entered[{steps}-1:0]) == 0);
    flag_leaves_{steps}: assert (entered[{steps}-1] ? flag_{steps} == flags[{steps}-1] : !cleared || !flag_{steps});
    leaves_{steps}: cover (cleared && flag_{steps} && !x);
  end
end
endmodule
