// column_maximum: its four outputs equal their definitions, three steps late.
module column_maximum_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [`D-1:0] newest;
  (* anyseq *) reg [6*`R-1:0] older;
  wire [`D-1:0] later, middle, earlier, five;
  column_maximum dut (
    .clock(clock), .advance(advance), .newest(newest), .older(older),
    .later(later), .middle(middle), .earlier(earlier), .five(five)
  );

  (* hierconn *) wire [`D-1:0] \dut.m01 ;
  (* hierconn *) wire [`D-1:0] \dut.v2_1 ;
  (* hierconn *) wire [`D-1:0] \dut.v3_1 ;
  (* hierconn *) wire [`D-1:0] \dut.v4_1 ;
  (* hierconn *) wire [`D-1:0] \dut.m56 ;
  (* hierconn *) wire [`D-1:0] \dut.m34 ;
  (* hierconn *) wire [`D-1:0] \dut.m012 ;
  (* hierconn *) wire [`D-1:0] \dut.v3_2 ;
  (* hierconn *) wire [`D-1:0] \dut.m456 ;
  (* hierconn *) wire [`D-1:0] \dut.m34_2 ;

  function [`D-1:0] larger(input [`D-1:0] a, input [`D-1:0] b);
    larger = a > b ? a : b;
  endfunction

  // Rows 0, the newest, to 6 as they came 1, 2 and 3 steps before.
  wire [7*`D-1:0] rows = {
    older[`R*5 +: `D], older[`R*4 +: `D], older[`R*3 +: `D], older[`R*2 +: `D], older[`R +: `D], older[`D-1:0], newest
  };
  reg [7*`D-1:0] r1, r2, r3;
  reg [2:0] filled = 0;
  always @(posedge clock)
    if (advance) begin
      {r3, r2, r1} <= {r2, r1, rows};
      filled <= {filled[1:0], 1'b1};
    end

  always @(posedge clock) begin
    if (filled[0]) step_1: assert (
      \dut.m01 == larger(r1[`D*0 +: `D], r1[`D*1 +: `D]) && \dut.v2_1 == r1[`D*2 +: `D] && \dut.v3_1 == r1[`D*3 +: `D]
      && \dut.v4_1 == r1[`D*4 +: `D] && \dut.m56 == larger(r1[`D*5 +: `D], r1[`D*6 +: `D]) && \dut.m34 == larger(r1[`D*3 +: `D], r1[`D*4 +: `D])
    );
    if (filled[1]) step_2: assert (
      \dut.m012 == larger(larger(r2[`D*0 +: `D], r2[`D*1 +: `D]), r2[`D*2 +: `D]) && \dut.v3_2 == r2[`D*3 +: `D]
      && \dut.m456 == larger(r2[`D*4 +: `D], larger(r2[`D*5 +: `D], r2[`D*6 +: `D])) && \dut.m34_2 == larger(r2[`D*3 +: `D], r2[`D*4 +: `D])
    );
    if (filled[2]) begin
      newest_three: assert (later == larger(larger(r3[`D*0 +: `D], r3[`D*1 +: `D]), r3[`D*2 +: `D]));
      centre: assert (middle == r3[`D*3 +: `D]);
      oldest_three: assert (earlier == larger(larger(r3[`D*4 +: `D], r3[`D*5 +: `D]), r3[`D*6 +: `D]));
      newest_five: assert (five == larger(larger(larger(r3[`D*0 +: `D], r3[`D*1 +: `D]), r3[`D*2 +: `D]), larger(r3[`D*3 +: `D], r3[`D*4 +: `D])));
      from_row_4: cover (five == r3[`D*4 +: `D] && five > later && five > middle);
    end
  end
endmodule
