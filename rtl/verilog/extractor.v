// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// From pixels to records.
//   lines       steps   from the pixel
//   0               1   into the smoothers
//   63            140   smoothed states
//   63            142   response DOG and its sign, both scale pairs
//   65            150   MaxDOG and sign, into the ring's lines
//   66            152   operands of the decision at the centre of the 7x7 window; candidates wait in the queue
//   81            165   the ring of the candidate is complete, and its record is written
// Latency: 81 lines and some 175 steps from a pixel to the record at `record`.
module extractor (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire [11:0] height,
  input  wire start,
  input  wire [15:0] pixel,
  input  wire [367:0] frame_bank,
  input  wire [3:0] errors,
  input  wire room,
  output wire write,
  output wire [255:0] record,
  output wire done,
  output wire [19:0] count,
  output wire [19:0] dropped,
  output wire [31:0] frames,
  output wire saturated,
  output wire [14:0] threshold_0,
  output wire [14:0] threshold_1
);

wire [15:0] pixels_y;
wire [367:0] smoothers_window_bank;
wire [9:0] smoothers_address;
wire [9:0] smoothers_address_1;
wire [17:0] smoothers_narrow;
wire [17:0] smoothers_middle;
wire [17:0] smoothers_wide;
wire smoothers_start_out;
wire response_start_y;
wire response_cursor_active;
wire [9:0] response_cursor_x;
wire [10:0] response_cursor_y;
wire response_cursor_first_column;
wire response_cursor_last_column;
wire response_cursor_first_row;
wire response_cursor_last_row;
wire [15:0] layer_0_response;
wire layer_0_saturated;
wire [14:0] layer_0_strict;
wire [14:0] layer_0_loose;
wire [15:0] layer_0_p;
wire [15:0] layer_0_centre;
wire [59:0] layer_0_neighbours;
wire [15:0] layer_0_ring;
wire [15:0] layer_1_response;
wire layer_1_saturated;
wire [14:0] layer_1_strict;
wire [14:0] layer_1_loose;
wire [15:0] layer_1_p;
wire [15:0] layer_1_centre;
wire [59:0] layer_1_neighbours;
wire [15:0] layer_1_ring;
wire window_start_y;
wire window_cursor_active;
wire [9:0] window_cursor_x;
wire [10:0] window_cursor_y;
wire window_cursor_first_column;
wire window_cursor_last_column;
wire window_cursor_first_row;
wire window_cursor_last_row;
wire eligible_eligible;
wire [20:0] eligible_place;
wire decision_0_hit;
wire decision_1_hit;
wire [14:0] level_0_threshold;
wire [19:0] level_0_count;
wire [14:0] level_1_threshold;
wire [19:0] level_1_count;
wire [174:0] candidate_word;
wire ring_start_y;
wire ring_cursor_active;
wire [9:0] ring_cursor_x;
wire [10:0] ring_cursor_y;
wire ring_cursor_first_column;
wire ring_cursor_last_column;
wire ring_cursor_first_row;
wire ring_cursor_last_row;
wire queue_found;
wire [174:0] queue_candidate;
wire [14:0] queue_centre_0;
wire [14:0] queue_centre_1;
wire [1:0] queue_dropped;
wire [239:0] ring_lines_0_y;
wire [223:0] ring_lines_1_y;
wire [239:0] ring_rows_1_y;
wire [511:0] ring_taps_0_points;
wire [511:0] ring_taps_1_points;
wire [31:0] ring_0_maxlbp;
wire [31:0] ring_0_sign;
wire [31:0] ring_1_maxlbp;
wire [31:0] ring_1_sign;
wire writer_write;
wire [255:0] writer_record;
wire writer_done;
wire [19:0] writer_count;
wire [19:0] writer_dropped;
wire [31:0] writer_frames;

delay_16x1 pixels (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(pixel),
  .y(pixels_y)
);

smoothers smoothers (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .start(start),
  .pixel(pixels_y),
  .frame_bank(frame_bank),
  .window_bank(smoothers_window_bank),
  .address(smoothers_address),
  .address_1(smoothers_address_1),
  .narrow(smoothers_narrow),
  .middle(smoothers_middle),
  .wide(smoothers_wide),
  .start_out(smoothers_start_out)
);

flag_delay_2 response_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(smoothers_start_out),
  .y(response_start_y)
);

layer layer_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .address(smoothers_address),
  .address_1(smoothers_address_1),
  .narrow(smoothers_narrow),
  .wide(smoothers_middle),
  .response(layer_0_response),
  .saturated(layer_0_saturated),
  .strict(layer_0_strict),
  .loose(layer_0_loose),
  .p(layer_0_p),
  .centre(layer_0_centre),
  .neighbours(layer_0_neighbours),
  .ring(layer_0_ring)
);

layer layer_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .address(smoothers_address),
  .address_1(smoothers_address_1),
  .narrow(smoothers_middle),
  .wide(smoothers_wide),
  .response(layer_1_response),
  .saturated(layer_1_saturated),
  .strict(layer_1_strict),
  .loose(layer_1_loose),
  .p(layer_1_p),
  .centre(layer_1_centre),
  .neighbours(layer_1_neighbours),
  .ring(layer_1_ring)
);

// What is not of a frame may be anything.
cursor response_cursor (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .start(response_start_y),
  .active(response_cursor_active),
  .x(response_cursor_x),
  .y(response_cursor_y),
  .first_column(response_cursor_first_column),
  .last_column(response_cursor_last_column),
  .first_row(response_cursor_first_row),
  .last_row(response_cursor_last_row)
);

assign saturated = (layer_0_saturated | layer_1_saturated) & response_cursor_active;
// The window: what is a feature.
frame_delay_3x10 window_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .x(response_start_y),
  .y(window_start_y)
);

cursor window_cursor (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .start(window_start_y),
  .active(window_cursor_active),
  .x(window_cursor_x),
  .y(window_cursor_y),
  .first_column(window_cursor_first_column),
  .last_column(window_cursor_last_column),
  .first_row(window_cursor_first_row),
  .last_row(window_cursor_last_row)
);

eligible eligible (
  .clock(clock),
  .advance(advance),
  .width(width),
  .height(height),
  .active(window_cursor_active),
  .x(window_cursor_x),
  .y(window_cursor_y),
  .eligible(eligible_eligible),
  .place(eligible_place)
);

decision decision_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .eligible(eligible_eligible),
  .p(layer_0_p[(32'h0)+:(15)]),
  .strict(layer_0_strict),
  .loose(layer_0_loose),
  .threshold(level_0_threshold),
  .hit(decision_0_hit)
);

threshold level_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .start(window_start_y),
  .hit(decision_0_hit),
  .follow(smoothers_window_bank[32'h160]),
  .manual(smoothers_window_bank[(32'h130)+:(15)]),
  .target(smoothers_window_bank[(32'h150)+:(16)]),
  .threshold(level_0_threshold),
  .count(level_0_count)
);

decision decision_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .eligible(eligible_eligible),
  .p(layer_1_p[(32'h0)+:(15)]),
  .strict(layer_1_strict),
  .loose(layer_1_loose),
  .threshold(level_1_threshold),
  .hit(decision_1_hit)
);

threshold level_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .start(window_start_y),
  .hit(decision_1_hit),
  .follow(smoothers_window_bank[32'h160]),
  .manual(smoothers_window_bank[(32'h140)+:(15)]),
  .target(smoothers_window_bank[(32'h150)+:(16)]),
  .threshold(level_1_threshold),
  .count(level_1_count)
);

assign threshold_0 = level_0_threshold;
assign threshold_1 = level_1_threshold;
// A candidate waits until its ring is complete.
candidate_word candidate (
  .place(eligible_place),
  .hit_0(decision_0_hit),
  .hit_1(decision_1_hit),
  .centre_0(layer_0_centre),
  .centre_1(layer_1_centre),
  .neighbours_0(layer_0_neighbours),
  .neighbours_1(layer_1_neighbours),
  .word(candidate_word)
);

frame_delay_15x13 ring_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .x(window_start_y),
  .y(ring_start_y)
);

cursor ring_cursor (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .start(ring_start_y),
  .active(ring_cursor_active),
  .x(ring_cursor_x),
  .y(ring_cursor_y),
  .first_column(ring_cursor_first_column),
  .last_column(ring_cursor_last_column),
  .first_row(ring_cursor_first_row),
  .last_row(ring_cursor_last_row)
);

candidate_queue queue (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .word(candidate_word),
  .active(ring_cursor_active),
  .x(ring_cursor_x),
  .y(ring_cursor_y),
  .found(queue_found),
  .candidate(queue_candidate),
  .centre_0(queue_centre_0),
  .centre_1(queue_centre_1),
  .dropped(queue_dropped)
);

// The ring: what a feature looks like.
line_delay_16x28_taps15 ring_lines_0 (
  .clock(clock),
  .advance(advance),
  .address(smoothers_address),
  .write_address(smoothers_address_1),
  .x(layer_0_ring),
  .y(ring_lines_0_y)
);

line_delay_16x32_taps14 ring_lines_1 (
  .clock(clock),
  .advance(advance),
  .address(smoothers_address),
  .write_address(smoothers_address_1),
  .x(layer_1_ring),
  .y(ring_lines_1_y)
);

ring_rows ring_rows_1 (
  .newest(layer_1_ring),
  .older(ring_lines_1_y),
  .y(ring_rows_1_y)
);

ring_taps_0 ring_taps_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .rows(ring_lines_0_y),
  .points(ring_taps_0_points)
);

ring_taps_1 ring_taps_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .rows(ring_rows_1_y),
  .points(ring_taps_1_points)
);

ring_comparator ring_0 (
  .clock(clock),
  .advance(advance),
  .centre(queue_centre_0),
  .points(ring_taps_0_points),
  .maxlbp(ring_0_maxlbp),
  .sign(ring_0_sign)
);

ring_comparator ring_1 (
  .clock(clock),
  .advance(advance),
  .centre(queue_centre_1),
  .points(ring_taps_1_points),
  .maxlbp(ring_1_maxlbp),
  .sign(ring_1_sign)
);

// Records.
record_writer writer (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .found(queue_found),
  .candidate(queue_candidate),
  .maxlbp_0(ring_0_maxlbp),
  .maxlbp_1(ring_1_maxlbp),
  .sign_0(ring_0_sign),
  .sign_1(ring_1_sign),
  .lost(queue_dropped),
  .frame_end(ring_cursor_last_row & ring_cursor_last_column),
  .errors(errors),
  .take(ring_cursor_first_row & ring_cursor_last_column),
  .threshold_0(level_0_threshold),
  .threshold_1(level_1_threshold),
  .room(room),
  .write(writer_write),
  .record(writer_record),
  .done(writer_done),
  .count(writer_count),
  .dropped(writer_dropped),
  .frames(writer_frames)
);

assign write = writer_write & advance;
assign record = writer_record;
assign done = writer_done & advance;
assign count = writer_count;
assign dropped = writer_dropped;
assign frames = writer_frames;

endmodule
