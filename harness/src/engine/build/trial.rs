//! The trial of a Verilator that the harness does not know: a small design whose every value must be what it should be.

use std::path::Path;

use super::{Build, Trace};
use crate::engine::model::{Direction, Message, Model};
use crate::engine::time::Time;

pub(super) const DESIGN: &str = include_str!("trial.v");

/// Builds and runs the design with the cache of `like` and the Verilator at `verilator`, in a folder.
///
/// # Errors
/// What was not as it should be.
pub(super) fn run(like: &Build, verilator: &Path, folder: &Path) -> Result<(), String> {
    let source = folder.join("trial.v");
    std::fs::write(&source, DESIGN).map_err(|e| format!("{} could not be written: {e}", source.display()))?;
    let mut build = Build::new("trial").source(&source).internal("*").trace(Trace::Vcd).verilator(verilator);
    build.cache.clone_from(&like.cache);
    build.on_trial = true;
    let library = build.compile().map_err(|e| e.to_string())?;
    let mut model = library.instance().map_err(|e| e.to_string())?;
    check(&mut model, folder).map_err(|e| e.to_string())
}

/// The error of the model, or a value that is not what it should be.
type Mismatch = Box<dyn std::error::Error>;

fn expect(what: &str, found: u64, expected: u64) -> Result<(), Mismatch> {
    if found == expected { Ok(()) } else { Err(format!("{what} is {found:#x}, not {expected:#x}").into()) }
}

/// Makes a clock cycle: low at `ns` nanoseconds, high 5 ns later.
fn cycle(model: &mut Model, ns: u64) -> Result<(), Mismatch> {
    let clk = model.find("clk")?;
    for (level, at) in [(0, ns), (1, ns + 5)] {
        model.set_time(Time::ns(at));
        model.set(clk, level)?;
        model.eval()?;
        model.trace_dump(Time::ns(at))?;
    }
    Ok(())
}

fn check(model: &mut Model, folder: &Path) -> Result<(), Mismatch> {
    let shape = |model: &Model, name: &str, width: u32, direction: Direction, signed: bool| -> Result<(), Mismatch> {
        let info = model.info(model.find(name)?);
        expect(&format!("the width of '{name}'"), u64::from(info.width), u64::from(width))?;
        if (info.direction, info.signed) == (direction, signed) {
            return Ok(());
        }
        Err(format!("'{name}' is {:?}, signed: {}", info.direction, info.signed).into())
    };
    shape(model, "data", 12, Direction::Input, false)?;
    shape(model, "offset", 20, Direction::Input, true)?;
    shape(model, "turned", 100, Direction::Output, false)?;
    shape(model, "lanes[1].held", 6, Direction::Internal, false)?;
    shape(model, "sum", 20, Direction::Internal, true)?;
    let find = |model: &Model, name: &str| model.find(name);

    let waves = folder.join("trial.vcd");
    model.trace_open(&waves, 0, "")?;
    let (address, data) = (find(model, "address")?, find(model, "data")?);
    model.set(find(model, "offset")?, 0xf_ff00)?;
    model.set(find(model, "key")?, 0x12_3456_789a)?;
    model.set_words(find(model, "wide")?, &[0x89ab_cdef, 0x0123_4567, 0xdead_beef, 0x5])?;
    model.set(find(model, "gain")?, 1.25f64.to_bits())?;
    let taps = find(model, "taps")?;
    for (at, value) in [(0, 1), (1, 10), (2, 30)] {
        model.set_element(taps, at, value)?;
    }
    for at in 4..=9 {
        model.set(address, at)?;
        model.set(data, 0xa00 + at)?;
        cycle(model, at * 10)?;
    }
    model.trace_close()?;

    let memory = find(model, "memory")?;
    for at in 4..=9 {
        expect(&format!("memory[{at}]"), model.get_element(memory, at)?, 0xa00 + at as u64)?;
    }
    model.set_element(memory, 5, 0x123)?;
    model.set(address, 5)?;
    model.eval()?;
    let value = |model: &Model, name: &str| -> Result<u64, Mismatch> { Ok(model.get(model.find(name)?)) };
    expect("'read' after a write of memory[5]", value(model, "read")?, 0x123)?;
    expect("'tap_sum'", value(model, "tap_sum")?, 141)?;
    expect("'scaled'", value(model, "scaled")?, 2.5f64.to_bits())?;
    expect("'sum'", value(model, "sum")?, 0xf_ffe0)?;
    expect("'state'", value(model, "state")?, 2)?;
    expect("'beat'", value(model, "beat")?, 0xa09)?;
    expect("'lanes[1].held'", value(model, "lanes[1].held")?, 0xa)?;
    expect("'u_part.kept'", value(model, "u_part.kept")?, 0xed_cba9_8765)?;
    // Word 3 of `wide` holds bits 96 to 99; `turned` has its halves of 50 bits exchanged.
    let wide = 0x5_dead_beef_0123_4567_89ab_cdef_u128;
    let turned = (wide & ((1 << 50) - 1)) << 50 | wide >> 50;
    let words: Vec<u32> = (0..4).map(|at| (turned >> (32 * at)) as u32).collect();
    if model.get_words(find(model, "turned")?) != words {
        return Err("'turned', 100 bits wide, is wrong".into());
    }
    let deep = model.get_element_words(find(model, "deep")?, 3)?;
    if deep != [0x89ab_cdef, 0x0123_4567, 0x6f] {
        return Err(format!("deep[3], 71 bits wide, is {deep:x?}").into());
    }
    // Row by row from the lowest indices: [1][4] is the second of the second row.
    expect("grid[1][4]", model.get_element(find(model, "grid")?, 4)?, 9)?;
    let items = model.info(find(model, "state")?).items.clone();
    if items != [("IDLE".to_owned(), 0), ("RUN".to_owned(), 2)] {
        return Err(format!("the items of 'state' are {items:?}").into());
    }
    let shown = Message::Text("address 9".into());
    if !model.take_messages().contains(&shown) {
        return Err("the line of $display did not arrive".into());
    }
    let recorded = std::fs::read_to_string(&waves).unwrap_or_default();
    // The last value of `data`, 0xa09, as 12 bits.
    if !recorded.contains("b101000001001 ") || !recorded.contains("$timescale") {
        return Err("the recorded waves do not have the values".into());
    }
    Ok(())
}
