// tail_counter: the lines after the last row of a frame, counted by definition, and the rows that each look-ahead and each
// stage uses outside the frame.
module tail_counter_properties (input clock);
  (* anyseq *) reg reset, advance, start;
  (* anyseq *) reg [`W-1:0] width;
  wire [`OUTSIDES-1:0] outside;
  tail_counter dut (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .start(start), .outside(outside)
  );
  (* hierconn *) wire [`X-1:0] \dut.x ;
  (* hierconn *) wire [5:0] \dut.line ;
  (* hierconn *) wire \dut.active ;

  // Column and line after the marker, counted from line 1; inside for 63 lines.
  reg begun = 0, inside = 0, was_reset;
  reg [`W-1:0] column, width_before;
  reg [6:0] line;
  wire line_ends = column == width - 11'd1;
  always @(posedge clock) begin
    begun <= 1;
    was_reset <= reset;
    width_before <= width;
    if (reset)
      inside <= 0;
    else if (advance) begin
      if (start) begin
        inside <= 1;
        column <= 11'd0;
        line <= 7'd1;
      end else if (inside) begin
        column <= line_ends ? 11'd0 : column + 11'd1;
        line <= line_ends ? line + 7'd1 : line;
        inside <= !(line_ends && line == 7'd63);
      end
    end
  end

  // For each look-ahead m of a smoother the three rows of its two longest stages, then the arriving row of each other stage.
  localparam LAST = 1 << `LONGEST;
  reg [`OUTSIDES-1:0] wanted;
  integer m, j, at;
  always @(*) begin
    wanted = 0;
    at = 0;
    for (m = 2; m <= `LONGEST; m = m + 1)
      if (`LOOK_AHEADS & (1 << m)) begin
        wanted[at] = inside && line > LAST - (1 << m) / 2 && line <= LAST - (1 << m) / 4;
        wanted[at + 1] = inside && line > LAST - (1 << m) * 3 / 4 && line <= LAST - (1 << m) / 4;
        wanted[at + 2] = inside && line > LAST - (1 << m) && line <= LAST - (1 << m) / 4;
        at = at + 3;
      end
    for (j = 0; j < `LONGEST - 2; j = j + 1)
      wanted[at + j] = inside && line > LAST - (2 << j) && line <= LAST - (1 << j);
  end

  always @(posedge clock) begin
    // Before the first reset the outputs mean nothing. Later ones come in any state.
    if (!begun) assume (reset && !\dut.active );
    // A possible width, or after a reset none and no step until the first one.
    assume ((begun && width == 11'd0 && !advance) || (width >= 11'd64 && width <= `COLUMNS));
    if (begun) begin
      if (inside) assume (width == width_before);
      active_in_tail: assert (\dut.active == inside);
      position: assert (!inside || ({1'b0, \dut.x } == column && {1'b0, \dut.line } == line && column < width
        && line >= 7'd1 && line <= 7'd63));
      cleared: assert (!was_reset || (\dut.x == 0 && \dut.line == 6'd0));
      outside_rows: assert (outside == wanted);
      second_column: cover (inside && column == 11'd2);
    end
  end
endmodule
