// record_writer: each record is packed from the inputs of its candidate; candidates that are not written are counted.
module record_writer_properties (input clock);
  (* anyseq *) reg reset, advance, found, frame_end, take, room;
  (* anyseq *) reg [174:0] candidate;
  (* anyseq *) reg [31:0] maxlbp_0, maxlbp_1, sign_0, sign_1;
  (* anyseq *) reg [1:0] lost, over_limit;
  (* anyseq *) reg [3:0] errors;
  (* anyseq *) reg [14:0] threshold_0, threshold_1;
  wire write, done;
  wire [255:0] record;
  wire [19:0] count, dropped;
  wire [31:0] frames;
  record_writer dut (
    .clock(clock), .reset(reset), .advance(advance), .found(found), .candidate(candidate), .maxlbp_0(maxlbp_0),
    .maxlbp_1(maxlbp_1), .sign_0(sign_0), .sign_1(sign_1), .lost(lost), .over_limit(over_limit), .frame_end(frame_end), .errors(errors),
    .take(take), .threshold_0(threshold_0), .threshold_1(threshold_1), .room(room), .write(write), .record(record),
    .done(done), .count(count), .dropped(dropped), .frames(frames)
  );

  (* hierconn *) wire \dut.waits ;
  (* hierconn *) wire [174:0] \dut.waiting ;
  (* hierconn *) wire [1:0] \dut.hits ;
  (* hierconn *) wire [174:0] \dut.now ;
  (* hierconn *) wire [127:0] \dut.ring_bits ;
  (* hierconn *) wire \dut.trailer ;
  (* hierconn *) wire [19:0] \dut.withheld ;
  (* hierconn *) wire [29:0] \dut.thresholds ;

  // A candidate: x 10 bits, y 11, hits 2, then of both scale pairs centre (16) and neighbours (60).
  localparam NOT_YET = 3'd0, WAITS = 3'd1, FIRST = 3'd2, SECOND = 3'd3, WRITTEN_FIRST = 3'd4, WRITTEN_LAST = 3'd5, GONE = 3'd6;
  reg begun = 0;
  reg [2:0] place = NOT_YET;
  (* anyseq *) reg choose;
  reg [174:0] followed;
  reg [127:0] bits;
  wire [9:0] x = followed[9:0];
  wire [10:0] y = followed[20:10];
  wire [1:0] hits = followed[22:21];
  // The record of a scale pair, field by field from the lowest.
  function [255:0] packing(input [174:0] c, input [127:0] ring, input pair);
    reg [15:0] centre;
    reg [59:0] around;
    begin
      centre = pair ? c[54:39] : c[38:23];
      around = pair ? c[174:115] : c[114:55];
      packing = 256'd0;
      packing[9:0] = c[9:0];                  // x
      packing[26:16] = c[20:10];              // y
      packing[46:32] = centre[14:0];          // response
      packing[48] = pair;
      packing[49] = centre[15];               // sign
      packing[78:64] = around[14:0];          // the four neighbours
      packing[94:80] = around[29:15];
      packing[110:96] = around[44:30];
      packing[126:112] = around[59:45];
      packing[255:128] = ring;
    end
  endfunction

  // The record that ends a frame, field by field from the lowest.
  function [255:0] trailing(
    input [31:0] frame, input [3:0] errors, input [19:0] count, input [19:0] dropped, input [19:0] withheld,
    input [29:0] thresholds
  );
    begin
      trailing = 256'd0;
      trailing[31:0] = frame;
      trailing[35:32] = errors;
      trailing[63] = 1'b1;                    // trailer
      trailing[83:64] = count;
      trailing[115:96] = dropped;
      trailing[142:128] = thresholds[14:0];
      trailing[158:144] = thresholds[29:15];
      trailing[211:192] = withheld;
    end
  endfunction

  reg had_room_first;
  reg [29:0] taken = 30'd0;
  reg known_thresholds = 0, known_before = 0;
  reg [29:0] was_taken;
  reg [31:0] was_frames;
  reg [3:0] was_errors;
  reg [19:0] was_count, was_dropped, was_withheld;
  // Scale pairs of which a record is due: those of a candidate two steps after it was found, then the second of two.
  reg [1:0] due, found_hits;
  reg was_found;
  wire [1:0] pending = \dut.hits ;
  // The writes of the step that ends now, by definition.
  wire feature = pending != 2'd0;
  wire end_now = \dut.trailer & ~feature;
  reg now_feature, now_end, ends_waiting;
  reg [31:0] frames_done;
  // Features written and dropped since the trailer, and candidates lost, by definition.
  reg [19:0] written_now, dropped_now, withheld_now;
  always @(posedge clock) begin
    begun <= 1;
    if (advance && take) begin
      taken <= {threshold_1, threshold_0};
      known_thresholds <= 1;
    end
    if (reset) begin
      ends_waiting <= 0;
      due <= 2'd0;
      was_found <= 0;
      frames_done <= 32'd0;
      place <= NOT_YET;
      now_feature <= 0;
      now_end <= 0;
      written_now <= 20'd0;
      dropped_now <= 20'd0;
      withheld_now <= 20'd0;
    end else if (advance) begin
      was_found <= found;
      found_hits <= candidate[22:21];
      due <= was_found ? found_hits : due[0] ? {due[1], 1'b0} : 2'd0;
      now_feature <= feature & room;
      now_end <= end_now;
      ends_waiting <= frame_end | (ends_waiting & feature);
      frames_done <= frames_done + {31'd0, done};
      known_before <= known_thresholds;
      was_taken <= taken;
      was_frames <= frames;
      was_errors <= errors;
      was_count <= count;
      was_dropped <= dropped;
      was_withheld <= withheld_now;
      written_now <= (done ? 20'd0 : written_now) + {19'd0, feature & room};
      dropped_now <= (done ? 20'd0 : dropped_now) + {18'd0, lost} + {19'd0, feature & ~room};
      withheld_now <= (done ? 20'd0 : withheld_now) + {18'd0, over_limit};
      had_room_first <= room;
      case (place)
        NOT_YET: if (found && choose) begin place <= WAITS; followed <= candidate; end
        WAITS: begin place <= hits[0] ? FIRST : hits[1] ? SECOND : GONE; bits <= {sign_1, sign_0, maxlbp_1, maxlbp_0}; end
        FIRST: place <= hits[1] ? WRITTEN_FIRST : WRITTEN_LAST;
        SECOND, WRITTEN_FIRST: place <= WRITTEN_LAST;
        default: place <= GONE;
      endcase
    end
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun) begin
      // Within three columns of a feature of both scale pairs there is no other feature.
      assume (!(found && \dut.waits && \dut.waiting [22:21] == 2'd3));
      pending_due: assert (pending == due && \dut.waits == was_found && (!was_found || \dut.waiting [22:21] == found_hits));
      waits: assert (place != WAITS || (\dut.waits && \dut.waiting == followed));
      first: assert (place != FIRST || (hits[0] && !(hits[1] && \dut.waits ) && pending == hits && \dut.now == followed && \dut.ring_bits == bits));
      second: assert (place != SECOND || (pending == 2'd2 && hits == 2'd2 && \dut.now == followed && \dut.ring_bits == bits));
      next: assert (place != WRITTEN_FIRST || (pending == 2'd2 && hits == 2'd3 && \dut.now == followed && \dut.ring_bits == bits));
      // The records of the followed candidate, scale pair 0 first.
      record_0: assert (place != WRITTEN_FIRST || (record == packing(followed, bits, 1'b0) && write == had_room_first));
      record_last: assert (place != WRITTEN_LAST || (record == packing(followed, bits, hits[1]) && write == had_room_first));
      writes: assert (write == (now_feature | now_end) && done == now_end && !(now_feature && now_end));
      waits_for_its_end: assert (\dut.trailer == ends_waiting && frames == frames_done);
      written: assert (count == written_now);
      not_written: assert (dropped == dropped_now);
      over: assert (\dut.withheld == withheld_now);
      took: assert (!known_thresholds || \dut.thresholds == taken);
      // Every bit of it; the thresholds are any before the first `take`.
      trailer: assert (!now_end || record == trailing(was_frames, was_errors, was_count, was_dropped, was_withheld,
        known_before ? was_taken : {record[158:144], record[142:128]}));
      in_both: cover (place == WRITTEN_LAST && hits == 2'd3 && write && record[63:0] != 64'd0);
      one_dropped: cover (place == WRITTEN_LAST && !write);
      ended: cover (done && record[83:64] == 20'd2);
    end
  end
endmodule
