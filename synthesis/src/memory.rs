//! The memories of the Verilog, and the blocks that hold them: `ceil(width / w)` block memories of the form `2^a x w`,
//! or 32-word MLABs of 20 bits.
//!
//! A memory that became registers would be thousands of them, and the estimate one of another design. So each
//! declaration `reg [width] name [words];`, with an attribute or without, must be found again in the netlist under its
//! own name, with all of its bits.

use hoverlock_fixed_point::analysis::resources::{MLAB_WORDS, blocks};
use serde::Serialize;

use crate::{
    EstimateError,
    netlist::{Flat, Kind},
};

/// A memory that a module declares. The numbers of blocks are those of one instance of the module.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Name of the module.
    pub module: String,
    /// Name of the memory in the module.
    pub name: String,
    /// Depth, words.
    pub words: u64,
    /// Width of a word, bits.
    pub width: u64,
    /// Number of 10-Kbit block memories that hold it; 0 if it is in MLABs.
    pub m10k: u64,
    /// Number of MLABs that hold it; 0 if it is in block memories.
    pub mlab: u64,
}

/// Returns the memories that a Verilog file declares: module, name, depth (words) and width (bits).
fn declared(verilog: &str) -> Vec<(String, String, u64, u64)> {
    let mut module = "";
    let mut found = Vec::new();
    for line in verilog.lines() {
        if let Some(rest) = line.strip_prefix("module ") {
            module = rest.split([' ', '(', ';']).next().unwrap_or_default();
        }
        let attribute = line.strip_prefix("(*").and_then(|line| line.split_once("*)"));
        let declaration = attribute.map_or(line, |(_, declaration)| declaration.trim_start());
        let memory = || {
            let rest = declaration.strip_prefix("reg ")?.trim().strip_suffix("];")?;
            let (word, words) = rest.rsplit_once('[')?;
            let (range, name) = match word.trim().strip_prefix('[') {
                Some(ranged) => ranged.split_once(']')?,
                None => ("0:0", word),
            };
            let count = |high: Option<&str>| Some(high?.trim().parse::<u64>().ok()? + 1);
            Some((name.trim().to_owned(), count(words.strip_prefix("0:"))?, count(range.strip_suffix(":0"))?))
        };
        found.extend(memory().map(|(name, words, width)| (module.to_owned(), name, words, width)));
    }
    found
}

/// Finds every memory of the Verilog in the netlist.
///
/// # Errors
/// If a memory is missing or incomplete in the netlist, or the netlist has memory cells without a declaration.
pub fn memories<'a>(verilog: impl Iterator<Item = &'a str>, flat: &Flat) -> Result<Vec<Memory>, EstimateError> {
    let mut found = Vec::new();
    let mut accounted = 0;
    for (module, name, words, width) in verilog.flat_map(declared) {
        let Some(index) = flat.modules.iter().position(|known| *known == module) else { continue };
        let Some(first) = flat.instances.iter().position(|instance| instance.module == index) else { continue };
        let instances = flat.instances.iter().filter(|instance| instance.module == index).count();
        let of_memory = |kind: Kind| {
            let mine = flat.cells.iter().filter(|cell| cell.instance == first && cell.kind == kind);
            mine.filter(|cell| cell.name.split_once('.').is_some_and(|(memory, _)| memory == name)).count() as u64
        };
        let (m10k, bits) = (of_memory(Kind::M10k), of_memory(Kind::Mlab));
        let want = blocks(words, width);
        // A small memory may go either way, but all of it goes one way.
        let whole = (m10k, bits) == (want, 0) || (words <= MLAB_WORDS && (m10k, bits) == (0, width));
        if !whole {
            return Err(EstimateError::Implausible(format!(
                "memory {name} of {module}, {words} x {width} bits, needs {want} M10K{}, and takes {m10k} M10K \
                 and {bits} bits of MLAB: the rest became registers or logic",
                if words <= MLAB_WORDS { format!(" or {width} bits of MLAB") } else { String::new() }
            )));
        }
        accounted += instances * (m10k + bits) as usize;
        found.push(Memory { module, name, words, width, m10k, mlab: bits.div_ceil(20) });
    }
    let cells = flat.cells.iter().filter(|cell| matches!(cell.kind, Kind::M10k | Kind::Mlab)).count();
    if cells != accounted {
        return Err(EstimateError::Implausible(format!(
            "{cells} memory cells are there, {accounted} of them belong to memories of the Verilog"
        )));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memories_are_read_off_their_declarations() {
        let verilog = "module a (\n  input wire clock\n);\n\nreg [575:0] memory [0:1023];\nreg [17:0] y;\n\
                       reg flag [0:3];\nwire [3:0] x [0:1];\nendmodule\nmodule b(\n\
                       (* ramstyle = \"MLAB\" *) reg [15:0] point_7_memory [0:12];\n";
        let of = |module: &str, name: &str, words, width| (module.to_owned(), name.to_owned(), words, width);
        assert_eq!(
            declared(verilog),
            [of("a", "memory", 1024, 576), of("a", "flag", 4, 1), of("b", "point_7_memory", 13, 16)]
        );
    }
}
