// candidate_queue: one arbitrary candidate is followed from its arrival to its departure.
module candidate_queue_properties (input clock);
  (* anyseq *) reg reset, advance, active, choose;
  (* anyseq *) reg [`Q-1:0] word;
  (* anyseq *) reg [`X-1:0] x;
  (* anyseq *) reg [10:0] y;
  wire found;
  wire [`Q-1:0] candidate;
  each pair wire [`D-1:0] centre_{k};
  wire [1:0] dropped;
  candidate_queue dut (
    .clock(clock), .reset(reset), .advance(advance), .word(word), .active(active), .x(x), .y(y), .found(found),
    .candidate(candidate),
    each pair .centre_{k}(centre_{k}),
    .dropped(dropped)
  );

  (* hierconn *) wire [`QUEUE_BITS:0] \dut.waiting ;
  (* hierconn *) wire [`QUEUE_BITS-1:0] \dut.read_address ;
  (* hierconn *) wire [`QUEUE_BITS-1:0] \dut.write_address ;
  (* hierconn *) wire \dut.next_valid ;
  (* hierconn *) wire \dut.head_valid ;
  (* hierconn *) wire [`Q-1:0] \dut.next ;
  (* hierconn *) wire [`Q-1:0] \dut.head ;
  (* hierconn *) wire [`QUEUE_BITS-1:0] \dut.watched_address ;
  (* hierconn *) wire [`Q-1:0] \dut.watched ;

  localparam NOT_YET = 3'd0, STORED = 3'd1, NEXT = 3'd2, HEAD = 3'd3, GONE = 3'd4;
  reg [2:0] place = NOT_YET;
  reg [`QUEUE_BITS-1:0] at;
  reg [`Q-1:0] kept;
  reg [`QUEUE_BITS:0] ahead, inside;
  reg begun = 0;
  // By the definition and not by the module's signals: a candidate is for one scale or both.
  wire arrives = |word[`X+11 +: `N];
  wire room = inside - {9'd0, \dut.next_valid } - {9'd0, \dut.head_valid } < `QUEUE;
  wire taken = advance & arrives & room;
  wire leaves = advance & active & \dut.head_valid & (\dut.head [`X-1:0] == x) & (\dut.head [`X +: 11] == y);
  wire moves_up = ~\dut.head_valid | leaves;
  wire chosen = taken & choose & (place == NOT_YET);
  assign \dut.watched_address = at;

  // Number of scale pairs that a candidate is a feature of.
  function [1:0] hits(input [`Q-1:0] of);
    begin
      hits = 2'd0;
      each pair hits = hits + {1'b0, of[`X+11+{k}]};
    end
  endfunction

  // Expected outputs after a step.
  reg stepped = 0, left;
  reg [`Q-1:0] left_word;
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
      lost <= room ? 2'd0 : hits(word);
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

  wire [`QUEUE_BITS-1:0] behind_read = at - \dut.read_address ;
  always @(posedge clock) begin
    if (!begun) assume (reset);
    if (begun) begin
      within: assert (\dut.waiting <= `QUEUE);
      addresses: assert (\dut.waiting [`QUEUE_BITS-1:0] == \dut.write_address - \dut.read_address );
      conserved: assert (inside == \dut.waiting + {9'd0, \dut.next_valid } + {9'd0, \dut.head_valid });
      stored: assert (place != STORED || (\dut.watched == kept && {1'b0, behind_read} < \dut.waiting
        && ahead == {1'b0, behind_read} + {9'd0, \dut.next_valid } + {9'd0, \dut.head_valid }));
      next: assert (place != NEXT || (\dut.next_valid && \dut.next == kept && ahead == {9'd0, \dut.head_valid }));
      head: assert (place != HEAD || (\dut.head_valid && \dut.head == kept && ahead == 10'd0));
      departs: assert (found == left);
      unchanged: assert (!left || candidate == left_word);
      each pair centre_{k}_of_it: assert (!left || centre_{k} == left_word[`X+11+`N+{k}*`R +: `D]);
      counted: assert (dropped == lost);
      known: assert (place <= GONE);
      gone: cover (place == GONE && kept[`X+10:0] == 77);
      queued: cover (place == STORED && ahead == 10'd2);
    end
  end
endmodule
