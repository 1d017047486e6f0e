//! The memories of the Verilog, and the blocks that hold them: `ceil(width / w)` block memories of the form `2^a x w`,
//! or 32-word MLABs of 20 bits.
//!
//! A memory that became registers would be thousands of them, and the estimate one of another design. So each
//! declaration `reg [width] name [words];`, with an attribute or without, must be found again in the netlist under its
//! own name, with all of its bits.

use std::collections::BTreeMap;

use hoverlock_fixed_point::analysis::resources::{MLAB_WORDS, blocks};
use hoverlock_rtl::emission::parameters::{Scope, Variant, active, value, width};
use serde::Serialize;

use crate::{
    EstimateError,
    netlist::{Flat, FlatCell, Kind},
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

/// Returns the memories that a module declares with these numbers: name, depth (words) and width (bits). A name in a
/// generate block begins with that of the block.
fn declared(text: &str, scope: &Scope) -> Vec<(String, u64, u64)> {
    let mut found = Vec::new();
    // Margin and name of each open block.
    let mut blocks: Vec<(usize, &str)> = Vec::new();
    let text = active(text, scope);
    for line in text.lines() {
        let margin = line.len() - line.trim_start().len();
        let line = line.trim();
        if line.starts_with("end") && blocks.last().is_some_and(|(at, _)| *at == margin) {
            blocks.pop();
        }
        if let Some((_, name)) = line.split_once(" begin : ") {
            blocks.push((margin, name));
        }
        let attribute = line.strip_prefix("(*").and_then(|line| line.split_once("*)"));
        let declaration = attribute.map_or(line, |(_, declaration)| declaration.trim_start());
        let memory = || {
            let rest = declaration.strip_prefix("reg ")?.trim().strip_suffix(';')?;
            let (word, words) = rest.strip_suffix(']')?.rsplit_once('[')?;
            let (range, name) = match word.trim().split_once(']') {
                Some((range, name)) => (format!("{range}]"), name),
                None => ("[0:0]".to_owned(), word),
            };
            let words = value(words.split_once(':')?.1, scope)? + 1;
            let blocks: String = blocks.iter().map(|(_, name)| format!("{name}.")).collect();
            Some((format!("{blocks}{}", name.trim()), words.try_into().ok()?, width(&range, scope)?.try_into().ok()?))
        };
        found.extend(memory());
    }
    found
}

/// Finds every memory of the Verilog in the netlist, whose modules have the labels of `variants`.
///
/// # Errors
/// If a memory is missing or incomplete in the netlist, or the netlist has memory cells without a declaration.
pub fn memories(texts: &BTreeMap<&str, &str>, variants: &[Variant], flat: &Flat) -> Result<Vec<Memory>, EstimateError> {
    let mut found = Vec::new();
    let mut accounted = 0;
    let of_variant = |variant: &Variant| {
        let text = texts.get(variant.module.as_str()).copied().unwrap_or_default();
        let memories = declared(text, &variant.scope(text)).into_iter();
        let label = variant.label();
        memories.map(move |(name, words, width)| (label.clone(), name, words, width)).collect::<Vec<_>>()
    };
    for (module, name, words, width) in variants.iter().flat_map(of_variant) {
        let Some(index) = flat.modules.iter().position(|known| *known == module) else { continue };
        let Some(first) = flat.instances.iter().position(|instance| instance.module == index) else { continue };
        let instances = flat.instances.iter().filter(|instance| instance.module == index).count();
        let of_memory = |kind: Kind| {
            let mine = flat.cells.iter().filter(|cell| cell.instance == first && cell.kind == kind);
            let is_of_it = |cell: &&FlatCell| cell.name.strip_prefix(&name).is_some_and(|rest| rest.starts_with('.'));
            mine.filter(is_of_it).count() as u64
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
        let text = "module a (\n  input wire clock\n);\n\nreg [575:0] memory [0:1023];\nreg [17:0] y;\n\
                    reg flag [0:3];\nwire [3:0] x [0:1];\ngenerate\n  if (N < 4) begin : small\n    \
                    reg [7:0] none [0:7];\n  end else begin : large\n    \
                    (* ramstyle = \"MLAB\" *) reg [B-1:0] memory [0:N-1];\n  end\nendgenerate\nendmodule\n";
        let of = |name: &str, words, width| (name.to_owned(), words, width);
        let scope = Scope::from([("N".to_owned(), 13), ("B".to_owned(), 16)]);
        let wanted = [of("memory", 1024, 576), of("flag", 4, 1), of("large.memory", 13, 16)];
        assert_eq!(declared(text, &scope), wanted);
    }
}
