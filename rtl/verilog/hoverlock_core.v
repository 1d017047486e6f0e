// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The extractor between its two streams.
//   sequencer   beats become steps, every frame whole
//   frame_bank  the committed set as the last frame that began took it
//   extractor   pixels become records
//   fifo        512 records wait for the sink
// `advance` is the clock enable of the whole datapath: one step. Every latency below is in steps and lines of W steps.
// Latency: 2 clocks in the sequencer, 81 lines and some 175 steps in the extractor, 3 clocks in the FIFO.
module hoverlock_core (
  input  wire clock,
  input  wire reset,
  input  wire enable,
  input  wire [10:0] new_width,
  input  wire [11:0] new_height,
  input  wire [367:0] bank,
  input  wire committed,
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
  output wire busy,
  output wire [3:0] errors,
  output wire begun,
  output wire done,
  output wire [19:0] count,
  output wire [19:0] dropped,
  output wire [31:0] frames,
  output wire saturated,
  output wire [14:0] threshold_0,
  output wire [14:0] threshold_1
);

wire sequencer_ready;
wire [10:0] sequencer_width;
wire [11:0] sequencer_height;
wire sequencer_capture;
wire sequencer_advance;
wire sequencer_start;
wire [15:0] sequencer_pixel;
wire sequencer_busy;
wire [3:0] sequencer_errors;
wire [3:0] sequencer_frame_errors;
wire [367:0] frame_bank_q;
wire extractor_write;
wire [255:0] extractor_record;
wire extractor_done;
wire [19:0] extractor_count;
wire [19:0] extractor_dropped;
wire [31:0] extractor_frames;
wire extractor_saturated;
wire [14:0] extractor_threshold_0;
wire [14:0] extractor_threshold_1;
wire fifo_room;
wire fifo_stop;
wire fifo_valid;
wire [255:0] fifo_data;
wire fifo_start_of_packet;
wire fifo_end_of_packet;

sequencer sequencer (
  .clock(clock),
  .reset(reset),
  .enable(enable),
  .new_width(new_width),
  .new_height(new_height),
  .committed(committed),
  .stop(fifo_stop),
  .ready(sequencer_ready),
  .valid(video_valid),
  .data(video_data),
  .start_of_packet(video_startofpacket),
  .end_of_packet(video_endofpacket),
  .width(sequencer_width),
  .height(sequencer_height),
  .capture(sequencer_capture),
  .advance(sequencer_advance),
  .start(sequencer_start),
  .pixel(sequencer_pixel),
  .busy(sequencer_busy),
  .errors(sequencer_errors),
  .frame_done(extractor_done),
  .frame_errors(sequencer_frame_errors)
);

bank frame_bank (
  .clock(clock),
  .load(sequencer_capture & committed),
  .d(bank),
  .q(frame_bank_q)
);

extractor extractor (
  .clock(clock),
  .reset(reset),
  .advance(sequencer_advance),
  .width(sequencer_width),
  .height(sequencer_height),
  .start(sequencer_start),
  .pixel(sequencer_pixel),
  .frame_bank(frame_bank_q),
  .errors(sequencer_frame_errors),
  .room(fifo_room),
  .write(extractor_write),
  .record(extractor_record),
  .done(extractor_done),
  .count(extractor_count),
  .dropped(extractor_dropped),
  .frames(extractor_frames),
  .saturated(extractor_saturated),
  .threshold_0(extractor_threshold_0),
  .threshold_1(extractor_threshold_1)
);

record_fifo fifo (
  .clock(clock),
  .reset(reset),
  .write(extractor_write),
  .record(extractor_record),
  .room(fifo_room),
  .stop(fifo_stop),
  .ready(feature_ready),
  .valid(fifo_valid),
  .data(fifo_data),
  .start_of_packet(fifo_start_of_packet),
  .end_of_packet(fifo_end_of_packet)
);

assign video_ready = sequencer_ready;
assign busy = sequencer_busy;
assign begun = sequencer_capture;
assign errors = sequencer_errors;
assign done = extractor_done;
assign count = extractor_count;
assign dropped = extractor_dropped;
assign frames = extractor_frames;
assign saturated = extractor_saturated;
assign threshold_0 = extractor_threshold_0;
assign threshold_1 = extractor_threshold_1;
assign feature_valid = fifo_valid;
assign feature_data = fifo_data;
assign feature_startofpacket = fifo_start_of_packet;
assign feature_endofpacket = fifo_end_of_packet;

endmodule
