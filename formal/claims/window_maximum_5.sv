// window_maximum of 5 samples: y[t] is the largest of x[t - 3] .. x[t - 7], for every sequence and every stall.
module window_maximum_5_properties (input clock);
  (* anyseq *) reg advance;
  (* anyseq *) reg [`D-1:0] x;
  wire [`D-1:0] y;
  window_maximum #(.BITS(`D), .SAMPLES(5)) dut (.clock(clock), .advance(advance), .x(x), .y(y));

  (* hierconn *) wire [`D-1:0] \dut.round[0].delayed ;
  (* hierconn *) wire [`D-1:0] \dut.round[0].larger ;
  (* hierconn *) wire [2*`D-1:0] \dut.round[1].delayed ;
  (* hierconn *) wire [`D-1:0] \dut.round[1].larger ;
  (* hierconn *) wire [1*`D-1:0] \dut.round[2].delayed ;

  function [`D-1:0] larger(input [`D-1:0] a, input [`D-1:0] b);
    larger = a > b ? a : b;
  endfunction

  // The last samples; s1 entered in the last step.
  reg [`D-1:0] s1, s2, s3, s4, s5, s6, s7;
  reg [3:0] steps = 0;
  always @(posedge clock)
    if (advance) begin
      {s7, s6, s5, s4, s3, s2, s1} <= {s6, s5, s4, s3, s2, s1, x};
      if (steps != 4'd7)
        steps <= steps + 4'd1;
    end

  wire [`D-1:0] two_1 = larger(s1, s2);
  wire [`D-1:0] two_2 = larger(s2, s3);
  wire [`D-1:0] two_3 = larger(s3, s4);
  wire [`D-1:0] two_4 = larger(s4, s5);
  wire [`D-1:0] two_5 = larger(s5, s6);
  wire [`D-1:0] two_6 = larger(s6, s7);
  wire [`D-1:0] four_1 = larger(two_1, two_3);
  wire [`D-1:0] four_2 = larger(two_2, two_4);
  wire [`D-1:0] four_3 = larger(two_3, two_5);
  wire [`D-1:0] four_4 = larger(two_4, two_6);

  always @(posedge clock) begin
    if (steps >= 4'd1) sample: assert (\dut.round[0].delayed == s1);
    if (steps >= 4'd2) pair_1: assert (\dut.round[0].larger == two_1);
    if (steps >= 4'd3) pair_2: assert (\dut.round[1].delayed [`D-1:0] == two_2);
    if (steps >= 4'd4) pair_3: assert (\dut.round[1].delayed [2*`D-1:`D] == two_3);
    if (steps >= 4'd5) four: assert (\dut.round[1].larger == four_2);
    if (steps >= 4'd6) four_late_1: assert (\dut.round[2].delayed [`D-1:0] == four_3);
    if (steps == 4'd7) begin
      definition: assert (y == larger(larger(larger(larger(s3, s4), s5), s6), s7));
      oldest: cover (y == s7 && y > s3);
    end
  end
endmodule
