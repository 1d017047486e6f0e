// record_limit: equality with its law in integers, for every limit, height, threshold and order of features.
module record_limit_properties (input clock);
  (* anyseq *) reg reset, advance, last_column, hit_0, hit_1;
  (* anyseq *) reg [11:0] height;
  (* anyseq *) reg [10:0] y;
  (* anyseq *) reg [15:0] limit;
  (* anyseq *) reg [14:0] threshold_0, threshold_1, centre_0, centre_1;
  wire keep_0, keep_1;
  wire [1:0] withheld;
  record_limit dut (
    .clock(clock), .reset(reset), .advance(advance), .height(height), .y(y), .last_column(last_column), .limit(limit),
    .threshold_0(threshold_0), .threshold_1(threshold_1), .hit_0(hit_0), .hit_1(hit_1), .centre_0(centre_0),
    .centre_1(centre_1), .keep_0(keep_0), .keep_1(keep_1), .withheld(withheld)
  );

  (* hierconn *) wire [16:0] \dut.left ;
  (* hierconn *) wire [9:0] \dut.quota ;
  (* hierconn *) wire [5:0] \dut.rows ;
  (* hierconn *) wire [5:0] \dut.last_row ;
  (* hierconn *) wire [14:0] \dut.gate_0 ;
  (* hierconn *) wire [14:0] \dut.gate_1 ;

  // The law, on 32 bits where nothing overflows.
  reg [31:0] left, quota;
  reg [14:0] gate_0, gate_1;
  reg [5:0] rows;
  reg [11:0] height_before;
  reg [1:0] withheld_wanted;
  // Rows of a band, less one: ceil((H - 36) / 64) - 1.
  wire [12:0] band_rows = ({1'b0, height_before} - 13'd36 + 13'd63) / 13'd64;
  wire loads = last_column && y == 11'd17;
  wire ends = last_column && {7'd0, rows} + 13'd1 == band_rows;
  wire strong_0 = hit_0 && centre_0 >= gate_0;
  wire strong_1 = hit_1 && centre_1 >= gate_1;
  wire sent_0 = strong_0 && left >= 32'd1;
  wire sent_1 = strong_1 && left >= (strong_0 ? 32'd2 : 32'd1);
  wire [31:0] sent = {31'd0, sent_0} + {31'd0, sent_1};
  function [14:0] raised(input [14:0] gate);
    reg [31:0] sum;
    begin
      sum = {17'd0, gate} + {17'd0, gate} / 32'd4 + 32'd1;
      raised = sum > 32'd32767 ? 15'd32767 : sum[14:0];
    end
  endfunction
  function [14:0] lowered(input [14:0] gate, input [14:0] threshold);
    reg [14:0] less;
    begin
      less = gate - gate / 15'd4 - 15'd1;
      lowered = less > threshold ? less : threshold;
    end
  endfunction

  reg begun = 0;
  always @(posedge clock) begin
    begun <= 1;
    height_before <= height;
    if (reset) begin
      left <= 32'd0;
      quota <= 32'd0;
      rows <= 6'd0;
      gate_0 <= 15'd0;
      gate_1 <= 15'd0;
      withheld_wanted <= 2'd0;
    end else if (advance) begin
      withheld_wanted <= {1'b0, hit_0 && !sent_0} + {1'b0, hit_1 && !sent_1};
      if (loads) begin
        quota <= {16'd0, limit} / 32'd64;
        left <= {16'd0, limit} - 32'd63 * ({16'd0, limit} / 32'd64);
        rows <= 6'd0;
        gate_0 <= threshold_0;
        gate_1 <= threshold_1;
      end else begin
        left <= left - sent + (ends ? quota : 32'd0);
        if (last_column) rows <= ends ? 6'd0 : rows + 6'd1;
        if (ends) begin
          gate_0 <= lowered(gate_0, threshold_0);
          gate_1 <= lowered(gate_1, threshold_1);
        end else if (strong_0 != sent_0 || strong_1 != sent_1) begin
          gate_0 <= raised(gate_0);
          gate_1 <= raised(gate_1);
        end
      end
    end
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    else begin
      // A frame has 64 to 2048 rows, as many in the clock before.
      assume (height >= 12'd64 && height <= 12'd2048 && height == height_before);
      // At most 100 bands of at most 1023 features end before the next frame loads the allowance.
      assume (left <= 32'd120000);
      band: assert ({7'd0, \dut.last_row } + 13'd1 == band_rows);
      state: assert (\dut.left == left[16:0] && \dut.quota == quota[9:0] && \dut.rows == rows
        && \dut.gate_0 == gate_0 && \dut.gate_1 == gate_1 && quota <= 32'd1023);
      passed_on: assert (keep_0 == sent_0 && keep_1 == sent_1);
      counted: assert (withheld == withheld_wanted);
      one_left: cover (keep_0 && hit_1 && !keep_1 && left == 32'd1);
      gated: cover (hit_0 && !keep_0 && left > 32'd1);
    end
  end
endmodule
