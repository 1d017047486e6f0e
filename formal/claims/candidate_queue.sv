// candidate_queue: one arbitrary candidate is followed from its arrival to its departure.
module candidate_queue_properties (input clock);
  (* anyseq *) reg reset, advance, active, choose;
  (* anyseq *) reg [174:0] word;
  (* anyseq *) reg [9:0] x;
  (* anyseq *) reg [10:0] y;
  wire found;
  wire [174:0] candidate;
  wire [14:0] centre_0, centre_1;
  wire [1:0] dropped;
  candidate_queue dut (
    .clock(clock), .reset(reset), .advance(advance), .word(word), .active(active), .x(x), .y(y), .found(found),
    .candidate(candidate), .centre_0(centre_0), .centre_1(centre_1), .dropped(dropped)
  );

  (* hierconn *) wire [9:0] \dut.waiting ;
  (* hierconn *) wire [8:0] \dut.read_address ;
  (* hierconn *) wire [8:0] \dut.write_address ;
  (* hierconn *) wire \dut.next_valid ;
  (* hierconn *) wire \dut.head_valid ;
  (* hierconn *) wire [174:0] \dut.next ;
  (* hierconn *) wire [174:0] \dut.head ;
  (* hierconn *) wire [8:0] \dut.watched_address ;
  (* hierconn *) wire [174:0] \dut.watched ;

  localparam NOT_YET = 3'd0, STORED = 3'd1, NEXT = 3'd2, HEAD = 3'd3, GONE = 3'd4;
  reg [2:0] place = NOT_YET;
  reg [8:0] at;
  reg [174:0] kept;
  reg [9:0] ahead, inside;
  reg begun = 0;
  // By the definition and not by the module's signals: a candidate is for one scale or both.
  wire arrives = |word[22:21];
  wire room = inside - {9'd0, \dut.next_valid } - {9'd0, \dut.head_valid } < 10'd512;
  wire taken = advance & arrives & room;
  wire leaves = advance & active & \dut.head_valid & (\dut.head [9:0] == x) & (\dut.head [20:10] == y);
  wire moves_up = ~\dut.head_valid | leaves;
  wire chosen = taken & choose & (place == NOT_YET);
  assign \dut.watched_address = at;

  // Expected outputs after a step.
  reg stepped = 0, left;
  reg [174:0] left_word;
  reg [1:0] lost;
  always @(posedge clock) begin
    begun <= 1;
    if (reset) begin
      place <= NOT_YET;
      inside <= 10'd0;
      stepped <= 1;
      left <= 0;
      lost <= 2'd0;
    end else if (advance) begin
      left <= leaves;
      left_word <= \dut.head ;
      lost <= room ? 2'd0 : {1'b0, word[21]} + {1'b0, word[22]};
      inside <= inside + {9'd0, taken} - {9'd0, leaves};
      if (chosen) begin
        place <= STORED;
        at <= \dut.write_address ;
        kept <= word;
        ahead <= inside - {9'd0, leaves};
      end else begin
        if (place == STORED && at == \dut.read_address && (~\dut.next_valid | moves_up)) place <= NEXT;
        if (place == NEXT && moves_up) place <= HEAD;
        if (place == HEAD && leaves) place <= GONE;
        if (place != NOT_YET && place != HEAD && leaves) ahead <= ahead - 10'd1;
      end
    end
  end

  wire [8:0] behind_read = at - \dut.read_address ;
  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun) begin
      within: assert (\dut.waiting <= 10'd512);
      addresses: assert (\dut.waiting [8:0] == \dut.write_address - \dut.read_address );
      conserved: assert (inside == \dut.waiting + {9'd0, \dut.next_valid } + {9'd0, \dut.head_valid });
      stored: assert (place != STORED || (\dut.watched == kept && {1'b0, behind_read} < \dut.waiting
        && ahead == {1'b0, behind_read} + {9'd0, \dut.next_valid } + {9'd0, \dut.head_valid }));
      next: assert (place != NEXT || (\dut.next_valid && \dut.next == kept && ahead == {9'd0, \dut.head_valid }));
      head: assert (place != HEAD || (\dut.head_valid && \dut.head == kept && ahead == 10'd0));
      departs: assert (found == left);
      unchanged: assert (!left || (candidate == left_word && centre_0 == left_word[37:23] && centre_1 == left_word[53:39]));
      counted: assert (dropped == lost);
      known: assert (place <= GONE);
      gone: cover (place == GONE && kept[20:0] == 21'd77);
      queued: cover (place == STORED && ahead == 10'd2);
    end
  end
endmodule
