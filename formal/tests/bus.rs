//! The library of property modules: each proves a correct design and refutes broken ones.

use std::path::Path;
use std::time::Duration;

use hoverlock_formal::claim::Claim;
use hoverlock_formal::engine::{Solver, find_program};
use hoverlock_formal::prove::{Outcome, Place, Status, Task, run};

/// Returns `true` if Yosys and the solver are installed; `make test` installs them.
fn installed() -> bool {
    let all = ["yosys", "yosys-smtbmc", "yices-smt2"].iter().all(|program| find_program(program).is_some());
    if !all {
        eprintln!("SKIPPED: no yosys or no yices-smt2; `make test` installs them");
    }
    all
}

fn outcome(source: &str, properties: &str, task: Task, depth: u32) -> Outcome {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("design.v"), source).unwrap();
    let claim = Claim {
        name: "design".into(),
        properties: properties.into(),
        sources: vec!["design.v".into()],
        depth,
        cover: depth,
        ..Claim::default()
    };
    let out = folder.path().join("out");
    run(
        &claim,
        task,
        &Place { sources: folder.path(), out: &out, limit: Duration::from_secs(120), solver: Solver::default() },
    )
    .unwrap()
}

/// Asserts that `good` is proved with its covers, and that with `from` replaced by `to` the property whose name ends in
/// `rule` is violated.
fn assert_sees(good: &str, properties: &str, depth: u32, faults: &[(&str, &str, &str)]) {
    if !installed() {
        return;
    }
    let proof = outcome(good, properties, Task::Proof, depth);
    assert_eq!((proof.status, proof.detail.as_str()), (Status::Proved, ""));
    let cover = outcome(good, properties, Task::Cover, depth);
    assert_eq!((cover.status, cover.detail.as_str()), (Status::Reached, ""));
    // Without the invariants of the wrapper, which would fail first, so that the rules themselves detect the fault.
    let rules: Vec<&str> = properties.lines().filter(|line| !line.trim_start().starts_with("invariant_")).collect();
    for (from, to, rule) in faults {
        assert_eq!(good.matches(from).count(), 1, "{from}");
        let refuted = outcome(&good.replace(from, to), &rules.join("\n"), Task::Proof, depth);
        assert!(!refuted.pass && refuted.detail.contains(rule), "{to}: {}", refuted.detail);
    }
}

#[test]
fn axi4_stream_and_stream_order_prove_the_fifo_of_the_readme() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let [fifo, properties] = ["fifo.v", "fifo.sv"].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
    let faults = [
        ("held != 3'd4", "held != 3'd5", "beats.full"),
        ("held != 3'd0", "held != 3'd0 & m_tready", "beats.offers"),
        ("entries[9 * read_count[1:0] +: 9]", "entries[9 * read_count[1:0] +: 9] ^ {8'd0, ~m_tready}", "out.hold"),
        ("entries[9 * read_count[1:0] +: 9]", "entries[8:0]", "beats.order"),
    ];
    assert_sees(&fifo, &properties, 12, &faults);
}

/// A register stage of an Avalon-ST stream.
const STAGE: &str = "module stage (
  input clock, input reset, output in_ready, input in_valid, input [9:0] in_beat,
  input out_ready, output reg out_valid, output reg [9:0] out_beat
);
assign in_ready = ~out_valid | out_ready;
always @(posedge clock) begin
  if (reset) out_valid <= 1'b0;
  else if (in_ready) out_valid <= in_valid;
  if (in_ready) out_beat <= in_beat;
end
endmodule
";

const STAGE_RULES: &str = "module stage_properties (
  input clock, input reset, input in_valid, input [9:0] in_beat, input out_ready
);
  wire in_ready, out_valid;
  wire [9:0] out_beat;
  stage dut (
    .clock(clock), .reset(reset), .in_ready(in_ready), .in_valid(in_valid), .in_beat(in_beat),
    .out_ready(out_ready), .out_valid(out_valid), .out_beat(out_beat)
  );
  wire in_packet, out_packet;
  avalon_stream #(.ASSUMED(1)) into (
    .clock(clock), .reset(reset), .ready(in_ready), .valid(in_valid), .data(in_beat[7:0]),
    .startofpacket(in_beat[9]), .endofpacket(in_beat[8]), .in_packet(in_packet)
  );
  avalon_stream out (
    .clock(clock), .reset(reset), .ready(out_ready), .valid(out_valid), .data(out_beat[7:0]),
    .startofpacket(out_beat[9]), .endofpacket(out_beat[8]), .in_packet(out_packet)
  );
  reg begun = 0;
  always @(posedge clock) begin
    begun <= 1;
    if (!begun) assume (reset);
    else begin
      invariant_same: assert (reset || in_packet == (out_valid ? ~out_beat[8] : out_packet));
      ended: cover (out_valid && out_ready && out_beat[8] && !out_beat[9]);
    end
  end
endmodule
";

#[test]
fn avalon_stream_proves_a_stage_and_sees_a_beat_that_changes_and_a_packet_without_start() {
    let faults = [
        ("if (in_ready) out_beat", "if (in_valid) out_beat", "out.hold"),
        ("out_beat <= in_beat;", "out_beat <= {1'b0, in_beat[8:0]};", "out.start"),
    ];
    assert_sees(STAGE, STAGE_RULES, 8, &faults);
}

/// Two registers behind one wait state, read data a clock after the read is accepted.
const REGISTERS: &str = "module registers (
  input clock, input reset, input address, input read, input write, input [31:0] writedata,
  output waitrequest, output reg readdatavalid, output reg [31:0] readdata
);
reg [31:0] low, high;
reg waited;
assign waitrequest = (read | write) & ~waited;
wire accepted_read = read & ~waitrequest;
always @(posedge clock) begin
  waited <= ~reset & waitrequest;
  readdatavalid <= ~reset & accepted_read;
  readdata <= address ? high : low;
  if (write & ~waitrequest & ~address) low <= writedata;
  if (write & ~waitrequest & address) high <= writedata;
end
endmodule
";

const REGISTER_RULES: &str = "module registers_properties (
  input clock, input reset, input address, input read, input write, input [31:0] writedata
);
  wire waitrequest, readdatavalid;
  wire [31:0] readdata;
  registers dut (
    .clock(clock), .reset(reset), .address(address), .read(read), .write(write), .writedata(writedata),
    .waitrequest(waitrequest), .readdatavalid(readdatavalid), .readdata(readdata)
  );
  wire followed, known, asked;
  wire [31:0] value, wanted;
  wire [7:0] outstanding, ahead;
  avalon_slave #(.ADDRESS(1), .WAITS(1), .LATENCY(1)) bus (
    .clock(clock), .reset(reset), .address(address), .read(read), .write(write), .writedata(writedata),
    .waitrequest(waitrequest), .readdatavalid(readdatavalid), .readdata(readdata), .bits(32'hffffffff),
    .followed(followed), .outstanding(outstanding), .known(known), .value(value), .asked(asked), .ahead(ahead),
    .wanted(wanted)
  );
  (* hierconn *) wire [31:0] \\dut.low ;
  (* hierconn *) wire [31:0] \\dut.high ;
  (* hierconn *) wire \\dut.waited ;
  (* hierconn *) wire [7:0] \\bus.waits_so_far ;
  wire answered = readdatavalid && ahead == 8'd0 && readdata == wanted;
  reg begun = 0;
  always @(posedge clock) begin
    begun <= 1;
    if (!begun) assume (reset);
    else begin
      invariant_kept: assert (!known || (followed ? \\dut.high : \\dut.low ) == value);
      invariant_one: assert (outstanding == {7'd0, readdatavalid} && (!asked || answered));
      invariant_waits: assert (\\bus.waits_so_far == {7'd0, \\dut.waited });
      read_back: cover (asked && readdata == 32'd77);
    end
  end
endmodule
";

#[test]
fn avalon_slave_proves_registers_with_wait_states_and_sees_their_faults() {
    let faults = [
        ("& ~waited;", "& 1'b1;", "bus.waits"),
        ("~reset & accepted_read;", "~reset & (accepted_read | write);", "bus.invented"),
        ("~reset & accepted_read;", "1'b0;", "bus.answers"),
        ("& address) high <= writedata;", "& address) high <= writedata ^ 32'd4;", "bus.order"),
    ];
    assert_sees(REGISTERS, REGISTER_RULES, 8, &faults);
}

/// A module without state.
const WIRE: &str = "module through (input x, output y);\nassign y = x;\nendmodule\n";

/// An instance of a property module, in a wrapper without a design.
fn alone(instance: &str) -> String {
    format!(
        "module alone (
  input clock, input reset, input [3:0] address, input read, input write, input [31:0] writedata
);
  wire zero;
  through dut (.x(1'b0), .y(zero));
  {instance}
  reg begun = 0;
  always @(posedge clock) begin
    begun <= 1;
    if (!begun) assume (reset);
  end
endmodule
"
    )
}

#[test]
fn limits_that_need_more_than_the_usual_bits_are_seen_to_be_broken() {
    if !installed() {
        return;
    }
    let slave = |limit: &str, wait: &str| {
        alone(&format!(
            "avalon_slave #({limit}) bus (
    .clock(clock), .reset(reset), .address(address), .read(read), .write(write), .writedata(writedata),
    .waitrequest({wait}), .readdatavalid(zero), .readdata(32'd0), .bits(32'd0)
  );"
        ))
    };
    let order = |limit: &str, take: &str, offered: &str| {
        alone(&format!(
            "reg had;
  always @(posedge clock) had <= ~reset;
  stream_order #({limit}) beats (
    .clock(clock), .reset(reset), .take({take}), .taken(8'd0), .offered({offered}), .leave(zero), .leaving(8'd0)
  );"
        ))
    };
    let cases = [
        (slave(".LATENCY(300)", "1'b0"), "bus.answers"),
        (slave(".WAITS(256)", "1'b1"), "bus.waits"),
        (order(".ENTRIES(1), .LATENCY(256)", "~had", "1'b0"), "beats.offers"),
        (order(".ENTRIES(65536)", "1'b1", "1'b1"), "beats.full"),
    ];
    for (properties, rule) in &cases {
        let broken = outcome(WIRE, properties, Task::Proof, 4);
        assert!(!broken.pass && broken.detail.contains(rule), "{rule}: {broken:?}");
    }
}
