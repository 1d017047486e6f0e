// sequencer: beats to steps. One arbitrary beat is followed through the skid buffer; the raster, the drain and the
// outputs are compared with their definitions.
module sequencer_properties (input clock);
  (* anyseq *) reg reset, enable, committed, stall, valid, start_of_packet, end_of_packet, frame_done, choose;
  (* anyseq *) reg [10:0] new_width;
  (* anyseq *) reg [11:0] new_height;
  (* anyseq *) reg [15:0] data;
  wire ready, capture, advance, start, busy;
  wire [10:0] width;
  wire [11:0] height;
  wire [15:0] pixel;
  wire [3:0] errors, frame_errors;
  sequencer dut (
    .clock(clock), .reset(reset), .enable(enable), .new_width(new_width), .new_height(new_height),
    .committed(committed), .stall(stall), .ready(ready), .valid(valid), .data(data),
    .start_of_packet(start_of_packet), .end_of_packet(end_of_packet), .width(width), .height(height),
    .capture(capture), .advance(advance), .start(start), .pixel(pixel), .busy(busy), .errors(errors),
    .frame_done(frame_done), .frame_errors(frame_errors)
  );

  (* hierconn *) wire [1:0] \dut.skid_count ;
  (* hierconn *) wire [17:0] \dut.skid_front ;
  (* hierconn *) wire [17:0] \dut.skid_back ;
  (* hierconn *) wire [1:0] \dut.state ;
  (* hierconn *) wire [1:0] \dut.settle ;
  (* hierconn *) wire [9:0] \dut.x ;
  (* hierconn *) wire [10:0] \dut.y ;
  (* hierconn *) wire [9:0] \dut.last_x ;
  (* hierconn *) wire [10:0] \dut.last_y ;
  (* hierconn *) wire [10:0] \dut.offered_width ;
  (* hierconn *) wire [11:0] \dut.offered_height ;
  (* hierconn *) wire \dut.possible ;
  (* hierconn *) wire \dut.same ;
  (* hierconn *) wire \dut.drained ;
  (* hierconn *) wire [16:0] \dut.drain ;
  (* hierconn *) wire [16:0] \dut.drain_from ;
  (* hierconn *) wire \dut.stray ;
  (* hierconn *) wire \dut.refuse ;
  (* hierconn *) wire \dut.begins ;
  (* hierconn *) wire \dut.takes ;
  (* hierconn *) wire \dut.pads ;
  (* hierconn *) wire \dut.drains ;
  (* hierconn *) wire \dut.keep ;

  localparam IDLE = 2'd0, FRAME = 2'd1, PAD = 2'd2;
  localparam NOT_YET = 2'd0, FRONT = 2'd1, BACK = 2'd2, GONE = 2'd3;
  reg begun = 0;
  reg was_reset;

  // A beat from the port to its use.
  reg [1:0] place = NOT_YET;
  reg [17:0] beat;
  wire used = \dut.stray | \dut.refuse | \dut.begins | \dut.takes ;
  wire pushed = valid & ready;
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
  wire [17:0] lines_96 = {1'b0, width, 6'd0} + {2'b0, width, 5'd0};

  // The raster of a frame by its definition, and the steps since the last pixel.
  wire with_pixel = \dut.begins | \dut.takes | \dut.pads ;
  reg [10:0] column = 11'd0;
  reg [11:0] row = 12'd0;
  reg inside = 0;
  reg [17:0] since, frames_lines;
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

  // Values of the previous clock.
  reg was_waiting, was_begins, was_step, was_pixel, was_stalled, was_new, was_idle_and_drained, was_ever;
  reg [15:0] was_beat, was_data;
  reg [10:0] was_width;
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
    was_beat <= \dut.skid_front [15:0];
    was_data <= pixel;
    was_idle_and_drained <= \dut.state == IDLE && \dut.drained && !\dut.begins ;
    was_width <= width;
    was_height <= height;
  end

  wire sized = width >= 11'd64 && width <= 11'd1024 && height >= 12'd64 && height <= 12'd2048;
  wire settled = \dut.last_x == width[9:0] - 10'd1 && \dut.last_y == height[10:0] - 11'd1 && \dut.drain_from == lines_96[16:0];
  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun) begin
      // Rules for beats.
      count: assert (\dut.skid_count <= 2'd2);
      front: assert (place != FRONT || (\dut.skid_count != 2'd0 && \dut.skid_front == beat));
      back: assert (place != BACK || (\dut.skid_count == 2'd2 && \dut.skid_back == beat));
      once: assert ({2'd0, \dut.stray } + {2'd0, \dut.refuse } + {2'd0, \dut.begins } + {2'd0, \dut.takes } <= 3'd1);
      there: assert (!used || \dut.skid_count != 2'd0);
      dropped: assert (!(\dut.stray || \dut.refuse ) || \dut.state == IDLE);
      // Rules for frames.
      states: assert (\dut.state != 2'd3 && inside == (\dut.state != IDLE));
      raster: assert (!inside || (column == {1'b0, \dut.x } && row == {1'b0, \dut.y } && sized && settled
        && column < width && row < height && !(column == 11'd0 && row == 12'd0)));
      complete: assert (\dut.keep == ends);
      begins_once: assert (!\dut.begins || (!inside && sized && settled));
      stable: assert (was_reset || (width == was_width && height == was_height) || was_idle_and_drained);
      size: assert (sized || (\dut.settle == 2'd0 && width == 11'd0 && height == 12'd0));
      settling: assert (width == 11'd0 || \dut.settle == 2'd3 || settled);
      // After a start of packet inside a frame the frame is padded from the next clock on; nothing else blocks the beat.
      progress: assert (was_reset || !was_waiting || \dut.state == PAD);
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
      draining: assert (\dut.drained || (ever && \dut.drain != 17'd0 && since + {1'b0, \dut.drain } == frames_lines));
      drain_reported: assert (busy == !\dut.drained );
      begin_frame: cover (\dut.begins );
      cut_short: cover (\dut.pads && \dut.x == 10'd4);
      used_late: cover (place == GONE && \dut.skid_count == 2'd2);
    end
  end
endmodule
