// eligible: a centre is eligible if its ring lies inside the frame, 18 pixels from each border.
module eligible_properties (input clock);
  (* anyseq *) reg advance, active;
  (* anyseq *) reg [`W-1:0] width;
  (* anyseq *) reg [11:0] height;
  (* anyseq *) reg [`X-1:0] x;
  (* anyseq *) reg [10:0] y;
  wire eligible;
  wire [`X+10:0] position;
  eligible dut (
    .clock(clock), .advance(advance), .width(width), .height(height), .active(active), .x(x), .y(y),
    .eligible(eligible), .position(position)
  );

  (* hierconn *) wire [`W-1:0] \dut.end_x ;
  (* hierconn *) wire [11:0] \dut.end_y ;

  reg begun = 0, stepped = 0;
  reg [`W-1:0] width_before;
  reg [11:0] height_before;
  reg [`X+10:0] last_position;
  always @(posedge clock) begin
    begun <= 1;
    width_before <= width;
    height_before <= height;
    if (advance) begin
      stepped <= 1;
      last_position <= {y, x};
    end
  end

  wire inside = x >= 10'd18 && {2'd0, x} + 12'd18 < {1'b0, width_before} && y >= 11'd18
    && {2'd0, y} + 13'd18 < {1'b0, height_before};
  always @(posedge clock) begin
    // A possible size, or none and no frame until the clock after the first one.
    assume ((width == 11'd0 && height == 12'd0 && !active)
      || (width >= 11'd64 && width <= `COLUMNS && height >= 12'd64 && height <= 12'd2048));
    // Before the first clock the registers have any value, and no frame is in progress.
    if (!begun) assume (!active);
    else begin
      possible: assert ((width_before == 11'd0 && height_before == 12'd0)
        || (width_before >= 11'd64 && width_before <= `COLUMNS && height_before >= 12'd64 && height_before <= 12'd2048));
      if (width_before == 11'd0) assume (!active);
      ends: assert (\dut.end_x == width_before - 11'd18 && \dut.end_y == height_before - 12'd18);
      ring_inside: assert (eligible == (active && inside));
      last_step: assert (!stepped || position == last_position);
      found: cover (eligible && x == 10'd18);
      beyond: cover (active && !eligible && y == 11'd30 && x == 10'd46);
    end
  end
endmodule
