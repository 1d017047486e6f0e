// threshold: equality with its law in integers, for every maximum, count, target and threshold. One arbitrary bin is
// followed from its maxima to its clearing, and the sum of all bins as they are read.
module threshold_properties (input clock);
  (* anyseq *) reg reset, advance, enters, start, maximum, hit, follow;
  (* anyseq *) reg [`D-1:0] manual, centre;
  (* anyseq *) reg [15:0] target;
  (* anyconst *) reg [6:0] followed;
  wire [`D-1:0] threshold;
  wire [19:0] count;
  threshold dut (
    .clock(clock), .reset(reset), .advance(advance), .enters(enters), .start(start), .maximum(maximum), .hit(hit),
    .centre(centre), .follow(follow), .manual(manual), .target(target), .threshold(threshold), .count(count)
  );

  (* hierconn *) wire [6:0] \dut.bin ;
  (* hierconn *) wire [6:0] \dut.bin_1 ;
  (* hierconn *) wire [6:0] \dut.bin_2 ;
  (* hierconn *) wire \dut.counting ;
  (* hierconn *) wire \dut.counting_1 ;
  (* hierconn *) wire \dut.counting_2 ;
  (* hierconn *) wire \dut.summing ;
  (* hierconn *) wire \dut.summing_1 ;
  (* hierconn *) wire \dut.summing_2 ;
  (* hierconn *) wire [15:0] \dut.word ;
  (* hierconn *) wire [15:0] \dut.word_1 ;
  (* hierconn *) wire [15:0] \dut.written ;
  (* hierconn *) wire [17:0] \dut.sum ;
  (* hierconn *) wire \dut.reached ;
  (* hierconn *) wire [6:0] \dut.last ;
  (* hierconn *) wire [15:0] \dut.last_count ;
  (* hierconn *) wire [15:0] \dut.surplus ;
  (* hierconn *) wire \dut.follows ;
  (* hierconn *) wire \dut.quarter_1 ;
  (* hierconn *) wire \dut.quarter_2 ;
  (* hierconn *) wire \dut.quarter_3 ;
  (* hierconn *) wire \dut.few ;
  (* hierconn *) wire [18:0] \dut.least ;
  (* hierconn *) wire [19:0] \dut.most ;
  (* hierconn *) wire \dut.met ;
  (* hierconn *) wire [`D-1:0] \dut.wanted ;
  (* hierconn *) wire [`D-1:0] \dut.lowest ;
  (* hierconn *) wire [`D-1:0] \dut.next ;
  (* hierconn *) wire [4:0] \dut.slot ;
  (* hierconn *) wire [63:0] \dut.watched ;
  assign \dut.slot = followed[6:2];

  // Bins of the law: those of the floor to the largest response, counted from the first octave that has any.
  localparam FIRST = `D > 12 ? 8 * (`D - 12) : 0;
  localparam FLOOR = `D > 10 ? 1 << (`D - 10) : 1;
  localparam LOWEST = FLOOR < 8 ? FLOOR : 0;
  localparam HIGHEST = 8 * (`D - 3) + 7 - FIRST;
  localparam BINS = HIGHEST - LOWEST + 1;
  function [31:0] edge_of(input [31:0] bin);
    edge_of = bin < 8 ? bin : (8 + bin % 8) << (bin / 8 - 1);
  endfunction
  wire [31:0] bin = {25'd0, followed} + FIRST;
  wire [31:0] response = {{(32-`D){1'b0}}, centre};
  wire inside = maximum && response >= edge_of(bin) && response < edge_of(bin + 1);

  // Maxima of the followed bin since it was cleared; unknown after a reset.
  reg known = 0;
  reg [15:0] maxima;
  wire [15:0] stored = \dut.watched [16 * followed[1:0] +: 16];
  wire to_come = (\dut.counting && \dut.bin == followed) || (\dut.counting_1 && \dut.bin_1 == followed)
    || (\dut.counting_2 && \dut.bin_2 == followed);

  // Bins that are left to be read; the sum of those read two steps before, in which bin it reached the target first.
  reg [6:0] left = 0, left_1 = 0, left_2 = 0;
  reg [31:0] sum, sum_before, surplus, last_count;
  reg reached, follows;
  reg [6:0] last;
  // From the entry of a frame to its start. Clocks since the sum is complete.
  reg entered = 0;
  reg [2:0] quiet = 0;
  // A maximum one step before, two steps before.
  reg [1:0] maxima_before = 0;

  // The law.
  wire [31:0] n = {12'd0, count}, wide_target = {16'd0, target}, t = {{(32-`D){1'b0}}, threshold};
  wire [31:0] apart = n > wide_target ? n - wide_target : wide_target - n;
  wire [31:0] last_bin = {25'd0, last} + FIRST;
  wire [31:0] quarters = {31'd0, 4 * surplus >= last_count} + {31'd0, 4 * surplus >= 2 * last_count}
    + {31'd0, 4 * surplus >= 3 * last_count};
  wire [31:0] width = edge_of(last_bin + 1) - edge_of(last_bin);
  wire [31:0] part = quarters == 0 ? 0 : quarters == 1 ? width : quarters == 2 ? 2 * width : 3 * width;
  wire [31:0] wanted = reached ? edge_of(last_bin) + part / 4 : FLOOR;
  wire [31:0] lowest = !reached && 8 * sum < wide_target ? t - t / 64 : t / 8;
  wire [31:0] next = 8 * apart <= wide_target ? t : wanted > lowest ? wanted : lowest;

  reg begun = 0;
  reg [`D-1:0] threshold_wanted;
  reg [19:0] count_wanted;
  reg [15:0] target_before;
  always @(posedge clock) begin
    begun <= 1;
    target_before <= target;
    if (reset) begin
      {known, left, left_1, left_2, entered, quiet, maxima_before, follows} <= 0;
      threshold_wanted <= 0;
      count_wanted <= 20'd0;
    end else begin
      if (advance) begin
        maxima_before <= {maxima_before[0], maximum};
        left <= enters ? BINS : left == 0 ? 0 : left - 1;
        left_1 <= left;
        left_2 <= left_1;
        if (\dut.summing_2 && \dut.bin_2 == followed) begin
          known <= 1;
          maxima <= 16'd0;
        end else if (inside && maxima != 16'hffff)
          maxima <= maxima + 16'd1;
        if (enters) begin
          sum <= 0;
          sum_before <= 0;
          reached <= 0;
        end else begin
          if (left_1 != 0) begin
            sum <= sum + {16'd0, \dut.word };
            sum_before <= sum;
          end
          if (left_2 != 0 && !reached && sum >= wide_target) begin
            reached <= 1;
            last <= left_2 - 7'd1 + LOWEST;
            last_count <= sum - sum_before;
            surplus <= sum - wide_target;
          end
        end
      end
      if (advance && enters) entered <= 1;
      else if (advance && start) entered <= 0;
      quiet <= !entered || (advance && start) || left != 0 || left_1 != 0 || left_2 != 0 ? 0 : quiet == 7 ? 7 : quiet + 1;
      if (advance && start) begin
        follows <= follow;
        count_wanted <= 20'd0;
        threshold_wanted <= !(follow && follows) ? (manual == 0 ? 1 : manual) : next[`D-1:0];
      end else begin
        threshold_wanted <= threshold;
        count_wanted <= advance && hit ? count + 20'd1 : count;
      end
    end
  end

  wire idle = left == 0 && left_1 == 0 && left_2 == 0;
  wire reads = left_1 != 0 && \dut.bin_1 == followed;
  wire counts = \dut.counting_1 && \dut.bin_1 == followed;
  always @(posedge clock) begin
    if (!begun) assume (reset);
    else begin
      assume (followed >= LOWEST && followed <= HIGHEST);
      // A maximum has a response of at least 1; two are at least three steps apart.
      if (maximum) assume (centre != 0 && maxima_before == 0);
      // A frame enters three steps or more after the last maximum of the one before; then there is none, and the target
      // stays, until its start.
      if (enters) assume (!entered && !maximum && maxima_before == 0);
      if (entered) assume (!maximum && !hit && target == target_before);
      if (start) assume (!enters && entered && quiet >= 3);

      spaced: assert ({1'b0, \dut.counting } + {1'b0, \dut.counting_1 } + {1'b0, \dut.counting_2 } <= 2'd1
        && maxima_before != 2'd3 && (!\dut.counting || maxima_before[0]) && (!\dut.counting_1 || maxima_before[1]));
      alone: assert (entered ? !\dut.counting && !\dut.counting_1 && !\dut.counting_2 : idle);
      if (left != 0) down: assert (left <= BINS && left_1 == (left == BINS ? 0 : left + 1)
        && left_2 == (left >= BINS - 1 ? 0 : left + 2));
      if (left == 0) ends: assert (left_1 == 0 ? left_2 <= 1 : left_1 == 1 && left_2 == 2);
      each_once: assert (\dut.summing == (left != 0) && \dut.summing_1 == (left_1 != 0)
        && \dut.summing_2 == (left_2 != 0) && (left == 0 || \dut.bin == left - 1 + LOWEST)
        && (left_1 == 0 || \dut.bin_1 == left_1 - 1 + LOWEST) && (left_2 == 0 || \dut.bin_2 == left_2 - 1 + LOWEST));

      if (counts || reads) read: assert (\dut.word == stored);
      if (known) counted: assert (maxima == stored + {15'd0, to_come && stored != 16'hffff});
      if (\dut.counting_2 && \dut.bin_2 == followed) raised: assert (\dut.written == stored + {15'd0, stored != 16'hffff});
      if (left_2 != 0) clears: assert (\dut.written == 16'd0);
      if (known && reads) added: assert (\dut.word == maxima);

      if (left_2 != 0) last_word: assert ({16'd0, \dut.word_1 } == sum - sum_before);
      if (entered && !reached) below: assert (left_2 == 0 ? sum == 0 || sum < wide_target
        : (sum_before == 0 || sum_before < wide_target) && sum >= sum_before && sum - sum_before <= 32'h0000ffff);
      if (left == BINS || left_1 == BINS) first: assert (sum == 0 && sum_before == 0 && !reached);
      if (entered) total: assert (\dut.reached == reached && (reached || {14'd0, \dut.sum } == sum));
      if (entered && reached) bin_of_target: assert (\dut.last == last && {16'd0, \dut.last_count } == last_count
        && {16'd0, \dut.surplus } == surplus && surplus <= last_count && last >= LOWEST && last <= HIGHEST);

      if (entered) limits_of_target: assert ({13'd0, \dut.least } == 7 * wide_target && {12'd0, \dut.most } == 9 * wide_target);
      if (quiet != 0) settled: assert (entered && idle);
      if (quiet >= 1) parts: assert (\dut.few == (!reached && 8 * sum < wide_target)
        && \dut.met == (8 * apart <= wide_target) && (!reached || {1'b0, \dut.quarter_1 } + {1'b0, \dut.quarter_2 }
        + {1'b0, \dut.quarter_3 } == quarters[1:0] && (\dut.quarter_1 || !\dut.quarter_2 )
        && (\dut.quarter_2 || !\dut.quarter_3 )));
      if (quiet >= 2) limits: assert (\dut.wanted == wanted && \dut.lowest == lowest);
      if (quiet >= 3) law: assert (\dut.next == next);
      mode: assert (\dut.follows == follows);
      equation: assert (threshold == threshold_wanted);
      features: assert (count == count_wanted);
      target_reached: cover (entered && reached && last == HIGHEST - 1 && quarters == 2 && known);
      not_reached: cover (left == BINS - 5 && !reached && sum > 3);
    end
  end
endmodule
