// smoothers: what is connected to what. Every part is abstracted. The list is written from the description of the
// pipeline: which marker starts which, whose 16 bits of the bank are whose, and how far apart the rows of a stage are.
module smoothers_properties (input clock);
  (* anyseq *) reg reset, advance, start;
  (* anyseq *) reg [10:0] width;
  (* anyseq *) reg [11:0] height;
  (* anyseq *) reg [15:0] pixel;
  (* anyseq *) reg [383:0] frame_bank;
  wire [383:0] window_bank;
  wire [9:0] address, address_delayed_1;
  wire [17:0] narrow, middle, wide;
  wire start_out;
  smoothers dut (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .height(height), .start(start), .pixel(pixel),
    .frame_bank(frame_bank), .window_bank(window_bank), .address(address), .address_delayed_1(address_delayed_1),
    .narrow(narrow), .middle(middle), .wide(wide), .start_out(start_out)
  );

  (* hierconn, keep *) wire [383:0] \dut.bank.d ;
  (* hierconn, keep *) wire \dut.bank.load ;
  (* hierconn, keep *) wire [383:0] \dut.bank.q ;
  (* hierconn, keep *) wire \dut.bank_load.advance ;
  (* hierconn, keep *) wire \dut.bank_load.reset ;
  (* hierconn, keep *) wire [10:0] \dut.bank_load.width ;
  (* hierconn, keep *) wire \dut.bank_load.x ;
  (* hierconn, keep *) wire \dut.bank_load.y ;
  (* hierconn, keep *) wire \dut.columns_done.advance ;
  (* hierconn, keep *) wire \dut.columns_done.reset ;
  (* hierconn, keep *) wire \dut.columns_done.x ;
  (* hierconn, keep *) wire \dut.columns_done.y ;
  (* hierconn, keep *) wire [9:0] \dut.counter.address ;
  (* hierconn, keep *) wire \dut.counter.advance ;
  (* hierconn, keep *) wire [9:0] \dut.counter.delayed_1 ;
  (* hierconn, keep *) wire [9:0] \dut.counter.delayed_5 ;
  (* hierconn, keep *) wire \dut.counter.reset ;
  (* hierconn, keep *) wire [10:0] \dut.counter.width ;
  (* hierconn, keep *) wire \dut.cursor.advance ;
  (* hierconn, keep *) wire [11:0] \dut.cursor.height ;
  (* hierconn, keep *) wire \dut.cursor.last_column ;
  (* hierconn, keep *) wire \dut.cursor.last_row ;
  (* hierconn, keep *) wire \dut.cursor.reset ;
  (* hierconn, keep *) wire \dut.cursor.start ;
  (* hierconn, keep *) wire [10:0] \dut.cursor.width ;
  (* hierconn, keep *) wire [9:0] \dut.held.address ;
  (* hierconn, keep *) wire \dut.held.advance ;
  (* hierconn, keep *) wire \dut.held.write ;
  (* hierconn, keep *) wire [9:0] \dut.held.write_address ;
  (* hierconn, keep *) wire [15:0] \dut.held.x ;
  (* hierconn, keep *) wire [15:0] \dut.held.y ;
  (* hierconn, keep *) wire \dut.held_delay_0.advance ;
  (* hierconn, keep *) wire \dut.held_delay_0.reset ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_0.x ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_0.y ;
  (* hierconn, keep *) wire \dut.held_delay_1.advance ;
  (* hierconn, keep *) wire \dut.held_delay_1.reset ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_1.x ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_1.y ;
  (* hierconn, keep *) wire \dut.held_delay_2.advance ;
  (* hierconn, keep *) wire \dut.held_delay_2.reset ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_2.x ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_2.y ;
  (* hierconn, keep *) wire \dut.held_delay_3.advance ;
  (* hierconn, keep *) wire \dut.held_delay_3.reset ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_3.x ;
  (* hierconn, keep *) wire [15:0] \dut.held_delay_3.y ;
  (* hierconn, keep *) wire [15:0] \dut.held_state_0.x ;
  (* hierconn, keep *) wire [17:0] \dut.held_state_0.y ;
  (* hierconn, keep *) wire [15:0] \dut.held_state_1.x ;
  (* hierconn, keep *) wire [17:0] \dut.held_state_1.y ;
  (* hierconn, keep *) wire [15:0] \dut.held_state_2.x ;
  (* hierconn, keep *) wire [17:0] \dut.held_state_2.y ;
  (* hierconn, keep *) wire [15:0] \dut.held_state_3.x ;
  (* hierconn, keep *) wire [17:0] \dut.held_state_3.y ;
  (* hierconn, keep *) wire [9:0] \dut.line_memory.address ;
  (* hierconn, keep *) wire \dut.line_memory.advance ;
  (* hierconn, keep *) wire [15:0] \dut.line_memory.pixel ;
  (* hierconn, keep *) wire [15:0] \dut.line_memory.taps_0 ;
  (* hierconn, keep *) wire [15:0] \dut.line_memory.taps_1 ;
  (* hierconn, keep *) wire [15:0] \dut.line_memory.taps_2 ;
  (* hierconn, keep *) wire [15:0] \dut.line_memory.taps_3 ;
  (* hierconn, keep *) wire [15:0] \dut.line_memory.taps_4 ;
  (* hierconn, keep *) wire [9:0] \dut.line_memory.write_address ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_0 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_1 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_2 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_3 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_4 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_5 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_6 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_7 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_8 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.x_9 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_0 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_1 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_2 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_3 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_4 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_5 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_6 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_7 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_8 ;
  (* hierconn, keep *) wire [17:0] \dut.line_memory.y_9 ;
  (* hierconn, keep *) wire \dut.middle_delay_0.advance ;
  (* hierconn, keep *) wire \dut.middle_delay_0.reset ;
  (* hierconn, keep *) wire [17:0] \dut.middle_delay_0.x ;
  (* hierconn, keep *) wire [17:0] \dut.middle_delay_0.y ;
  (* hierconn, keep *) wire \dut.middle_delay_1.advance ;
  (* hierconn, keep *) wire \dut.middle_delay_1.reset ;
  (* hierconn, keep *) wire [17:0] \dut.middle_delay_1.x ;
  (* hierconn, keep *) wire [17:0] \dut.middle_delay_1.y ;
  (* hierconn, keep *) wire [9:0] \dut.middle_smoother.address ;
  (* hierconn, keep *) wire [9:0] \dut.middle_smoother.address_delayed_5 ;
  (* hierconn, keep *) wire \dut.middle_smoother.advance ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.arriving_0 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.arriving_1 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.arriving_2 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.delayed_0 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.delayed_1 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.delayed_2 ;
  (* hierconn, keep *) wire \dut.middle_smoother.first_column ;
  (* hierconn, keep *) wire \dut.middle_smoother.first_row ;
  (* hierconn, keep *) wire [15:0] \dut.middle_smoother.g ;
  (* hierconn, keep *) wire [15:0] \dut.middle_smoother.g_j_0 ;
  (* hierconn, keep *) wire [15:0] \dut.middle_smoother.g_j_1 ;
  (* hierconn, keep *) wire [15:0] \dut.middle_smoother.g_j_2 ;
  (* hierconn, keep *) wire [15:0] \dut.middle_smoother.g_j_3 ;
  (* hierconn, keep *) wire [15:0] \dut.middle_smoother.g_j_4 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.held_0 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.held_1 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.held_2 ;
  (* hierconn, keep *) wire \dut.middle_smoother.last_column ;
  (* hierconn, keep *) wire \dut.middle_smoother.outside_0 ;
  (* hierconn, keep *) wire \dut.middle_smoother.outside_1 ;
  (* hierconn, keep *) wire \dut.middle_smoother.outside_2 ;
  (* hierconn, keep *) wire \dut.middle_smoother.recursion_load ;
  (* hierconn, keep *) wire \dut.middle_smoother.reset ;
  (* hierconn, keep *) wire \dut.middle_smoother.row_load ;
  (* hierconn, keep *) wire [63:0] \dut.middle_smoother.rows ;
  (* hierconn, keep *) wire \dut.middle_smoother.rows_load ;
  (* hierconn, keep *) wire \dut.middle_smoother.stage_load_0 ;
  (* hierconn, keep *) wire \dut.middle_smoother.stage_load_1 ;
  (* hierconn, keep *) wire \dut.middle_smoother.stage_load_2 ;
  (* hierconn, keep *) wire [17:0] \dut.middle_smoother.y ;
  (* hierconn, keep *) wire \dut.narrow_delay_0.advance ;
  (* hierconn, keep *) wire \dut.narrow_delay_0.reset ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_delay_0.x ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_delay_0.y ;
  (* hierconn, keep *) wire \dut.narrow_delay_1.advance ;
  (* hierconn, keep *) wire \dut.narrow_delay_1.reset ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_delay_1.x ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_delay_1.y ;
  (* hierconn, keep *) wire [9:0] \dut.narrow_smoother.address ;
  (* hierconn, keep *) wire [9:0] \dut.narrow_smoother.address_delayed_5 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.advance ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.arriving_0 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.arriving_1 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.arriving_2 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.delayed_0 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.delayed_1 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.delayed_2 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.first_column ;
  (* hierconn, keep *) wire \dut.narrow_smoother.first_row ;
  (* hierconn, keep *) wire [15:0] \dut.narrow_smoother.g ;
  (* hierconn, keep *) wire [15:0] \dut.narrow_smoother.g_j_0 ;
  (* hierconn, keep *) wire [15:0] \dut.narrow_smoother.g_j_1 ;
  (* hierconn, keep *) wire [15:0] \dut.narrow_smoother.g_j_2 ;
  (* hierconn, keep *) wire [15:0] \dut.narrow_smoother.g_j_3 ;
  (* hierconn, keep *) wire [15:0] \dut.narrow_smoother.g_j_4 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.held_0 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.held_1 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.held_2 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.last_column ;
  (* hierconn, keep *) wire \dut.narrow_smoother.outside_0 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.outside_1 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.outside_2 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.recursion_load ;
  (* hierconn, keep *) wire \dut.narrow_smoother.reset ;
  (* hierconn, keep *) wire \dut.narrow_smoother.row_load ;
  (* hierconn, keep *) wire [63:0] \dut.narrow_smoother.rows ;
  (* hierconn, keep *) wire \dut.narrow_smoother.rows_load ;
  (* hierconn, keep *) wire \dut.narrow_smoother.stage_load_0 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.stage_load_1 ;
  (* hierconn, keep *) wire \dut.narrow_smoother.stage_load_2 ;
  (* hierconn, keep *) wire [17:0] \dut.narrow_smoother.y ;
  (* hierconn, keep *) wire \dut.outside_delay_0.advance ;
  (* hierconn, keep *) wire \dut.outside_delay_0.reset ;
  (* hierconn, keep *) wire \dut.outside_delay_0.x ;
  (* hierconn, keep *) wire \dut.outside_delay_0.y ;
  (* hierconn, keep *) wire \dut.outside_delay_1.advance ;
  (* hierconn, keep *) wire \dut.outside_delay_1.reset ;
  (* hierconn, keep *) wire \dut.outside_delay_1.x ;
  (* hierconn, keep *) wire \dut.outside_delay_1.y ;
  (* hierconn, keep *) wire \dut.outside_delay_2.advance ;
  (* hierconn, keep *) wire \dut.outside_delay_2.reset ;
  (* hierconn, keep *) wire \dut.outside_delay_2.x ;
  (* hierconn, keep *) wire \dut.outside_delay_2.y ;
  (* hierconn, keep *) wire \dut.outside_delay_3.advance ;
  (* hierconn, keep *) wire \dut.outside_delay_3.reset ;
  (* hierconn, keep *) wire \dut.outside_delay_3.x ;
  (* hierconn, keep *) wire \dut.outside_delay_3.y ;
  (* hierconn, keep *) wire \dut.recursion_cursor.advance ;
  (* hierconn, keep *) wire \dut.recursion_cursor.first_row ;
  (* hierconn, keep *) wire [11:0] \dut.recursion_cursor.height ;
  (* hierconn, keep *) wire \dut.recursion_cursor.reset ;
  (* hierconn, keep *) wire \dut.recursion_cursor.start ;
  (* hierconn, keep *) wire [10:0] \dut.recursion_cursor.width ;
  (* hierconn, keep *) wire \dut.recursion_load.advance ;
  (* hierconn, keep *) wire \dut.recursion_load.reset ;
  (* hierconn, keep *) wire \dut.recursion_load.x ;
  (* hierconn, keep *) wire \dut.recursion_load.y ;
  (* hierconn, keep *) wire \dut.recursion_start.advance ;
  (* hierconn, keep *) wire \dut.recursion_start.reset ;
  (* hierconn, keep *) wire \dut.recursion_start.x ;
  (* hierconn, keep *) wire \dut.recursion_start.y ;
  (* hierconn, keep *) wire \dut.row_cursor.advance ;
  (* hierconn, keep *) wire \dut.row_cursor.first_column ;
  (* hierconn, keep *) wire [11:0] \dut.row_cursor.height ;
  (* hierconn, keep *) wire \dut.row_cursor.last_column ;
  (* hierconn, keep *) wire \dut.row_cursor.reset ;
  (* hierconn, keep *) wire \dut.row_cursor.start ;
  (* hierconn, keep *) wire [10:0] \dut.row_cursor.width ;
  (* hierconn, keep *) wire \dut.row_load.advance ;
  (* hierconn, keep *) wire \dut.row_load.reset ;
  (* hierconn, keep *) wire \dut.row_load.x ;
  (* hierconn, keep *) wire \dut.row_load.y ;
  (* hierconn, keep *) wire \dut.rows_5.advance ;
  (* hierconn, keep *) wire [15:0] \dut.rows_5.held ;
  (* hierconn, keep *) wire [2:0] \dut.rows_5.outside ;
  (* hierconn, keep *) wire [15:0] \dut.rows_5.rows_0 ;
  (* hierconn, keep *) wire [15:0] \dut.rows_5.rows_1 ;
  (* hierconn, keep *) wire [15:0] \dut.rows_5.rows_2 ;
  (* hierconn, keep *) wire [15:0] \dut.rows_5.rows_3 ;
  (* hierconn, keep *) wire [63:0] \dut.rows_5.y ;
  (* hierconn, keep *) wire \dut.rows_6.advance ;
  (* hierconn, keep *) wire [15:0] \dut.rows_6.held ;
  (* hierconn, keep *) wire [2:0] \dut.rows_6.outside ;
  (* hierconn, keep *) wire [15:0] \dut.rows_6.rows_0 ;
  (* hierconn, keep *) wire [15:0] \dut.rows_6.rows_1 ;
  (* hierconn, keep *) wire [15:0] \dut.rows_6.rows_2 ;
  (* hierconn, keep *) wire [15:0] \dut.rows_6.rows_3 ;
  (* hierconn, keep *) wire [63:0] \dut.rows_6.y ;
  (* hierconn, keep *) wire \dut.rows_delay_5.advance ;
  (* hierconn, keep *) wire \dut.rows_delay_5.reset ;
  (* hierconn, keep *) wire [63:0] \dut.rows_delay_5.x ;
  (* hierconn, keep *) wire [63:0] \dut.rows_delay_5.y ;
  (* hierconn, keep *) wire \dut.rows_load_5.advance ;
  (* hierconn, keep *) wire \dut.rows_load_5.reset ;
  (* hierconn, keep *) wire [10:0] \dut.rows_load_5.width ;
  (* hierconn, keep *) wire \dut.rows_load_5.x ;
  (* hierconn, keep *) wire \dut.rows_load_5.y ;
  (* hierconn, keep *) wire \dut.rows_load_6.advance ;
  (* hierconn, keep *) wire \dut.rows_load_6.reset ;
  (* hierconn, keep *) wire \dut.rows_load_6.x ;
  (* hierconn, keep *) wire \dut.rows_load_6.y ;
  (* hierconn, keep *) wire \dut.stage_load_0.advance ;
  (* hierconn, keep *) wire \dut.stage_load_0.reset ;
  (* hierconn, keep *) wire [10:0] \dut.stage_load_0.width ;
  (* hierconn, keep *) wire \dut.stage_load_0.x ;
  (* hierconn, keep *) wire \dut.stage_load_0.y ;
  (* hierconn, keep *) wire \dut.stage_load_1.advance ;
  (* hierconn, keep *) wire \dut.stage_load_1.reset ;
  (* hierconn, keep *) wire [10:0] \dut.stage_load_1.width ;
  (* hierconn, keep *) wire \dut.stage_load_1.x ;
  (* hierconn, keep *) wire \dut.stage_load_1.y ;
  (* hierconn, keep *) wire \dut.stage_load_2.advance ;
  (* hierconn, keep *) wire \dut.stage_load_2.reset ;
  (* hierconn, keep *) wire [10:0] \dut.stage_load_2.width ;
  (* hierconn, keep *) wire \dut.stage_load_2.x ;
  (* hierconn, keep *) wire \dut.stage_load_2.y ;
  (* hierconn, keep *) wire \dut.stage_load_3.advance ;
  (* hierconn, keep *) wire \dut.stage_load_3.reset ;
  (* hierconn, keep *) wire [10:0] \dut.stage_load_3.width ;
  (* hierconn, keep *) wire \dut.stage_load_3.x ;
  (* hierconn, keep *) wire \dut.stage_load_3.y ;
  (* hierconn, keep *) wire \dut.tail.advance ;
  (* hierconn, keep *) wire [9:0] \dut.tail.outside ;
  (* hierconn, keep *) wire \dut.tail.reset ;
  (* hierconn, keep *) wire \dut.tail.start ;
  (* hierconn, keep *) wire [10:0] \dut.tail.width ;
  (* hierconn, keep *) wire [9:0] \dut.wide_smoother.address ;
  (* hierconn, keep *) wire [9:0] \dut.wide_smoother.address_delayed_5 ;
  (* hierconn, keep *) wire \dut.wide_smoother.advance ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.arriving_0 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.arriving_1 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.arriving_2 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.arriving_3 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.delayed_0 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.delayed_1 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.delayed_2 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.delayed_3 ;
  (* hierconn, keep *) wire \dut.wide_smoother.first_column ;
  (* hierconn, keep *) wire \dut.wide_smoother.first_row ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g_j_0 ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g_j_1 ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g_j_2 ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g_j_3 ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g_j_4 ;
  (* hierconn, keep *) wire [15:0] \dut.wide_smoother.g_j_5 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.held_0 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.held_1 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.held_2 ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.held_3 ;
  (* hierconn, keep *) wire \dut.wide_smoother.last_column ;
  (* hierconn, keep *) wire \dut.wide_smoother.outside_0 ;
  (* hierconn, keep *) wire \dut.wide_smoother.outside_1 ;
  (* hierconn, keep *) wire \dut.wide_smoother.outside_2 ;
  (* hierconn, keep *) wire \dut.wide_smoother.outside_3 ;
  (* hierconn, keep *) wire \dut.wide_smoother.recursion_load ;
  (* hierconn, keep *) wire \dut.wide_smoother.reset ;
  (* hierconn, keep *) wire \dut.wide_smoother.row_load ;
  (* hierconn, keep *) wire [63:0] \dut.wide_smoother.rows ;
  (* hierconn, keep *) wire \dut.wide_smoother.rows_load ;
  (* hierconn, keep *) wire \dut.wide_smoother.stage_load_0 ;
  (* hierconn, keep *) wire \dut.wide_smoother.stage_load_1 ;
  (* hierconn, keep *) wire \dut.wide_smoother.stage_load_2 ;
  (* hierconn, keep *) wire \dut.wide_smoother.stage_load_3 ;
  (* hierconn, keep *) wire \dut.wide_smoother.start_out ;
  (* hierconn, keep *) wire [17:0] \dut.wide_smoother.y ;

  always @(posedge clock) begin
    markers: assert (\dut.bank_load.x == start && \dut.rows_load_6.x == \dut.bank_load.y
      && \dut.rows_load_5.x == \dut.rows_load_6.y && \dut.stage_load_3.x == \dut.rows_load_6.y
      && \dut.stage_load_2.x == \dut.stage_load_3.y && \dut.stage_load_1.x == \dut.stage_load_2.y
      && \dut.stage_load_0.x == \dut.stage_load_1.y && \dut.recursion_start.x == \dut.stage_load_0.y
      && \dut.recursion_load.x == \dut.recursion_start.y && \dut.columns_done.x == \dut.recursion_start.y
      && \dut.row_load.x == \dut.columns_done.y );
    bank: assert (\dut.bank.load == \dut.bank_load.y && \dut.bank.d == frame_bank && window_bank == \dut.bank.q );
    narrow_coefficients: assert (\dut.narrow_smoother.g == \dut.bank.q [15:0]
      && \dut.narrow_smoother.g_j_0 == \dut.bank.q [31:16] && \dut.narrow_smoother.g_j_1 == \dut.bank.q [47:32]
      && \dut.narrow_smoother.g_j_2 == \dut.bank.q [63:48] && \dut.narrow_smoother.g_j_3 == \dut.bank.q [79:64]
      && \dut.narrow_smoother.g_j_4 == \dut.bank.q [95:80]);
    middle_coefficients: assert (\dut.middle_smoother.g == \dut.bank.q [111:96]
      && \dut.middle_smoother.g_j_0 == \dut.bank.q [127:112] && \dut.middle_smoother.g_j_1 == \dut.bank.q [143:128]
      && \dut.middle_smoother.g_j_2 == \dut.bank.q [159:144] && \dut.middle_smoother.g_j_3 == \dut.bank.q [175:160]
      && \dut.middle_smoother.g_j_4 == \dut.bank.q [191:176]);
    wide_coefficients: assert (\dut.wide_smoother.g == \dut.bank.q [207:192]
      && \dut.wide_smoother.g_j_0 == \dut.bank.q [223:208] && \dut.wide_smoother.g_j_1 == \dut.bank.q [239:224]
      && \dut.wide_smoother.g_j_2 == \dut.bank.q [255:240] && \dut.wide_smoother.g_j_3 == \dut.bank.q [271:256]
      && \dut.wide_smoother.g_j_4 == \dut.bank.q [287:272] && \dut.wide_smoother.g_j_5 == \dut.bank.q [303:288]);
    narrow_loads: assert (\dut.narrow_smoother.rows_load == \dut.rows_load_5.y
      && \dut.narrow_smoother.stage_load_0 == \dut.stage_load_0.y
      && \dut.narrow_smoother.stage_load_1 == \dut.stage_load_1.y
      && \dut.narrow_smoother.stage_load_2 == \dut.stage_load_2.y
      && \dut.narrow_smoother.recursion_load == \dut.recursion_load.y
      && \dut.narrow_smoother.row_load == \dut.row_load.y );
    middle_loads: assert (\dut.middle_smoother.rows_load == \dut.rows_load_5.y
      && \dut.middle_smoother.stage_load_0 == \dut.stage_load_0.y
      && \dut.middle_smoother.stage_load_1 == \dut.stage_load_1.y
      && \dut.middle_smoother.stage_load_2 == \dut.stage_load_2.y
      && \dut.middle_smoother.recursion_load == \dut.recursion_load.y
      && \dut.middle_smoother.row_load == \dut.row_load.y );
    wide_loads: assert (\dut.wide_smoother.rows_load == \dut.rows_load_6.y
      && \dut.wide_smoother.stage_load_0 == \dut.stage_load_0.y
      && \dut.wide_smoother.stage_load_1 == \dut.stage_load_1.y
      && \dut.wide_smoother.stage_load_2 == \dut.stage_load_2.y
      && \dut.wide_smoother.stage_load_3 == \dut.stage_load_3.y
      && \dut.wide_smoother.recursion_load == \dut.recursion_load.y
      && \dut.wide_smoother.row_load == \dut.row_load.y );
    narrow_samples: assert (\dut.narrow_smoother.rows == \dut.rows_delay_5.y
      && \dut.narrow_smoother.delayed_0 == \dut.line_memory.y_0
      && \dut.narrow_smoother.held_0 == \dut.held_state_0.y
      && \dut.narrow_smoother.outside_0 == \dut.outside_delay_0.y
      && \dut.narrow_smoother.delayed_1 == \dut.line_memory.y_1
      && \dut.narrow_smoother.held_1 == \dut.held_state_1.y
      && \dut.narrow_smoother.outside_1 == \dut.outside_delay_1.y
      && \dut.narrow_smoother.delayed_2 == \dut.line_memory.y_2
      && \dut.narrow_smoother.held_2 == \dut.held_state_2.y
      && \dut.narrow_smoother.outside_2 == \dut.outside_delay_2.y
      && \dut.narrow_smoother.first_row == \dut.recursion_cursor.first_row
      && \dut.narrow_smoother.first_column == \dut.row_cursor.first_column
      && \dut.narrow_smoother.last_column == \dut.row_cursor.last_column
      && \dut.narrow_smoother.address == \dut.counter.address
      && \dut.narrow_smoother.address_delayed_5 == \dut.counter.delayed_5 );
    middle_samples: assert (\dut.middle_smoother.rows == \dut.rows_delay_5.y
      && \dut.middle_smoother.delayed_0 == \dut.line_memory.y_3
      && \dut.middle_smoother.held_0 == \dut.held_state_0.y
      && \dut.middle_smoother.outside_0 == \dut.outside_delay_0.y
      && \dut.middle_smoother.delayed_1 == \dut.line_memory.y_4
      && \dut.middle_smoother.held_1 == \dut.held_state_1.y
      && \dut.middle_smoother.outside_1 == \dut.outside_delay_1.y
      && \dut.middle_smoother.delayed_2 == \dut.line_memory.y_5
      && \dut.middle_smoother.held_2 == \dut.held_state_2.y
      && \dut.middle_smoother.outside_2 == \dut.outside_delay_2.y
      && \dut.middle_smoother.first_row == \dut.recursion_cursor.first_row
      && \dut.middle_smoother.first_column == \dut.row_cursor.first_column
      && \dut.middle_smoother.last_column == \dut.row_cursor.last_column
      && \dut.middle_smoother.address == \dut.counter.address
      && \dut.middle_smoother.address_delayed_5 == \dut.counter.delayed_5 );
    wide_samples: assert (\dut.wide_smoother.rows == \dut.rows_6.y
      && \dut.wide_smoother.delayed_0 == \dut.line_memory.y_6  && \dut.wide_smoother.held_0 == \dut.held_state_0.y
      && \dut.wide_smoother.outside_0 == \dut.outside_delay_0.y
      && \dut.wide_smoother.delayed_1 == \dut.line_memory.y_7  && \dut.wide_smoother.held_1 == \dut.held_state_1.y
      && \dut.wide_smoother.outside_1 == \dut.outside_delay_1.y
      && \dut.wide_smoother.delayed_2 == \dut.line_memory.y_8  && \dut.wide_smoother.held_2 == \dut.held_state_2.y
      && \dut.wide_smoother.outside_2 == \dut.outside_delay_2.y
      && \dut.wide_smoother.delayed_3 == \dut.line_memory.y_9  && \dut.wide_smoother.held_3 == \dut.held_state_3.y
      && \dut.wide_smoother.outside_3 == \dut.outside_delay_3.y
      && \dut.wide_smoother.first_row == \dut.recursion_cursor.first_row
      && \dut.wide_smoother.first_column == \dut.row_cursor.first_column
      && \dut.wide_smoother.last_column == \dut.row_cursor.last_column
      && \dut.wide_smoother.address == \dut.counter.address
      && \dut.wide_smoother.address_delayed_5 == \dut.counter.delayed_5 );
    line_memory: assert (\dut.line_memory.pixel == pixel && \dut.line_memory.address == \dut.counter.address
      && \dut.line_memory.write_address == \dut.counter.delayed_1
      && \dut.line_memory.x_0 == \dut.narrow_smoother.arriving_0
      && \dut.line_memory.x_1 == \dut.narrow_smoother.arriving_1
      && \dut.line_memory.x_2 == \dut.narrow_smoother.arriving_2
      && \dut.line_memory.x_3 == \dut.middle_smoother.arriving_0
      && \dut.line_memory.x_4 == \dut.middle_smoother.arriving_1
      && \dut.line_memory.x_5 == \dut.middle_smoother.arriving_2
      && \dut.line_memory.x_6 == \dut.wide_smoother.arriving_0
      && \dut.line_memory.x_7 == \dut.wide_smoother.arriving_1
      && \dut.line_memory.x_8 == \dut.wide_smoother.arriving_2
      && \dut.line_memory.x_9 == \dut.wide_smoother.arriving_3 );
    rows_of_5: assert (\dut.rows_5.rows_0 == \dut.line_memory.taps_4
      && \dut.rows_5.rows_1 == \dut.line_memory.taps_3  && \dut.rows_5.rows_2 == \dut.line_memory.taps_2
      && \dut.rows_5.rows_3 == \dut.line_memory.taps_1  && \dut.rows_5.held == \dut.held.y
      && \dut.rows_5.outside == \dut.tail.outside [2:0] && \dut.rows_delay_5.x == \dut.rows_5.y );
    rows_of_6: assert (\dut.rows_6.rows_0 == \dut.line_memory.taps_3
      && \dut.rows_6.rows_1 == \dut.line_memory.taps_1  && \dut.rows_6.rows_2 == \dut.line_memory.taps_0
      && \dut.rows_6.rows_3 == pixel && \dut.rows_6.held == \dut.held.y
      && \dut.rows_6.outside == \dut.tail.outside [5:3]);
    last_row: assert (\dut.held.x == pixel && \dut.held.write == \dut.cursor.last_row
      && \dut.held.address == \dut.counter.address  && \dut.held.write_address == \dut.counter.delayed_1
      && \dut.held_delay_3.x == \dut.held.y && \dut.held_delay_2.x == \dut.held_delay_3.y
      && \dut.held_delay_1.x == \dut.held_delay_2.y && \dut.held_delay_0.x == \dut.held_delay_1.y
      && \dut.held_state_0.x == \dut.held_delay_0.y && \dut.held_state_1.x == \dut.held_delay_1.y
      && \dut.held_state_2.x == \dut.held_delay_2.y && \dut.held_state_3.x == \dut.held_delay_3.y );
    outside_rows: assert (\dut.outside_delay_0.x == \dut.tail.outside [6]
      && \dut.outside_delay_1.x == \dut.tail.outside [7] && \dut.outside_delay_2.x == \dut.tail.outside [8]
      && \dut.outside_delay_3.x == \dut.tail.outside [9]
      && \dut.tail.start == (\dut.cursor.last_row  & \dut.cursor.last_column ));
    cursors: assert (\dut.cursor.start == start && \dut.recursion_cursor.start == \dut.recursion_start.y
      && \dut.row_cursor.start == \dut.columns_done.y );
    outputs: assert (\dut.narrow_delay_0.x == \dut.narrow_smoother.y
      && \dut.narrow_delay_1.x == \dut.narrow_delay_0.y && narrow == \dut.narrow_delay_1.y
      && \dut.middle_delay_0.x == \dut.middle_smoother.y && \dut.middle_delay_1.x == \dut.middle_delay_0.y
      && middle == \dut.middle_delay_1.y && wide == \dut.wide_smoother.y
      && start_out == \dut.wide_smoother.start_out  && address == \dut.counter.address
      && address_delayed_1 == \dut.counter.delayed_1 );
    widths: assert (\dut.counter.width == width && \dut.cursor.width == width && \dut.tail.width == width
      && \dut.bank_load.width == width && \dut.rows_load_5.width == width && \dut.stage_load_3.width == width
      && \dut.stage_load_2.width == width && \dut.stage_load_1.width == width && \dut.stage_load_0.width == width
      && \dut.recursion_cursor.width == width && \dut.row_cursor.width == width);
    heights: assert (\dut.cursor.height == height && \dut.recursion_cursor.height == height
      && \dut.row_cursor.height == height);
    steps: assert (\dut.counter.advance == advance && \dut.line_memory.advance == advance
      && \dut.narrow_smoother.advance == advance && \dut.middle_smoother.advance == advance
      && \dut.wide_smoother.advance == advance && \dut.cursor.advance == advance && \dut.tail.advance == advance
      && \dut.held.advance == advance && \dut.held_delay_3.advance == advance
      && \dut.outside_delay_3.advance == advance && \dut.held_delay_2.advance == advance
      && \dut.outside_delay_2.advance == advance && \dut.held_delay_1.advance == advance
      && \dut.outside_delay_1.advance == advance && \dut.held_delay_0.advance == advance
      && \dut.outside_delay_0.advance == advance && \dut.bank_load.advance == advance
      && \dut.rows_load_6.advance == advance && \dut.rows_load_5.advance == advance
      && \dut.stage_load_3.advance == advance && \dut.stage_load_2.advance == advance
      && \dut.stage_load_1.advance == advance && \dut.stage_load_0.advance == advance
      && \dut.recursion_start.advance == advance && \dut.recursion_cursor.advance == advance
      && \dut.recursion_load.advance == advance && \dut.columns_done.advance == advance
      && \dut.row_cursor.advance == advance && \dut.row_load.advance == advance && \dut.rows_5.advance == advance
      && \dut.rows_delay_5.advance == advance && \dut.rows_6.advance == advance
      && \dut.narrow_delay_0.advance == advance && \dut.narrow_delay_1.advance == advance
      && \dut.middle_delay_0.advance == advance && \dut.middle_delay_1.advance == advance);
    resets: assert (\dut.counter.reset == reset && \dut.narrow_smoother.reset == reset
      && \dut.middle_smoother.reset == reset && \dut.wide_smoother.reset == reset && \dut.cursor.reset == reset
      && \dut.tail.reset == reset && \dut.held_delay_3.reset == reset && \dut.outside_delay_3.reset == reset
      && \dut.held_delay_2.reset == reset && \dut.outside_delay_2.reset == reset && \dut.held_delay_1.reset == reset
      && \dut.outside_delay_1.reset == reset && \dut.held_delay_0.reset == reset
      && \dut.outside_delay_0.reset == reset && \dut.bank_load.reset == reset && \dut.rows_load_6.reset == reset
      && \dut.rows_load_5.reset == reset && \dut.stage_load_3.reset == reset && \dut.stage_load_2.reset == reset
      && \dut.stage_load_1.reset == reset && \dut.stage_load_0.reset == reset && \dut.recursion_start.reset == reset
      && \dut.recursion_cursor.reset == reset && \dut.recursion_load.reset == reset
      && \dut.columns_done.reset == reset && \dut.row_cursor.reset == reset && \dut.row_load.reset == reset
      && \dut.rows_delay_5.reset == reset && \dut.narrow_delay_0.reset == reset && \dut.narrow_delay_1.reset == reset
      && \dut.middle_delay_0.reset == reset && \dut.middle_delay_1.reset == reset);
    loaded: cover (\dut.bank.load && \dut.wide_smoother.g_j_5 == 16'd5);
  end
endmodule
