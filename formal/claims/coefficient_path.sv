// coefficient_path: how the set of a frame and its markers go through `smoothers`. Every part is abstracted. The table
// of parts is written from the description of the pipeline: which marker starts which, and which 16 bits of the bank are whose.
module coefficient_path_properties (input clock);
  (* anyseq *) reg reset, advance, start;
  (* anyseq *) reg [10:0] width;
  (* anyseq *) reg [11:0] height;
  (* anyseq *) reg [15:0] pixel;
  (* anyseq *) reg [383:0] frame_bank;
  wire [383:0] window_bank;
  wire start_out;
  smoothers dut (
    .clock(clock), .reset(reset), .advance(advance), .width(width), .height(height), .start(start), .pixel(pixel),
    .frame_bank(frame_bank), .window_bank(window_bank), .start_out(start_out)
  );

  (* hierconn *) wire \dut.bank_load.x ;
  (* hierconn *) wire \dut.bank_load.y ;
  (* hierconn *) wire \dut.bank_load.advance ;
  (* hierconn *) wire \dut.bank_load.reset ;
  (* hierconn *) wire \dut.rows_load_6.x ;
  (* hierconn *) wire \dut.rows_load_6.y ;
  (* hierconn *) wire \dut.rows_load_6.advance ;
  (* hierconn *) wire \dut.rows_load_6.reset ;
  (* hierconn *) wire \dut.rows_load_5.x ;
  (* hierconn *) wire \dut.rows_load_5.y ;
  (* hierconn *) wire \dut.rows_load_5.advance ;
  (* hierconn *) wire \dut.rows_load_5.reset ;
  (* hierconn *) wire \dut.stage_load_3.x ;
  (* hierconn *) wire \dut.stage_load_3.y ;
  (* hierconn *) wire \dut.stage_load_3.advance ;
  (* hierconn *) wire \dut.stage_load_3.reset ;
  (* hierconn *) wire \dut.stage_load_2.x ;
  (* hierconn *) wire \dut.stage_load_2.y ;
  (* hierconn *) wire \dut.stage_load_2.advance ;
  (* hierconn *) wire \dut.stage_load_2.reset ;
  (* hierconn *) wire \dut.stage_load_1.x ;
  (* hierconn *) wire \dut.stage_load_1.y ;
  (* hierconn *) wire \dut.stage_load_1.advance ;
  (* hierconn *) wire \dut.stage_load_1.reset ;
  (* hierconn *) wire \dut.stage_load_0.x ;
  (* hierconn *) wire \dut.stage_load_0.y ;
  (* hierconn *) wire \dut.stage_load_0.advance ;
  (* hierconn *) wire \dut.stage_load_0.reset ;
  (* hierconn *) wire \dut.recursion_start.x ;
  (* hierconn *) wire \dut.recursion_start.y ;
  (* hierconn *) wire \dut.recursion_start.advance ;
  (* hierconn *) wire \dut.recursion_start.reset ;
  (* hierconn *) wire \dut.recursion_load.x ;
  (* hierconn *) wire \dut.recursion_load.y ;
  (* hierconn *) wire \dut.recursion_load.advance ;
  (* hierconn *) wire \dut.recursion_load.reset ;
  (* hierconn *) wire \dut.columns_done.x ;
  (* hierconn *) wire \dut.columns_done.y ;
  (* hierconn *) wire \dut.columns_done.advance ;
  (* hierconn *) wire \dut.columns_done.reset ;
  (* hierconn *) wire \dut.row_load.x ;
  (* hierconn *) wire \dut.row_load.y ;
  (* hierconn *) wire \dut.row_load.advance ;
  (* hierconn *) wire \dut.row_load.reset ;
  (* hierconn *) wire [10:0] \dut.bank_load.width ;
  (* hierconn *) wire [10:0] \dut.rows_load_5.width ;
  (* hierconn *) wire [10:0] \dut.stage_load_3.width ;
  (* hierconn *) wire [10:0] \dut.stage_load_2.width ;
  (* hierconn *) wire [10:0] \dut.stage_load_1.width ;
  (* hierconn *) wire [10:0] \dut.stage_load_0.width ;
  (* hierconn *) wire \dut.cursor.start ;
  (* hierconn *) wire [10:0] \dut.cursor.width ;
  (* hierconn *) wire [11:0] \dut.cursor.height ;
  (* hierconn *) wire \dut.cursor.advance ;
  (* hierconn *) wire \dut.cursor.reset ;
  (* hierconn *) wire \dut.recursion_cursor.start ;
  (* hierconn *) wire [10:0] \dut.recursion_cursor.width ;
  (* hierconn *) wire [11:0] \dut.recursion_cursor.height ;
  (* hierconn *) wire \dut.recursion_cursor.advance ;
  (* hierconn *) wire \dut.recursion_cursor.reset ;
  (* hierconn *) wire \dut.row_cursor.start ;
  (* hierconn *) wire [10:0] \dut.row_cursor.width ;
  (* hierconn *) wire [11:0] \dut.row_cursor.height ;
  (* hierconn *) wire \dut.row_cursor.advance ;
  (* hierconn *) wire \dut.row_cursor.reset ;
  (* hierconn *) wire \dut.bank.load ;
  (* hierconn *) wire [383:0] \dut.bank.d ;
  (* hierconn *) wire [383:0] \dut.bank.q ;
  (* hierconn *) wire [15:0] \dut.narrow_smoother.g ;
  (* hierconn *) wire [15:0] \dut.narrow_smoother.g_j_0 ;
  (* hierconn *) wire [15:0] \dut.narrow_smoother.g_j_1 ;
  (* hierconn *) wire [15:0] \dut.narrow_smoother.g_j_2 ;
  (* hierconn *) wire [15:0] \dut.narrow_smoother.g_j_3 ;
  (* hierconn *) wire [15:0] \dut.narrow_smoother.g_j_4 ;
  (* hierconn *) wire \dut.narrow_smoother.rows_load ;
  (* hierconn *) wire \dut.narrow_smoother.stage_load_0 ;
  (* hierconn *) wire \dut.narrow_smoother.stage_load_1 ;
  (* hierconn *) wire \dut.narrow_smoother.stage_load_2 ;
  (* hierconn *) wire \dut.narrow_smoother.recursion_load ;
  (* hierconn *) wire \dut.narrow_smoother.row_load ;
  (* hierconn *) wire [15:0] \dut.middle_smoother.g ;
  (* hierconn *) wire [15:0] \dut.middle_smoother.g_j_0 ;
  (* hierconn *) wire [15:0] \dut.middle_smoother.g_j_1 ;
  (* hierconn *) wire [15:0] \dut.middle_smoother.g_j_2 ;
  (* hierconn *) wire [15:0] \dut.middle_smoother.g_j_3 ;
  (* hierconn *) wire [15:0] \dut.middle_smoother.g_j_4 ;
  (* hierconn *) wire \dut.middle_smoother.rows_load ;
  (* hierconn *) wire \dut.middle_smoother.stage_load_0 ;
  (* hierconn *) wire \dut.middle_smoother.stage_load_1 ;
  (* hierconn *) wire \dut.middle_smoother.stage_load_2 ;
  (* hierconn *) wire \dut.middle_smoother.recursion_load ;
  (* hierconn *) wire \dut.middle_smoother.row_load ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g_j_0 ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g_j_1 ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g_j_2 ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g_j_3 ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g_j_4 ;
  (* hierconn *) wire [15:0] \dut.wide_smoother.g_j_5 ;
  (* hierconn *) wire \dut.wide_smoother.rows_load ;
  (* hierconn *) wire \dut.wide_smoother.stage_load_0 ;
  (* hierconn *) wire \dut.wide_smoother.stage_load_1 ;
  (* hierconn *) wire \dut.wide_smoother.stage_load_2 ;
  (* hierconn *) wire \dut.wide_smoother.stage_load_3 ;
  (* hierconn *) wire \dut.wide_smoother.recursion_load ;
  (* hierconn *) wire \dut.wide_smoother.row_load ;
  (* hierconn *) wire \dut.wide_smoother.start_out ;

  always @(posedge clock) begin
    bank_load: assert (\dut.bank_load.x == start && \dut.bank_load.advance == advance
      && \dut.bank_load.reset == reset);
    rows_load_6: assert (\dut.rows_load_6.x == \dut.bank_load.y && \dut.rows_load_6.advance == advance
      && \dut.rows_load_6.reset == reset);
    rows_load_5: assert (\dut.rows_load_5.x == \dut.rows_load_6.y && \dut.rows_load_5.advance == advance
      && \dut.rows_load_5.reset == reset);
    stage_load_3: assert (\dut.stage_load_3.x == \dut.rows_load_6.y && \dut.stage_load_3.advance == advance
      && \dut.stage_load_3.reset == reset);
    stage_load_2: assert (\dut.stage_load_2.x == \dut.stage_load_3.y && \dut.stage_load_2.advance == advance
      && \dut.stage_load_2.reset == reset);
    stage_load_1: assert (\dut.stage_load_1.x == \dut.stage_load_2.y && \dut.stage_load_1.advance == advance
      && \dut.stage_load_1.reset == reset);
    stage_load_0: assert (\dut.stage_load_0.x == \dut.stage_load_1.y && \dut.stage_load_0.advance == advance
      && \dut.stage_load_0.reset == reset);
    recursion_start: assert (\dut.recursion_start.x == \dut.stage_load_0.y
      && \dut.recursion_start.advance == advance && \dut.recursion_start.reset == reset);
    recursion_load: assert (\dut.recursion_load.x == \dut.recursion_start.y
      && \dut.recursion_load.advance == advance && \dut.recursion_load.reset == reset);
    columns_done: assert (\dut.columns_done.x == \dut.recursion_start.y && \dut.columns_done.advance == advance
      && \dut.columns_done.reset == reset);
    row_load: assert (\dut.row_load.x == \dut.columns_done.y && \dut.row_load.advance == advance
      && \dut.row_load.reset == reset);
    bank_load_width: assert (\dut.bank_load.width == width);
    rows_load_5_width: assert (\dut.rows_load_5.width == width);
    stage_load_3_width: assert (\dut.stage_load_3.width == width);
    stage_load_2_width: assert (\dut.stage_load_2.width == width);
    stage_load_1_width: assert (\dut.stage_load_1.width == width);
    stage_load_0_width: assert (\dut.stage_load_0.width == width);
    cursor: assert (\dut.cursor.start == start && \dut.cursor.width == width && \dut.cursor.height == height
      && \dut.cursor.advance == advance && \dut.cursor.reset == reset);
    recursion_cursor: assert (\dut.recursion_cursor.start == \dut.recursion_start.y
      && \dut.recursion_cursor.width == width && \dut.recursion_cursor.height == height
      && \dut.recursion_cursor.advance == advance && \dut.recursion_cursor.reset == reset);
    row_cursor: assert (\dut.row_cursor.start == \dut.columns_done.y && \dut.row_cursor.width == width
      && \dut.row_cursor.height == height
      && \dut.row_cursor.advance == advance && \dut.row_cursor.reset == reset);
    bank: assert (\dut.bank.load == \dut.bank_load.y && \dut.bank.d == frame_bank && window_bank == \dut.bank.q );
    narrow_g: assert (\dut.narrow_smoother.g == \dut.bank.q [15:0]);
    narrow_g_j_0: assert (\dut.narrow_smoother.g_j_0 == \dut.bank.q [31:16]);
    narrow_g_j_1: assert (\dut.narrow_smoother.g_j_1 == \dut.bank.q [47:32]);
    narrow_g_j_2: assert (\dut.narrow_smoother.g_j_2 == \dut.bank.q [63:48]);
    narrow_g_j_3: assert (\dut.narrow_smoother.g_j_3 == \dut.bank.q [79:64]);
    narrow_g_j_4: assert (\dut.narrow_smoother.g_j_4 == \dut.bank.q [95:80]);
    narrow_loads: assert (\dut.narrow_smoother.rows_load == \dut.rows_load_5.y
      && \dut.narrow_smoother.stage_load_0 == \dut.stage_load_0.y
      && \dut.narrow_smoother.stage_load_1 == \dut.stage_load_1.y
      && \dut.narrow_smoother.stage_load_2 == \dut.stage_load_2.y
      && \dut.narrow_smoother.recursion_load == \dut.recursion_load.y
      && \dut.narrow_smoother.row_load == \dut.row_load.y );
    middle_g: assert (\dut.middle_smoother.g == \dut.bank.q [111:96]);
    middle_g_j_0: assert (\dut.middle_smoother.g_j_0 == \dut.bank.q [127:112]);
    middle_g_j_1: assert (\dut.middle_smoother.g_j_1 == \dut.bank.q [143:128]);
    middle_g_j_2: assert (\dut.middle_smoother.g_j_2 == \dut.bank.q [159:144]);
    middle_g_j_3: assert (\dut.middle_smoother.g_j_3 == \dut.bank.q [175:160]);
    middle_g_j_4: assert (\dut.middle_smoother.g_j_4 == \dut.bank.q [191:176]);
    middle_loads: assert (\dut.middle_smoother.rows_load == \dut.rows_load_5.y
      && \dut.middle_smoother.stage_load_0 == \dut.stage_load_0.y
      && \dut.middle_smoother.stage_load_1 == \dut.stage_load_1.y
      && \dut.middle_smoother.stage_load_2 == \dut.stage_load_2.y
      && \dut.middle_smoother.recursion_load == \dut.recursion_load.y
      && \dut.middle_smoother.row_load == \dut.row_load.y );
    wide_g: assert (\dut.wide_smoother.g == \dut.bank.q [207:192]);
    wide_g_j_0: assert (\dut.wide_smoother.g_j_0 == \dut.bank.q [223:208]);
    wide_g_j_1: assert (\dut.wide_smoother.g_j_1 == \dut.bank.q [239:224]);
    wide_g_j_2: assert (\dut.wide_smoother.g_j_2 == \dut.bank.q [255:240]);
    wide_g_j_3: assert (\dut.wide_smoother.g_j_3 == \dut.bank.q [271:256]);
    wide_g_j_4: assert (\dut.wide_smoother.g_j_4 == \dut.bank.q [287:272]);
    wide_g_j_5: assert (\dut.wide_smoother.g_j_5 == \dut.bank.q [303:288]);
    wide_loads: assert (\dut.wide_smoother.rows_load == \dut.rows_load_6.y
      && \dut.wide_smoother.stage_load_0 == \dut.stage_load_0.y
      && \dut.wide_smoother.stage_load_1 == \dut.stage_load_1.y
      && \dut.wide_smoother.stage_load_2 == \dut.stage_load_2.y
      && \dut.wide_smoother.stage_load_3 == \dut.stage_load_3.y
      && \dut.wide_smoother.recursion_load == \dut.recursion_load.y
      && \dut.wide_smoother.row_load == \dut.row_load.y );
    start_out_of_wide: assert (start_out == \dut.wide_smoother.start_out );
    loaded: cover (\dut.bank.load && \dut.wide_smoother.g_j_5 == 16'd5);
  end
endmodule
