// address_counter: the address is inside the frame's width for every sequence of widths, and its past is exact.
module address_counter_properties (input clock);
  (* anyseq *) reg reset, advance;
  (* anyseq *) reg [`W-1:0] width;
  wire [`X-1:0] address, write_address, registered_write_address, recursion_write_address;
  address_counter dut (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .address(address), .write_address(write_address),
    .registered_write_address(registered_write_address), .recursion_write_address(recursion_write_address)
  );

  (* hierconn *) wire [5*`X-1:0] \dut.delayed ;
  (* hierconn *) wire [`W-1:0] \dut.last ;

  reg begun = 0;
  // Equal initial values make the covers quicker to reach.
  reg always_64 = 1, always_widest = 1;
  reg [`X-1:0] before;
  reg advanced, was_reset;
  reg [`W-1:0] width_before, width_two_before;
  // The addresses of the last five steps, the newest lowest.
  reg [5*`X-1:0] history;
  always @(posedge clock) begin
    begun <= 1;
    before <= address;
    advanced <= advance;
    was_reset <= reset;
    width_before <= width;
    width_two_before <= width_before;
    always_64 <= always_64 && width == 11'd64 && advance && reset == !begun;
    always_widest <= always_widest && width == `COLUMNS && advance && reset == !begun;
    if (reset)
      history <= 0;
    else if (advance)
      history <= {history[4*`X-1:0], address};
  end

  always @(posedge clock) begin
    // A possible width, or none and no step until the first one.
    assume ((width == 11'd0 && !advance) || (width >= 11'd64 && width <= `COLUMNS));
    // No step in the two clocks of a new width.
    assume (!advance || (width == width_before && width == width_two_before));
    if (!begun)
      assume (reset);
    else begin
      inside: assert (width_two_before == 11'd0 || {1'b0, address} < width_two_before);
      step_inside: assert (!advance || {1'b0, address} < width);
      last: assert (\dut.last == width_before - 11'd1);
      copies: assert (
        write_address == history[`X-1:0] && registered_write_address == history[`X +: `X] && recursion_write_address == history[4*`X +: `X]
      );
      whole: assert (\dut.delayed == history);
      if (was_reset)
        cleared: assert (address == 10'd0);
      else if (advanced && {1'b0, before} < width_before)
        counts: assert (address == ({1'b0, before} + 11'd1 == width_before ? 10'd0 : before + 10'd1));
      else if (!advanced && (width_two_before == 11'd0 || {1'b0, before} < width_two_before))
        waits: assert (address == before);
      else
        narrowed: assert (address == 10'd0);
      narrower: cover (always_widest && width == 11'd64 && address == 10'd65);
      returns: cover (always_64 && before == 10'd63 && address == 10'd0);
    end
  end
endmodule
