// column_memory: a value read at an address is the one written there as many visits before as its output has lines. With
// the address counter, which counts modulo the width, these are lines.

// One input of the memory: `column` and `watched` are its bits of the column register and of a word. `written` are the
// samples written at that word, the newest lowest. Bit k of `visited` is set once the word was written more than k times;
// the samples of before are the initial contents of the memory, which are free.
module rows_checked #(parameter WIDTH = 18, LINES = 1) (
  input clock, input [LINES-1:0] visited, input at_hand, input write, input [WIDTH-1:0] x,
  input [WIDTH*LINES-1:0] column, input [WIDTH*LINES-1:0] watched, output reg [WIDTH*LINES-1:0] written
);
  always @(posedge clock)
    if (write) written <= {written, x};
  reg [LINES-1:0] is_kept, is_read;
  integer line;
  always @(*)
    for (line = 0; line < LINES; line = line + 1) begin
      is_kept[line] = watched[WIDTH*line +: WIDTH] == written[WIDTH*line +: WIDTH];
      is_read[line] = column[WIDTH*line +: WIDTH] == written[WIDTH*line +: WIDTH];
    end
  always @(posedge clock) begin
    kept: assert ((visited & ~is_kept) == {LINES{1'b0}});
    read: assert (!at_hand || (visited & ~is_read) == {LINES{1'b0}});
  end
endmodule

module column_memory_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [9:0] address;
  (* anyseq *) reg [15:0] pixel;
  (* anyseq *) reg [179:0] x;
  (* anyconst *) reg [9:0] column;
  wire [15:0] tap_0, tap_1, tap_2, tap_3, tap_4;
  wire [17:0] y_0, y_1, y_2, y_3, y_4, y_5, y_6, y_7, y_8, y_9;
  // A column is written one step after it was read.
  reg [9:0] write_address;
  column_memory dut (
    .clock(clock), .advance(advance), .address(address), .write_address(write_address), .pixel(pixel),
    .taps_0(tap_0), .taps_1(tap_1), .taps_2(tap_2), .taps_3(tap_3), .taps_4(tap_4),
    .x_0(x[17:0]), .x_1(x[35:18]), .x_2(x[53:36]), .x_3(x[71:54]), .x_4(x[89:72]),
    .x_5(x[107:90]), .x_6(x[125:108]), .x_7(x[143:126]), .x_8(x[161:144]), .x_9(x[179:162]),
    .y_0(y_0), .y_1(y_1), .y_2(y_2), .y_3(y_3), .y_4(y_4),
    .y_5(y_5), .y_6(y_6), .y_7(y_7), .y_8(y_8), .y_9(y_9)
  );

  (* hierconn *) wire [1417:0] \dut.column ;
  (* hierconn *) wire [9:0] \dut.watched_address ;
  (* hierconn *) wire [1417:0] \dut.watched ;
  assign \dut.watched_address = column;

  // Bit k: the column was visited more than k times.
  reg [55:0] visited = 56'd0;
  // The column register holds the column's word.
  reg at_hand = 0;
  reg begun = 0;
  wire write = advance && begun && write_address == column;
  always @(posedge clock)
    if (advance) begin
      begun <= 1;
      write_address <= address;
      at_hand <= address == column;
      if (write) visited <= {visited, 1'b1};
    end
  always @(posedge clock) begin
    // The width is at least two columns.
    if (advance && begun) assume (address != write_address);
    agrees: assert (!begun || at_hand == (write_address == column));
    unvisited: assert (begun || visited == 56'd0);
    twice: cover (visited[1:0] == 2'b11 && !visited[2] && at_hand && y_1 == 18'd5);
  end
  wire here = begun && at_hand;

  wire [895:0] written_pixel;
  rows_checked #(.WIDTH(16), .LINES(56)) checked_pixel (
    .clock(clock), .visited(visited[55:0]), .at_hand(here), .write(write), .x(pixel),
    .column(\dut.column [895:0]), .watched(\dut.watched [895:0]), .written(written_pixel)
  );
  always @(posedge clock) begin
    delayed_tap_0: assert (!here || !visited[15] || tap_0 == written_pixel[255:240]);
    delayed_tap_1: assert (!here || !visited[31] || tap_1 == written_pixel[511:496]);
    delayed_tap_2: assert (!here || !visited[39] || tap_2 == written_pixel[639:624]);
    delayed_tap_3: assert (!here || !visited[47] || tap_3 == written_pixel[767:752]);
    delayed_tap_4: assert (!here || !visited[55] || tap_4 == written_pixel[895:880]);
  end
  wire [17:0] written_x_0;
  rows_checked #(.WIDTH(18), .LINES(1)) checked_x_0 (
    .clock(clock), .visited(visited[0:0]), .at_hand(here), .write(write), .x(x[17:0]),
    .column(\dut.column [913:896]), .watched(\dut.watched [913:896]), .written(written_x_0)
  );
  always @(posedge clock)
    delayed_y_0: assert (!here || !visited[0] || y_0 == written_x_0[17:0]);
  wire [35:0] written_x_1;
  rows_checked #(.WIDTH(18), .LINES(2)) checked_x_1 (
    .clock(clock), .visited(visited[1:0]), .at_hand(here), .write(write), .x(x[35:18]),
    .column(\dut.column [949:914]), .watched(\dut.watched [949:914]), .written(written_x_1)
  );
  always @(posedge clock)
    delayed_y_1: assert (!here || !visited[1] || y_1 == written_x_1[35:18]);
  wire [71:0] written_x_2;
  rows_checked #(.WIDTH(18), .LINES(4)) checked_x_2 (
    .clock(clock), .visited(visited[3:0]), .at_hand(here), .write(write), .x(x[53:36]),
    .column(\dut.column [1021:950]), .watched(\dut.watched [1021:950]), .written(written_x_2)
  );
  always @(posedge clock)
    delayed_y_2: assert (!here || !visited[3] || y_2 == written_x_2[71:54]);
  wire [17:0] written_x_3;
  rows_checked #(.WIDTH(18), .LINES(1)) checked_x_3 (
    .clock(clock), .visited(visited[0:0]), .at_hand(here), .write(write), .x(x[71:54]),
    .column(\dut.column [1039:1022]), .watched(\dut.watched [1039:1022]), .written(written_x_3)
  );
  always @(posedge clock)
    delayed_y_3: assert (!here || !visited[0] || y_3 == written_x_3[17:0]);
  wire [35:0] written_x_4;
  rows_checked #(.WIDTH(18), .LINES(2)) checked_x_4 (
    .clock(clock), .visited(visited[1:0]), .at_hand(here), .write(write), .x(x[89:72]),
    .column(\dut.column [1075:1040]), .watched(\dut.watched [1075:1040]), .written(written_x_4)
  );
  always @(posedge clock)
    delayed_y_4: assert (!here || !visited[1] || y_4 == written_x_4[35:18]);
  wire [71:0] written_x_5;
  rows_checked #(.WIDTH(18), .LINES(4)) checked_x_5 (
    .clock(clock), .visited(visited[3:0]), .at_hand(here), .write(write), .x(x[107:90]),
    .column(\dut.column [1147:1076]), .watched(\dut.watched [1147:1076]), .written(written_x_5)
  );
  always @(posedge clock)
    delayed_y_5: assert (!here || !visited[3] || y_5 == written_x_5[71:54]);
  wire [17:0] written_x_6;
  rows_checked #(.WIDTH(18), .LINES(1)) checked_x_6 (
    .clock(clock), .visited(visited[0:0]), .at_hand(here), .write(write), .x(x[125:108]),
    .column(\dut.column [1165:1148]), .watched(\dut.watched [1165:1148]), .written(written_x_6)
  );
  always @(posedge clock)
    delayed_y_6: assert (!here || !visited[0] || y_6 == written_x_6[17:0]);
  wire [35:0] written_x_7;
  rows_checked #(.WIDTH(18), .LINES(2)) checked_x_7 (
    .clock(clock), .visited(visited[1:0]), .at_hand(here), .write(write), .x(x[143:126]),
    .column(\dut.column [1201:1166]), .watched(\dut.watched [1201:1166]), .written(written_x_7)
  );
  always @(posedge clock)
    delayed_y_7: assert (!here || !visited[1] || y_7 == written_x_7[35:18]);
  wire [71:0] written_x_8;
  rows_checked #(.WIDTH(18), .LINES(4)) checked_x_8 (
    .clock(clock), .visited(visited[3:0]), .at_hand(here), .write(write), .x(x[161:144]),
    .column(\dut.column [1273:1202]), .watched(\dut.watched [1273:1202]), .written(written_x_8)
  );
  always @(posedge clock)
    delayed_y_8: assert (!here || !visited[3] || y_8 == written_x_8[71:54]);
  wire [143:0] written_x_9;
  rows_checked #(.WIDTH(18), .LINES(8)) checked_x_9 (
    .clock(clock), .visited(visited[7:0]), .at_hand(here), .write(write), .x(x[179:162]),
    .column(\dut.column [1417:1274]), .watched(\dut.watched [1417:1274]), .written(written_x_9)
  );
  always @(posedge clock)
    delayed_y_9: assert (!here || !visited[7] || y_9 == written_x_9[143:126]);
endmodule
