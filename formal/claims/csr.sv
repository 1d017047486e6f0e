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
  (* hierconn *) wire \dut.control_automatic ;
  (* hierconn *) wire \dut.status_begun ;
  (* hierconn *) wire \dut.status_saturated ;
  (* hierconn *) wire \dut.status_dropped ;
  (* hierconn *) wire \dut.status_refused ;
  (* hierconn *) wire \dut.status_interrupted ;
  (* hierconn *) wire \dut.status_long_frame ;
  (* hierconn *) wire \dut.status_short_frame ;
  (* hierconn *) wire \dut.status_frame ;

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
  wire [15:0] in_bank = bank[index * 16 +: 16];
  wire [31:0] held = coefficient ? {16'd0, in_bank}
    : followed == CONTROL ? {28'd0, \dut.control_interrupt_error , \dut.control_interrupt_frame , \dut.control_automatic , enable}
    : followed == SIZE ? {4'd0, \dut.size_height , 5'd0, \dut.size_width }
    : followed == THRESHOLD ? {bank[335:304]}
    : followed == RECORD_LIMIT ? {16'd0, bank[383:368]}
    : {16'd0, bank[351:336]};

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
  wire [407:0] set = {\dut.control_automatic , \dut.size_height , \dut.size_width , bank};
  reg [407:0] set_committed, was_set;
  reg was_quiet;
  wire [7:0] status = {
    \dut.status_begun , \dut.status_saturated , \dut.status_dropped , \dut.status_refused , \dut.status_interrupted ,
    \dut.status_long_frame , \dut.status_short_frame , \dut.status_frame
  };
  wire [7:0] events = clear ? 8'd0 : {begun, saturated, done & dropped != 20'd0, errors[3:0], done};
  reg [7:0] status_wanted;
  reg [10:0] width_taken;
  reg [11:0] height_taken;
  always @(posedge clock) begin
    running <= 1;
    was_reset <= reset;
    was_read <= read & ~reset;
    was_set <= set;
    was_quiet <= !write && !reset;
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
      // Invariant of the bus rules: at most one read is outstanding, and it is answered in this clock.
      one_read: assert (outstanding == {7'd0, was_read} && (!asked || (was_read && ahead == 8'd0 && readdata == wanted)));
      reads_change_nothing: assert (!was_quiet || set == was_set);
      whole_set: assert (!committed || was_reset || set == set_committed);
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
