// column_maximum: its four outputs equal their definitions, three steps late.
module column_maximum_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [14:0] newest;
  (* anyseq *) reg [95:0] older;
  wire [14:0] later, middle, earlier, five;
  column_maximum dut (
    .clock(clock), .advance(advance), .newest(newest), .older(older),
    .later(later), .middle(middle), .earlier(earlier), .five(five)
  );

  (* hierconn *) wire [14:0] \dut.m01 ;
  (* hierconn *) wire [14:0] \dut.v2_1 ;
  (* hierconn *) wire [14:0] \dut.v3_1 ;
  (* hierconn *) wire [14:0] \dut.v4_1 ;
  (* hierconn *) wire [14:0] \dut.m56 ;
  (* hierconn *) wire [14:0] \dut.m34 ;
  (* hierconn *) wire [14:0] \dut.m012 ;
  (* hierconn *) wire [14:0] \dut.v3_2 ;
  (* hierconn *) wire [14:0] \dut.m456 ;
  (* hierconn *) wire [14:0] \dut.m34_2 ;

  function [14:0] larger(input [14:0] a, input [14:0] b);
    larger = a > b ? a : b;
  endfunction

  // Rows 0, the newest, to 6 as they came 1, 2 and 3 steps before.
  wire [104:0] rows = {older[94:80], older[78:64], older[62:48], older[46:32], older[30:16], older[14:0], newest};
  reg [104:0] r1, r2, r3;
  reg [2:0] filled = 0;
  always @(posedge clock)
    if (advance) begin
      {r3, r2, r1} <= {r2, r1, rows};
      filled <= {filled[1:0], 1'b1};
    end

  always @(posedge clock) begin
    if (filled[0]) step_1: assert (
      \dut.m01 == larger(r1[14:0], r1[29:15]) && \dut.v2_1 == r1[44:30] && \dut.v3_1 == r1[59:45]
      && \dut.v4_1 == r1[74:60] && \dut.m56 == larger(r1[89:75], r1[104:90]) && \dut.m34 == larger(r1[59:45], r1[74:60])
    );
    if (filled[1]) step_2: assert (
      \dut.m012 == larger(larger(r2[14:0], r2[29:15]), r2[44:30]) && \dut.v3_2 == r2[59:45]
      && \dut.m456 == larger(r2[74:60], larger(r2[89:75], r2[104:90])) && \dut.m34_2 == larger(r2[59:45], r2[74:60])
    );
    if (filled[2]) begin
      newest_three: assert (later == larger(larger(r3[14:0], r3[29:15]), r3[44:30]));
      centre: assert (middle == r3[59:45]);
      oldest_three: assert (earlier == larger(larger(r3[74:60], r3[89:75]), r3[104:90]));
      newest_five: assert (five == larger(larger(larger(r3[14:0], r3[29:15]), r3[44:30]), larger(r3[59:45], r3[74:60])));
      from_row_4: cover (five == r3[74:60] && five > later && five > middle);
    end
  end
endmodule
