//! The claim about the connections of `hoverlock_top`, `hoverlock_core` and `extractor`, generated from a table that is
//! written by hand (`claims/connections.txt`, its first lines say how).
//!
//! Every other part is abstracted: its outputs may have any value in each step. For each input of each part the claim
//! says which value it has, in terms of outputs of parts and of inputs of the top. So it holds for any contents of the
//! parts.

use std::collections::{BTreeMap, BTreeSet};

use crate::claim::{Claim, Mutant};
use crate::ring::ring_rows;
use crate::shape::Shape;

/// The connections.
const TABLE: &str = include_str!("../claims/connections.txt");
/// Modules that are not abstracted.
const WIRING: [&str; 3] = ["hoverlock_top.v", "hoverlock_core.v", "extractor.v"];
/// Path of the instance in the wrapper.
const DUT: &str = "dut";

/// Generates the claim for a design.
pub(crate) fn claim(shape: &Shape) -> Claim {
    let lines = expanded(shape);
    let mut parts: Vec<Part> = Vec::new();
    for line in &lines {
        let words: Vec<&str> = line.splitn(3, ' ').collect();
        match (words.as_slice(), parts.last_mut()) {
            (["part", path, module], _) => parts.push(Part { path, module, ports: Vec::new() }),
            ([">", name, bits], Some(part)) => part.ports.push(Port { name, bits, value: None }),
            ([name, bits, value], Some(part)) => part.ports.push(Port { name, bits, value: Some(value) }),
            _ => {}
        }
    }
    let modules: BTreeSet<&str> = parts.iter().skip(1).map(|part| part.module).collect();
    let files = modules.iter().map(|module| format!("{module}.v"));
    Claim {
        name: "wiring".into(),
        statement:
            "In `hoverlock_top`, `hoverlock_core` and `extractor`, for any behaviour of the parts: each input of \
                    each part, and each output of the top, has the value that the table of connections says."
                .into(),
        sources: WIRING.iter().map(|file| (*file).to_owned()).chain(files).collect(),
        properties: properties(&parts, shape),
        top: Some("wiring_properties".into()),
        depth: 2,
        cover: 4,
        fault: 3,
        cut: modules.into_iter().map(str::to_owned).collect(),
        mutants: mutants(),
        ..Claim::default()
    }
}

/// Returns faults that the claim must detect: smoothers swapped, a marker without its row, another pulse and count.
fn mutants() -> Vec<Mutant> {
    let mutant = |file: &str, from: &str, to: &str| Mutant { file: file.into(), from: from.into(), to: to.into() };
    vec![
        mutant("extractor.v", ".wide(smoothers_middle)", ".wide(smoothers_narrow)"),
        mutant(
            "extractor.v",
            ".take(ring_cursor_first_row & ring_cursor_last_column)",
            ".take(ring_cursor_last_column)",
        ),
        mutant("hoverlock_core.v", ".frame_done(extractor_done)", ".frame_done(extractor_write)"),
        mutant("hoverlock_core.v", "assign dropped = extractor_dropped;", "assign dropped = extractor_count;"),
    ]
}

/// A part and its ports.
struct Part<'a> {
    path: &'a str,
    module: &'a str,
    ports: Vec<Port<'a>>,
}

/// A port: an input with its value, or an output.
struct Port<'a> {
    name: &'a str,
    bits: &'a str,
    value: Option<&'a str>,
}

/// Returns the modules of the parts of a design.
pub(crate) fn part_modules(shape: &Shape) -> Vec<String> {
    let lines = expanded(shape);
    let modules = lines.iter().filter_map(|line| line.strip_prefix("part ")?.split(' ').nth(1));
    modules.skip(1).map(str::to_owned).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Returns the lines of the table for a design, without comments, repetitions and placeholders.
fn expanded(shape: &Shape) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    // Pairs and lines of the block that has begun.
    let mut block: Option<(Vec<usize>, Vec<&str>)> = None;
    for line in TABLE.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
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
}

/// Returns the wrapper.
fn properties(parts: &[Part], shape: &Shape) -> String {
    let (mut signals, mut ports, mut asserts) = (String::new(), String::new(), String::new());
    // The last name of a path stands for the part.
    let short = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    let paths: BTreeMap<String, &str> = parts.iter().map(|part| (short(part.path), part.path)).collect();
    for Part { path, ports: of_part, .. } in parts {
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
    format!(
        "// Generated from claims/connections.txt.\nmodule wiring_properties (input clock);\n  {}\n{signals}  \
         hoverlock_top {DUT} (.clock(clock){ports});\n  reg begun = 0;\n  always @(posedge clock) \
         begin\n    begun <= 1;\n    if (begun) begin\n{asserts}      \
         flows: cover (video_ready && feature_valid);\n    end\n  end\nendmodule\n",
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

    #[test]
    fn the_table_has_every_input_of_every_part() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog");
        let lines = expanded(&Shape::kt27());
        let mut missing = Vec::new();
        for block in lines.join("\n").split("part ").skip(2) {
            let (head, ports) = block.split_once('\n').unwrap();
            let module = head.split(' ').nth(1).unwrap();
            let text = fs::read_to_string(folder.join(format!("{module}.v"))).unwrap();
            let inputs = text.lines().filter_map(|line| line.trim().strip_prefix("input  wire "));
            for input in inputs.map(|line| line.trim_end_matches(',').rsplit(' ').next().unwrap()) {
                let is_listed = ports.lines().any(|line| line.starts_with(&format!("{input} ")));
                if input != "clock" && !is_listed {
                    missing.push(format!("{module}.{input}"));
                }
            }
        }
        assert_eq!(missing, [""; 0]);
        let parts = lines.iter().filter(|line| line.starts_with("part core.extractor.")).count();
        let text = fs::read_to_string(folder.join("extractor.v")).unwrap();
        assert_eq!(parts, text.matches(" (\n  .").count(), "parts of the extractor");
    }
}
