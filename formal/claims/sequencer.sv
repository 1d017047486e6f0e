// sequencer: beats to steps. One arbitrary beat is followed through the skid buffer, and the error bits of one arbitrary
// frame to its trailer; the raster, the drain and the outputs are compared with their definitions.
module sequencer_properties (input clock);
  (* anyseq *) reg reset, enable, committed, stall, valid, start_of_packet, end_of_packet, frame_done, choose, choose_frame;
  (* anyseq *) reg [`W-1:0] new_width;
  (* anyseq *) reg [11:0] new_height;
  (* anyseq *) reg [`P-1:0] data;
  wire ready, capture, advance, start, busy;
  wire [`W-1:0] width;
  wire [11:0] height;
  wire [`P-1:0] pixel;
  wire [3:0] errors, frame_errors;
  sequencer dut (
    .clock(clock), .reset(reset), .enable(enable), .new_width(new_width), .new_height(new_height),
    .committed(committed), .stall(stall), .ready(ready), .valid(valid), .data(data),
    .start_of_packet(start_of_packet), .end_of_packet(end_of_packet), .width(width), .height(height),
    .capture(capture), .advance(advance), .start(start), .pixel(pixel), .busy(busy), .errors(errors),
    .frame_done(frame_done), .frame_errors(frame_errors)
  );

  (* hierconn *) wire [1:0] \dut.skid_count ;
  (* hierconn *) wire [`P+1:0] \dut.skid_front ;
  (* hierconn *) wire [`P+1:0] \dut.skid_back ;
  (* hierconn *) wire [1:0] \dut.state ;
  (* hierconn *) wire [1:0] \dut.settle ;
  (* hierconn *) wire [`X-1:0] \dut.x ;
  (* hierconn *) wire [10:0] \dut.y ;
  (* hierconn *) wire [`X-1:0] \dut.last_x ;
  (* hierconn *) wire [10:0] \dut.last_y ;
  (* hierconn *) wire [`W-1:0] \dut.offered_width ;
  (* hierconn *) wire [11:0] \dut.offered_height ;
  (* hierconn *) wire \dut.possible ;
  (* hierconn *) wire \dut.same ;
  (* hierconn *) wire \dut.drained ;
  (* hierconn *) wire [`W+5:0] \dut.drain ;
  (* hierconn *) wire [`W+5:0] \dut.drain_from ;
  (* hierconn *) wire \dut.stray ;
  (* hierconn *) wire \dut.refuse ;
  (* hierconn *) wire \dut.begins ;
  (* hierconn *) wire \dut.takes ;
  (* hierconn *) wire \dut.pads ;
  (* hierconn *) wire \dut.drains ;
  (* hierconn *) wire \dut.keep ;
  (* hierconn *) wire \dut.breaks ;
  (* hierconn *) wire \dut.ignoring ;
  (* hierconn *) wire \dut.committed_delayed ;
  (* hierconn *) wire \dut.done_before ;
  (* hierconn *) wire [2:0] \dut.own ;
  (* hierconn *) wire [11:0] \dut.kept ;
  (* hierconn *) wire [2:0] \dut.frames ;

  localparam IDLE = 2'd0, FRAME = 2'd1, PAD = 2'd2;
  localparam NOT_YET = 2'd0, FRONT = 2'd1, BACK = 2'd2, GONE = 2'd3;
  reg begun = 0;
  reg was_reset;

  // A beat from the port to its use.
  reg [1:0] place = NOT_YET;
  reg [`P+1:0] beat;
  wire used = \dut.stray | \dut.refuse | \dut.begins | \dut.takes ;
  wire pushed = valid & ready;
  // Beats that were taken at the input and not used yet.
  reg [2:0] beats = 3'd0;
  always @(posedge clock)
    beats <= reset ? 3'd0 : beats + {2'd0, pushed} - {2'd0, used};
  always @(posedge clock) begin
    begun <= 1;
    was_reset <= reset;
    if (reset)
      place <= NOT_YET;
    else if (place == NOT_YET && pushed && choose) begin
      place <= \dut.skid_count == 2'd0 || used ? FRONT : BACK;
      beat <= {end_of_packet, start_of_packet, data};
    end else if (used)
      place <= place == BACK ? FRONT : place == FRONT ? GONE : place;
  end

  // 96 lines, in steps.
  wire [`W+6:0] lines_96 = {1'b0, width, 6'd0} + {2'b0, width, 5'd0};

  // The raster of a frame by its definition, and the steps since the last pixel.
  wire with_pixel = \dut.begins | \dut.takes | \dut.pads ;
  reg [`W-1:0] column = 11'd0;
  reg [11:0] row = 12'd0;
  reg inside = 0;
  reg [`W+6:0] since, frames_lines;
  reg ever = 0;
  wire last_column = column == width - 11'd1;
  wire ends = with_pixel & ~\dut.begins & last_column & (row == height - 12'd1);
  always @(posedge clock)
    if (reset) begin
      inside <= 0;
      ever <= 0;
    end else begin
      if (\dut.begins ) begin
        inside <= 1;
        column <= 11'd1;
        row <= 12'd0;
      end else if (with_pixel) begin
        inside <= ~ends;
        column <= last_column ? 11'd0 : column + 11'd1;
        row <= last_column ? row + 12'd1 : row;
      end
      if (with_pixel) begin
        since <= 18'd0;
        frames_lines <= lines_96;
        ever <= 1;
      end else if (\dut.drains )
        since <= since + 18'd1;
    end

  // Errors by their definitions: a packet that ends before its frame is full, one that does not end there, a start of
  // packet inside a frame whose packet has not ended, and a packet that no frame can take.
  wire first_beat = \dut.skid_front [`P];
  wire last_beat = \dut.skid_front [`P+1];
  wire taken = \dut.begins | \dut.takes ;
  wire ends_early = taken & last_beat & ~ends;
  wire ends_late = \dut.takes & ends & ~last_beat;
  wire cut_off = inside & packet_open & \dut.skid_count != 2'd0 & first_beat;
  // The packet of the last beat used has not ended, neither by an end nor by the start of another.
  reg packet_open = 0;
  // Errors of the frame in progress.
  reg [2:0] own;
  wire [2:0] own_now = (\dut.begins ? 3'd0 : own) | {cut_off, ends_late, ends_early};
  always @(posedge clock) begin
    if (reset) packet_open <= 0;
    else if (cut_off) packet_open <= 0;
    else if (used) packet_open <= ~last_beat;
    own <= own_now;
  end

  // The errors of an arbitrary frame, from its end to its trailer: `tags` frames have ended and wait, `tags_ahead` of them
  // before it. A trailer takes the oldest away one clock after `frame_done`.
  reg was_done = 0, followed = 0;
  reg [2:0] tags = 3'd0, tags_ahead, tag;
  wire tag_leaves = was_done & tags != 3'd0;
  wire [2:0] tags_left = tags - {2'd0, tag_leaves};
  always @(posedge clock) begin
    was_done <= frame_done & ~reset;
    if (reset) begin
      tags <= 3'd0;
      followed <= 0;
    end else begin
      tags <= tags_left + {2'd0, ends & tags_left != 3'd4};
      if (!followed && choose_frame && ends && tags_left != 3'd4) begin
        followed <= 1;
        tags_ahead <= tags_left;
        tag <= own_now;
      end else if (followed && tag_leaves) begin
        followed <= tags_ahead != 3'd0;
        tags_ahead <= tags_ahead - 3'd1;
      end
    end
  end
  wire [11:0] from_tag = \dut.kept >> (tags_ahead * 3);

  // Values of the previous clock.
  reg [3:0] was_errors;
  reg was_captured, was_committed;
  reg [`W-1:0] was_new_width;
  reg [11:0] was_new_height;
  wire was_possible = was_new_width >= 11'd64 && was_new_width <= `COLUMNS && was_new_height >= 12'd64
    && was_new_height <= 12'd2048;
  always @(posedge clock) begin
    was_errors <= {enable & (\dut.refuse | (\dut.stray & ~packet_open)), cut_off, ends_late, ends_early};
    was_captured <= capture;
    was_committed <= committed;
    was_new_width <= new_width;
    was_new_height <= new_height;
  end
  reg was_waiting, was_begins, was_step, was_pixel, was_stalled, was_new, was_idle_and_drained, was_ever;
  reg [`P-1:0] was_beat, was_data;
  reg [`W-1:0] was_width, was_width_before;
  reg [11:0] was_height;
  always @(posedge clock) begin
    // A frame in progress has a beat and no stall, and takes no step.
    was_waiting <= inside & (\dut.skid_count != 2'd0 | \dut.state == PAD) & ~stall & ~with_pixel;
    was_begins <= \dut.begins ;
    was_step <= with_pixel | \dut.drains ;
    was_pixel <= with_pixel;
    was_stalled <= stall;
    was_new <= \dut.begins | \dut.takes ;
    was_ever <= ever;
    was_beat <= \dut.skid_front [`P-1:0];
    was_data <= pixel;
    was_idle_and_drained <= \dut.state == IDLE && \dut.drained && !\dut.begins ;
    was_width <= width;
    was_width_before <= was_width;
    was_height <= height;
  end

  // The beat in front begins a frame that may be taken; what happens then depends on size, drain and commit.
  wire may_begin = \dut.state == IDLE && \dut.skid_count != 2'd0 && first_beat && enable && \dut.possible ;
  reg was_resized, was_settling, was_start;
  reg [1:0] was_settle;
  reg [`W-1:0] was_offered_width;
  reg [11:0] was_offered_height;
  always @(posedge clock) begin
    was_resized <= may_begin & ~\dut.same & \dut.drained ;
    was_settling <= may_begin & \dut.same & \dut.settle != 2'd0 & \dut.drained ;
    was_settle <= \dut.settle ;
    was_start <= start;
    was_offered_width <= \dut.offered_width ;
    was_offered_height <= \dut.offered_height ;
  end

  wire sized = width >= 11'd64 && width <= `COLUMNS && height >= 12'd64 && height <= 12'd2048;
  wire settled = \dut.last_x == width[`X-1:0] - 10'd1 && \dut.last_y == height[10:0] - 11'd1 && \dut.drain_from == lines_96[`W+5:0];
  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun) begin
      // Proved of `csr`: the offered size changes only with `committed`.
      assume (reset || (new_width == was_new_width && new_height == was_new_height) || committed != was_committed);
      // Rules for beats.
      count: assert (\dut.skid_count <= 2'd2 && beats == {1'b0, \dut.skid_count });
      takes_beats: assert (ready == (\dut.skid_count != 2'd2));
      takes_when: assert (\dut.takes == (\dut.state == FRAME && \dut.skid_count != 2'd0 && !first_beat && !stall));
      pads_when: assert (\dut.pads == (\dut.state == PAD && !stall));
      front: assert (place != FRONT || (\dut.skid_count != 2'd0 && \dut.skid_front == beat));
      back: assert (place != BACK || (\dut.skid_count == 2'd2 && \dut.skid_back == beat));
      once: assert ({2'd0, \dut.stray } + {2'd0, \dut.refuse } + {2'd0, \dut.begins } + {2'd0, \dut.takes } <= 3'd1);
      there: assert (!used || \dut.skid_count != 2'd0);
      dropped: assert (!(\dut.stray || \dut.refuse ) || \dut.state == IDLE);
      strays: assert (\dut.stray == (\dut.state == IDLE && \dut.skid_count != 2'd0 && !first_beat));
      refuses: assert (\dut.refuse == (\dut.state == IDLE && \dut.skid_count != 2'd0 && first_beat
        && !(enable && \dut.possible )));
      begins_when: assert (\dut.begins == (may_begin && \dut.same && \dut.settle == 2'd0 && committed == was_committed
        && !stall));
      drains_when: assert (\dut.drains == (\dut.state == IDLE && !\dut.drained && !\dut.begins && !stall));
      // Rules for frames.
      cleared: assert (!was_reset || (\dut.x == 10'd0 && \dut.y == 11'd0));
      counts_down: assert (\dut.settle == (was_reset ? 2'd0 : was_resized ? 2'd3 : was_settle - {1'b0, was_settling}));
      resized: assert (was_reset || !was_resized || (width == was_offered_width && height == was_offered_height));
      start_held: assert (was_reset || was_step || start == was_start);
      states: assert (\dut.state != 2'd3 && inside == (\dut.state != IDLE));
      raster: assert (!inside || (column == {1'b0, \dut.x } && row == {1'b0, \dut.y } && sized && settled
        && column < width && row < height && !(column == 11'd0 && row == 12'd0)));
      complete: assert (\dut.keep == ends);
      begins_once: assert (!\dut.begins || (!inside && sized && settled));
      stable: assert (was_reset || (width == was_width && height == was_height) || was_idle_and_drained);
      size: assert (sized || (\dut.settle == 2'd0 && width == 11'd0 && height == 12'd0));
      no_step_without_a_size: assert (sized || (!advance && !ever));
      settled_size: assert (!advance || (width == was_width && width == was_width_before));
      settling: assert (width == 11'd0 || \dut.settle == 2'd3 || settled);
      // After a start of packet inside a frame the frame is padded from the next clock on; nothing else blocks the beat.
      progress: assert (was_reset || !was_waiting || \dut.state == PAD);
      // A frame begins with the size that is offered in the clock of its capture, and is captured one clock before its
      // first step.
      offered: assert (!capture || (enable && width == new_width && height == new_height));
      captured: assert (was_reset || (advance && start) == was_captured);
      refused: assert (!\dut.refuse || !enable || !was_possible);
      latest: assert (\dut.offered_width == was_new_width && \dut.offered_height == was_new_height
        && \dut.possible == was_possible && \dut.committed_delayed == was_committed);
      compared: assert (was_reset || \dut.same == (width == was_new_width && height == was_new_height));
      // Rules for errors.
      reported: assert (was_reset || errors == was_errors);
      open: assert (inside ? packet_open == (\dut.state == FRAME) : packet_open == \dut.ignoring );
      own_errors: assert (!inside || own == \dut.own );
      done: assert (was_reset || was_done == \dut.done_before );
      waiting_tags: assert (tags == \dut.frames && tags <= 3'd4 && (\dut.kept >> (tags * 3)) == 12'd0);
      position: assert (!followed || (tags_ahead < tags && from_tag[2:0] == tag));
      own_trailer: assert (!followed || tags_ahead != 3'd0 || frame_errors == {1'b0, tag});
      no_frame: assert (tags != 3'd0 || frame_errors == 4'd0);
      // Rules for steps.
      steps: assert (was_reset || advance == was_step);
      no_stalled_step: assert (was_reset || !was_stalled || !advance);
      inside_ever: assert (!inside || ever);
      first_marked: assert (was_reset || was_ever || !advance || start);
      marked: assert (was_reset || !advance || start == was_begins);
      pixel_of_beat: assert (was_reset || !was_new || pixel == was_beat);
      pixel_held: assert (was_reset || was_new || pixel == was_data);
      // Rules for the drain.
      drains_96_lines: assert (!\dut.drained || !ever || since == frames_lines);
      nothing_to_drain: assert (!\dut.drained || \dut.drain == 17'd0);
      draining: assert (\dut.drained || (ever && \dut.drain != 17'd0 && since + {1'b0, \dut.drain } == frames_lines));
      drain_reported: assert (busy == !\dut.drained );
      begin_frame: cover (\dut.begins );
      cut_short: cover (\dut.pads && \dut.x == 10'd4);
      used_late: cover (place == GONE && \dut.skid_count == 2'd2);
    end
  end
endmodule
