//! The Yosys estimate: small designs whose counts are known, faults it must not pass over, and the top within its
//! limits.

use std::collections::BTreeMap;
use std::io::Write as _;

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_fixed_point::analysis::resources::{memories, resources};
use hoverlock_rtl::emission::File;
use hoverlock_synthesis::{DSP_LIMIT, Estimate, EstimateError, estimate, of};

/// Sizes a file below module `top`; `None` if there is no Yosys.
fn sized(verilog: &str) -> Option<Result<Estimate, EstimateError>> {
    let file = File { path: "verilog/top.v".into(), text: verilog.into() };
    match of(&[file], "top", &mut |_| ()) {
        Err(EstimateError::Missing(_)) => {
            writeln!(std::io::stderr(), "SKIPPED: the estimate: install yosys").expect("stderr is open");
            None
        }
        other => Some(other),
    }
}

/// Two instances of a cell with a memory, a multiplier between registers, an adder followed by a multiplexer.
const KNOWN: &str = "
module cell_ (input wire clock, input wire [9:0] at, input wire [19:0] x, input wire pick, output reg [19:0] y);
reg [19:0] memory [0:1023];
reg [19:0] word;
reg [17:0] a;
reg [17:0] b;
reg [35:0] product;
reg        picked;
reg [19:0] old;
wire [19:0] sum = word + {2'd0, product[17:0]};
always @(posedge clock) begin
  word <= memory[at];
  memory[at] <= x;
  a <= x[17:0];
  b <= {x[15:0], x[17:16]};
  product <= a * b;
  picked <= pick;
  old <= y;
  y <= picked ? sum ^ {product[35:18], 2'd0} : old;
end
endmodule
module top (input wire clock, input wire [9:0] at, input wire [19:0] x, input wire pick, output wire [39:0] y);
cell_ left (.clock(clock), .at(at), .x(x), .pick(pick), .y(y[19:0]));
cell_ right (.clock(clock), .at(at), .x({x[0], x[19:1]}), .pick(pick), .y(y[39:20]));
endmodule
";

#[test]
fn a_design_of_known_size_is_sized_right() {
    let Some(estimate) = sized(KNOWN) else { return };
    let estimate = estimate.unwrap();
    // A memory word of 20 bits takes two memories of 1024 x 10; two multipliers share a block.
    assert_eq!((estimate.m10k, estimate.mul18, estimate.dsp), (4, 2, 1));
    assert_eq!(estimate.unregistered_multipliers, 0);
    let cell = estimate.modules.iter().find(|module| module.name == "cell_").unwrap();
    assert_eq!((cell.instances, cell.m10k, cell.mul18), (2, 4, 2));
    // a, b, product, picked, old, y: the memory's output register is its own.
    assert_eq!(cell.registers, 2 * (18 + 18 + 36 + 1 + 20 + 20));
    // The adder, however long, and the multiplexer; its 20 bits: from the block memory into the chain, 18 to 19 bits
    // on, out, and a LUT.
    assert_eq!((estimate.logic_levels, cell.logic_levels), (2, 2));
    assert!(
        (787 + 629 + 18 * 10 + 249 + 76..=787 + 629 + 19 * 10 + 249 + 387).contains(&cell.cell_delay_ps),
        "{cell:?}"
    );
    sums_agree(&estimate);
}

#[test]
fn memories_deeper_than_a_block_are_counted_in_the_form_that_yosys_takes() {
    let memory = |width: u32| {
        format!(
            "module top (input wire clock, input wire [11:0] at, input wire [{top}:0] x, output reg [{top}:0] y);\n\
             reg [{top}:0] memory [0:4095];\nalways @(posedge clock) begin memory[at] <= x; y <= memory[at]; end\n\
             endmodule\n",
            top = width - 1
        )
    };
    for (width, blocks) in [(10, 4), (18, 9), (35, 14)] {
        let Some(estimate) = sized(&memory(width)) else { return };
        assert_eq!(estimate.unwrap().m10k, blocks, "4096 x {width}");
    }
}

/// The modules add up to the top, and every limit follows its rule.
fn sums_agree(estimate: &Estimate) {
    let modules = &estimate.modules;
    let sum = |of: fn(&hoverlock_synthesis::ModuleEstimate) -> u64| modules.iter().map(of).sum::<u64>();
    assert_eq!(sum(|module| module.alm), estimate.alm);
    assert_eq!(sum(|module| module.m10k), estimate.m10k);
    assert_eq!(sum(|module| module.mul18), estimate.mul18);
    assert_eq!(sum(|module| module.dsp), estimate.dsp);
    assert_eq!(sum(|module| module.registers), estimate.registers);
    // The same cells counted without regard to modules.
    for (kind, counted) in [("M10K", estimate.m10k), ("MUL18X18", estimate.mul18), ("FF", estimate.registers)] {
        assert_eq!(estimate.cells.get(kind).copied().unwrap_or_default(), counted, "{kind}");
    }
    for device in &estimate.devices {
        let [alm, m10k, dsp] = device.limits;
        assert!(3 * alm <= 2 * device.alm && 3 * m10k <= 2 * device.m10k && 3 * dsp <= 2 * device.dsp);
        assert!(dsp <= DSP_LIMIT);
        assert_eq!(device.fits, estimate.alm <= alm && estimate.m10k <= m10k && estimate.dsp <= dsp);
    }
}

#[test]
fn a_memory_that_becomes_registers_is_refused() {
    // Reset of every word is nothing that a block memory can do.
    let verilog =
        KNOWN.replace("memory[at] <= x;", "memory[at] <= x; if (pick) memory[0] <= 20'd0; if (at[0]) memory[1] <= x;");
    let Some(refused) = sized(&verilog.replace("[0:1023]", "[0:63]")) else { return };
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("memory of cell_, 64 x 20 bits") && message.contains("became registers"), "{message}");
}

#[test]
fn a_black_box_is_refused() {
    let verilog =
        KNOWN.replace("module top", "(* blackbox *) module hole (input wire x, output wire y);\nendmodule\nmodule top");
    let verilog = verilog.replace(".pick(pick), .y(y[19:0])", ".pick(open), .y(y[19:0])");
    let verilog = verilog.replace("cell_ left", "wire open;\nhole hole (.x(pick), .y(open));\ncell_ left");
    let Some(refused) = sized(&verilog) else { return };
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("`hole`"), "{message}");
}

#[test]
fn a_bare_multiplier_is_counted() {
    let Some(before) = sized(&KNOWN.replace("product <= a * b;", "product <= (a ^ b) * b;")) else { return };
    assert_eq!(before.unwrap().unregistered_multipliers, 2);
    let after = sized(&KNOWN.replace("product <= a * b;", "product <= a * b + 36'd3;")).unwrap();
    assert_eq!(after.unwrap().unregistered_multipliers, 2);
}

#[test]
fn a_fault_in_the_verilog_is_one_line() {
    let Some(refused) = sized("module top (input wire a, output wire b);\nassign b = c d;\nendmodule\n") else {
        return;
    };
    let message = refused.unwrap_err().to_string();
    assert!(message.starts_with("yosys fails: ") && message.lines().count() == 1, "{message}");
    assert!(message.contains("top.v:2"), "{message}");
}

/// What the report's sweep of word lengths is drawn with: the same memories, one by one.
fn the_memory_model_equals_it(estimate: &Estimate) {
    let model = resources(&KT27);
    assert_eq!((model.m10k, model.mul18, model.dsp), (estimate.m10k, estimate.mul18, estimate.dsp));
    let mut modelled: BTreeMap<(u64, u64), u64> = BTreeMap::new();
    memories(&KT27)
        .iter()
        .for_each(|memory| *modelled.entry((memory.words, memory.width)).or_default() += memory.count);
    let mut found: BTreeMap<(u64, u64), u64> = BTreeMap::new();
    for memory in estimate.memories.iter().filter(|memory| memory.m10k > 0) {
        let module = estimate.modules.iter().find(|module| module.name == memory.module).unwrap();
        *found.entry((memory.words, memory.width)).or_default() += module.instances;
    }
    assert_eq!(modelled, found);
}

/// The memory model without Yosys: block memories and DSP blocks of the shipped designs, as `hoverlock rtl estimate`
/// counted them in the Verilog of each.
#[test]
fn the_memory_model_counts_what_yosys_counted_in_every_shipped_design() {
    for (name, m10k, dsp) in [("kt27", 291, 27), ("hd1080", 377, 27), ("small", 118, 20)] {
        let model = resources(&DesignPoint::shipped(name).unwrap());
        assert_eq!((model.m10k, model.dsp), (m10k, dsp), "{name}");
    }
}

/// Yosys counts other ALMs where it reads the same modules in another order, so the order given must not count.
#[test]
fn the_order_of_files_changes_nothing() {
    let (cell, top) = KNOWN.split_once("module top").unwrap();
    let file = |name: &str, text: &str| File { path: format!("verilog/{name}.v"), text: text.into() };
    let files = [file("cell_", cell), file("top", &format!("module top{top}"))];
    let sized = [of(&files, "top", &mut |_| ()), of(&[files[1].clone(), files[0].clone()], "top", &mut |_| ())];
    match sized {
        [Err(EstimateError::Missing(_)), _] => {
            writeln!(std::io::stderr(), "SKIPPED: the estimate: install yosys").expect("stderr is open");
        }
        [one, other] => assert_eq!(one.unwrap(), other.unwrap()),
    }
}

#[test]
#[ignore = "Yosys on the whole top takes a minute"]
fn the_top_fits_the_smallest_device_with_a_third_free() {
    let estimate = match estimate(&KT27, None, &mut |_| ()) {
        Err(EstimateError::Missing(_)) => {
            return writeln!(std::io::stderr(), "SKIPPED: the estimate: install yosys").expect("stderr is open");
        }
        other => other.unwrap(),
    };
    sums_agree(&estimate);
    assert!(estimate.fits && estimate.device == "5AGXA1");
    assert!(estimate.m10k <= 533 && estimate.dsp <= 60 && 3 * estimate.alm <= 2 * 28_302, "{estimate:?}");
    assert_eq!(estimate.unregistered_multipliers, 0);
    the_memory_model_equals_it(&estimate);
    // One multiplier a cell, and no other.
    let cells = estimate.modules.iter().find(|module| module.name == "lerp").unwrap();
    assert_eq!((cells.mul18, estimate.mul18), (cells.instances, cells.instances));
    // An adder of 20 bits and a multiplexer: from a register into the chain, 19 bits on, out, through a LUT of three.
    let adder_and_multiplexer = 470 + 629 + 19 * 10 + 249 + 317;
    for name in ["lerp", "difference"] {
        let module = estimate.modules.iter().find(|module| module.name == name).unwrap();
        assert!(module.cell_delay_ps <= adder_and_multiplexer, "{module:?}");
    }
    // Comparisons are trees of LUTs here, chains in Quartus; control is deeper. The path from a frame's width over the
    // end of a band into the allowance of records, 3.85 ns, leaves six tenths of 10 ns to wires.
    assert!(estimate.cell_delay_ps <= 4000, "{}", estimate.cell_delay_ps);
}
