// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The registers of registers/REGISTERS.md behind an Avalon-MM slave without wait states. Status bits are set by hardware and cleared by
// writing 1; where both meet the bit stays. A software reset clears the pipeline for one clock and leaves the registers.
// `committed`: the registers are a whole set for the next frame that begins; a write to one of them withdraws it.
// Latency: 1 clock from `read` to `readdata`.
module csr (
  input  wire clock,
  input  wire reset,
  input  wire [5:0] address,
  input  wire read,
  output reg  [31:0] readdata,
  input  wire write,
  input  wire [31:0] writedata,
  output reg  irq,
  output reg  clear,
  output reg  enable,
  output reg  [10:0] width,
  output reg  [11:0] height,
  output reg  [367:0] bank,
  output reg  committed,
  input  wire busy,
  input  wire [3:0] errors,
  input  wire begun,
  input  wire done,
  input  wire [19:0] count,
  input  wire [19:0] dropped,
  input  wire [31:0] frames,
  input  wire saturated,
  input  wire [14:0] threshold_0,
  input  wire [14:0] threshold_1
);

wire [31:0] identification_letters = 32'h484c434b;
wire [31:0] version_number = 32'h20000;
wire [31:0] emission_hash = 32'h302a3a79;
reg  clear_now;
wire control_reset = 1'b0;
reg  control_interrupt_error;
reg  control_interrupt_frame;
reg  control_automatic;
reg  control_enable;
wire status_busy = busy;
reg  status_begun;
reg  status_saturated;
reg  status_dropped;
reg  status_refused;
reg  status_interrupted;
reg  status_long_frame;
reg  status_short_frame;
reg  status_frame;
reg  [11:0] size_height;
reg  [10:0] size_width;
reg  [14:0] threshold_coarse;
reg  [14:0] threshold_fine;
reg  [15:0] target_count;
wire [14:0] threshold_now_coarse = threshold_1;
wire [14:0] threshold_now_fine = threshold_0;
wire [31:0] frames_count = frames;
reg  [19:0] features_count;
reg  [19:0] dropped_count;
reg  commit_pending;
reg  [15:0] narrow_g_code;
reg  [15:0] narrow_g0_code;
reg  [15:0] narrow_g1_code;
reg  [15:0] narrow_g2_code;
reg  [15:0] narrow_g3_code;
reg  [15:0] narrow_g4_code;
reg  [15:0] middle_g_code;
reg  [15:0] middle_g0_code;
reg  [15:0] middle_g1_code;
reg  [15:0] middle_g2_code;
reg  [15:0] middle_g3_code;
reg  [15:0] middle_g4_code;
reg  [15:0] wide_g_code;
reg  [15:0] wide_g0_code;
reg  [15:0] wide_g1_code;
reg  [15:0] wide_g2_code;
reg  [15:0] wide_g3_code;
reg  [15:0] wide_g4_code;
reg  [15:0] wide_g5_code;

// A write to the set leaves it half changed: what was committed is withdrawn.
wire disturbs = write & ((address == 6'd5) | (address == 6'd6) | (address == 6'd7) | ((address >= 6'd16) & (address <= 6'd34)) | ((address == 6'd3) & (writedata[1] ^ control_automatic)));
// The size as the last frame took it.
reg  [10:0] taken_width;
reg  [11:0] taken_height;

always @(posedge clock)
  if (reset) begin
    clear_now <= 1'b1;
    control_interrupt_error <= 1'd0;
    control_interrupt_frame <= 1'd0;
    control_automatic <= 1'd0;
    control_enable <= 1'd0;
    status_begun <= 1'd0;
    status_saturated <= 1'd0;
    status_dropped <= 1'd0;
    status_refused <= 1'd0;
    status_interrupted <= 1'd0;
    status_long_frame <= 1'd0;
    status_short_frame <= 1'd0;
    status_frame <= 1'd0;
    size_height <= 12'd768;
    size_width <= 11'd1024;
    threshold_coarse <= 15'd2048;
    threshold_fine <= 15'd2048;
    target_count <= 16'd512;
    features_count <= 20'd0;
    dropped_count <= 20'd0;
    commit_pending <= 1'd1;
    narrow_g_code <= 16'd24536;
    narrow_g0_code <= 16'd40315;
    narrow_g1_code <= 16'd47101;
    narrow_g2_code <= 16'd56830;
    narrow_g3_code <= 16'd64033;
    narrow_g4_code <= 16'd65500;
    middle_g_code <= 16'd17102;
    middle_g0_code <= 16'd37685;
    middle_g1_code <= 16'd42386;
    middle_g2_code <= 16'd50478;
    middle_g3_code <= 16'd60180;
    middle_g4_code <= 16'd65021;
    wide_g_code <= 16'd11450;
    wide_g0_code <= 16'd35905;
    wide_g1_code <= 16'd38984;
    wide_g2_code <= 16'd44768;
    wide_g3_code <= 16'd53931;
    wide_g4_code <= 16'd62636;
    wide_g5_code <= 16'd65396;
    taken_width <= 11'd0;
    taken_height <= 12'd0;
  end else begin
    clear_now <= write & (address == 6'd3) & writedata[31];
    if (write & (address == 6'd3))
      control_interrupt_error <= writedata[3];
    if (write & (address == 6'd3))
      control_interrupt_frame <= writedata[2];
    if (write & (address == 6'd3))
      control_automatic <= writedata[1];
    if (write & (address == 6'd3))
      control_enable <= writedata[0];
    status_begun <= (status_begun & ~(write & (address == 6'd4) & writedata[7])) | (~clear_now & begun);
    status_saturated <= (status_saturated & ~(write & (address == 6'd4) & writedata[6])) | (~clear_now & saturated);
    status_dropped <= (status_dropped & ~(write & (address == 6'd4) & writedata[5])) | (~clear_now & done & (dropped != 20'd0));
    status_refused <= (status_refused & ~(write & (address == 6'd4) & writedata[4])) | (~clear_now & errors[3]);
    status_interrupted <= (status_interrupted & ~(write & (address == 6'd4) & writedata[3])) | (~clear_now & errors[2]);
    status_long_frame <= (status_long_frame & ~(write & (address == 6'd4) & writedata[2])) | (~clear_now & errors[1]);
    status_short_frame <= (status_short_frame & ~(write & (address == 6'd4) & writedata[1])) | (~clear_now & errors[0]);
    status_frame <= (status_frame & ~(write & (address == 6'd4) & writedata[0])) | (~clear_now & done);
    if (write & (address == 6'd5))
      size_height <= writedata[27:16];
    if (write & (address == 6'd5))
      size_width <= writedata[10:0];
    if (write & (address == 6'd6))
      threshold_coarse <= writedata[30:16];
    if (write & (address == 6'd6))
      threshold_fine <= writedata[14:0];
    if (write & (address == 6'd7))
      target_count <= writedata[15:0];
    if (done & ~clear_now)
      features_count <= count;
    if (done & ~clear_now)
      dropped_count <= dropped;
    commit_pending <= (commit_pending & ~disturbs & ~begun) | (write & (address == 6'd12) & writedata[0]);
    if (write & (address == 6'd16))
      narrow_g_code <= writedata[15:0];
    if (write & (address == 6'd17))
      narrow_g0_code <= writedata[15:0];
    if (write & (address == 6'd18))
      narrow_g1_code <= writedata[15:0];
    if (write & (address == 6'd19))
      narrow_g2_code <= writedata[15:0];
    if (write & (address == 6'd20))
      narrow_g3_code <= writedata[15:0];
    if (write & (address == 6'd21))
      narrow_g4_code <= writedata[15:0];
    if (write & (address == 6'd22))
      middle_g_code <= writedata[15:0];
    if (write & (address == 6'd23))
      middle_g0_code <= writedata[15:0];
    if (write & (address == 6'd24))
      middle_g1_code <= writedata[15:0];
    if (write & (address == 6'd25))
      middle_g2_code <= writedata[15:0];
    if (write & (address == 6'd26))
      middle_g3_code <= writedata[15:0];
    if (write & (address == 6'd27))
      middle_g4_code <= writedata[15:0];
    if (write & (address == 6'd28))
      wide_g_code <= writedata[15:0];
    if (write & (address == 6'd29))
      wide_g0_code <= writedata[15:0];
    if (write & (address == 6'd30))
      wide_g1_code <= writedata[15:0];
    if (write & (address == 6'd31))
      wide_g2_code <= writedata[15:0];
    if (write & (address == 6'd32))
      wide_g3_code <= writedata[15:0];
    if (write & (address == 6'd33))
      wide_g4_code <= writedata[15:0];
    if (write & (address == 6'd34))
      wide_g5_code <= writedata[15:0];
    if (begun & commit_pending) begin
      taken_width <= size_width;
      taken_height <= size_height;
    end
  end

always @(posedge clock)
  if (read)
    case (address)
      6'd0: readdata <= {identification_letters};
      6'd1: readdata <= {version_number};
      6'd2: readdata <= {emission_hash};
      6'd3: readdata <= {control_reset, 27'd0, control_interrupt_error, control_interrupt_frame, control_automatic, control_enable};
      6'd4: readdata <= {status_busy, 23'd0, status_begun, status_saturated, status_dropped, status_refused, status_interrupted, status_long_frame, status_short_frame, status_frame};
      6'd5: readdata <= {4'd0, size_height, 5'd0, size_width};
      6'd6: readdata <= {1'd0, threshold_coarse, 1'd0, threshold_fine};
      6'd7: readdata <= {16'd0, target_count};
      6'd8: readdata <= {1'd0, threshold_now_coarse, 1'd0, threshold_now_fine};
      6'd9: readdata <= {frames_count};
      6'd10: readdata <= {12'd0, features_count};
      6'd11: readdata <= {12'd0, dropped_count};
      6'd12: readdata <= {31'd0, commit_pending};
      6'd16: readdata <= {16'd0, narrow_g_code};
      6'd17: readdata <= {16'd0, narrow_g0_code};
      6'd18: readdata <= {16'd0, narrow_g1_code};
      6'd19: readdata <= {16'd0, narrow_g2_code};
      6'd20: readdata <= {16'd0, narrow_g3_code};
      6'd21: readdata <= {16'd0, narrow_g4_code};
      6'd22: readdata <= {16'd0, middle_g_code};
      6'd23: readdata <= {16'd0, middle_g0_code};
      6'd24: readdata <= {16'd0, middle_g1_code};
      6'd25: readdata <= {16'd0, middle_g2_code};
      6'd26: readdata <= {16'd0, middle_g3_code};
      6'd27: readdata <= {16'd0, middle_g4_code};
      6'd28: readdata <= {16'd0, wide_g_code};
      6'd29: readdata <= {16'd0, wide_g0_code};
      6'd30: readdata <= {16'd0, wide_g1_code};
      6'd31: readdata <= {16'd0, wide_g2_code};
      6'd32: readdata <= {16'd0, wide_g3_code};
      6'd33: readdata <= {16'd0, wide_g4_code};
      6'd34: readdata <= {16'd0, wide_g5_code};
      default: readdata <= 32'd0;
    endcase

always @(*) begin
  irq = (control_interrupt_frame & status_frame)
      | (control_interrupt_error & (status_short_frame | status_long_frame | status_interrupted | status_refused
                                          | status_dropped | status_saturated));
  clear  = clear_now;
  enable = control_enable;
  committed = commit_pending;
  width  = commit_pending ? size_width : taken_width;
  height = commit_pending ? size_height : taken_height;
  bank   = {15'd0, control_automatic, target_count, 1'b0, threshold_coarse, 1'b0, threshold_fine,
            wide_g5_code,
            wide_g4_code,
            wide_g3_code,
            wide_g2_code,
            wide_g1_code,
            wide_g0_code,
            wide_g_code,
            middle_g4_code,
            middle_g3_code,
            middle_g2_code,
            middle_g1_code,
            middle_g0_code,
            middle_g_code,
            narrow_g4_code,
            narrow_g3_code,
            narrow_g2_code,
            narrow_g1_code,
            narrow_g0_code,
            narrow_g_code};
end

endmodule
