// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The feature extractor: Avalon-ST video in, Avalon-ST feature records out, Avalon-MM registers, an interrupt.
//   registers   what software sees; a frame takes a committed set over as it begins
//   core        everything between the two streams
// One clock, one pixel a clock. A step is a clock with `advance` in the core: one pixel, or none while the pipeline drains.
// Latency: 81 lines and some 175 steps from a pixel to its record; a register is read one cycle later.
module hoverlock_top (
  input  wire clock,
  input  wire reset,
  output wire video_ready,
  input  wire video_valid,
  input  wire [15:0] video_data,
  input  wire video_startofpacket,
  input  wire video_endofpacket,
  input  wire feature_ready,
  output wire feature_valid,
  output wire [255:0] feature_data,
  output wire feature_startofpacket,
  output wire feature_endofpacket,
  input  wire [5:0] csr_address,
  input  wire csr_read,
  output wire [31:0] csr_readdata,
  input  wire csr_write,
  input  wire [31:0] csr_writedata,
  output wire irq
);

wire [31:0] registers_readdata;
wire registers_irq;
wire registers_clear;
wire registers_enable;
wire [10:0] registers_width;
wire [11:0] registers_height;
wire [367:0] registers_bank;
wire registers_committed;
wire core_video_ready;
wire core_feature_valid;
wire [255:0] core_feature_data;
wire core_feature_startofpacket;
wire core_feature_endofpacket;
wire core_busy;
wire [3:0] core_errors;
wire core_begun;
wire core_done;
wire [19:0] core_count;
wire [19:0] core_dropped;
wire [31:0] core_frames;
wire core_saturated;
wire [14:0] core_threshold_0;
wire [14:0] core_threshold_1;

csr registers (
  .clock(clock),
  .reset(reset),
  .address(csr_address),
  .read(csr_read),
  .readdata(registers_readdata),
  .write(csr_write),
  .writedata(csr_writedata),
  .irq(registers_irq),
  .clear(registers_clear),
  .enable(registers_enable),
  .width(registers_width),
  .height(registers_height),
  .bank(registers_bank),
  .committed(registers_committed),
  .busy(core_busy),
  .errors(core_errors),
  .begun(core_begun),
  .done(core_done),
  .count(core_count),
  .dropped(core_dropped),
  .frames(core_frames),
  .saturated(core_saturated),
  .threshold_0(core_threshold_0),
  .threshold_1(core_threshold_1)
);

hoverlock_core core (
  .clock(clock),
  .reset(registers_clear),
  .enable(registers_enable),
  .new_width(registers_width),
  .new_height(registers_height),
  .bank(registers_bank),
  .committed(registers_committed),
  .video_ready(core_video_ready),
  .video_valid(video_valid),
  .video_data(video_data),
  .video_startofpacket(video_startofpacket),
  .video_endofpacket(video_endofpacket),
  .feature_ready(feature_ready),
  .feature_valid(core_feature_valid),
  .feature_data(core_feature_data),
  .feature_startofpacket(core_feature_startofpacket),
  .feature_endofpacket(core_feature_endofpacket),
  .busy(core_busy),
  .errors(core_errors),
  .begun(core_begun),
  .done(core_done),
  .count(core_count),
  .dropped(core_dropped),
  .frames(core_frames),
  .saturated(core_saturated),
  .threshold_0(core_threshold_0),
  .threshold_1(core_threshold_1)
);

assign csr_readdata = registers_readdata;
assign irq = registers_irq;
assign video_ready = core_video_ready;
assign feature_valid = core_feature_valid;
assign feature_data = core_feature_data;
assign feature_startofpacket = core_feature_startofpacket;
assign feature_endofpacket = core_feature_endofpacket;

endmodule
