// cursor: its position is compared with a raster counted by definition, W x H samples from the marker.
module cursor_properties (input clock);
  (* anyseq *) reg reset, advance, start;
  (* anyseq *) reg [`W-1:0] width;
  (* anyseq *) reg [11:0] height;
  wire active, first_column, last_column, first_row, last_row;
  wire [`X-1:0] x;
  wire [10:0] y;
  cursor dut (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .height(height), .start(start), .active(active),
    .x(x), .y(y), .first_column(first_column), .last_column(last_column), .first_row(first_row), .last_row(last_row)
  );

  reg begun = 0, inside = 0, was_reset;
  reg [`W-1:0] column, width_before;
  reg [11:0] row, height_before;
  wire row_ends = column == width - 11'd1;
  always @(posedge clock) begin
    begun <= 1;
    was_reset <= reset;
    width_before <= width;
    height_before <= height;
    if (reset)
      inside <= 0;
    else if (advance) begin
      if (start) begin
        inside <= 1;
        column <= 11'd0;
        row <= 12'd0;
      end else if (inside) begin
        column <= row_ends ? 11'd0 : column + 11'd1;
        row <= row_ends ? row + 12'd1 : row;
        inside <= !(row_ends && row == height - 12'd1);
      end
    end
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    // A possible size, or after a reset none and no step until the first one.
    assume ((begun && width == 11'd0 && height == 12'd0 && !advance)
      || (width >= 11'd64 && width <= `COLUMNS && height >= 12'd64 && height <= 12'd2048));
    if (begun) begin
      if (inside) assume (width == width_before && height == height_before);
      active_in_frame: assert (active == inside);
      position: assert (!inside || ({1'b0, x} == column && {1'b0, y} == row && column < width && row < height));
      flags: assert (first_column == (inside && column == 11'd0) && last_column == (inside && row_ends)
        && first_row == (inside && row == 12'd0) && last_row == (inside && row == height - 12'd1));
      cleared: assert (!was_reset || (x == 10'd0 && y == 11'd0));
      fifth: cover (inside && column == 11'd5);
    end
  end
endmodule
