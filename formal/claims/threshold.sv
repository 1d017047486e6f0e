// threshold: equality with its equation in integers, for every count, target and threshold.
module threshold_properties (input clock);
  (* anyseq *) reg reset, advance, start, hit, follow;
  (* anyseq *) reg [`D-1:0] manual;
  (* anyseq *) reg [15:0] target;
  wire [`D-1:0] threshold;
  wire [19:0] count;
  threshold dut (
    .clock(clock), .reset(reset), .advance(advance), .start(start), .hit(hit), .follow(follow), .manual(manual),
    .target(target), .threshold(threshold), .count(count)
  );

  (* hierconn *) wire \dut.follows ;
  (* hierconn *) wire \dut.more ;
  (* hierconn *) wire \dut.less ;
  (* hierconn *) wire [`D-3:0] \dut.change ;

  // 4 n, 3 N and 5 N without overflow; T + T / 8 + 1 and T - T / 8 - 1, kept in range.
  wire [23:0] n4 = {2'd0, count, 2'd0};
  wire [23:0] t3 = {8'd0, target} * 24'd3, t5 = {8'd0, target} * 24'd5;
  wire [17:0] up = threshold + (threshold >> 3) + 18'd1;
  wire [17:0] step = (threshold >> 3) + 18'd1;
  wire [`D-1:0] higher = up > {`D{1'b1}} ? {`D{1'b1}} : up[`D-1:0];
  wire [`D-1:0] lower = threshold <= step ? 1 : threshold - step[`D-1:0];
  wire [`D-1:0] by_hand = manual == 0 ? 1 : manual;

  reg begun = 0, automatic_before;
  reg [`D-1:0] threshold_wanted, threshold_before;
  reg [15:0] target_before;
  reg [19:0] count_wanted, count_before;
  reg same_1, same_2;
  always @(posedge clock) begin
    begun <= 1;
    count_before <= count;
    target_before <= target;
    threshold_before <= threshold;
    if (reset) begin
      automatic_before <= 0;
      threshold_wanted <= 0;
      count_wanted <= 20'd0;
    end else if (advance && start) begin
      automatic_before <= follow;
      count_wanted <= 20'd0;
      threshold_wanted <= !(follow && automatic_before) ? by_hand : n4 > t5 ? higher : n4 < t3 ? lower : threshold;
    end else begin
      threshold_wanted <= threshold;
      count_wanted <= advance && hit ? count + 20'd1 : count;
    end
  end

  wire stable = count == count_before && target == target_before && threshold == threshold_before;
  always @(posedge clock) begin
    if (!begun) assume (reset);
    else begin
      // The marker comes when the count is stable.
      if (advance && start) assume (stable);
      mode: assert (\dut.follows == automatic_before);
      ready: assert (\dut.change == {1'b0, threshold_before[`D-1:3]} + 1'b1
        && \dut.more == ({2'd0, count_before, 2'd0} > {8'd0, target_before} * 24'd5)
        && \dut.less == ({2'd0, count_before, 2'd0} < {8'd0, target_before} * 24'd3));
      equation: assert (threshold == threshold_wanted);
      counts: assert (count == count_wanted);
      rises: cover (threshold == 3 && automatic_before);
    end
  end
endmodule
