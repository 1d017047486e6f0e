// csr: the register map as software sees it, over all sequences of accesses and events. One arbitrary register
// of those that can be written is followed.
module csr_properties (input clock);
  (* anyseq *) reg reset, read, write, busy, begun, done, saturated;
  (* anyseq *) reg [5:0] address;
  (* anyseq *) reg [31:0] writedata, frames;
  (* anyseq *) reg [3:0] errors;
  (* anyseq *) reg [19:0] count, dropped;
  each pair (* anyseq *) reg [`D-1:0] threshold_{k};
  wire [5:0] followed;
  wire [31:0] readdata;
  wire irq, clear, enable, committed;
  wire [`W-1:0] width;
  wire [11:0] height;
  wire [`B-1:0] bank;
  csr dut (
    .clock(clock), .reset(reset), .address(address), .read(read), .readdata(readdata), .write(write),
    .writedata(writedata), .irq(irq), .clear(clear), .enable(enable), .width(width), .height(height), .bank(bank),
    .committed(committed), .busy(busy), .errors(errors), .begun(begun), .done(done), .count(count), .dropped(dropped),
    .frames(frames),
    each pair .threshold_{k}(threshold_{k}),
    .saturated(saturated)
  );

  (* hierconn *) wire [`W-1:0] \dut.size_width ;
  (* hierconn *) wire [11:0] \dut.size_height ;
  (* hierconn *) wire [`W-1:0] \dut.taken_width ;
  (* hierconn *) wire [11:0] \dut.taken_height ;
  (* hierconn *) wire \dut.control_interrupt_error ;
  (* hierconn *) wire \dut.control_interrupt_frame ;
  (* hierconn *) wire [19:0] \dut.features_count ;
  (* hierconn *) wire [19:0] \dut.dropped_count ;
  (* hierconn *) wire \dut.status_begun ;
  (* hierconn *) wire \dut.status_saturated ;
  (* hierconn *) wire \dut.status_dropped ;
  (* hierconn *) wire \dut.status_refused ;
  (* hierconn *) wire \dut.status_interrupted ;
  (* hierconn *) wire \dut.status_long_frame ;
  (* hierconn *) wire \dut.status_short_frame ;
  (* hierconn *) wire \dut.status_frame ;

  (* hierconn *) wire [31:0] \dut.emission_hash ;

  localparam VERSION = 6'd1, HASH = 6'd2, THRESHOLD_NOW = 6'd8, FRAMES = 6'd9, FEATURES = 6'd10, DROPPED = 6'd11;
  localparam CONTROL = 6'd3, STATUS = 6'd4, SIZE = 6'd5, THRESHOLD = 6'd6, TARGET = 6'd7, COMMIT = 6'd12, RECORD_LIMIT = 6'd15;
  localparam FIRST_COEFFICIENT = 6'd16, LAST_COEFFICIENT = 6'd15 + `G;
  // Of a third scale pair.
  localparam THRESHOLD_2 = 6'd13, THRESHOLD_2_NOW = 6'd14;
  wire coefficient = followed >= FIRST_COEFFICIENT && followed <= LAST_COEFFICIENT;
  wire writable = coefficient || followed == CONTROL || (followed >= SIZE && followed <= TARGET)
    || followed == RECORD_LIMIT || (`N == 3 && followed == THRESHOLD_2);
  // Writable bits by the register map.
  wire [31:0] bits = followed == CONTROL ? 32'h0000000f : followed == SIZE ? {16'h0fff, 16'd2 ** `W - 16'd1}
    : followed == THRESHOLD ? {`N == 1 ? 16'd0 : 16'd2 ** `D - 16'd1, 16'd2 ** `D - 16'd1}
    : followed == THRESHOLD_2 ? {16'd0, 16'd2 ** `D - 16'd1}
    : coefficient ? {16'd0, 16'd2 ** `C - 16'd1} : 32'h0000ffff;

  // The bank: coefficients, thresholds, target, mode and limit, 16 bits each.
  localparam TARGET_AT = 16 * (`G + `N), MODE_AT = TARGET_AT + 16, LIMIT_AT = TARGET_AT + 32;
  wire [15:0] target = bank[TARGET_AT +: 16], limit = bank[LIMIT_AT +: 16];
  wire follows = bank[MODE_AT];
  wire [15:0] threshold_2_held = bank[TARGET_AT - 16 +: 16];
  wire [31:0] size;
  assign size[31:16] = {4'd0, \dut.size_height };
  assign size[15:0] = \dut.size_width ;

  // Contents of the register, as the outputs show them.
  wire [5:0] index = followed - FIRST_COEFFICIENT;
  reg [15:0] in_bank;
  integer at;
  always @(*) begin
    in_bank = 16'd0;
    for (at = 0; at < `G; at = at + 1)
      if (index == at) in_bank = bank[at * 16 +: 16];
  end
  wire [31:0] held = coefficient ? {16'd0, in_bank}
    : followed == CONTROL ? {28'd0, \dut.control_interrupt_error , \dut.control_interrupt_frame , follows, enable}
    : followed == SIZE ? size
    : followed == THRESHOLD ? {`N == 1 ? 16'd0 : bank[16*`G+16 +: 16], bank[16*`G +: 16]}
    : followed == RECORD_LIMIT ? {16'd0, limit}
    : followed == THRESHOLD_2 ? {16'd0, threshold_2_held}
    : {16'd0, target};

  // Values after a reset, by the register map.
  function [31:0] after_reset(input [5:0] register);
    case (register)
      {resets}
      default: after_reset = 32'd0;
    endcase
  endfunction
  // Not written since a reset.
  reg untouched = 0;

  // The bus: read data one clock after `read`, no wait states.
  reg running = 0;
  reg was_read = 0;
  wire known, asked;
  wire [31:0] value, wanted;
  wire [7:0] outstanding, ahead;
  avalon_slave #(.ADDRESS(6)) slave (
    .clock(clock), .reset(reset), .address(address), .read(read), .write(write), .writedata(writedata),
    .waitrequest(1'b0), .readdatavalid(was_read), .readdata(readdata), .bits(writable ? bits : 32'd0),
    .followed(followed), .outstanding(outstanding), .known(known), .value(value), .asked(asked), .ahead(ahead),
    .wanted(wanted)
  );
  reg was_reset;
  // The set at the time of its commit.
  wire [`B+`W+12:0] set = {follows, \dut.size_height , \dut.size_width , bank};
  reg [`B+`W+12:0] set_committed, was_set;
  reg was_quiet;
  wire [7:0] status = {
    \dut.status_begun , \dut.status_saturated , \dut.status_dropped , \dut.status_refused , \dut.status_interrupted ,
    \dut.status_long_frame , \dut.status_short_frame , \dut.status_frame
  };
  wire [7:0] events = clear ? 8'd0 : {begun, saturated, done & dropped != 20'd0, errors[3:0], done};
  // A commit by its definition: written as 1, it holds until a frame takes the set or a register of the set is written,
  // of which `control` counts only where it changes its follows bit.
  wire in_set = (address >= SIZE && address <= TARGET) || address == RECORD_LIMIT
    || (address >= FIRST_COEFFICIENT && address <= LAST_COEFFICIENT)
    || (address == CONTROL && writedata[1] != follows)
    || (`N == 3 && address == THRESHOLD_2);
  reg commit_wanted;
  // The counts of the last frame that ended.
  reg [19:0] last_count, last_dropped;
  // Thresholds in use.
  wire [31:0] now, now_2;
  wire [15:0] now_of_0, now_of_1, now_of_2;
  each pair assign now_of_{k} = threshold_{k};
  assign now = {`N == 1 ? 16'd0 : now_of_1, now_of_0};
  assign now_2 = {16'd0, now_of_2};
  // Registers that software cannot write.
  reg [31:0] read_only;
  reg is_read_only;
  reg [31:0] was_readdata;
  reg [`W-1:0] was_width;
  reg [11:0] was_height;
  reg was_committed, clear_wanted;
  reg [7:0] status_wanted;
  reg [`W-1:0] width_taken;
  reg [11:0] height_taken;
  always @(posedge clock) begin
    running <= 1;
    was_reset <= reset;
    untouched <= reset || (untouched && !(write && address == followed));
    was_read <= read & ~reset;
    was_readdata <= readdata;
    was_set <= set;
    was_quiet <= !write && !reset;
    was_width <= width;
    was_height <= height;
    was_committed <= committed;
    clear_wanted <= reset || (write && address == CONTROL && writedata[31]);
    commit_wanted <= reset || (commit_wanted && !begun && !(write && in_set))
      || (write && address == COMMIT && writedata[0]);
    if (reset) begin
      last_count <= 20'd0;
      last_dropped <= 20'd0;
    end else if (done && !clear) begin
      last_count <= count;
      last_dropped <= dropped;
    end
    if (read) begin
      is_read_only <= !(address >= CONTROL && address <= TARGET && address != STATUS)
        && address != RECORD_LIMIT && (`N != 3 || address != THRESHOLD_2) && !(address >= FIRST_COEFFICIENT && address <= LAST_COEFFICIENT);
      case (address)
        6'd0: read_only <= "HLCK";
        // The hash of the emitted text is whatever it is.
        HASH: read_only <= \dut.emission_hash ;
        VERSION: read_only <= after_reset(VERSION);
        STATUS: read_only <= {busy, 23'd0, status};
        THRESHOLD_NOW: read_only <= now;
        FRAMES: read_only <= frames;
        FEATURES: read_only <= {12'd0, last_count};
        DROPPED: read_only <= {12'd0, last_dropped};
        THRESHOLD_2_NOW: read_only <= `N == 3 ? now_2 : 32'd0;
        COMMIT: read_only <= {31'd0, committed};
        default: read_only <= 32'd0;
      endcase
    end
    if (!committed || was_reset)
      set_committed <= set;
    status_wanted <= reset ? 8'd0 : (status & ~(write && address == STATUS ? writedata[7:0] : 8'd0)) | events;
    if (reset) begin
      width_taken <= 11'd0;
      height_taken <= 12'd0;
    end else if (begun && committed) begin
      width_taken <= width;
      height_taken <= height;
    end
  end

  always @(posedge clock) begin
    if (!running) assume (reset);
    assume (writable);
    if (running) begin
      holds: assert (!known || held == (value & bits));
      as_reset: assert (!untouched || held == after_reset(followed));
      // Invariant of the bus rules: at most one read is outstanding, and it is answered in this clock.
      one_read: assert (outstanding == {7'd0, was_read} && (!asked || (was_read && ahead == 8'd0 && readdata == wanted)));
      reads_change_nothing: assert (!was_quiet || set == was_set);
      whole_set: assert (!committed || was_reset || set == set_committed);
      commit: assert (committed == commit_wanted);
      // The assumption of claim `sequencer`.
      with_commit: assert (clear || (width == was_width && height == was_height) || committed != was_committed);
      cleared: assert (clear == clear_wanted);
      unused_bits: assert (bank[MODE_AT+1 +: 15] == 15'd0);
      each pair unused_{k}: assert (bank[16*(`G+{k})+`D +: 16-`D] == 0);
      held_between_reads: assert (was_read || was_reset || readdata == was_readdata);
      by_hardware: assert (!was_read || !is_read_only || readdata == read_only);
      counts: assert (last_count == \dut.features_count && last_dropped == \dut.dropped_count );
      status_bits: assert (status == status_wanted);
      last_size: assert (\dut.taken_width == width_taken && \dut.taken_height == height_taken);
      offered: assert (committed ? width == \dut.size_width && height == \dut.size_height
        : width == width_taken && height == height_taken);
      interrupt: assert (irq == ((\dut.control_interrupt_frame && status[0])
        || (\dut.control_interrupt_error && status[6:1] != 6'd0)));
      withdrawn: cover (known && !committed && followed == LAST_COEFFICIENT);
      read_back: cover (asked && followed == THRESHOLD && readdata == (`N == 1 ? 32'h2 : 32'h00010002));
    end
  end
endmodule
