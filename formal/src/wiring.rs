//! Claims about connections, generated from tables that are written by hand (`claims/wiring.txt`, whose first lines say
//! how to read one, and `claims/smoothers.txt`).
//!
//! Every part is abstracted: its outputs may have any value in each step. For each input and each parameter of a part
//! the claim says which value it has, in terms of outputs of parts and of inputs of the top. So it holds for any
//! contents of the parts.

use std::collections::{BTreeMap, BTreeSet};

use crate::claim::{Claim, ClaimError};
use crate::ring::{ring_rows, ring_taps};
use crate::shape::Shape;

/// The connections of `hoverlock_top`, `hoverlock_core` and `extractor`.
pub(crate) const WIRING: &str = include_str!("../claims/wiring.txt");
/// The connections of `smoothers`.
pub(crate) const SMOOTHERS: &str = include_str!("../claims/smoothers.txt");
/// Path of the instance in the wrapper.
const DUT: &str = "dut";

/// Generates a claim from its TOML file and its table, for a design.
///
/// # Errors
/// If the TOML file is invalid.
pub(crate) fn claim(name: &str, settings: &str, table: &str, shape: &Shape) -> Result<Claim, ClaimError> {
    let lines = expanded(table, shape);
    let mut parts: Vec<Part> = Vec::new();
    let (mut covers, mut whole) = (Vec::new(), Vec::new());
    for line in &lines {
        let words: Vec<&str> = line.splitn(3, ' ').collect();
        match (words.as_slice(), parts.last_mut()) {
            (["whole", module], _) => whole.push(*module),
            (["part", path, module], _) => {
                let (module, numbers) = module.split_once(' ').unwrap_or((module, ""));
                let parameters = numbers.split_whitespace().filter_map(|number| number.split_once('=')).collect();
                parts.push(Part { path, module, parameters, ports: Vec::new() });
            }
            (["cover", name, expression], _) => covers.push((*name, *expression)),
            ([">", name, bits], Some(part)) => part.ports.push(Port { name, bits, value: None }),
            ([name, bits, value], Some(part)) => part.ports.push(Port { name, bits, value: Some(value) }),
            _ => {}
        }
    }
    let top = parts.first().map_or("", |part| part.module);
    let cut = part_modules(table, shape);
    let sources = std::iter::once(top).chain(whole).chain(cut.iter().map(String::as_str));
    let sources = sources.map(|module| format!("{module}.v")).collect();
    let properties = properties(name, top, &parts, &covers, shape);
    Ok(Claim { sources, cut, ..Claim::parse(name, settings, &properties)? })
}

/// A part, its parameters with their values, and its ports.
struct Part<'a> {
    path: &'a str,
    module: &'a str,
    parameters: Vec<(&'a str, &'a str)>,
    ports: Vec<Port<'a>>,
}

/// A port: an input with its value, or an output.
struct Port<'a> {
    name: &'a str,
    bits: &'a str,
    value: Option<&'a str>,
}

/// Returns the modules of the parts of a table.
pub(crate) fn part_modules(table: &str, shape: &Shape) -> Vec<String> {
    let lines = expanded(table, shape);
    let modules = lines.iter().filter_map(|line| line.strip_prefix("part ")?.split(' ').nth(1));
    modules.skip(1).map(str::to_owned).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Returns the lines of a table for a design, without comments, repetitions and placeholders.
fn expanded(table: &str, shape: &Shape) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    // Pairs and lines of the block that has begun.
    let mut block: Option<(Vec<usize>, Vec<&str>)> = None;
    let table = shape.unrolled(table);
    for line in table.iter().map(String::as_str).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        match (line, &mut block) {
            ("end", Some((pairs, of_block))) => {
                let all = pairs.iter().flat_map(|&k| of_block.iter().map(move |line| (k, *line)));
                lines.extend(all.map(|(k, line)| of_pair(line, k, shape)));
                block = None;
            }
            (line, Some((_, of_block))) => of_block.push(line),
            (line, None) => match line.strip_prefix("for ") {
                Some(which) => block = Some((pairs(which, shape), Vec::new())),
                None => lines.extend(each(line, shape)),
            },
        }
    }
    lines
}

/// Returns the scale pairs that a block is about.
fn pairs(which: &str, shape: &Shape) -> Vec<usize> {
    let of = |k: &usize| match which {
        "part_rings" => !shape.is_full_ring(*k),
        "full_rings" => shape.is_full_ring(*k),
        _ => true,
    };
    (0..shape.pairs()).filter(of).collect()
}

/// Returns the lines that a line outside of a block stands for.
fn each(line: &str, shape: &Shape) -> Vec<String> {
    if let Some(line) = line.strip_prefix("each smoother ") {
        return shape.smoothers.iter().map(|name| line.replace("{smoother}", name)).collect();
    }
    let line = line.replace("{P}", &shape.pixel_bits.to_string());
    if line.starts_with("each pair ") {
        return shape.pairs_of(&line);
    }
    let Some((before, rest)) = line.split_once("any(") else { return vec![line] };
    let Some((text, after)) = rest.split_once(')') else { return vec![line] };
    let all: Vec<String> = (0..shape.pairs()).map(|k| of_pair(text, k, shape)).collect();
    vec![format!("{before}({}){after}", all.join(" | "))]
}

/// Replaces the placeholders of a scale pair.
fn of_pair(line: &str, k: usize, shape: &Shape) -> String {
    let radius = shape.ring_radii[k];
    let first = shape.ring_radii.iter().position(|other| *other == radius).unwrap_or(k);
    let rows = ring_rows(radius).len() - usize::from(shape.is_full_ring(k));
    shape
        .of_pair(line, k)
        .replace("{narrow}", &shape.smoothers[k])
        .replace("{wide}", &shape.smoothers[k + 1])
        .replace("{ring}", &first.to_string())
        .replace("{R}", &(shape.dog_bits + 1).to_string())
        .replace("{lines}", &(16 + radius).to_string())
        .replace("{rows}", &rows.to_string())
        .replace("{taps}", &ring_taps(radius).to_string())
}

/// Returns the wrapper of a claim about the module `top`.
fn properties(claim: &str, top: &str, parts: &[Part], covers: &[(&str, &str)], shape: &Shape) -> String {
    let (mut signals, mut ports, mut asserts) = (String::new(), String::new(), String::new());
    // The last name of a path stands for the part.
    let short = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    let paths: BTreeMap<String, &str> = parts.iter().map(|part| (short(part.path), part.path)).collect();
    for Part { path, parameters, ports: of_part, .. } in parts {
        for (name, value) in parameters {
            let wire = format!("\\{DUT}.{path}.parameter_{name} ");
            signals += &format!("  (* hierconn, keep *) wire [31:0] {wire};\n");
            asserts += &format!("      {}_{name}: assert ({wire}== ({value}));\n", short(path));
        }
        for Port { name, bits, value } in of_part {
            let is_top = *path == ".";
            let wire = if is_top { (*name).to_owned() } else { format!("\\{DUT}.{path}.{name} ") };
            signals += &match (is_top, value) {
                (true, None) => format!("  (* anyseq *) reg [{bits}-1:0] {wire};\n"),
                (true, Some(_)) => format!("  wire [{bits}-1:0] {wire};\n"),
                (false, _) => format!("  (* hierconn, keep *) wire [{bits}-1:0] {wire};\n"),
            };
            if is_top {
                ports += &format!(", .{name}({name})");
            }
            if let Some(value) = value {
                let label = if is_top { format!("of_top_{name}") } else { format!("{}_{name}", short(path)) };
                asserts += &format!("      {label}: assert ({wire}== ({}));\n", resolved(value, &paths));
            }
        }
    }
    let covers: String =
        covers.iter().map(|(name, wanted)| format!("      {name}: cover ({});\n", resolved(wanted, &paths))).collect();
    format!(
        "// Generated from claims/{claim}.txt.\nmodule {claim}_properties (input clock);\n  {}\n{signals}  \
         {top} {DUT} (.clock(clock){ports});\n  reg begun = 0;\n  always @(posedge clock) \
         begin\n    begun <= 1;\n    if (begun) begin\n{asserts}{covers}    end\n  end\nendmodule\n",
        shape.parameters()
    )
}

/// Replaces each `PART.PORT` of an expression by the wire of this port.
fn resolved(value: &str, paths: &BTreeMap<String, &str>) -> String {
    let (mut text, mut word) = (String::new(), String::new());
    for letter in value.chars().chain([' ']) {
        if letter.is_alphanumeric() || ['_', '.'].contains(&letter) {
            word.push(letter);
            continue;
        }
        let wire = word.split_once('.').and_then(|(part, port)| Some(format!("\\{DUT}.{}.{port} ", paths.get(part)?)));
        text += &wire.unwrap_or_else(|| word.clone());
        word.clear();
        text.push(letter);
    }
    text
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    /// Checks that a table has every input of its parts, and every part of `holder`, whose paths begin with `prefix`.
    fn check(table: &str, holder: &str, prefix: &str) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog");
        let text_of = |module: &str| fs::read_to_string(folder.join(format!("{module}.v"))).unwrap();
        let lines = expanded(table, &Shape::kt27());
        let mut missing = Vec::new();
        for block in lines.join("\n").split("part ").skip(2) {
            let (head, ports) = block.split_once('\n').unwrap();
            let module = head.split(' ').nth(1).unwrap();
            let text = text_of(module);
            let given: Vec<&str> = head.split(' ').skip(2).filter_map(|one| Some(one.split_once('=')?.0)).collect();
            let parameters = text.lines().filter_map(|line| line.trim().strip_prefix("parameter "));
            let parameters: Vec<&str> =
                parameters.filter_map(|line| line.split(" =").next()?.rsplit(' ').next()).collect();
            if given != parameters {
                missing.push(format!("{module}: {parameters:?}"));
            }
            let inputs = text.lines().filter_map(|line| line.trim().strip_prefix("input  wire "));
            for input in inputs.map(|line| line.trim_end_matches(',').rsplit(' ').next().unwrap()) {
                let is_listed = ports.lines().any(|line| line.starts_with(&format!("{input} ")));
                if input != "clock" && !is_listed {
                    missing.push(format!("{module}.{input}"));
                }
            }
        }
        assert_eq!(missing, [""; 0]);
        let paths = lines.iter().filter_map(|line| line.strip_prefix("part ")).filter(|line| !line.starts_with('.'));
        let parts = paths.filter(|path| path.starts_with(prefix)).count();
        assert_eq!(parts, text_of(holder).matches(" (\n  .").count(), "parts of {holder}");
    }

    #[test]
    fn the_tables_have_every_input_of_every_part() {
        check(WIRING, "extractor", "core.extractor.");
        check(SMOOTHERS, "smoothers", "");
    }
}
