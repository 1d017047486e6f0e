// line_delay_18x32: the value read at an address is the one written there 32 visits before. With the address counter,
// which counts modulo the width, these are 32 lines.
module line_delay_18x32_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [9:0] address;
  (* anyseq *) reg [17:0] x;
  (* anyconst *) reg [9:0] column;
  wire [17:0] y;
  // A column is written one step after it was read.
  reg [9:0] write_address;
  line_delay_18x32 dut (
    .clock(clock), .advance(advance), .address(address), .write_address(write_address), .x(x), .y(y)
  );

  (* hierconn *) wire [575:0] \dut.column ;
  (* hierconn *) wire [9:0] \dut.watched_address ;
  (* hierconn *) wire [575:0] \dut.watched ;
  assign \dut.watched_address = column;

  // The samples written at the column, the newest lowest, and how many there were.
  reg [575:0] written;
  reg [5:0] visits = 6'd0;
  // The column register holds the column's word.
  reg at_hand = 0;
  reg begun = 0;
  always @(posedge clock)
    if (advance) begin
      begun <= 1;
      write_address <= address;
      at_hand <= address == column;
      if (begun && write_address == column) begin
        written <= {written[557:0], x};
        if (visits != 6'd32) visits <= visits + 6'd1;
      end
    end

  // Only the samples of the last visits: the initial contents of the memory are free.
  wire [575:0] known = ~({576{1'b1}} << (visits * 10'd18));
  always @(posedge clock) begin
    // The width is at least two columns.
    if (advance && begun) assume (address != write_address);
    kept: assert (((\dut.watched ^ written) & known) == 576'd0);
    read: assert (!(begun && at_hand) || ((\dut.column ^ written) & known) == 576'd0);
    agrees: assert (!begun || at_hand == (write_address == column));
    counts: assert (visits <= 6'd32 && (begun || visits == 6'd0));
    delayed: assert (!(begun && at_hand && visits == 6'd32) || y == written[575:558]);
    twice: cover (visits == 6'd2 && at_hand && y == 18'd5);
  end
endmodule
