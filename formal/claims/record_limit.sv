// record_limit: equality with its law in integers, for every limit, height, threshold and order of features.
module record_limit_properties (input clock);
  (* anyseq *) reg reset, advance, last_column;
  each pair (* anyseq *) reg hit_{k};
  each pair (* anyseq *) reg [`D-1:0] threshold_{k}, p_{k};
  (* anyseq *) reg [11:0] height;
  (* anyseq *) reg [10:0] y;
  (* anyseq *) reg [15:0] limit;
  each pair wire keep_{k};
  wire [1:0] withheld;
  record_limit dut (
    .clock(clock), .reset(reset), .advance(advance), .height(height), .y(y), .last_column(last_column), .limit(limit),
    each pair .threshold_{k}(threshold_{k}), .hit_{k}(hit_{k}), .p_{k}(p_{k}), .keep_{k}(keep_{k}),
    .withheld(withheld)
  );

  (* hierconn *) wire [16:0] \dut.left ;
  (* hierconn *) wire [9:0] \dut.quota ;
  (* hierconn *) wire [5:0] \dut.rows ;
  (* hierconn *) wire [5:0] \dut.last_row ;
  each pair (* hierconn *) wire [`D-1:0] \dut.gate_{k} ;
  each pair (* hierconn *) wire \dut.reached_{k} , \dut.reached_higher_{k} ;
  (* hierconn *) wire \dut.was_raised ;
  each pair wire reached_{k} = \dut.was_raised ? \dut.reached_higher_{k} : \dut.reached_{k} ;

  // The law, on 32 bits where nothing overflows.
  reg [31:0] left, quota;
  each pair reg [`D-1:0] gate_{k};
  // The response of the step before, which may be a feature unless that step was the last of a row.
  each pair reg [`D-1:0] centre_{k};
  reg within_row;
  reg [5:0] rows;
  reg [11:0] height_before;
  reg [1:0] withheld_wanted;
  // Rows of a band, less one: ceil((H - 36) / 64) - 1.
  wire [12:0] band_rows = ({1'b0, height_before} - 13'd36 + 13'd63) / 13'd64;
  wire loads = last_column && y == 11'd17;
  wire ends = last_column && {7'd0, rows} + 13'd1 == band_rows;
  // Features that reach their gate use the allowance in the order of their pairs.
  wire [2:0] before_0 = 3'd0;
  each pair wire strong_{k} = hit_{k} && centre_{k} >= gate_{k};
  each pair wire [2:0] before_{next} = before_{k} + {2'd0, strong_{k}};
  each pair wire sent_{k} = strong_{k} && left > {29'd0, before_{k}};
  wire [31:0] sum_0 = 32'd0;
  each pair wire [31:0] sum_{next} = sum_{k} + {31'd0, sent_{k}};
  wire [31:0] sent = sum_{pairs};
  wire [1:0] over_0 = 2'd0;
  each pair wire [1:0] over_{next} = over_{k} + {1'b0, hit_{k} && !sent_{k}};
  wire any_0 = 0;
  each pair wire any_{next} = any_{k} || strong_{k} != sent_{k};
  function [`D-1:0] raised(input [`D-1:0] gate);
    reg [31:0] sum;
    begin
      sum = gate + gate / 32'd4 + 32'd1;
      raised = sum > {`D{1'b1}} ? {`D{1'b1}} : sum[`D-1:0];
    end
  endfunction
  function [`D-1:0] lowered(input [`D-1:0] gate, input [`D-1:0] threshold);
    reg [`D-1:0] less;
    begin
      less = gate - gate / 4 - 1;
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
      each pair gate_{k} <= 0;
      withheld_wanted <= 2'd0;
      within_row <= 0;
    end else if (advance) begin
      within_row <= !last_column;
      each pair centre_{k} <= p_{k};
      withheld_wanted <= over_{pairs};
      if (loads) begin
        quota <= {16'd0, limit} / 32'd64;
        left <= {16'd0, limit} - 32'd63 * ({16'd0, limit} / 32'd64);
        rows <= 6'd0;
        each pair gate_{k} <= threshold_{k};
      end else begin
        left <= left - sent + (ends ? quota : 32'd0);
        if (last_column) rows <= ends ? 6'd0 : rows + 6'd1;
        if (ends) begin
          each pair gate_{k} <= lowered(gate_{k}, threshold_{k});
        end else if (any_{pairs}) begin
          each pair gate_{k} <= raised(gate_{k});
        end
      end
    end
  end

  always @(posedge clock) begin
    // A possible height, or none and no step until the clock after the first one.
    assume ((height == 12'd0 && !advance) || (height >= 12'd64 && height <= 12'd2048));
    if (!begun) assume (reset);
    else begin
      possible: assert (height_before == 12'd0 || (height_before >= 12'd64 && height_before <= 12'd2048));
      if (height_before == 12'd0) assume (!advance);
      // A feature has 18 samples of its row before it and after it.
      each pair assume (within_row || !hit_{k});
      each pair compared_{k}: assert (!within_row || reached_{k} == (centre_{k} >= gate_{k}));
      // At most 100 bands of at most 1023 features end before the next frame loads the allowance.
      assume (left <= 32'd120000);
      band: assert (height_before == 12'd0 || {7'd0, \dut.last_row } + 13'd1 == band_rows);
      state: assert (\dut.left == left[16:0] && \dut.quota == quota[9:0] && \dut.rows == rows && quota <= 32'd1023);
      each pair gate_{k}_of_law: assert (\dut.gate_{k} == gate_{k});
      each pair passed_on_{k}: assert (keep_{k} == sent_{k});
      counted: assert (withheld == withheld_wanted);
      one_left: cover (keep_0 && hit_1 && !keep_1 && left == 32'd1);
      gated: cover (hit_0 && !keep_0 && left > 32'd1);
      gated_by_the_step_before: cover (hit_1 && \dut.was_raised && \dut.reached_1 && !\dut.reached_higher_1 );
    end
  end
endmodule
