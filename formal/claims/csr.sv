// csr: the register map as software sees it, over all sequences of accesses and events. One arbitrary register
// of those that can be written is followed.
module csr_properties (input clock);
  (* anyseq *) reg reset, read, write, busy, begun, done, saturated;
  (* anyseq *) reg [5:0] address;
  (* anyseq *) reg [31:0] writedata, frames;
  (* anyseq *) reg [3:0] errors;
  (* anyseq *) reg [19:0] count, dropped;
  (* anyseq *) reg [14:0] threshold_0, threshold_1;
  wire [5:0] followed;
  wire [31:0] readdata;
  wire irq, clear, enable, committed;
  wire [10:0] width;
  wire [11:0] height;
  wire [383:0] bank;
  csr dut (
    .clock(clock), .reset(reset), .address(address), .read(read), .readdata(readdata), .write(write),
    .writedata(writedata), .irq(irq), .clear(clear), .enable(enable), .width(width), .height(height), .bank(bank),
    .committed(committed), .busy(busy), .errors(errors), .begun(begun), .done(done), .count(count), .dropped(dropped),
    .frames(frames), .saturated(saturated), .threshold_0(threshold_0), .threshold_1(threshold_1)
  );

  (* hierconn *) wire [10:0] \dut.size_width ;
  (* hierconn *) wire [11:0] \dut.size_height ;
  (* hierconn *) wire [10:0] \dut.taken_width ;
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
  localparam FIRST_COEFFICIENT = 6'd16, LAST_COEFFICIENT = 6'd34;
  wire coefficient = followed >= FIRST_COEFFICIENT && followed <= LAST_COEFFICIENT;
  wire writable = coefficient || followed == CONTROL || (followed >= SIZE && followed <= TARGET)
    || followed == RECORD_LIMIT;
  // Writable bits by the register map.
  wire [31:0] bits = followed == CONTROL ? 32'h0000000f : followed == SIZE ? 32'h0fff07ff
    : followed == THRESHOLD ? 32'h7fff7fff : 32'h0000ffff;

  // Contents of the register, as the outputs show them.
  wire [5:0] index = followed - FIRST_COEFFICIENT;
  reg [15:0] in_bank;
  integer at;
  always @(*) begin
    in_bank = 16'd0;
    for (at = 0; at < 19; at = at + 1)
      if (index == at) in_bank = bank[at * 16 +: 16];
  end
  wire [31:0] held = coefficient ? {16'd0, in_bank}
    : followed == CONTROL ? {28'd0, \dut.control_interrupt_error , \dut.control_interrupt_frame , bank[352] , enable}
    : followed == SIZE ? {4'd0, \dut.size_height , 5'd0, \dut.size_width }
    : followed == THRESHOLD ? {bank[335:304]}
    : followed == RECORD_LIMIT ? {16'd0, bank[383:368]}
    : {16'd0, bank[351:336]};

  // Values after a reset, by the register map.
  function [31:0] after_reset(input [5:0] register);
    case (register)
      SIZE: after_reset = {16'd768, 16'd1024};
      THRESHOLD: after_reset = {16'd2048, 16'd2048};
      TARGET: after_reset = 32'd512;
      RECORD_LIMIT: after_reset = 32'd2046;
      6'd16: after_reset = 32'd24536;
      6'd17: after_reset = 32'd40315;
      6'd18: after_reset = 32'd47101;
      6'd19: after_reset = 32'd56830;
      6'd20: after_reset = 32'd64033;
      6'd21: after_reset = 32'd65500;
      6'd22: after_reset = 32'd17102;
      6'd23: after_reset = 32'd37685;
      6'd24: after_reset = 32'd42386;
      6'd25: after_reset = 32'd50478;
      6'd26: after_reset = 32'd60180;
      6'd27: after_reset = 32'd65021;
      6'd28: after_reset = 32'd11450;
      6'd29: after_reset = 32'd35905;
      6'd30: after_reset = 32'd38984;
      6'd31: after_reset = 32'd44768;
      6'd32: after_reset = 32'd53931;
      6'd33: after_reset = 32'd62636;
      6'd34: after_reset = 32'd65396;
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
  wire [407:0] set = {bank[352] , \dut.size_height , \dut.size_width , bank};
  reg [407:0] set_committed, was_set;
  reg was_quiet;
  wire [7:0] status = {
    \dut.status_begun , \dut.status_saturated , \dut.status_dropped , \dut.status_refused , \dut.status_interrupted ,
    \dut.status_long_frame , \dut.status_short_frame , \dut.status_frame
  };
  wire [7:0] events = clear ? 8'd0 : {begun, saturated, done & dropped != 20'd0, errors[3:0], done};
  // A commit by its definition: written as 1, it holds until a frame takes the set or a register of the set is written,
  // of which `control` counts only where it changes its automatic bit.
  wire in_set = (address >= SIZE && address <= TARGET) || address == RECORD_LIMIT
    || (address >= FIRST_COEFFICIENT && address <= LAST_COEFFICIENT)
    || (address == CONTROL && writedata[1] != bank[352]);
  reg commit_wanted;
  // The counts of the last frame that ended.
  reg [19:0] last_count, last_dropped;
  // Registers that software cannot write.
  reg [31:0] read_only;
  reg is_read_only;
  reg [31:0] was_readdata;
  reg [10:0] was_width;
  reg [11:0] was_height;
  reg was_committed, clear_wanted;
  reg [7:0] status_wanted;
  reg [10:0] width_taken;
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
        && address != RECORD_LIMIT && !(address >= FIRST_COEFFICIENT && address <= LAST_COEFFICIENT);
      case (address)
        6'd0: read_only <= "HLCK";
        // The hash of the emitted text is whatever it is.
        HASH: read_only <= \dut.emission_hash ;
        VERSION: read_only <= 32'h20001;
        STATUS: read_only <= {busy, 23'd0, status};
        THRESHOLD_NOW: read_only <= {1'b0, threshold_1, 1'b0, threshold_0};
        FRAMES: read_only <= frames;
        FEATURES: read_only <= {12'd0, last_count};
        DROPPED: read_only <= {12'd0, last_dropped};
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
      unused_bits: assert (bank[367:353] == 15'd0 && !bank[335] && !bank[319]);
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
      read_back: cover (asked && followed == THRESHOLD && readdata == 32'h00110022);
    end
  end
endmodule
